//! Flow-angle vanes as measurements of the air velocity where they stand.
//!
//! Consumes the air velocity where the instrument stands; produces the predicted reading and its row of H.
//!     alpha = atan2(w, u)                                                                         (1)
//!     beta = asin(v / V),  V = sqrt(u^2 + v^2 + w^2)                                              (2)
//! with u, v, w at the vane (`LocalVelocity`). Derivatives, with s = u^2 + w^2:
//!     d alpha = (-w du + u dw)/s,   d beta = (s dv - v (u du + w dw))/(V^2 sqrt(s))                (3)
//! Returns `None` below `AIRSPEED_MIN_M_S` along the plane of symmetry.

use crate::realtime::estimation::aid::{AIRSPEED_MIN_M_S, LocalVelocity, Prediction};
use crate::realtime::estimation::config::Noise;

/// (1) with its row of H.
pub fn predict_incidence(local: &LocalVelocity, noise: &Noise) -> Option<Prediction> {
    let [u, _, w] = local.velocity;
    let s = u * u + w * w;
    if !(s > AIRSPEED_MIN_M_S * AIRSPEED_MIN_M_S) {
        return None;
    }
    let row = local.row([-w / s, 0.0, u / s]);
    let noise_var = noise.incidence_std * noise.incidence_std;
    Some(Prediction { value: libm::atan2(w, u), row, noise_var, wraps: true })
}

/// (2) with its row of H.
pub fn predict_sideslip(local: &LocalVelocity, noise: &Noise) -> Option<Prediction> {
    let [u, v, w] = local.velocity;
    let s = u * u + w * w;
    if !(s > AIRSPEED_MIN_M_S * AIRSPEED_MIN_M_S) {
        return None;
    }
    let root = libm::sqrt(s);
    let speed2 = s + v * v;
    let row = local.row([-v * u / (speed2 * root), root / speed2, -v * w / (speed2 * root)]);
    let noise_var = noise.sideslip_std * noise.sideslip_std;
    // atan2(v, sqrt(u^2 + w^2)) is asin(v/V) without its loss of digits near +-90 deg.
    Some(Prediction { value: libm::atan2(v, root), row, noise_var, wraps: true })
}
