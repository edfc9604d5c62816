//! Flow-angle vanes as measurements of the air velocity where they stand.
//!
//! Consumes the air velocity where the instrument stands; produces the predicted reading and its row of H by (3) and (4) of
//! `sensors`.
//! Returns `None` below `AIRSPEED_MIN_M_S` along the plane of symmetry.

use crate::dynamics::sensors::AirData;
use crate::realtime::estimation::aid::prediction::{AIRSPEED_MIN_M_S, LocalVelocity, Prediction};
use crate::realtime::estimation::config::Noise;

/// Incidence with its row of H.
pub fn predict_incidence(local: &LocalVelocity, noise: &Noise) -> Option<Prediction> {
    predict(AirData::Incidence, local, noise.incidence_std)
}

/// Sideslip with its row of H.
pub fn predict_sideslip(local: &LocalVelocity, noise: &Noise) -> Option<Prediction> {
    predict(AirData::Sideslip, local, noise.sideslip_std)
}

fn predict(angle: AirData, local: &LocalVelocity, std: f64) -> Option<Prediction> {
    let [u, _, w] = local.velocity;
    if !(u * u + w * w > AIRSPEED_MIN_M_S * AIRSPEED_MIN_M_S) {
        return None;
    }
    let reading = angle.reading(local.velocity);
    Some(Prediction { value: reading.value, row: local.row(&reading), noise_var: std * std, wraps: true })
}
