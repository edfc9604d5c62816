//! A small run with every topic, every kind of absence and awkward numbers, the same at each call.

use sideslip::flight::channel::{Channel, ControlNames};
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::flight::file::log_head::LogHead;
use sideslip::flight::sample::Sample;
use sideslip::io::outputs::log::mcap_log::{LogSummary, McapLog};
use sideslip::io::outputs::record::{EventKind, EventRecord, Message};
use sideslip::io::telemetry::mcap::{LogLosses, SampleReader};
use sideslip::postflight::output_error::record::{OutputErrorProgress, OutputErrorRecord, ParameterRecord};
use sideslip::realtime::estimation::record::{Aid, EstimationEvent, Innovation, LaggedRecord, StateRecord};
use sideslip::realtime::modes::record::{ModesRecord, OscillatoryMode, RealRoot};
use sideslip::realtime::regression::record::{DerivativesRecord, EquationRecord, FrequencyTerm, Reason, Status, TermRecord};
use std::io::{Cursor, Read, Seek};
use std::path::{Path, PathBuf};

/// A folder of this test alone, empty.
pub(crate) fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("conformance").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// A generator of numbers that look random; the same for the same seed (xorshift64*).
pub(crate) struct Dice(pub(crate) u64);

impl Dice {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D)
    }

    pub(crate) fn below(&mut self, limit: usize) -> usize {
        (self.bits() % limit.max(1) as u64) as usize
    }
}

pub(crate) type Row = (Sample, Vec<f64>);

pub(crate) fn head() -> LogHead {
    let columns = [("ax", "m/s^2"), ("p", "rad/s"), ("fuel", "litre"), ("beta", "rad"), ("rudder", "rad"), ("egt \"1\"", "degC")];
    LogHead {
        run_toml: "run = \"467/10/11\"\naircraft = \"P\u{fc}ma\"\n".to_owned(),
        channels: columns.map(|(name, unit)| (name.to_owned(), unit.to_owned())).to_vec(),
        controls: ControlNames::FixedWing,
        ..LogHead::default()
    }
}

/// Rows of any bits that are a number, with absences and values that are none.
pub(crate) fn rows(count: u32) -> Vec<Row> {
    let mut dice = Dice(0x5EED);
    let mut number = move || match dice.below(8) {
        0 => f64::NAN,
        1 => f64::INFINITY,
        2 => -0.0,
        3 => 5e-324,
        _ => f64::from_bits(dice.bits()),
    };
    let row = |k: u32| {
        let mut sample = Sample::new(f64::from(k) / 256.0 - 0.01);
        for channel in [Channel::Ax, Channel::P, Channel::Beta, Channel::Pedal] {
            if !(k as usize + channel.index()).is_multiple_of(3) {
                sample.set(channel, number());
            }
        }
        (sample, vec![number(), if k.is_multiple_of(2) { f64::NAN } else { f64::from(k) }])
    };
    (0..count).map(row).collect()
}

fn derivatives(time_s: f64) -> Message {
    let mut equations = Axis::ALL.map(|axis| EquationRecord::empty(axis, Status::Waiting));
    equations[0].status = Status::NotIdentifiable(Reason::RateTooLow { hz: 4.0, needed_hz: 8.0 });
    let yaw = &mut equations[5];
    yaw.status = Status::Converging;
    for variable in [None, Some(Variable::V), Some(Variable::Pedal)] {
        let frequency = Some(FrequencyTerm { value: time_s, std: 0.2 });
        yaw.terms
            .push(TermRecord { variable, value: time_s, std: 0.1, std_white: 0.05, step: 1, primary: true, frequency })
            .unwrap();
    }
    Message::Derivatives(DerivativesRecord { time_s, equations, lateral: None, excited: true })
}

fn modes(time_s: f64, with_numbers: bool) -> Message {
    let pair = OscillatoryMode { real: -0.2, imag: 1.8, omega: 1.81, zeta: 0.11, std_omega: 0.01, std_zeta: 0.02 };
    let root = RealRoot { value: -2.0, std: 0.1 };
    Message::Modes(ModesRecord {
        time_s,
        status: if with_numbers { Status::Converged } else { Status::Waiting },
        dutch_roll: with_numbers.then_some(pair),
        roll: with_numbers.then_some(root),
        spiral: with_numbers.then_some(root),
        lateral_phugoid: None,
        coupled: None,
    })
}

fn output_error(time_s: f64, with_numbers: bool) -> Message {
    let mut record = OutputErrorRecord { time_s, ..OutputErrorRecord::EMPTY };
    if with_numbers {
        record.progress = OutputErrorProgress::Converging;
        record.fitted_s = time_s - 0.5;
        record.dutch_roll =
            Some(OscillatoryMode { real: -0.2, imag: 1.8, omega: 1.81, zeta: 0.11, std_omega: 0.01, std_zeta: 0.02 });
        record.explain("search not ended");
        let one = ParameterRecord { axis: Axis::N, variable: Variable::Pedal, value: -1.5, std: 0.1, std_cramer_rao: 0.05 };
        record.parameters.push(one).unwrap();
    }
    Message::OutputError(record)
}

pub(crate) fn state(time_s: f64) -> Message {
    Message::State(state_record(time_s))
}

/// Of half a second before.
fn smoothed(time_s: f64) -> Message {
    Message::Smoothed(LaggedRecord { state: StateRecord { fused: 0, ..state_record(time_s - 0.5) }, lag_s: 0.5 })
}

fn state_record(time_s: f64) -> StateRecord {
    StateRecord {
        time_s,
        velocity: [51.0, 0.5, 2.0],
        velocity_std: [0.1, 0.2, 0.3],
        rates: [0.01, 0.02, 0.03],
        rates_std: [1e-3, 2e-3, 3e-3],
        angular_acceleration: [0.1, 0.2, 0.3],
        angular_acceleration_std: [0.01, 0.02, 0.03],
        specific_force: [0.5, 0.1, -9.7],
        specific_force_std: [0.02, 0.03, 0.04],
        attitude: [0.1, 0.2, 0.3],
        attitude_std: [0.01; 3],
        altitude: 1000.0,
        altitude_std: 2.0,
        accelerometer_bias: [0.1, 0.2, 0.3],
        accelerometer_bias_std: [0.01, 0.02, 0.03],
        gyro_bias: [0.001, 0.002, 0.003],
        gyro_bias_std: [1e-4, 2e-4, 3e-4],
        fused: 4,
    }
}

fn innovation(time_s: f64) -> Message {
    Message::Innovation(Innovation {
        time_s,
        aid: Aid::Sideslip,
        observation: 0.02,
        observation_var: 1e-6,
        innovation: 0.001,
        innovation_var: 2e-6,
        test_ratio: 0.02,
        fused: true,
    })
}

/// Logs rows with what a pipeline would say of each; flushes after every `chunk` rows.
pub(crate) fn write(path: &Path, rows: &[Row], chunk: usize) -> LogSummary {
    let mut log = McapLog::create(path, head(), Box::new(|line| panic!("{line}"))).unwrap();
    for (k, (sample, unknown)) in rows.iter().enumerate() {
        log.sample(sample, unknown);
        log.message(&state(sample.time_s));
        log.message(&innovation(sample.time_s));
        if k % 8 == 0 {
            log.message(&smoothed(sample.time_s));
            log.message(&derivatives(sample.time_s));
            log.message(&modes(sample.time_s, k >= 16));
            log.message(&output_error(sample.time_s, k >= 16));
        }
        if k % 50 == 0 {
            let kind = EventKind::Estimation(EstimationEvent::NotFinite { channel: Channel::Pedal });
            log.message(&Message::Event(EventRecord { time_s: sample.time_s, kind }));
        }
        if k % chunk == chunk - 1 {
            log.flush();
        }
    }
    log.close()
}

/// Everything that can be read, and what could not.
pub(crate) fn read(source: impl Read + Seek) -> Option<(Vec<Row>, LogLosses)> {
    let mut reader = SampleReader::open(source).ok()?;
    let mut rows = Vec::new();
    while let Some((sample, unknown)) = reader.next_sample().unwrap() {
        rows.push((sample, unknown.iter().map(|value| value.unwrap_or(f64::NAN)).collect()));
    }
    Some((rows, reader.losses()))
}

pub(crate) fn read_bytes(bytes: &[u8]) -> Option<(Vec<Row>, LogLosses)> {
    read(Cursor::new(bytes))
}

/// The bits of a row as they come back from a log: what is no number is NaN.
pub(crate) fn bits(row: &Row) -> (u64, Vec<Option<u64>>, Vec<u64>) {
    let of = |value: f64| if value.is_finite() { value.to_bits() } else { f64::NAN.to_bits() };
    let (sample, unknown) = row;
    let known = Channel::ALL.iter().map(|channel| sample.get(*channel).map(of)).collect();
    (of(sample.time_s), known, unknown.iter().map(|value| of(*value)).collect())
}
