//! Tables of other programs, read by a map, against the run file that they were made from.

use crate::support::program::{ended, folder, path, puma, sideslip};
use crate::support::recorded_samples::samples_of;
use sideslip::flight::channel::Channel;
use sideslip::flight::sample::Sample;
use std::fmt::Write as _;
use std::path::PathBuf;

const DEG: f64 = 180.0 / std::f64::consts::PI;

/// What a spreadsheet of a European office would call a channel, and how many of its units are one of SI.
const EUROPEAN: [(Channel, &str, f64); 17] = [
    (Channel::P, "Roll Rate [deg/s]", DEG),
    (Channel::Q, "Pitch Rate (deg/s)", DEG),
    (Channel::R, "yaw_rate_dps", DEG),
    (Channel::Ax, "nx [g]", 1.0 / 9.806_65),
    (Channel::Ay, "ny, g", 1.0 / 9.806_65),
    (Channel::Az, "nz [g]", -1.0 / 9.806_65),
    (Channel::Phi, "Bank Angle [\u{b0}]", DEG),
    (Channel::Theta, "Pitch", DEG),
    (Channel::Psi, "Heading [deg]", DEG),
    (Channel::Tas, "True Airspeed [kts]", 3600.0 / 1852.0),
    (Channel::Alpha, "AoA [deg]", DEG),
    (Channel::Beta, "AoS [deg]", DEG),
    (Channel::Altitude, "Alt [feet]", 1.0 / 0.304_8),
    (Channel::Pedal, "Pedal Position [%]", 250.0),
    (Channel::LonCyclic, "Lon Cyclic [rad]", 1.0),
    (Channel::LatCyclic, "Lat Cyclic [rad]", 1.0),
    (Channel::Collective, "Collective [mrad]", 1e3),
];

/// The map of that table; the pedal's percent are of 0.4 rad.
const MAP: &str = "time = \"Zeit\"\n[channels]\np = \"Roll Rate [deg/s]\"\nq = \"Pitch Rate\"\nr = \"yaw_rate_dps\"\n\
    ax = \"nx [g]\"\nay = \"ny, g\"\naz = { column = \"nz [g]\", sign = -1 }\nphi = \"Bank Angle\"\n\
    theta = { column = \"Pitch\", unit = \"degrees\" }\npsi = \"Heading [deg]\"\ntas = \"True Airspeed\"\nalpha = \"AoA [deg]\"\n\
    beta = \"AoS [deg]\"\naltitude = \"Alt [feet]\"\npedal = { column = \"Pedal Position [%]\", unit = \"rad\", scale = 0.004 }\n\
    lon_cyclic = \"Lon Cyclic [rad]\"\nlat_cyclic = \"Lat Cyclic [rad]\"\ncollective = \"Collective\"\n[run]\naircraft = \"Puma\"\n";

/// A table with `;`, decimal commas, quoted headers with spaces, times by `time`, and a column of words.
fn european(samples: &[Sample], time: impl Fn(f64) -> String) -> String {
    let headers: Vec<String> = EUROPEAN.iter().map(|(_, header, _)| format!("\"{header}\"")).collect();
    let mut text = format!("\u{feff}Zeit;{};Bemerkung\r\n", headers.join(";"));
    for sample in samples {
        text.push_str(&time(sample.time_s));
        for (channel, _, factor) in EUROPEAN {
            let cell = sample.get(channel).map(|value| (value * factor).to_string().replace('.', ","));
            let _ = write!(text, ";{}", cell.unwrap_or_default());
        }
        text.push_str(";\"gut; ruhig\"\r\n");
    }
    text
}

fn milliseconds(time_s: f64) -> String {
    (time_s * 1e3).to_string().replace('.', ",")
}

/// The table of the project's recording, and its map.
fn written(name: &str, time: impl Fn(f64) -> String) -> (PathBuf, PathBuf, Vec<Sample>) {
    let folder = folder(name);
    let (table, map) = (folder.join("flug 12.csv"), folder.join("map.toml"));
    let samples = samples_of(&puma());
    std::fs::write(&table, european(&samples, time)).unwrap();
    std::fs::write(&map, MAP).unwrap();
    (table, map, samples)
}

fn assert_same(read: &[Sample], expected: &[Sample], offset_s: f64, channels: &[Channel]) {
    assert_eq!(read.len(), expected.len());
    for (read, expected) in read.iter().zip(expected) {
        // A quarter of a microsecond is the last place of times since 1970.
        assert!((read.time_s - expected.time_s - offset_s).abs() < 3e-7, "{} {}", read.time_s, expected.time_s);
        for channel in channels {
            match (read.get(*channel), expected.get(*channel)) {
                (Some(read), Some(expected)) => {
                    assert!((read - expected).abs() <= 1e-12 * expected.abs().max(1.0), "{channel:?}: {read} {expected}");
                }
                (read, expected) => assert_eq!(read, expected, "{channel:?}"),
            }
        }
    }
}

#[test]
fn a_european_spreadsheet_gives_the_samples_of_the_run_file() {
    let (table, map, expected) = written("maps-european", milliseconds);
    let out = table.with_file_name("ours.csv");
    let (status, _, said) = ended(&sideslip(&["convert", path(&table), path(&out), "--map", path(&map)]));
    assert_eq!(status, 0, "{said}");
    for found in ["cells are parted by `;`", "the decimal sign is a comma", "the time is in ms: neither header nor map"] {
        assert!(said.contains(found), "{found} is not in {said}");
    }
    assert_same(&samples_of(&out), &expected, 0.0, &EUROPEAN.map(|(channel, ..)| channel));
}

#[test]
fn every_command_that_reads_runs_takes_the_map() {
    let (table, map, _) = written("maps-commands", milliseconds);
    let (table, map) = (path(&table), path(&map));
    let model = crate::support::program::own("replay/models/puma.toml");
    let calls: [&[&str]; 7] = [
        &["inspect", table],
        &["replay", table],
        &["replay", table, "--bus"],
        &["check", table],
        &["identify", table, "--states", "v,p,phi,r"],
        &["compare", table, "--model", path(&model)],
        &["identify", table, "--response", "ay", "--candidates", "beta;p;r;pedal"],
    ];
    for call in calls {
        let (status, _, said) = ended(&sideslip(call));
        assert!(status == 2 && said.contains("--map-template"), "{call:?}: {said}");
        let (status, out, said) = ended(&sideslip(&[call, &["--map", map]].concat()));
        assert!(matches!(status, 0 | 3 | 4) && !out.is_empty(), "{call:?}: {status} {said}");
    }
}

#[test]
fn dates_are_seconds_of_their_day() {
    let (table, map, expected) = written("maps-dates", |time_s| {
        let ms = (time_s * 1e3).round() as u64 + 59_500;
        format!("2024-05-17T09:{:02}:{:02},{:03}Z", 30 + ms / 60_000, ms / 1000 % 60, ms % 1000)
    });
    let out = table.with_file_name("ours.csv");
    let (status, _, said) = ended(&sideslip(&["convert", path(&table), path(&out), "--map", path(&map)]));
    assert!(status == 0 && said.contains("the time is a date and time"), "{said}");
    let begin_s = 9.0 * 3600.0 + 30.0 * 60.0 + 59.5;
    assert!((samples_of(&out)[0].time_s - begin_s).abs() < 1e-9);
    assert_eq!(samples_of(&out).len(), expected.len());
    assert!(std::fs::read_to_string(&out).unwrap().contains("recorded_at = \"2024-05-17T09:30:59.500Z\""));
}

#[test]
fn dates_as_spreadsheets_write_them_and_numbers_of_samples_are_times() {
    let day_ms = |time_s: f64| (time_s * 1e3).round() as u64 + (9 * 3600 + 30 * 60) * 1000;
    let clock = move |time_s: f64| {
        let ms = day_ms(time_s);
        format!("{}:{:02}:{:02},{:03}", ms / 3_600_000, ms / 60_000 % 60, ms / 1000 % 60, ms % 1000)
    };
    let dotted = move |time_s: f64| format!("17.05.2024 {}", clock(time_s));
    let stroked = move |time_s: f64| format!("5/17/2024 {} AM", clock(time_s));
    let numbered = |time_s: f64| (50.0 * time_s).round().to_string();
    // date -d 2024-05-17 +%s
    let epoch = move |time_s: f64| (1_715_904_000_000 + day_ms(time_s)).to_string();
    let cases = [
        ("epoch", &epoch as &dyn Fn(f64) -> String, "time = \"Zeit\"", 34_200.0),
        ("dotted", &dotted, "time = \"Zeit\"", 34_200.0),
        ("stroked", &stroked, "time = { column = \"Zeit\", format = \"mdy\" }", 34_200.0),
        ("numbered", &numbered, "time = { column = \"Zeit\", rate_hz = 50 }", 0.0),
    ];
    for (name, time, line, begin_s) in cases {
        let (table, map, expected) = written(&format!("maps-{name}"), time);
        std::fs::write(&map, MAP.replace("time = \"Zeit\"", line)).unwrap();
        let out = table.with_file_name("ours.csv");
        let (status, _, said) = ended(&sideslip(&["convert", path(&table), path(&out), "--map", path(&map)]));
        assert_eq!(status, 0, "{name}: {said}");
        assert_same(&samples_of(&out), &expected, begin_s, &[Channel::P]);
        let dated = std::fs::read_to_string(&out).unwrap().contains("recorded_at = \"2024-05-17T09:30:00Z\"");
        assert_eq!(dated, begin_s > 0.0, "{name}");
    }
}

#[test]
fn refusals_say_what_to_do_next() {
    let folder = folder("maps-refused");
    let (table, map) = (folder.join("a.csv"), folder.join("map.toml"));
    std::fs::write(&table, "Time,Roll Rate [deg/s],q\n0,1,2\n0.1,1,2\n").unwrap();
    let refused = |args: &[&str]| {
        let (status, _, said) = ended(&sideslip(args));
        assert_eq!(status, 2, "{said}");
        said
    };
    let said = refused(&["replay", path(&table)]);
    for words in
        ["did you mean `Time` as time", "`Roll Rate [deg/s]` as p in deg/s", "sideslip inspect FILE --map-template map.toml"]
    {
        assert!(said.contains(words), "{words} is not in {said}");
    }
    for (text, words) in [
        ("time = \"Time\"\n[channels]\nq = \"q\"\n", "say it in the map: q = { column = \"q\", unit = \"...\" }"),
        ("time = \"Time\"\n[channels]\nq = \"Pitch\"\n", "expected a column `Pitch`, found none"),
        ("time = \"Time\"\n[channels]\nroll = \"q\"\n", "nearest is `"),
        ("time = \"Time\"\n[channels]\nq = { column = \"q\", unit = \"?\" }\n", "map.toml:3:"),
        ("time = \"Time\"\n[channels]\nq = { column = \"q\", unit = \"kn\" }\n", "(rad/s, deg/s, rpm, ...), found `kn`"),
        ("tim = \"Time\"\n[channels]\nq = \"q\"\n", "nearest is `time`"),
        ("time = \"Time\"\n[channels]\np = \"q\"\nq = \"q\"\n", "map, "),
    ] {
        std::fs::write(&map, text).unwrap();
        let said = refused(&["inspect", path(&table), "--map", path(&map)]);
        assert!(said.contains(words), "{words} is not in {said}");
    }
    // A near miss in a run file costs nothing and is said.
    std::fs::write(&table, "time,p (deg/s),q\n0,1,2\n0.1,1,2\n").unwrap();
    let (status, out, _) = ended(&sideslip(&["inspect", path(&table)]));
    assert!(status == 0 && out.contains("columns that are no channels: did you mean `p (deg/s)` as p in deg/s?"), "{out}");
}

#[test]
fn the_template_is_a_map_of_its_file() {
    let (table, _, expected) = written("maps-template", milliseconds);
    let (map, out) = (table.with_file_name("template.toml"), table.with_file_name("ours.csv"));
    let (status, _, said) = ended(&sideslip(&["inspect", path(&table), "--map-template", path(&map)]));
    assert!(status == 0 && said.contains("guesses to be checked"), "{said}");
    let (status, _, said) = ended(&sideslip(&["inspect", path(&table), "--map-template", path(&map)]));
    assert!(status == 2 && said.contains("exists already"), "{said}");
    // Two units are not stated, or are none.
    let written = std::fs::read_to_string(&map).unwrap();
    let theta = "theta = { column = \"Pitch\", unit = \"?\" }";
    let pedal = "pedal = { column = \"Pedal Position [%]\", unit = \"?\" }";
    assert!(written.contains(theta) && written.contains(pedal), "{written}");
    let said = written
        .replace(theta, &theta.replace('?', "deg"))
        .replace(pedal, &pedal.replace('?', "rad\", scale = 0.004, sign = 1.0 }#"));
    std::fs::write(&map, said).unwrap();
    let (status, _, said) = ended(&sideslip(&["convert", path(&table), path(&out), "--map", path(&map)]));
    assert_eq!(status, 0, "{said}");
    assert_same(&samples_of(&out), &expected, 0.0, &EUROPEAN.map(|(channel, ..)| channel));
}

#[test]
fn tables_in_several_files_are_one_recording() {
    let folder = folder("maps-files");
    let expected = samples_of(&puma());
    let file = |topic: &str, header: &str, row: &dyn Fn(&Sample) -> Option<String>| {
        let mut text = format!("timestamp,{header}\n");
        for sample in &expected {
            if let Some(row) = row(sample) {
                let _ = writeln!(text, "{},{row}", (sample.time_s * 1e6).round());
            }
        }
        std::fs::write(folder.join(format!("flight_{topic}_0.csv")), text).unwrap();
    };
    let vector = |sample: &Sample, channels: [Channel; 3]| {
        let values = channels.map(|channel| sample.get(channel));
        values
            .iter()
            .copied()
            .collect::<Option<Vec<f64>>>()
            .map(|values| values.iter().map(f64::to_string).collect::<Vec<_>>().join(","))
    };
    file("vehicle_angular_velocity", "xyz[0],xyz[1],xyz[2]", &|sample| vector(sample, Channel::GYROS));
    file("vehicle_acceleration", "xyz[0],xyz[1],xyz[2]", &|sample| vector(sample, Channel::ACCELEROMETERS));
    file("airspeed", "true_airspeed_m_s", &|sample| sample.get(Channel::Tas).map(|value| value.to_string()));
    file("vehicle_attitude", "q[0],q[1],q[2],q[3]", &|sample| {
        let half = [Channel::Phi, Channel::Theta, Channel::Psi].map(|channel| sample.get(channel).map(|angle| angle / 2.0));
        let [Some(roll), Some(pitch), Some(yaw)] = half else { return None };
        let ((sr, cr), (sp, cp), (sy, cy)) = (roll.sin_cos(), pitch.sin_cos(), yaw.sin_cos());
        let quaternion =
            [cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy];
        Some(quaternion.map(|part| part.to_string()).join(","))
    });
    let map = folder.join("map.toml");
    let three = |names: [&str; 3], unit: &str| {
        (0..3).map(|at| format!("{} = {{ column = \"xyz[{at}]\", unit = \"{unit}\" }}\n", names[at])).collect::<String>()
    };
    let section = |topic: &str, channels: &str| {
        format!(
            "[[file]]\nends = \"_{topic}_0.csv\"\ntime = {{ column = \"timestamp\", unit = \"us\" }}\n[file.channels]\n{channels}"
        )
    };
    let text = [
        section("vehicle_angular_velocity", &three(["p", "q", "r"], "rad/s")),
        section("vehicle_acceleration", &three(["ax", "ay", "az"], "m/s^2")),
        section("airspeed", "tas = \"true_airspeed_m_s\"\n"),
        section("vehicle_attitude", "attitude = [\"q[0]\", \"q[1]\", \"q[2]\", \"q[3]\"]\n"),
    ];
    std::fs::write(&map, text.concat()).unwrap();
    let channels: Vec<Channel> = Channel::ALL[..10].to_vec();
    // By the folder, by the beginning of the names, and by one of the files.
    let one = folder.join("flight_airspeed_0.csv");
    for (name, given) in [("by-folder.mcap", folder.clone()), ("by-begin.mcap", folder.join("flight")), ("by-file.mcap", one)] {
        let out = folder.join(name);
        let (status, _, said) = ended(&sideslip(&["convert", path(&given), path(&out), "--map", path(&map)]));
        assert_eq!(status, 0, "{said}");
        assert_same(&samples_of(&out), &expected, 0.0, &channels);
    }
    std::fs::write(folder.join("other_airspeed_0.csv"), "timestamp,true_airspeed_m_s\n0,1\n").unwrap();
    let (status, _, said) = ended(&sideslip(&["inspect", path(&folder), "--map", path(&map)]));
    assert!(status == 2 && said.contains("name the beginning of one recording's"), "{said}");
    let (status, out, said) = ended(&sideslip(&["inspect", path(&folder.join("flight")), "--map", path(&map)]));
    assert!(status == 0 && out.contains("CSV in several files"), "{said}");
    std::fs::remove_file(folder.join("flight_vehicle_attitude_0.csv")).unwrap();
    let (status, _, said) = ended(&sideslip(&["inspect", path(&folder.join("flight")), "--map", path(&map)]));
    assert!(status == 2 && said.contains("ends with `_vehicle_attitude_0.csv`, found none"), "{said}");
}

#[test]
fn a_folder_of_ulog2csv_gets_a_map_of_its_files() {
    let folder = folder("maps-ulog2csv");
    let rows = |header: &str, row: &str| {
        let rows: String = (0..20).map(|at| format!("{},{row}\n", at * 4000)).collect();
        format!("timestamp,{header}\n{rows}")
    };
    let gyros = "gyro_rad[0],gyro_rad[1],gyro_rad[2],accelerometer_m_s2[0],accelerometer_m_s2[1],accelerometer_m_s2[2]";
    for (topic, text) in [
        ("sensor_combined", rows(gyros, "0.1,0.2,0.3,1,2,-9.8")),
        ("vehicle_attitude", rows("q[0],q[1],q[2],q[3]", "1,0,0,0")),
        ("airspeed", rows("calibrated_airspeed_m_s,true_airspeed_m_s", "50,51")),
        ("cpuload", rows("load", "0.5")),
    ] {
        std::fs::write(folder.join(format!("flight_{topic}_0.csv")), text).unwrap();
    }
    let (status, map, said) = ended(&sideslip(&["inspect", path(&folder), "--map-template"]));
    assert_eq!(status, 0, "{said}");
    for words in [
        "[[file]]\nends = \"_sensor_combined_0.csv\"",
        "time = { column = \"timestamp\", unit = \"us\" }",
        "p = { column = \"gyro_rad[0]\", unit = \"?\" }",
        "attitude = [\"q[0]\", \"q[1]\", \"q[2]\", \"q[3]\"]",
        "\ntas = \"true_airspeed_m_s\"",
        "#   \"_cpuload_0.csv\": timestamp load",
    ] {
        assert!(map.contains(words), "{words} is not in\n{map}");
    }
    let file = folder.join("map.toml");
    std::fs::write(&file, map.replace("\"?\"", "\"rad/s\"")).unwrap();
    let (status, out, said) = ended(&sideslip(&["inspect", path(&folder), "--map", path(&file)]));
    assert!(status == 0 && out.contains("median rate 250 Hz") && out.contains("phi"), "{said}{out}");
}

#[test]
fn a_run_file_of_another_program_in_ms_is_read_as_such_and_ours_never() {
    let folder = folder("maps-run-file");
    let file = folder.join("a.csv");
    let rows: String = (0..20).map(|at| format!("{};0,5\n", at * 20)).collect();
    for (head, range, found) in [("", "time 0 to 0.38 s", true), ("# run = \"7\"\n", "time 0 to 380 s", false)] {
        std::fs::write(&file, format!("{head}time;p[deg/s]\n{rows}")).unwrap();
        let (status, out, said) = ended(&sideslip(&["inspect", path(&file)]));
        assert!(status == 0 && out.contains(range), "{said}{out}");
        assert!(out.contains("cells are parted by `;`") && out.contains("the decimal sign is a comma"), "{out}");
        assert_eq!(out.contains("the time is in ms: its header states no unit, rows are 20 apart"), found, "{out}");
    }
}
