//! R2 of the flow angles' rates against the kinematic rates from accelerometers, gyros and attitude, before and
//! after corrections.
//!
//! Consumes a record and parameters; produces R2 of `consistency` for incidence and sideslip: the slope of the corrected angle,
//! brought to where the accelerometers stand, beside the kinematic rate there, both smoothed by the same kernel of
//! [`HALF_WIDTH_S`]. A lag is taken for a skew of the same size. `None` where a channel is missing or hardly anything moves.

use super::parameter::{ACCELEROMETER_PLACE, ALPHA_PLACE, BETA_PLACE, INPUTS, Theta, VANE_PLACE};
use super::run_channels::RunChannels;
use crate::dynamics::sensors::{AirData, velocity_at_foot, velocity_of_air_data};
use crate::flight::signal::series::Series;
use crate::num::kernel::weights;
use crate::realtime::estimation::consistency::{Consistency, flow_angle_rates};

/// Half width of the smoothing kernel, s.
pub(crate) const HALF_WIDTH_S: f64 = 0.4;
/// Shorter ones are no gap, s.
const GAP_MIN_S: f64 = 0.25;

/// R2 of incidence and sideslip.
pub(crate) fn flow_angle_r2(record: &RunChannels, theta: &Theta) -> [Option<f64>; 2] {
    [1, 2].map(|output| of_angle(record, theta, output))
}

fn of_angle(record: &RunChannels, theta: &Theta, output: usize) -> Option<f64> {
    if !record.velocities {
        return None;
    }
    let angle = record.outputs.get(output)?.as_ref()?;
    let [vane, accelerometer] = [VANE_PLACE, ACCELEROMETER_PLACE].map(|from| theta.place(from));
    let alone = theta.place(if output == 1 { ALPHA_PLACE } else { BETA_PLACE });
    let arm: [f64; 3] =
        core::array::from_fn(|i| record.vane_place[i] + vane[i] + alone[i] - record.accelerometer_place[i] - accelerometer[i]);
    let half_s = (0.5 * record.sample_s).max(0.02);
    // Inputs and outputs alike: the corrected reading of a measured channel, `INPUTS` of them before the outputs.
    let read = |measured: usize, time_s: f64| -> Option<f64> {
        let series = match measured.checked_sub(INPUTS) {
            Some(output) => record.outputs.get(output),
            None => record.inputs.get(measured),
        };
        let series = series?.as_ref()?;
        let at_s = time_s + theta.skew_s(measured) + theta.lag_s(measured);
        Some((series.mean(at_s - half_s, at_s + half_s) - theta.bias(measured)) / theta.factor(measured))
    };
    let noise = angle.noise_std() / theta.factor(INPUTS + output);
    let measured = INPUTS + output;
    let late_s = theta.skew_s(measured) + theta.lag_s(measured);
    // At each sample: the angle at the accelerometers, and its rate.
    let mut times = Vec::new();
    let (mut angles, mut rates) = (Vec::new(), Vec::new());
    for (sampled_s, value) in angle.samples() {
        let time_s = sampled_s - late_s;
        let own = (value - theta.bias(measured)) / theta.factor(measured);
        let speed = read(INPUTS, time_s)?;
        let mut alpha = read(INPUTS + 1, time_s).unwrap_or(0.0);
        let mut beta = read(INPUTS + 2, time_s).unwrap_or(0.0);
        if output == 1 {
            alpha = own
        } else {
            beta = own
        }
        let [ax, ay, az, p, q, r] = [0, 1, 2, 3, 4, 5].map(|i| read(i, time_s).unwrap_or(0.0));
        let velocity = velocity_at_foot(velocity_of_air_data(speed, alpha, beta), [p, q, r], arm);
        let attitude = [read(INPUTS + 3, time_s).unwrap_or(0.0), read(INPUTS + 4, time_s).unwrap_or(0.0)];
        let [by_alpha, by_beta] = flow_angle_rates(velocity, attitude, [ax, ay, az], [p, q, r])?;
        times.push(time_s);
        angles.push(if output == 1 { AirData::Incidence } else { AirData::Sideslip }.value(velocity));
        rates.push(if output == 1 { by_alpha } else { by_beta });
    }
    let mut compared = Consistency::NEW;
    let (mut smooth, mut slope) = (Vec::new(), Vec::new());
    // Of what else enters: no line over a gap is taken for a motion.
    let longest = |series: &Series| series.interval_s().map_or(0.0, |interval_s| GAP_MIN_S.max(2.5 * interval_s));
    let used = record.inputs.iter().chain(record.outputs.iter().take(5)).flatten();
    let used: Vec<(&Series, f64)> = used.map(|series| (series, longest(series))).collect();
    let whole = |centre: f64| {
        let gap_s = |series: &Series| series.longest_gap_s(centre - HALF_WIDTH_S, centre + HALF_WIDTH_S);
        used.iter().all(|&(series, longest_s)| gap_s(series) <= longest_s)
    };
    for centre in (0..record.mesh.nodes).map(|node| record.mesh.time_s(node)).filter(|&centre| whole(centre)) {
        let from = times.partition_point(|&t| t < centre - HALF_WIDTH_S).saturating_sub(1);
        let to = (times.partition_point(|&t| t <= centre + HALF_WIDTH_S) + 1).min(times.len());
        let Some(window) = times.get(from..to) else { continue };
        smooth.resize(window.len(), 0.0);
        slope.resize(window.len(), 0.0);
        if !weights(window, centre, HALF_WIDTH_S, 0.25, &mut smooth, &mut slope) {
            continue;
        }
        let sum = |weights: &[f64], values: &[f64]| -> f64 {
            weights.iter().zip(values.get(from..to).unwrap_or(&[])).map(|(a, b)| a * b).sum()
        };
        let noise_var = noise * noise * slope.iter().map(|weight| weight * weight).sum::<f64>();
        compared.compare(sum(&slope, &angles), sum(&smooth, &rates), noise_var);
    }
    compared.r_squared()
}
