//! Channels from the topics of a PX4 ULog.
//!
//! Consumes [`UlogData`]; produces [`LogRow`]s. ULog names no units: those of PX4's topics are taken (SI, radians; angles of
//! attitude from a quaternion). Time is `timestamp_sample`, of the measurement, where the topic has one, else `timestamp`, of
//! its publication; accelerometers of `sensor_combined` have a time of their own, relative to that of the gyros. [`SOURCES`]
//! says of each topic what it is: attitude, wind and density are the autopilot's estimates, actuators its commands.
//! Source: PX4 User Guide, "uORB Message Reference" (v1.11 to v1.15).

use super::super::ulog::keyed::UlogKeyed;
use super::super::ulog::message::UlogData;
use super::super::ulog::value::UlogValue;
use super::atmosphere::{angles, standard};
use super::gate::{LogGroup, LogOffer, RowGate};
use super::stated_controls::StatedControls;
use super::{
    ALTITUDE, ANGLES, FLOW, FORCES, GPS, HEIGHT, IAS, MOTORS, OUTPUTS, RATES, RHO, ROTOR, SECOND_OUTPUTS, SERVOS, TAS, WIND,
};
use super::{LogChannel, LogMappingTally, LogNature, LogRow, LogSource};

static COMBINED_FORCE: LogSource =
    source("sensor_combined", "ax ay az", LogNature::Instrument, "accelerometers, calibrated, averaged since the sample before");
static COMBINED_RATES: LogSource =
    source("sensor_combined", "p q r", LogNature::Instrument, "gyros, calibrated, averaged since the sample before");
static ACCELERATION: LogSource =
    source("vehicle_acceleration", "ax ay az", LogNature::Processed, "less the estimated bias, low-pass filtered");
static ANGULAR_VELOCITY: LogSource =
    source("vehicle_angular_velocity", "p q r", LogNature::Processed, "less the estimated bias, low-pass filtered");
static ATTITUDE: LogSource =
    source("vehicle_attitude", "phi theta psi", LogNature::Estimate, "attitude of the autopilot's filter");
static AIRSPEED: LogSource =
    source("airspeed", "ias", LogNature::Instrument, "airspeed as indicated, from differential pressure");
static TRUE_AIRSPEED: LogSource =
    source("airspeed", "tas", LogNature::Processed, "true airspeed with measured pressure and temperature of the air");
static VALIDATED_AIRSPEED: LogSource =
    source("airspeed_validated", "tas", LogNature::Estimate, "with an estimated scale, or made of ground speed and wind");
static PRESSURE_ALTITUDE: LogSource =
    source("vehicle_air_data", "altitude", LogNature::Instrument, "pressure altitude from its static pressure");
static BAROMETRIC_HEIGHT: LogSource = source(
    "vehicle_air_data",
    "barometric_height",
    LogNature::Processed,
    "altitude by the pressure at sea level that the autopilot was given",
);
static DENSITY: LogSource =
    source("vehicle_air_data", "rho", LogNature::Estimate, "density of the air, from pressure and a temperature of the sensor");
static ACTUATOR_OUTPUTS: LogSource = source(
    "actuator_outputs",
    "output_1 to output_16, second_output_1 to second_output_16",
    LogNature::Command,
    "sent to outputs: pulse widths in us, or as their driver counts; `second_` of the topic's second instance",
);
static ACTUATOR_MOTORS: LogSource =
    source("actuator_motors", "motor_1 to motor_12", LogNature::Command, "thrust demanded, 1 is all of it; no speed");
static ACTUATOR_SERVOS: LogSource =
    source("actuator_servos", "servo_1 to servo_8", LogNature::Command, "deflection demanded, from -1 to 1; no positions");
static STATED_CONTROLS: LogSource = source(
    "actuator_servos",
    "controls in rad",
    LogNature::Command,
    "deflection demanded, by the scale that parameters SIDESLIP_... state",
);
static VANES: LogSource = source(
    "debug_vect",
    "alpha beta",
    LogNature::Instrument,
    "x and y of the vector called `flow`, rad: how vanes, of which PX4 has no topic, are logged",
);
static ROTOR_SPEED: LogSource =
    source("rpm", "rotor_speed", LogNature::Instrument, "measured, of the first sensor, of whatever shaft that is");
static WIND_ESTIMATE: LogSource =
    source("wind", "wind_north wind_east", LogNature::Estimate, "of the autopilot's filter (or wind_estimate, estimator_wind)");
static POSITION: LogSource =
    source("vehicle_gps_position", "gps_...", LogNature::Instrument, "the receiver's own filtered solution");

/// What each topic gives.
pub static SOURCES: [&LogSource; 19] = [
    &COMBINED_FORCE,
    &COMBINED_RATES,
    &ACCELERATION,
    &ANGULAR_VELOCITY,
    &ATTITUDE,
    &AIRSPEED,
    &TRUE_AIRSPEED,
    &VALIDATED_AIRSPEED,
    &PRESSURE_ALTITUDE,
    &BAROMETRIC_HEIGHT,
    &DENSITY,
    &ACTUATOR_OUTPUTS,
    &ACTUATOR_MOTORS,
    &ACTUATOR_SERVOS,
    &STATED_CONTROLS,
    &VANES,
    &ROTOR_SPEED,
    &WIND_ESTIMATE,
    &POSITION,
];

const fn source(message: &'static str, channels: &'static str, nature: LogNature, note: &'static str) -> LogSource {
    LogSource { message, channels, nature, note }
}

/// Maps data.
#[derive(Debug, Default)]
pub struct UlogMapping {
    gate: RowGate,
    stated: StatedControls,
}

/// What a vector of `debug_vect` is called that holds incidence and sideslip, rad.
pub const FLOW_VECTOR: &str = "flow";

/// Time of the measurement, us.
fn sampled_us(data: &UlogData<'_>) -> Option<u64> {
    match data.field("timestamp_sample").and_then(|stamp| stamp.get(0)) {
        Some(UlogValue::Unsigned(time_us)) if time_us > 0 => Some(time_us),
        _ => data.time_us(),
    }
}

/// The numbers of an array.
fn numbers<const N: usize>(data: &UlogData<'_>, field: &str) -> Option<[f64; N]> {
    let values = data.field(field)?;
    let mut numbers = [0.0; N];
    for (at, number) in numbers.iter_mut().enumerate() {
        *number = values.get(at)?.number();
    }
    Some(numbers)
}

/// Whether its field `name` is that text.
fn is_named(data: &UlogData<'_>, wanted: &str) -> bool {
    data.field("name").and_then(|name| name.text()) == Some(wanted.as_bytes())
}

fn with<const N: usize>(channels: [LogChannel; N], numbers: [f64; N]) -> [(LogChannel, f64); N] {
    let mut numbers = numbers.into_iter();
    channels.map(|channel| (channel, numbers.next().unwrap_or(f64::NAN)))
}

impl UlogMapping {
    /// Nothing seen yet.
    pub fn new() -> Self {
        UlogMapping::default()
    }

    /// What was handed on and what not.
    pub fn tally(&self) -> LogMappingTally {
        self.gate.tally
    }

    /// No more data will come.
    pub fn finish(&mut self) {
        self.gate.finish();
    }

    /// Takes in a parameter of the log.
    pub fn parameter(&mut self, keyed: &UlogKeyed<'_>) {
        if let Some(value) = keyed.value() {
            self.stated.parameter(keyed.key, value.number());
        }
    }

    /// Hands on the rows of data.
    pub fn map(&mut self, data: &UlogData<'_>, mut put: impl FnMut(LogRow)) {
        let put = &mut put;
        let first = data.multi_id() == 0;
        match data.name() {
            "sensor_combined" => self.sensors(data, put),
            "vehicle_acceleration" => self.vector(data, &ACCELERATION, LogGroup::Force, FORCES, put),
            "vehicle_angular_velocity" => self.vector(data, &ANGULAR_VELOCITY, LogGroup::Rates, RATES, put),
            "vehicle_attitude" => {
                if let Some(quaternion) = numbers::<4>(data, "q") {
                    match angles(quaternion) {
                        Some(angles) => self.offer(data, &ATTITUDE, (LogGroup::Attitude, 0), &with(ANGLES, angles), put),
                        None => self.gate.tally.not_a_number += 1,
                    }
                }
            }
            "airspeed" => {
                self.field(data, &AIRSPEED, (LogGroup::IndicatedAirspeed, 0), "indicated_airspeed_m_s", IAS, put);
                self.field(data, &TRUE_AIRSPEED, (LogGroup::Airspeed, 0), "true_airspeed_m_s", TAS, put);
            }
            "airspeed_validated" => {
                self.field(data, &VALIDATED_AIRSPEED, (LogGroup::Airspeed, 256), "true_airspeed_m_s", TAS, put)
            }
            "vehicle_air_data" => {
                if let Some(pressure) = data.number("baro_pressure_pa") {
                    match standard(pressure) {
                        Some((altitude, _)) => {
                            let group = (LogGroup::Altitude, 0);
                            self.offer(data, &PRESSURE_ALTITUDE, group, &[(ALTITUDE, altitude)], put);
                        }
                        None => self.gate.tally.not_a_number += 1,
                    }
                }
                self.field(data, &BAROMETRIC_HEIGHT, (LogGroup::BarometricHeight, 0), "baro_alt_meter", HEIGHT, put);
                self.field(data, &DENSITY, (LogGroup::Density, 0), "rho", RHO, put);
            }
            "actuator_outputs" => {
                let count = data.number("noutputs").unwrap_or(16.0);
                // Two drivers (of the main and of the auxiliary pins) publish at once, each its own outputs.
                let (group, names) = if first { (LogGroup::Outputs, OUTPUTS) } else { (LogGroup::SecondOutputs, SECOND_OUTPUTS) };
                self.commands(data, &ACTUATOR_OUTPUTS, group, ("output", count), names, "raw", put);
            }
            "actuator_motors" => self.commands(data, &ACTUATOR_MOTORS, LogGroup::Motors, ("control", 12.0), MOTORS, "", put),
            "actuator_servos" => {
                self.commands(data, &ACTUATOR_SERVOS, LogGroup::Servos, ("control", 8.0), SERVOS, "", put);
                let controls = data.field("control");
                let output = |number: usize| controls?.get(number.wrapping_sub(1)).map(|control| control.number());
                let (angles, count) = self.stated.angles(output);
                self.offer(data, &STATED_CONTROLS, (LogGroup::Controls, 0), angles.get(..count).unwrap_or_default(), put);
            }
            "debug_vect" if is_named(data, FLOW_VECTOR) => {
                if let (Some(alpha), Some(beta)) = (data.number("x"), data.number("y")) {
                    self.offer(data, &VANES, (LogGroup::Flow, 0), &with(FLOW, [alpha, beta]), put);
                }
            }
            "rpm" if first => {
                let rpm = data.number("rpm_raw").or_else(|| data.number("indicated_frequency_rpm"));
                let speed = rpm.map(|rpm| (ROTOR, rpm * std::f64::consts::TAU / 60.0));
                self.offer(data, &ROTOR_SPEED, (LogGroup::Rotor, 0), speed.as_slice(), put);
            }
            "wind" | "wind_estimate" | "estimator_wind" if first => {
                let rank = ["wind", "wind_estimate", "estimator_wind"].iter().position(|name| *name == data.name());
                let winds = [data.number("windspeed_north"), data.number("windspeed_east")];
                if let ([Some(north), Some(east)], Some(rank)) = (winds, rank) {
                    self.offer(data, &WIND_ESTIMATE, (LogGroup::Wind, rank), &with(WIND, [north, east]), put);
                }
            }
            "vehicle_gps_position" | "sensor_gps" if first => self.position(data, put),
            _ => {}
        }
    }

    fn offer(
        &mut self,
        data: &UlogData<'_>,
        source: &'static LogSource,
        group: (LogGroup, usize),
        values: &[(LogChannel, f64)],
        put: &mut impl FnMut(LogRow),
    ) {
        self.offer_at(data, source, group, sampled_us(data), values, put);
    }

    /// The instruments of one topic stand in a row, in the order of their number, behind the topics before it.
    fn offer_at(
        &mut self,
        data: &UlogData<'_>,
        source: &'static LogSource,
        group: (LogGroup, usize),
        time_us: Option<u64>,
        values: &[(LogChannel, f64)],
        put: &mut impl FnMut(LogRow),
    ) {
        let instance = data.multi_id();
        let (group, rank) = (group.0, group.1 + usize::from(instance));
        self.gate.offer(LogOffer { source, group, rank, instance }, time_us, values, put);
    }

    fn field(
        &mut self,
        data: &UlogData<'_>,
        source: &'static LogSource,
        group: (LogGroup, usize),
        field: &str,
        channel: LogChannel,
        put: &mut impl FnMut(LogRow),
    ) {
        if let Some(value) = data.number(field) {
            self.offer(data, source, group, &[(channel, value)], put);
        }
    }

    fn vector(
        &mut self,
        data: &UlogData<'_>,
        source: &'static LogSource,
        group: LogGroup,
        channels: [LogChannel; 3],
        put: &mut impl FnMut(LogRow),
    ) {
        if let Some(vector) = numbers(data, "xyz") {
            self.offer(data, source, (group, 256), &with(channels, vector), put);
        }
    }

    fn sensors(&mut self, data: &UlogData<'_>, put: &mut impl FnMut(LogRow)) {
        if let Some(rates) = numbers(data, "gyro_rad") {
            self.offer(data, &COMBINED_RATES, (LogGroup::Rates, 0), &with(RATES, rates), put);
        }
        let Some(forces) = numbers(data, "accelerometer_m_s2") else { return };
        let relative = match data.field("accelerometer_timestamp_relative").and_then(|stamp| stamp.get(0)) {
            // The topic's way to say that there is no such measurement.
            Some(UlogValue::Signed(relative)) if relative == i64::from(i32::MAX) => {
                self.gate.tally.no_time += 1;
                return;
            }
            Some(UlogValue::Signed(relative)) => relative,
            _ => 0,
        };
        let time_us = data.time_us().and_then(|time_us| time_us.checked_add_signed(relative));
        self.offer_at(data, &COMBINED_FORCE, (LogGroup::Force, 0), time_us, &with(FORCES, forces), put);
    }

    #[expect(clippy::too_many_arguments, reason = "a table's row, spelt out")]
    fn commands(
        &mut self,
        data: &UlogData<'_>,
        source: &'static LogSource,
        group: LogGroup,
        (field, count): (&str, f64),
        names: [&'static str; 16],
        unit: &'static str,
        put: &mut impl FnMut(LogRow),
    ) {
        let Some(controls) = data.field(field) else { return };
        let mut values = [(ALTITUDE, 0.0); 16];
        let mut used = 0;
        for (at, (name, control)) in names.into_iter().zip(controls.iter()).enumerate() {
            let value = control.number();
            // What is no number is an output that is not in use.
            if (at as f64) < count
                && !value.is_nan()
                && let Some(place) = values.get_mut(used)
            {
                *place = (LogChannel { name, unit }, value);
                used += 1;
            }
        }
        self.offer(data, source, (group, 0), values.get(..used).unwrap_or_default(), put);
    }

    fn position(&mut self, data: &UlogData<'_>, put: &mut impl FnMut(LogRow)) {
        if data.number("fix_type").is_some_and(|fix| fix < 3.0) {
            self.gate.tally.no_fix += 1;
            return;
        }
        // Until v1.14 integers of 1e-7 degrees and millimetres, since then double precision.
        let old = |name: &str, divisor: f64| data.number(name).map(|value| value / divisor);
        let found = [
            data.number("latitude_deg").or_else(|| old("lat", 1e7)),
            data.number("longitude_deg").or_else(|| old("lon", 1e7)),
            data.number("altitude_msl_m").or_else(|| old("alt", 1e3)),
            data.number("vel_m_s"),
            data.number("cog_rad"),
            data.number("vel_d_m_s").map(|down| -down),
        ];
        let mut values = [(ALTITUDE, 0.0); 6];
        let mut count = 0;
        for (channel, value) in GPS.into_iter().zip(found) {
            if let (Some(value), Some(place)) = (value, values.get_mut(count)) {
                *place = (channel, value);
                count += 1;
            }
        }
        // One receiver may be logged by both topics.
        let rank = usize::from(data.name() == "sensor_gps");
        self.offer(data, &POSITION, (LogGroup::Position, rank), values.get(..count).unwrap_or_default(), put);
    }
}
