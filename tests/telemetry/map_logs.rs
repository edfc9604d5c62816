//! MCAP logs of other programs, messages in JSON, read by a map of topics and fields.

use crate::support::program::{ended, folder, path, puma, sideslip};
use crate::support::recorded_samples::samples_of;
use mcap::records::MessageHeader;
use serde_json::json;
use sideslip::flight::channel::Channel;
use sideslip::flight::sample::Sample;
use std::collections::BTreeMap;
use std::path::Path;

/// 2024-05-17T09:30:00Z.
const BEGIN_NS: u64 = 1_715_938_200_000_000_000;

const MAP: &str = "[[topic]]\nname = \"/imu\"\n[topic.channels]\n\
    p = { field = \"angular_velocity.x\", unit = \"rad/s\" }\nq = { field = \"angular_velocity.y\", unit = \"rad/s\", sign = -1 }\n\
    r = { field = \"angular_velocity.z\", unit = \"rad/s\", sign = -1 }\nax = { field = \"acceleration[0]\", unit = \"g\" }\n\
    ay = { field = \"acceleration[1]\", unit = \"g\" }\naz = { field = \"acceleration[2]\", unit = \"g\" }\n\
    [[topic]]\nname = \"/air\"\ntime = { field = \"stamp\", format = \"iso8601\" }\n[topic.channels]\ntas = \"airspeed_kts\"\n\
    [run]\naircraft = \"Puma\"\n";

/// A log of axes forward, left, up, as robots have them, with the airspeed under a time stamp of its own.
fn write(file: &Path, samples: &[Sample], encoding: &str) {
    let mut writer = mcap::Writer::new(std::fs::File::create(file).unwrap()).unwrap();
    let imu = writer.add_channel(0, "/imu", encoding, &BTreeMap::new()).unwrap();
    let air = writer.add_channel(0, "/air", encoding, &BTreeMap::new()).unwrap();
    for sample in samples {
        let log_time = BEGIN_NS + (sample.time_s * 1e9).round() as u64;
        let of = |channel| sample.get(channel).unwrap();
        let ns = (sample.time_s * 1e9).round() as u64;
        let (sec, nanosec) = (BEGIN_NS / 1_000_000_000 + ns / 1_000_000_000, ns % 1_000_000_000);
        let messages = [
            (
                imu,
                json!({"angular_velocity": {"x": of(Channel::P), "y": -of(Channel::Q), "z": -of(Channel::R)},
                       "acceleration": Channel::ACCELEROMETERS.map(|channel| of(channel) / 9.806_65)}),
            ),
            (air, json!({"stamp": {"sec": sec, "nanosec": nanosec}, "airspeed_kts": of(Channel::Tas) * 3600.0 / 1852.0})),
        ];
        for (channel_id, message) in messages {
            let header = MessageHeader { channel_id, sequence: 0, log_time, publish_time: log_time };
            writer.write_to_known_channel(&header, &serde_json::to_vec(&message).unwrap()).unwrap();
        }
    }
    writer.finish().unwrap();
}

#[test]
fn topics_and_fields_give_the_samples_that_they_were_made_of() {
    let folder = folder("maps-mcap");
    let (log, map, out) = (folder.join("robot.mcap"), folder.join("map.toml"), folder.join("ours.csv"));
    let motion: Vec<Channel> = Channel::INERTIAL.into_iter().chain([Channel::Tas]).collect();
    let whole = |sample: &Sample| motion.iter().all(|channel| sample.get(*channel).is_some());
    let expected: Vec<Sample> = samples_of(&puma()).into_iter().filter(whole).take(500).collect();
    write(&log, &expected, "json");
    std::fs::write(&map, MAP).unwrap();
    let (status, _, said) = ended(&sideslip(&["convert", path(&log), path(&out)]));
    assert!(status == 2 && said.contains("`/imu`") || said.contains("/imu") && said.contains("read by a map"), "{said}");
    let (status, _, said) = ended(&sideslip(&["convert", path(&log), path(&out), "--map", path(&map)]));
    assert_eq!(status, 0, "{said}");
    let read = samples_of(&out);
    assert_eq!(read.len(), expected.len());
    for (read, expected) in read.iter().zip(&expected) {
        // 09:30 of that day.
        assert!((read.time_s - 34_200.0 - expected.time_s).abs() < 1e-6, "{} {}", read.time_s, expected.time_s);
        for channel in &motion {
            let (read, expected) = (read.get(*channel).unwrap(), expected.get(*channel).unwrap());
            assert!((read - expected).abs() <= 1e-12 * expected.abs().max(1.0), "{channel:?}: {read} {expected}");
        }
    }
}

#[test]
fn what_a_log_lacks_or_writes_otherwise_is_said() {
    let folder = folder("maps-mcap-refused");
    let (log, map) = (folder.join("robot.mcap"), folder.join("map.toml"));
    let expected: Vec<Sample> = samples_of(&puma()).into_iter().take(3).collect();
    let refused = |text: &str| {
        std::fs::write(&map, text).unwrap();
        let (status, _, said) = ended(&sideslip(&["inspect", path(&log), "--map", path(&map)]));
        assert_eq!(status, 2, "{said}");
        said
    };
    write(&log, &expected, "json");
    let said = refused(&MAP.replace("/imu", "/gyro"));
    assert!(said.contains("expected a topic `/gyro`, found `/air` `/imu`"), "{said}");
    let said = refused("time = \"t\"\n[channels]\np = \"x\"\n");
    assert!(said.contains("expected a map of topics ([[topic]])"), "{said}");
    let said = refused(&MAP.replace("field = \"angular_velocity.x\", unit = \"rad/s\"", "field = \"angular_velocity.x\""));
    assert!(said.contains("p: expected the unit of column `angular_velocity.x`"), "{said}");
    write(&log, &expected, "cdr");
    let said = refused(MAP);
    assert!(said.contains("expected messages in JSON, found `cdr`"), "{said}");
}
