//! The samples of a flight as PX4 logs them: sensor_combined, vehicle_attitude, vehicle_air_data, airspeed, actuator_servos, rpm,
//! debug_vect.
//!
//! Consumes samples in SI and radians, in order of time; produces a ULog. Time is that of the sample to the nearest microsecond,
//! in `timestamp` and, where the topic has one, `timestamp_sample`; a topic comes as often as
//! [`sample_rates`](super::sample_rates) allows; a channel that is not due is NaN in it. Topics, fields and units are
//! PX4's (v1.15), in the order of size that its logger writes; fields that a simulated flight has no value for are left out. PX4
//! has no topic of vanes: incidence and sideslip are x and y of a `debug_vect` called `flow`. Controls are deflections demanded
//! of `actuator_servos`, 1 for 30 degrees ([`SCALES`]), which the log states as parameters (see
//! [`stated_controls`](super::super::mapping::stated_controls)). A sample without all three attitude angles has no quaternion.
//! Source: PX4 User Guide, "uORB Message Reference", "ULog File Format".
//! Refused: negative times, altitudes outside of the standard atmosphere's first layer.

use super::super::mapping::atmosphere::{RHO0, pressure_at, standard, temperature_at};
use super::super::mapping::stated_controls::StatedScale;
use super::super::mapping::ulog::FLOW_VECTOR;
use super::LogEncodeError;
use super::flight::quaternion;
use super::sample_dataflash::microseconds;
use super::sample_rates::{LoggedKind, SampleRates, ULOG_IMU_HZ};
use super::ulog::UlogWriter;
use crate::flight::channel::{Channel, ControlNames};
use crate::flight::sample::Sample;

/// Outputs and scales of the controls, in the order of [`Channel::CONTROLS`].
pub const SCALES: [StatedScale; 4] = [servo(2), servo(1), servo(3), servo(4)];

const fn servo(output: usize) -> StatedScale {
    StatedScale { output, zero: 0.0, degrees: 30.0 }
}

const SENSORS: u16 = 0;
const ATTITUDE: u16 = 1;
const AIR_DATA: u16 = 2;
const AIRSPEED: u16 = 3;
const SERVOS: u16 = 4;
const ROTOR: u16 = 5;
const VECTOR: u16 = 6;

/// In the order of their numbers.
const FORMATS: [&str; 7] = [
    "sensor_combined:uint64_t timestamp;float[3] gyro_rad;int32_t accelerometer_timestamp_relative;\
     float[3] accelerometer_m_s2;uint8_t[4] _padding0;",
    "vehicle_attitude:uint64_t timestamp;uint64_t timestamp_sample;float[4] q;",
    "vehicle_air_data:uint64_t timestamp;uint64_t timestamp_sample;float baro_alt_meter;float baro_pressure_pa;float rho;\
     float ambient_temperature;",
    "airspeed:uint64_t timestamp;uint64_t timestamp_sample;float indicated_airspeed_m_s;float true_airspeed_m_s;",
    "actuator_servos:uint64_t timestamp;uint64_t timestamp_sample;float[8] control;",
    "rpm:uint64_t timestamp;float rpm_estimate;float rpm_raw;",
    "debug_vect:uint64_t timestamp;float x;float y;float z;char[10] name;uint8_t[2] _padding0;",
];
/// Every so many samples a place to begin at.
const SYNC_EVERY: usize = 500;

/// The log of a flight; `about` says in a line what it is.
///
/// # Errors
/// [`LogEncodeError`] where a value does not fit.
pub fn ulog_of_samples(samples: &[Sample], controls: ControlNames, about: &str) -> Result<Vec<u8>, LogEncodeError> {
    let start_us = samples.first().map_or(Ok(0), |sample| microseconds(sample.time_s))?;
    let mut writer = UlogWriter::new(start_us);
    writer.keyed(b'I', &format!("char[{}] sys_name", about.len()), about.as_bytes())?;
    for (channel, scale) in Channel::CONTROLS.into_iter().zip(SCALES) {
        for (name, value) in scale.parameters(channel, controls).into_iter().flatten() {
            writer.keyed(b'P', &format!("float {name}"), &single(&[value]))?;
        }
    }
    FORMATS.iter().try_for_each(|format| writer.format(format))?;
    for (id, format) in (0..).zip(FORMATS) {
        writer.subscribe(0, id, format.split(':').next().unwrap_or_default())?;
    }
    let mut rates = SampleRates::new(ULOG_IMU_HZ);
    for (count, sample) in samples.iter().enumerate() {
        if count % SYNC_EVERY == 0 {
            writer.sync();
        }
        one(&mut writer, &mut rates, sample)?;
    }
    Ok(writer.bytes().to_vec())
}

fn single(values: &[f64]) -> Vec<u8> {
    #[expect(clippy::cast_possible_truncation, reason = "the nearest single-precision number is meant")]
    values.iter().flat_map(|value| (*value as f32).to_le_bytes()).collect()
}

fn one(writer: &mut UlogWriter, rates: &mut SampleRates, sample: &Sample) -> Result<(), LogEncodeError> {
    let time = microseconds(sample.time_s)?.to_le_bytes();
    let at = |due: &Sample, channel| due.get(channel).unwrap_or(f64::NAN);
    if let Some(due) = rates.due(LoggedKind::Imu, sample) {
        let (gyros, forces) = (Channel::GYROS.map(|c| at(&due, c)), Channel::ACCELEROMETERS.map(|c| at(&due, c)));
        writer.data(SENSORS, &[&time, &single(&gyros), &0_i32.to_le_bytes(), &single(&forces)])?;
    }
    if let (Some(phi), Some(theta), Some(psi)) = (sample.get(Channel::Phi), sample.get(Channel::Theta), sample.get(Channel::Psi))
        && rates.due(LoggedKind::Attitude, sample).is_some()
    {
        writer.data(ATTITUDE, &[&time, &time, &single(&quaternion([phi, theta, psi]))])?;
    }
    if rates.due(LoggedKind::Pressure, sample).is_some()
        && let Some(altitude) = sample.get(Channel::Altitude)
    {
        let pressure = pressure_at(altitude).ok_or(LogEncodeError::Altitude(altitude))?;
        let density = sample.get(Channel::Rho).or_else(|| standard(pressure).map(|(_, density)| density));
        let air = [altitude, pressure, density.unwrap_or(f64::NAN), temperature_at(altitude)];
        writer.data(AIR_DATA, &[&time, &time, &single(&air)])?;
    }
    if let Some(due) = rates.due(LoggedKind::Airspeed, sample) {
        let density = sample.get(Channel::Altitude).and_then(pressure_at).and_then(standard);
        let indicated = density.map_or(f64::NAN, |(_, density)| at(&due, Channel::Tas) * libm::sqrt(density / RHO0));
        writer.data(AIRSPEED, &[&time, &time, &single(&[indicated, at(&due, Channel::Tas)])])?;
    }
    if let Some(due) = rates.due(LoggedKind::Controls, sample) {
        let mut demands = [f64::NAN; 8];
        for (channel, scale) in Channel::CONTROLS.into_iter().zip(SCALES) {
            if let (Some(angle), Some(demand)) = (due.get(channel), demands.get_mut(scale.output - 1)) {
                *demand = scale.output_at(angle);
            }
        }
        writer.data(SERVOS, &[&time, &time, &single(&demands)])?;
    }
    if let Some(due) = rates.due(LoggedKind::Rotor, sample) {
        let rpm = at(&due, Channel::RotorSpeed) * 60.0 / std::f64::consts::TAU;
        writer.data(ROTOR, &[&time, &single(&[rpm, rpm])])?;
    }
    if let Some(due) = rates.due(LoggedKind::Flow, sample) {
        let mut name = [0; 10];
        name.iter_mut().zip(FLOW_VECTOR.bytes()).for_each(|(place, byte)| *place = byte);
        writer.data(VECTOR, &[&time, &single(&[at(&due, Channel::Alpha), at(&due, Channel::Beta), 0.0]), &name])?;
    }
    Ok(())
}
