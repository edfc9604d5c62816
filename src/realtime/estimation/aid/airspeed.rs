//! True airspeed as a measurement of the air velocity at the centre of mass.
//!
//! Consumes the air velocity where the instrument stands; produces the predicted reading and its row of H.
//! Its equation is (2) of `sensors`.
//! Returns `None` below `AIRSPEED_MIN_M_S`.

use crate::dynamics::sensors::{AirData, AirDataReading};
use crate::realtime::estimation::aid::prediction::{AIRSPEED_MIN_M_S, LocalVelocity, Prediction};
use crate::realtime::estimation::config::Noise;

/// Airspeed with its row of H.
pub fn predict(local: &LocalVelocity, noise: &Noise) -> Option<Prediction> {
    let value = AirData::Airspeed.value(local.velocity);
    if !(value > AIRSPEED_MIN_M_S) {
        return None;
    }
    let row = local.row(&AirDataReading::of_airspeed(value, local.velocity));
    Some(Prediction { value, row, noise_var: noise.airspeed_std * noise.airspeed_std, wraps: false })
}
