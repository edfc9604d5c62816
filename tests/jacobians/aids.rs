//! Every aid's prediction, row of H and noise against the measurement equations in dual numbers.

use super::dual::Dual;
use super::states::{DRAWS, assert_close, draw, variables};
use crate::support::uniform::Uniform;
use sideslip::flight::run::RunGeometry;
use sideslip::realtime::estimation::aid::prediction::AIRSPEED_MIN_M_S;
use sideslip::realtime::estimation::aid::{inertial, predict};
use sideslip::realtime::estimation::config::EstimationConfig;
use sideslip::realtime::estimation::process::STATES;
use sideslip::realtime::estimation::record::Aid;

/// Velocity at `position`: that of the accelerometers, which the state holds, and omega x (position - accelerometers).
fn velocity_at(position: [f64; 3], accelerometers: [f64; 3], x: &[Dual; STATES]) -> [Dual; 3] {
    let omega = [x[7], x[8], x[9]];
    let arm: [Dual; 3] = std::array::from_fn(|i| Dual::constant(position[i]) - Dual::constant(accelerometers[i]));
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        x[i] + omega[j] * arm[k] - omega[k] * arm[j]
    })
}

/// What the aid reads, as the instruments are described.
fn published(aid: Aid, x: &[Dual; STATES], geometry: &RunGeometry) -> Dual {
    let vane = velocity_at(geometry.vane_position_m, geometry.accelerometer_position_m, x);
    let centre = velocity_at([0.0; 3], geometry.accelerometer_position_m, x);
    let speed = |[u, v, w]: [Dual; 3]| (u * u + v * v + w * w).sqrt();
    let scale: [Dual; 3] = std::array::from_fn(|i| Dual::constant(1.0) + x[22 + i]);
    match aid {
        Aid::Airspeed => scale[0] * speed(centre),
        Aid::Incidence => scale[1] * vane[2].atan2(vane[0]),
        Aid::Sideslip => scale[2] * (vane[1] / speed(vane)).asin(),
        Aid::Bank => x[3],
        Aid::Pitch => x[4],
        Aid::Heading => x[5],
        Aid::Altitude => x[6],
    }
}

fn std_of(aid: Aid, config: &EstimationConfig) -> f64 {
    let n = &config.noise;
    match aid {
        Aid::Airspeed => n.airspeed_std,
        Aid::Incidence => n.incidence_std,
        Aid::Sideslip => n.sideslip_std,
        Aid::Bank => n.bank_std,
        Aid::Pitch => n.pitch_std,
        Aid::Heading => n.heading_std,
        Aid::Altitude => n.altitude_std,
    }
}

#[test]
fn predictions_rows_and_noise_are_the_published_ones() {
    let mut uniform = Uniform(43);
    let config = EstimationConfig::default();
    let mut compared = [0; Aid::ALL.len()];
    for draw_number in 0..DRAWS {
        let state = draw(&mut uniform);
        // Every fourth draw has the instruments at the centre of mass, as most runs do.
        let arm = if draw_number % 4 == 0 { 0.0 } else { 1.0 };
        let geometry = RunGeometry {
            accelerometer_position_m: [2.0, 1.0, 1.0].map(|half| arm * uniform.within(half)),
            vane_position_m: [15.0, 3.0, 3.0].map(|half| arm * uniform.within(half)),
            ..RunGeometry::default()
        };
        let x = variables(&state);
        for aid in Aid::ALL {
            let Some(found) = predict(aid, &state, &geometry, &config.noise) else { continue };
            compared[aid.index()] += 1;
            let expected = published(aid, &x, &geometry);
            let what = |entry: &str| format!("{aid:?} {entry} at {state:?} {geometry:?}");
            assert_close(found.value, expected.value, &|| what("value"));
            for j in 0..STATES {
                assert_close(found.row[j], expected.partials[j], &|| what(&format!("row {j}")));
            }
            let own = std_of(aid, &config);
            assert_close(found.noise_var, own * own, &|| what("noise"));
            assert!(found.noise_var > 0.0);
            let angle = !matches!(aid, Aid::Airspeed | Aid::Altitude);
            assert_eq!(found.wraps, angle);
        }
    }
    assert!(compared.iter().all(|&count| count > DRAWS * 9 / 10), "{compared:?}");
}

#[test]
fn gyros_and_accelerometers_read_their_rate_or_force_and_their_bias() {
    let mut uniform = Uniform(45);
    let mut noise = EstimationConfig::default().noise;
    (noise.gyro_std, noise.accelerometer_std) = ([0.1, 0.2, 0.3], [0.4, 0.5, 0.6]);
    for _ in 0..100 {
        let state = draw(&mut uniform);
        let x = variables(&state);
        for place in 0..6 {
            let (truth, bias) = if place < 3 { (x[7 + place], x[19 + place]) } else { (x[10 + place], x[13 + place]) };
            let (found, expected) = (inertial::predict(place, &state, &noise), truth + bias);
            assert_close(found.value, expected.value, &|| format!("{place}"));
            assert_eq!(found.row[..], expected.partials[..STATES]);
            let std = 0.1 * (place + 1) as f64;
            assert_close(found.noise_var, std * std, &|| format!("noise of {place}"));
            assert!(!found.wraps);
        }
    }
}

#[test]
fn readings_that_mean_nothing_at_low_speed_are_refused() {
    let config = EstimationConfig::default();
    let geometry = RunGeometry::default();
    let mut uniform = Uniform(44);
    let mut refused = 0;
    for _ in 0..DRAWS {
        let mut state = draw(&mut uniform);
        for velocity in &mut state[..3] {
            *velocity *= 0.1;
        }
        let [u, v, w, ..] = state;
        let speed = (u * u + v * v + w * w).sqrt();
        let in_symmetry = (u * u + w * w).sqrt();
        let some = |aid| predict(aid, &state, &geometry, &config.noise).is_some();
        assert_eq!(some(Aid::Airspeed), speed > AIRSPEED_MIN_M_S);
        assert_eq!(some(Aid::Incidence), in_symmetry > AIRSPEED_MIN_M_S);
        assert_eq!(some(Aid::Sideslip), in_symmetry > AIRSPEED_MIN_M_S);
        assert!(some(Aid::Bank) && some(Aid::Pitch) && some(Aid::Heading) && some(Aid::Altitude));
        refused += usize::from(speed <= AIRSPEED_MIN_M_S);
    }
    assert!(refused > 100, "{refused}");
}
