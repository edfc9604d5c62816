//! Channels from logs: simulated flights against their closed form, and recordings against values read by hand.
use crate::support::program::data;
use sideslip::io::telemetry::logs::dataflash::reader::DataflashReader;
use sideslip::io::telemetry::logs::encode::flight::{FlightTruth, START_US, SimulatedFlight};
use sideslip::io::telemetry::logs::mapping::dataflash::DataflashMapping;
use sideslip::io::telemetry::logs::mapping::ulog::UlogMapping;
use sideslip::io::telemetry::logs::mapping::{LogMappingTally, LogNature, LogRow};
use sideslip::io::telemetry::logs::ulog::message::UlogMessage;
use sideslip::io::telemetry::logs::ulog::reader::UlogReader;
use std::collections::BTreeMap;

/// Bytes of a recording; `None`, said loudly, where it is absent.
fn recording(name: &str) -> Option<Vec<u8>> {
    data("logs", name).map(|file| std::fs::read(file).unwrap())
}

fn dataflash_rows(bytes: &[u8]) -> (Vec<LogRow>, LogMappingTally) {
    let (mut reader, mut mapping, mut rows) = (DataflashReader::new(), DataflashMapping::new(), Vec::new());
    for mut piece in bytes.chunks(1000) {
        while !piece.is_empty() {
            piece = &piece[reader.take(piece)..];
            while let Some(message) = reader.next_message() {
                mapping.map(&message, |row| rows.push(row));
            }
        }
    }
    while let Some(message) = reader.last_message() {
        mapping.map(&message, |row| rows.push(row));
    }
    mapping.finish();
    (rows, mapping.tally())
}

fn ulog_rows(bytes: &[u8]) -> (Vec<LogRow>, LogMappingTally) {
    let (mut reader, mut mapping, mut rows) = (UlogReader::new(), UlogMapping::new(), Vec::new());
    for mut piece in bytes.chunks(1000) {
        while !piece.is_empty() {
            piece = &piece[reader.take(piece)..];
            while let Some(message) = reader.next_message().unwrap() {
                if let UlogMessage::Data(data) = message {
                    mapping.map(&data, |row| rows.push(row));
                }
            }
        }
    }
    while let Some(message) = reader.last_message().unwrap() {
        if let UlogMessage::Data(data) = message {
            mapping.map(&data, |row| rows.push(row));
        }
    }
    mapping.finish();
    (rows, mapping.tally())
}

fn counts(rows: &[LogRow]) -> BTreeMap<&'static str, usize> {
    let mut counts = BTreeMap::new();
    rows.iter().for_each(|row| *counts.entry(row.channel.name).or_default() += 1);
    counts
}

/// Rows of every stream in order of time.
fn assert_in_order(rows: &[LogRow]) {
    let mut last = BTreeMap::new();
    for row in rows {
        let stream = (row.source.message, row.channel.name, row.instance);
        let before = last.insert(stream, (row.restart, row.time_us));
        assert!(before.is_none_or(|before| before < (row.restart, row.time_us)), "{row:?}");
    }
}

/// What the channel should be, and how far a value in the log may be from it.
fn truth(row: &LogRow, angle_step: f64) -> Option<(f64, f64)> {
    let truth = FlightTruth::at((row.time_us - START_US) as f64 / 1e6);
    let at = |values: &[f64], names: [&str; 4]| {
        names.iter().position(|name| *name == row.channel.name).and_then(|place| values.get(place)).copied()
    };
    let single = |value: f64| (value, 1e-7 * value.abs() + 1e-9);
    at(&truth.force, ["ax", "ay", "az", ""])
        .or_else(|| at(&truth.rates, ["p", "q", "r", ""]))
        .or_else(|| at(&truth.flow, ["alpha", "beta", "", ""]))
        .or_else(|| at(&[truth.indicated], ["ias", "", "", ""]))
        .map(single)
        .or_else(|| at(&truth.attitude, ["phi", "theta", "psi", ""]).map(|value| (value, angle_step)))
        .or_else(|| at(&truth.servos, ["servo_1", "servo_2", "servo_3", "servo_4"]).map(|value| (value, 0.5001)))
        .or_else(|| at(&truth.servos, ["output_1", "output_2", "output_3", "output_4"]).map(|value| (value, 1e-4)))
}

fn flights() -> impl Iterator<Item = SimulatedFlight> {
    let rates = [(50.0, 10.0, 10.0), (100.0, 25.0, 20.0), (250.0, 100.0, 91.0), (400.0, 50.0, 50.0)];
    rates.into_iter().map(|(imu_hz, attitude_hz, air_hz)| SimulatedFlight { duration_s: 8.0, imu_hz, attitude_hz, air_hz })
}

#[test]
fn a_simulated_flight_comes_back_from_a_dataflash_log() {
    for flight in flights() {
        let (rows, tally) = dataflash_rows(&flight.dataflash().unwrap());
        assert_in_order(&rows);
        // A count of hundredths of a degree is half a step off at most.
        let step = 0.00501_f64.to_radians();
        let checked = rows.iter().filter_map(|row| truth(row, step).map(|expected| (row, expected)));
        let checked = checked.inspect(|(row, (value, within))| assert!((row.value - value).abs() <= *within, "{row:?} {value}"));
        let [imu, attitude, air] = [flight.imu_hz, flight.attitude_hz, flight.air_hz].map(|hz| (8.0 * hz).ceil() as usize);
        assert_eq!(checked.count(), 6 * imu + 7 * attitude + 3 * air);
        let tas = rows.iter().filter(|row| row.channel.name == "tas").map(|row| {
            let truth = FlightTruth::at((row.time_us - START_US) as f64 / 1e6);
            // Density between those of the tables at 500 m and 1000 m: 95461.3 Pa, 1.16727 kg/m^3; 89874.6 Pa, 1.11164 kg/m^3.
            let exponent = (1.16727_f64 / 1.11164).ln() / (95_461.3_f64 / 89_874.6).ln();
            let density = 1.16727 * (truth.pressure / 95_461.3).powf(exponent);
            let standard = truth.indicated * (1.225 / density).sqrt();
            assert!((row.value / standard - 1.0).abs() < 2e-5, "{} {standard}", row.value);
            assert_eq!(row.source.nature, LogNature::Processed);
        });
        assert_eq!(tas.count(), air);
        assert_eq!(tally, LogMappingTally { rows: rows.len() as u64, ..LogMappingTally::default() });
        assert!(rows.iter().filter(|row| row.channel.name == "alpha").all(|row| row.source.nature == LogNature::Estimate));
    }
}

#[test]
fn a_simulated_flight_comes_back_from_a_ulog() {
    for flight in flights() {
        let (rows, tally) = ulog_rows(&flight.ulog().unwrap());
        assert_in_order(&rows);
        let checked = rows.iter().filter_map(|row| truth(row, 5e-7).map(|expected| (row, expected)));
        let checked = checked.inspect(|(row, (value, within))| assert!((row.value - value).abs() <= *within, "{row:?} {value}"));
        let [imu, attitude, air] = [flight.imu_hz, flight.attitude_hz, flight.air_hz].map(|hz| (8.0 * hz).ceil() as usize);
        assert_eq!(checked.count(), 6 * imu + 7 * attitude + air);
        assert_eq!([counts(&rows)["tas"], counts(&rows)["altitude"], counts(&rows)["rho"]], [air; 3]);
        assert_eq!(tally, LogMappingTally { rows: rows.len() as u64, ..LogMappingTally::default() });
        // The time of a pressure is that of the measurement, not of its publication.
        let first = rows.iter().find(|row| row.channel.name == "altitude").unwrap();
        assert_eq!(first.time_us, START_US);
    }
}

#[test]
fn the_dataflash_recording_gives_its_channels() {
    let Some(bytes) = recording("plane-3.8.2.BIN") else { return };
    let (rows, tally) = dataflash_rows(&bytes);
    assert_in_order(&rows);
    let counts = counts(&rows);
    let expected = [("ax", 45), ("p", 45), ("phi", 24), ("psi", 24), ("alpha", 23), ("altitude", 8), ("servo_14", 23)];
    assert!(expected.iter().all(|(name, count)| counts[name] == *count), "{counts:?}");
    assert!(!counts.contains_key("tas") && !counts.contains_key("ias"), "it has no airspeed sensor");
    // The second instrument of its kind is not mixed in.
    assert_eq!(tally.not_preferred, 2 * 45);
    assert_eq!((tally.repeated, tally.out_of_order, tally.wrong_unit, tally.not_a_number), (0, 0, 0, 0));
    // The first of each, as printed by pymavlink.
    let first = |name: &str| rows.iter().find(|row| row.channel.name == name).unwrap();
    for (name, time_us, value) in [
        ("p", 81_794_643, -0.116_570_852_696_895_6),
        ("az", 81_794_643, -9.780_994_415_283_203),
        ("phi", 81_795_644, -7.18_f64.to_radians()),
        ("psi", 81_795_644, 337.1_f64.to_radians()),
        ("servo_2", 81_796_497, 1402.0),
        ("gps_latitude", 81_855_471, -35.362_627_7),
        ("gps_climb", 81_855_471, -0.349_999_994_039_535_5),
        ("barometric_height", 81_875_711, 0.027_998_920_530_080_795),
    ] {
        let row = first(name);
        assert!((row.value - value).abs() < 1e-12 && row.time_us == time_us, "{row:?}");
    }
    // 94144.23 Pa: 615 m by the tables of the standard atmosphere; the receiver says 588.8 m.
    assert!((first("altitude").value - 615.0).abs() < 1.0, "{:?}", first("altitude"));
}

#[test]
fn the_ulog_recording_gives_its_channels() {
    let Some(bytes) = recording("sample_log_small.ulg") else { return };
    let (rows, tally) = ulog_rows(&bytes);
    assert_in_order(&rows);
    let counts = counts(&rows);
    let expected = [("p", 1298), ("az", 1298), ("theta", 1298), ("ias", 595), ("tas", 595), ("altitude", 120), ("rho", 120)];
    assert!(expected.iter().all(|(name, count)| counts[name] == *count), "{counts:?}");
    // Each of two drivers of outputs has columns of its own.
    assert_eq!((counts["output_1"], counts["second_output_1"]), (65, 65));
    // It stands on the ground: gravity, no rates.
    let mean = |name: &str| {
        let values: Vec<f64> = rows.iter().filter(|row| row.channel.name == name).map(|row| row.value).collect();
        values.iter().sum::<f64>() / values.len() as f64
    };
    assert!((mean("az") + 9.8).abs() < 0.3 && mean("p").abs() < 0.02, "{} {}", mean("az"), mean("p"));
    assert_eq!((tally.out_of_order, tally.gaps, tally.restarts, tally.no_time), (0, 0, 0, 0), "{tally:?}");
}
