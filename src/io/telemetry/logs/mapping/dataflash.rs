//! Channels from the messages of an ArduPilot dataflash log.
//!
//! Consumes [`DataflashMessage`]s; produces [`LogRow`]s. Units are those that the log's FMTU names, converted once; where it
//! names none, those of ArduPilot's documentation. Time is TimeUS: when the message was written. [`SOURCES`] says of each
//! message what it is: attitude, flow angles and wind are the autopilot's estimates, servo outputs its commands. True airspeed
//! from ARSP, which is calibrated for sea-level density, with the standard density at the pressure of BARO:
//!     tas = ias sqrt(rho0 / rho(p))                                                                   (1)
//! Source: ArduPilot, "Onboard Message Log Messages" (Plane 3.8 to 4.5).

use super::super::dataflash::message::DataflashMessage;
use super::atmosphere::{RHO0, standard};
use super::gate::{LogGroup, LogOffer, RowGate, SILENCE_US};
use super::stated_controls::StatedControls;
use super::{ALTITUDE, ANGLES, FLOW, FORCES, GPS, HEIGHT, IAS, RATES, ROTOR, SERVOS, TAS, WIND, channel};
use super::{LogChannel, LogMappingTally, LogNature, LogRow, LogSource};

static IMU_FORCE: LogSource =
    source("IMU", "ax ay az", LogNature::Instrument, "accelerometers, calibrated, moved to no other place");
static IMU_RATES: LogSource = source("IMU", "p q r", LogNature::Instrument, "gyros, with their calibrated offsets taken off");
static ATTITUDE: LogSource = source(
    "ATT",
    "phi theta psi",
    LogNature::Estimate,
    "attitude of the autopilot's filter, heading from 0 to 2 pi; older logs round to 0.01 deg",
);
static AIRSPEED: LogSource =
    source("ARSP", "ias", LogNature::Instrument, "airspeed at sea-level density, from differential pressure");
static TRUE_AIRSPEED: LogSource =
    source("ARSP", "tas", LogNature::Processed, "by (1): 10 K off the standard temperature make 1.8 %");
static FLOW_ANGLES: LogSource = source(
    "AOA",
    "alpha beta",
    LogNature::Estimate,
    "from inertial velocity and estimated wind; no vanes, which the log never has",
);
static PRESSURE_ALTITUDE: LogSource =
    source("BARO", "altitude", LogNature::Instrument, "pressure altitude from its static pressure");
static BAROMETRIC_HEIGHT: LogSource =
    source("BARO", "barometric_height", LogNature::Processed, "above where the barometer was zeroed; corrected for temperature");
static ROTOR_SPEED: LogSource =
    source("RPM", "rotor_speed", LogNature::Instrument, "the first of its sensors, of whatever shaft that is");
static SERVO_OUTPUTS: LogSource =
    source("RCOU", "servo_1 to servo_16", LogNature::Command, "pulse widths sent to servos, us; no positions");
static STATED_CONTROLS: LogSource =
    source("RCOU", "controls in rad", LogNature::Command, "servo outputs by the scale that parameters SIDESLIP_... state");
static DEMANDS: LogSource =
    source("AETR", "..._command", LogNature::Command, "demands before mixing, counts of 4500 (throttle: percent)");
static POSITION: LogSource =
    source("GPS", "gps_...", LogNature::Instrument, "the receiver's own filtered solution, later than its time stamp says");
static WIND_ESTIMATE: LogSource =
    source("XKF2", "wind_north wind_east", LogNature::Estimate, "of the first core of the autopilot's filter (or NKF2)");

/// What each message gives; the first of a kind is preferred.
pub static SOURCES: [&LogSource; 14] = [
    &IMU_FORCE,
    &IMU_RATES,
    &ATTITUDE,
    &AIRSPEED,
    &TRUE_AIRSPEED,
    &FLOW_ANGLES,
    &PRESSURE_ALTITUDE,
    &BAROMETRIC_HEIGHT,
    &ROTOR_SPEED,
    &SERVO_OUTPUTS,
    &STATED_CONTROLS,
    &DEMANDS,
    &POSITION,
    &WIND_ESTIMATE,
];

const fn source(message: &'static str, channels: &'static str, nature: LogNature, note: &'static str) -> LogSource {
    LogSource { message, channels, nature, note }
}

const COMMANDS: [(&str, LogChannel); 4] = [
    ("Ail", channel("aileron_command", "count")),
    ("Elev", channel("elevator_command", "count")),
    ("Thr", channel("throttle_command", "percent")),
    ("Rudd", channel("rudder_command", "count")),
];

const RCOU_FIELDS: [&str; 16] =
    ["C1", "C2", "C3", "C4", "C5", "C6", "C7", "C8", "C9", "C10", "C11", "C12", "C13", "C14", "C15", "C16"];

/// What a field measures; with the unit that it has where the log names none.
#[derive(Clone, Copy, Debug)]
enum Measure {
    /// rad/s.
    Rate,
    /// m/s^2.
    Acceleration,
    /// deg.
    Angle,
    /// m/s.
    Speed,
    /// Pa.
    Pressure,
    /// m.
    Length,
    /// Taken as it stands.
    Any,
}

impl Measure {
    /// SI for one of that unit of the log.
    fn factor(self, unit: Option<&str>) -> Option<f64> {
        const DEGREE: f64 = std::f64::consts::PI / 180.0;
        Some(match (self, unit) {
            (Measure::Rate, None | Some("rad/s")) => 1.0,
            (Measure::Rate, Some("deg/s")) => DEGREE,
            (Measure::Acceleration, None | Some("m/s/s" | "m/s^2")) => 1.0,
            (Measure::Angle, None | Some("deg" | "degheading")) => DEGREE,
            (Measure::Angle, Some("rad")) => 1.0,
            (Measure::Speed, None | Some("m/s")) => 1.0,
            (Measure::Pressure, None | Some("Pa")) => 1.0,
            (Measure::Length, None | Some("m")) => 1.0,
            (Measure::Any, _) => 1.0,
            _ => return None,
        })
    }
}

/// Maps messages.
#[derive(Debug, Default)]
pub struct DataflashMapping {
    gate: RowGate,
    /// Static pressure, Pa, and when it was written, us.
    pressure: Option<(f64, u64)>,
    stated: StatedControls,
}

impl DataflashMapping {
    /// Nothing seen yet.
    pub fn new() -> Self {
        DataflashMapping::default()
    }

    /// What was handed on and what not.
    pub fn tally(&self) -> LogMappingTally {
        self.gate.tally
    }

    /// No more messages will come.
    pub fn finish(&mut self) {
        self.gate.finish();
    }

    /// Hands on the rows of a message.
    pub fn map(&mut self, message: &DataflashMessage<'_>, mut put: impl FnMut(LogRow)) {
        let put = &mut put;
        let name = message.name();
        // Before there was a column for it, the number of an instrument stood in the name: IMU2 is the second.
        let (stem, instance) = match name.split_at_checked(3) {
            Some(("IMU", number @ ("2" | "3"))) => ("IMU", u64::from(number == "3") + 1),
            Some(("BAR", number @ ("2" | "3"))) => ("BARO", u64::from(number == "3") + 1),
            _ => (name, message.instance().unwrap_or_default()),
        };
        let Ok(instance) = u8::try_from(instance) else { return };
        match stem {
            "IMU" => {
                let accelerations = [("AccX", FORCES[0]), ("AccY", FORCES[1]), ("AccZ", FORCES[2])];
                let rates = [("GyrX", RATES[0]), ("GyrY", RATES[1]), ("GyrZ", RATES[2])];
                if self.healthy(message, "AH") {
                    self.give(message, &IMU_FORCE, LogGroup::Force, instance, &accelerations, Measure::Acceleration, put);
                }
                if self.healthy(message, "GH") {
                    self.give(message, &IMU_RATES, LogGroup::Rates, instance, &rates, Measure::Rate, put);
                }
            }
            "ATT" => {
                let angles = [("Roll", ANGLES[0]), ("Pitch", ANGLES[1]), ("Yaw", ANGLES[2])];
                self.give(message, &ATTITUDE, LogGroup::Attitude, instance, &angles, Measure::Angle, put);
            }
            "ARSP" if self.healthy(message, "H") => self.airspeed(message, instance, put),
            "AOA" => {
                let angles = [("AOA", FLOW[0]), ("SSA", FLOW[1])];
                self.give(message, &FLOW_ANGLES, LogGroup::Flow, instance, &angles, Measure::Angle, put);
            }
            "BARO" if self.healthy(message, "H") => self.barometer(message, instance, put),
            "RPM" if instance == 0 => {
                let rpm = self.value(message, "rpm1", Measure::Any).or_else(|| self.value(message, "RPM", Measure::Any));
                let values = rpm.map(|rpm| (ROTOR, rpm * std::f64::consts::TAU / 60.0));
                self.offer(message, &ROTOR_SPEED, LogGroup::Rotor, instance, values.as_slice(), put);
            }
            "RCOU" => {
                let mut fields = [("", ALTITUDE); 16];
                for (place, (field, name)) in fields.iter_mut().zip(RCOU_FIELDS.into_iter().zip(SERVOS)) {
                    *place = (field, channel(name, "us"));
                }
                self.give(message, &SERVO_OUTPUTS, LogGroup::Servos, instance, &fields, Measure::Any, put);
                let output = |number: usize| {
                    let field = RCOU_FIELDS.get(number.wrapping_sub(1))?;
                    message.field(field).and_then(|output| output.scaled)
                };
                let (angles, count) = self.stated.angles(output);
                self.offer(message, &STATED_CONTROLS, LogGroup::Controls, instance, angles.get(..count).unwrap_or_default(), put);
            }
            "PARM" => {
                let name =
                    message.field("Name").and_then(|name| name.value.text()).and_then(|text| core::str::from_utf8(text).ok());
                let value = message.field("Value").and_then(|value| value.value.number());
                if let (Some(name), Some(value)) = (name, value) {
                    self.stated.parameter(name, value);
                }
            }
            "AETR" => self.give(message, &DEMANDS, LogGroup::Demands, instance, &COMMANDS, Measure::Any, put),
            "GPS" if instance == 0 => self.position(message, put),
            "XKF2" | "NKF2" if message.field("C").and_then(|core| core.value.number()).is_none_or(|core| core <= 0.0) => {
                let wind = [("VWN", WIND[0]), ("VWE", WIND[1])];
                let rank = u8::from(stem == "NKF2");
                self.give(message, &WIND_ESTIMATE, LogGroup::Wind, rank, &wind, Measure::Speed, put);
            }
            _ => {}
        }
    }

    /// Whether the autopilot trusts the instrument; where it says nothing it does.
    fn healthy(&mut self, message: &DataflashMessage<'_>, field: &str) -> bool {
        let healthy = message.field(field).and_then(|health| health.value.number()).is_none_or(|health| health > 0.0);
        self.gate.tally.unhealthy += u64::from(!healthy);
        healthy
    }

    fn value(&mut self, message: &DataflashMessage<'_>, field: &str, measure: Measure) -> Option<f64> {
        let reading = message.field(field)?;
        let value = reading.scaled?;
        let factor = measure.factor(reading.unit);
        self.gate.tally.wrong_unit += u64::from(factor.is_none());
        factor.map(|factor| value * factor)
    }

    /// Offers fields of one measure, each as a channel.
    #[expect(clippy::too_many_arguments, reason = "a table's row, spelt out")]
    fn give(
        &mut self,
        message: &DataflashMessage<'_>,
        source: &'static LogSource,
        group: LogGroup,
        instance: u8,
        fields: &[(&str, LogChannel)],
        measure: Measure,
        put: &mut impl FnMut(LogRow),
    ) {
        let mut values = [(ALTITUDE, 0.0); 16];
        let mut count = 0;
        for (field, channel) in fields {
            if let (Some(value), Some(place)) = (self.value(message, field, measure), values.get_mut(count)) {
                *place = (*channel, value);
                count += 1;
            }
        }
        self.offer(message, source, group, instance, values.get(..count).unwrap_or_default(), put);
    }

    fn offer(
        &mut self,
        message: &DataflashMessage<'_>,
        source: &'static LogSource,
        group: LogGroup,
        instance: u8,
        values: &[(LogChannel, f64)],
        put: &mut impl FnMut(LogRow),
    ) {
        let rank = usize::from(instance);
        self.gate.offer(LogOffer { source, group, rank, instance }, message.time_us(), values, put);
    }

    fn airspeed(&mut self, message: &DataflashMessage<'_>, instance: u8, put: &mut impl FnMut(LogRow)) {
        let Some(indicated) = self.value(message, "Airspeed", Measure::Speed) else { return };
        self.offer(message, &AIRSPEED, LogGroup::IndicatedAirspeed, instance, &[(IAS, indicated)], put);
        let now_us = message.time_us().unwrap_or_default();
        let recent = self.pressure.filter(|(_, then_us)| then_us.abs_diff(now_us) <= SILENCE_US);
        match recent.and_then(|(pressure, _)| standard(pressure)) {
            Some((_, rho)) => {
                let tas = indicated * libm::sqrt(RHO0 / rho);
                self.offer(message, &TRUE_AIRSPEED, LogGroup::Airspeed, instance, &[(TAS, tas)], put);
            }
            None => self.gate.tally.no_density += 1,
        }
    }

    fn barometer(&mut self, message: &DataflashMessage<'_>, instance: u8, put: &mut impl FnMut(LogRow)) {
        if let Some(pressure) = self.value(message, "Press", Measure::Pressure) {
            match standard(pressure) {
                Some((altitude, _)) => {
                    if instance == 0
                        && let Some(time_us) = message.time_us()
                    {
                        self.pressure = Some((pressure, time_us));
                    }
                    self.offer(message, &PRESSURE_ALTITUDE, LogGroup::Altitude, instance, &[(ALTITUDE, altitude)], put);
                }
                None => self.gate.tally.not_a_number += 1,
            }
        }
        self.give(message, &BAROMETRIC_HEIGHT, LogGroup::BarometricHeight, instance, &[("Alt", HEIGHT)], Measure::Length, put);
    }

    fn position(&mut self, message: &DataflashMessage<'_>, put: &mut impl FnMut(LogRow)) {
        let fix = message.field("Status").and_then(|status| status.value.number());
        if fix.is_some_and(|fix| fix < 3.0) {
            self.gate.tally.no_fix += 1;
            return;
        }
        let fields = [
            ("Lat", GPS[0], Measure::Any),
            ("Lng", GPS[1], Measure::Any),
            ("Alt", GPS[2], Measure::Length),
            ("Spd", GPS[3], Measure::Speed),
            ("GCrs", GPS[4], Measure::Angle),
            ("VZ", GPS[5], Measure::Speed),
        ];
        let mut values = [(ALTITUDE, 0.0); 6];
        let mut count = 0;
        for (field, channel, measure) in fields {
            if let (Some(value), Some(place)) = (self.value(message, field, measure), values.get_mut(count)) {
                // The log counts vertical speed positive down.
                *place = (channel, if field == "VZ" { -value } else { value });
                count += 1;
            }
        }
        self.offer(message, &POSITION, LogGroup::Position, 0, values.get(..count).unwrap_or_default(), put);
    }
}
