//! What a filter over a recorded run starts from: means of the first readings, and the velocity of measured air data.

use crate::dynamics::sensors::velocity_of_air_data;
use crate::flight::signal::series::Series;

/// The mean over this interval starts a filter, s.
const INTERVAL_S: f64 = 0.2;
/// Least airspeed at the start, m/s: flow angles need one.
const AIRSPEED_MIN_M_S: f64 = 3.0;

/// Mean of a channel from that time on.
pub(crate) fn start_reading(series: &Series, time_s: f64) -> f64 {
    series.mean(time_s, time_s + INTERVAL_S)
}

/// u, v, w of the air data, m/s and rad.
pub(crate) fn start_velocity(airspeed: f64, alpha: f64, beta: f64) -> [f64; 3] {
    velocity_of_air_data(airspeed.max(AIRSPEED_MIN_M_S), alpha, beta)
}
