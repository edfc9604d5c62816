//! True airspeed as a measurement of the air velocity at the centre of mass.
//!
//! Consumes the air velocity where the instrument stands; produces the predicted reading and its row of H.
//!     tas = sqrt(u^2 + v^2 + w^2)                                                                 (1)
//! Returns `None` below `AIRSPEED_MIN_M_S`.

use crate::realtime::estimation::aid::{AIRSPEED_MIN_M_S, LocalVelocity, Prediction};
use crate::realtime::estimation::config::Noise;

/// (1) with its row of H.
pub fn predict(local: &LocalVelocity, noise: &Noise) -> Option<Prediction> {
    let [u, v, w] = local.velocity;
    let value = libm::sqrt(u * u + v * v + w * w);
    if !(value > AIRSPEED_MIN_M_S) {
        return None;
    }
    let row = local.row([u / value, v / value, w / value]);
    Some(Prediction { value, row, noise_var: noise.airspeed_std * noise.airspeed_std, wraps: false })
}
