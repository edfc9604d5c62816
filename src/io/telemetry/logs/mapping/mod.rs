//! Which messages of a log become the channels of the aircraft, with their time and their nature.
//!
//! In: messages of a dataflash log ([`dataflash`]) or of a ULog ([`ulog`]). Out: [`LogRow`]s: time, channel, value in SI and
//! radians (or a unit that is named), where it comes from; in order of time within each stream ([`gate`]), a stream being one
//! message of one instrument. Of several messages that give the same channel the first by preference is used, the next only
//! after two seconds of silence, so that two instruments are never mixed. Channels: `ax ay az` m/s^2, `p q r` rad/s, `phi
//! theta psi` rad, `tas` m/s, `alpha beta` rad, `altitude` m, `rho` kg/m^3, `rotor_speed` rad/s, and under names of their own:
//! `ias`, `barometric_height`, `wind_north wind_east`, `gps_...`, and controls, which in both logs are commands and not
//! positions of surfaces: counts or microseconds are never called radians, unless the log states their scale
//! ([`stated_controls`]); then the controls' own channels are given too.
//! Assumed: the units that PX4's topics and ArduPilot's messages are documented with, where the log itself names none.
//! Refused and counted: values that are no numbers, units that are not those of the quantity, instruments that the autopilot
//! calls unhealthy, positions without a fix, times that contradict their stream.
//! Sources: ArduPilot, "Onboard Message Log Messages"; PX4 User Guide, "uORB Message Reference".

pub mod atmosphere;
pub mod dataflash;
pub mod gate;
pub mod stated_controls;
pub mod ulog;

/// What a value is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LogNature {
    /// The reading of an instrument, calibrated.
    Instrument,
    /// A reading that was filtered, corrected by an estimate, or converted with other readings.
    Processed,
    /// An estimate of the autopilot.
    Estimate,
    /// What was demanded, not what happened.
    Command,
}

/// Where values come from.
#[derive(Debug, PartialEq, Eq)]
pub struct LogSource {
    /// Message or topic.
    pub message: &'static str,
    /// Its channels.
    pub channels: &'static str,
    /// What they are.
    pub nature: LogNature,
    /// What to know of them.
    pub note: &'static str,
}

/// A channel with the unit of its values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LogChannel {
    /// Name.
    pub name: &'static str,
    /// Unit, empty where it has none.
    pub unit: &'static str,
}

/// One value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogRow {
    /// When, us since the autopilot started.
    pub time_us: u64,
    /// How often the clock of its stream began anew before.
    pub restart: u32,
    /// What.
    pub channel: LogChannel,
    /// How much.
    pub value: f64,
    /// Where from.
    pub source: &'static LogSource,
    /// Which of several instruments, from 0.
    pub instance: u8,
}

impl LogRow {
    /// When, s.
    #[expect(clippy::cast_precision_loss, reason = "below 2^53 us, 285 years")]
    pub fn time_s(&self) -> f64 {
        self.time_us as f64 / 1e6
    }
}

/// What the mapping did not hand on, and why.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LogMappingTally {
    /// Rows handed on.
    pub rows: u64,
    /// Values that are no numbers, or outside of what they can be.
    pub not_a_number: u64,
    /// Values whose unit in the log is not one of their quantity.
    pub wrong_unit: u64,
    /// Messages of instruments that the autopilot calls unhealthy.
    pub unhealthy: u64,
    /// Positions without a fix in three dimensions.
    pub no_fix: u64,
    /// Airspeeds without a recent pressure: no true airspeed.
    pub no_density: u64,
    /// Messages without a time.
    pub no_time: u64,
    /// Messages that another one is preferred to.
    pub not_preferred: u64,
    /// Messages with the time of the one before in their stream.
    pub repeated: u64,
    /// Messages whose time their stream contradicts: refused.
    pub out_of_order: u64,
    /// Steps forward of more than ten seconds that the next message confirmed.
    pub gaps: u64,
    /// Steps back that the next message confirmed: the clock began anew.
    pub restarts: u64,
    /// Messages of more streams than are kept.
    pub streams_exceeded: u64,
}

const fn channel(name: &'static str, unit: &'static str) -> LogChannel {
    LogChannel { name, unit }
}

const FORCES: [LogChannel; 3] = [channel("ax", "m/s^2"), channel("ay", "m/s^2"), channel("az", "m/s^2")];
const RATES: [LogChannel; 3] = [channel("p", "rad/s"), channel("q", "rad/s"), channel("r", "rad/s")];
const ANGLES: [LogChannel; 3] = [channel("phi", "rad"), channel("theta", "rad"), channel("psi", "rad")];
const TAS: LogChannel = channel("tas", "m/s");
const IAS: LogChannel = channel("ias", "m/s");
const FLOW: [LogChannel; 2] = [channel("alpha", "rad"), channel("beta", "rad")];
const ALTITUDE: LogChannel = channel("altitude", "m");
const HEIGHT: LogChannel = channel("barometric_height", "m");
const RHO: LogChannel = channel("rho", "kg/m^3");
const ROTOR: LogChannel = channel("rotor_speed", "rad/s");
const WIND: [LogChannel; 2] = [channel("wind_north", "m/s"), channel("wind_east", "m/s")];
const GPS: [LogChannel; 6] = [
    channel("gps_latitude", "deg"),
    channel("gps_longitude", "deg"),
    channel("gps_altitude", "m"),
    channel("gps_speed", "m/s"),
    channel("gps_course", "rad"),
    channel("gps_climb", "m/s"),
];

/// `servo_1` to `servo_16` and the like.
macro_rules! numbered {
    ($stem:literal) => {
        [
            concat!($stem, "_1"),
            concat!($stem, "_2"),
            concat!($stem, "_3"),
            concat!($stem, "_4"),
            concat!($stem, "_5"),
            concat!($stem, "_6"),
            concat!($stem, "_7"),
            concat!($stem, "_8"),
            concat!($stem, "_9"),
            concat!($stem, "_10"),
            concat!($stem, "_11"),
            concat!($stem, "_12"),
            concat!($stem, "_13"),
            concat!($stem, "_14"),
            concat!($stem, "_15"),
            concat!($stem, "_16"),
        ]
    };
}

const SERVOS: [&str; 16] = numbered!("servo");
const OUTPUTS: [&str; 16] = numbered!("output");
const SECOND_OUTPUTS: [&str; 16] = numbered!("second_output");
const MOTORS: [&str; 16] = numbered!("motor");
