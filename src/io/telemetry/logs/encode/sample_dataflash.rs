//! The samples of a flight as ArduPilot logs them: PARM, MSG, IMU, ATT, AOA, BARO, ARSP, RCOU, RPM.
//!
//! Consumes samples in SI and radians, in order of time; produces a dataflash log. TimeUS is the time of the sample to the
//! nearest microsecond; a message comes as often as [`sample_rates`](super::sample_rates) allows; a channel that is not
//! due is NaN in it. Names, columns and units are ArduPilot's, columns that a simulated flight has no value for left out.
//! Airspeed is that at sea-level density, from the standard atmosphere at the last static pressure written, as ArduPilot's is;
//! without an altitude there is no airspeed that a reader could use. Controls are pulse widths of whole microseconds,
//! [`SCALES`], which the log states as parameters (see [`stated_controls`](super::super::mapping::stated_controls)): a step is
//! 0.02 degrees.
//! Source: ArduPilot, `LogStructure.h` of AP_Logger, AP_AHRS, AP_Baro, AP_RPM (4.5).
//! Refused: negative times, altitudes outside of the standard atmosphere's first layer, pulses that 16 bits do not hold.

use super::super::mapping::atmosphere::{RHO0, pressure_at, standard, temperature_at};
use super::super::mapping::stated_controls::StatedScale;
use super::LogEncodeError;
use super::dataflash::{DataflashCell, DataflashWriter};
use super::sample_rates::{DATAFLASH_IMU_HZ, LoggedKind, SampleRates};
use crate::flight::channel::{Channel, ControlNames};
use crate::flight::sample::Sample;

/// Outputs and scales of the controls, in the order of [`Channel::CONTROLS`]: as MAVLink's by default.
pub const SCALES: [StatedScale; 4] = [pulses(2), pulses(1), pulses(3), pulses(4)];

const fn pulses(output: usize) -> StatedScale {
    StatedScale { output, zero: 1500.0, degrees: 0.02 }
}

const PARM: u8 = 1;
const MSG: u8 = 2;
const IMU: u8 = 3;
const ATT: u8 = 4;
const AOA: u8 = 5;
const BARO: u8 = 6;
const ARSP: u8 = 7;
const RCOU: u8 = 8;
const RPM: u8 = 9;

/// Type, name, format characters, columns, units, multipliers.
const DEFINITIONS: [(u8, &str, &str, &str, &str, &str); 9] = [
    (PARM, "PARM", "QNff", "TimeUS,Name,Value,Default", "s---", "F---"),
    (MSG, "MSG", "QZ", "TimeUS,Message", "s-", "F-"),
    (IMU, "IMU", "QBffffffBB", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,GH,AH", "s#EEEooo--", "F-000000--"),
    (ATT, "ATT", "Qfff", "TimeUS,Roll,Pitch,Yaw", "sddh", "F000"),
    (AOA, "AOA", "Qff", "TimeUS,AOA,SSA", "sdd", "F00"),
    (BARO, "BARO", "QBffcB", "TimeUS,I,Alt,Press,Temp,H", "s#mPO-", "F-00B-"),
    (ARSP, "ARSP", "QBfBB", "TimeUS,I,Airspeed,U,H", "s#n--", "F-0--"),
    (RCOU, "RCOU", "QHHHH", "TimeUS,C1,C2,C3,C4", "sYYYY", "F----"),
    (RPM, "RPM", "QBffB", "TimeUS,I,RPM,Qual,H", "s#q--", "F-000"),
];

const LABELS: [(char, &str); 13] = [
    ('s', "s"),
    ('#', "instance"),
    ('E', "rad/s"),
    ('o', "m/s/s"),
    ('d', "deg"),
    ('h', "degheading"),
    ('n', "m/s"),
    ('P', "Pa"),
    ('m', "m"),
    ('O', "degC"),
    ('Y', "us"),
    ('q', "rpm"),
    ('-', ""),
];

/// A flight on its way into a log.
#[derive(Debug)]
struct SampleLog {
    writer: DataflashWriter,
    rates: SampleRates,
    /// Altitude of the first pressure, m.
    zero_m: Option<f64>,
    /// Density at the last pressure as a reader finds it, kg/m^3.
    density: Option<f64>,
}

/// The log of a flight; `about` says in a line what it is.
///
/// # Errors
/// [`LogEncodeError`] where a value does not fit.
pub fn dataflash_of_samples(samples: &[Sample], controls: ControlNames, about: &str) -> Result<Vec<u8>, LogEncodeError> {
    let mut log =
        SampleLog { writer: DataflashWriter::new(), rates: SampleRates::new(DATAFLASH_IMU_HZ), zero_m: None, density: None };
    log.head(controls, about)?;
    samples.iter().try_for_each(|sample| log.sample(sample))?;
    Ok(log.writer.bytes().to_vec())
}

fn number(value: Option<f64>) -> DataflashCell<'static> {
    DataflashCell::Number(value.unwrap_or(f64::NAN))
}

/// Microseconds of a time, s.
pub(super) fn microseconds(time_s: f64) -> Result<u64, LogEncodeError> {
    let time_us = libm::round(time_s * 1e6);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 2^52")]
    if (0.0..4.5e15).contains(&time_us) { Ok(time_us as u64) } else { Err(LogEncodeError::Time(time_s)) }
}

impl SampleLog {
    fn head(&mut self, controls: ControlNames, about: &str) -> Result<(), LogEncodeError> {
        self.writer.tables(&LABELS, &[('F', 1e-6), ('0', 1.0), ('B', 0.01), ('-', 0.0)])?;
        for (kind, name, characters, columns, units, multipliers) in DEFINITIONS {
            self.writer.define(kind, name, characters, columns)?;
            self.writer.units(kind, units, multipliers)?;
        }
        let begin = DataflashCell::Whole(0);
        // A message has 64 bytes.
        let line: String = about.chars().filter(char::is_ascii).take(64).collect();
        self.writer.message(MSG, &[begin, DataflashCell::Text(&line)])?;
        for (channel, scale) in Channel::CONTROLS.into_iter().zip(SCALES) {
            for (name, value) in scale.parameters(channel, controls).into_iter().flatten() {
                let name = DataflashCell::Text(&name);
                self.writer.message(PARM, &[begin, name, DataflashCell::Number(value), number(None)])?;
            }
        }
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), LogEncodeError> {
        let time = DataflashCell::Whole(microseconds(sample.time_s)?);
        let first = DataflashCell::Whole(0);
        let healthy = DataflashCell::Whole(1);
        let degrees = |due: &Sample, channel| number(due.get(channel).map(f64::to_degrees));
        if let Some(due) = self.rates.due(LoggedKind::Imu, sample) {
            let [p, q, r] = Channel::GYROS.map(|channel| number(due.get(channel)));
            let [ax, ay, az] = Channel::ACCELEROMETERS.map(|channel| number(due.get(channel)));
            self.writer.message(IMU, &[time, first, p, q, r, ax, ay, az, healthy, healthy])?;
        }
        if let Some(due) = self.rates.due(LoggedKind::Attitude, sample) {
            let heading = number(due.get(Channel::Psi).map(|psi| psi.to_degrees().rem_euclid(360.0)));
            self.writer.message(ATT, &[time, degrees(&due, Channel::Phi), degrees(&due, Channel::Theta), heading])?;
        }
        if let Some(due) = self.rates.due(LoggedKind::Flow, sample) {
            self.writer.message(AOA, &[time, degrees(&due, Channel::Alpha), degrees(&due, Channel::Beta)])?;
        }
        if self.rates.due(LoggedKind::Pressure, sample).is_some()
            && let Some(altitude) = sample.get(Channel::Altitude)
        {
            let pressure = pressure_at(altitude).ok_or(LogEncodeError::Altitude(altitude))?;
            #[expect(clippy::cast_possible_truncation, reason = "as the log holds it")]
            let read = f64::from(pressure as f32);
            self.density = standard(read).map(|(_, density)| density);
            let above = altitude - *self.zero_m.get_or_insert(altitude);
            let temperature = number(Some(temperature_at(altitude)));
            self.writer.message(BARO, &[time, first, number(Some(above)), number(Some(pressure)), temperature, healthy])?;
        }
        if let Some(due) = self.rates.due(LoggedKind::Airspeed, sample) {
            let indicated = due.get(Channel::Tas).zip(self.density).map(|(tas, density)| tas * libm::sqrt(density / RHO0));
            self.writer.message(ARSP, &[time, first, number(indicated), healthy, healthy])?;
        }
        if let Some(due) = self.rates.due(LoggedKind::Controls, sample) {
            let mut pulses = [DataflashCell::Whole(0); 4];
            for (channel, scale) in Channel::CONTROLS.into_iter().zip(SCALES) {
                if let (Some(angle), Some(pulse)) = (due.get(channel), pulses.get_mut(scale.output - 1)) {
                    *pulse = DataflashCell::Number(scale.output_at(angle));
                }
            }
            let [first, second, third, fourth] = pulses;
            self.writer.message(RCOU, &[time, first, second, third, fourth])?;
        }
        if let Some(due) = self.rates.due(LoggedKind::Rotor, sample) {
            let rpm = due.get(Channel::RotorSpeed).map(|speed| speed * 60.0 / std::f64::consts::TAU);
            self.writer.message(RPM, &[time, first, number(rpm), number(Some(1.0)), healthy])?;
        }
        Ok(())
    }
}
