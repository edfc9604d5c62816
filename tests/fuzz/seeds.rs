//! The seeds of the corpus: small files of every format, made by the project's own encoders, the same at each call.

use super::targets::pcm::FORMATS;
use sideslip::flight::channel::{Channel, ControlNames};
use sideslip::flight::file::log_head::LogHead;
use sideslip::flight::file::run_file::{RunFileWriter, RunInfo};
use sideslip::flight::sample::Sample;
use sideslip::io::telemetry::logs::encode::dataflash::{DataflashCell, DataflashWriter};
use sideslip::io::telemetry::logs::encode::flight::SimulatedFlight;
use sideslip::io::telemetry::logs::encode::ulog::UlogWriter;
use sideslip::io::telemetry::mavlink::encode::{Encoder, ME};
use sideslip::io::telemetry::mavlink::mapping::MavlinkConfig;
use sideslip::io::telemetry::mavlink::tlog::write_record;
use sideslip::io::telemetry::pcm::encoder::PcmEncoder;
use sideslip::io::telemetry::pcm::layout::PcmFormat;
use std::collections::BTreeMap;
use std::io::Cursor;

/// A seed: name of its target, of the file, content.
pub(crate) type Seed = (&'static str, &'static str, Vec<u8>);

const SETUP: &str = "G\\PN:SEED;R-1\\TK1-1:7;R-1\\CDLN-1:A;R-1\\PDP-1:TM;R-1\\TK1-2:8;R-1\\DSI-2:S;M-7\\ID:S;M-7\\BB\\DLN:B;\n\
    COMMENT: made for tests;P-1\\DLN:A;P-1\\D1:NRZ-L;P-1\\D2:1000000;P-1\\D4:N;P-1\\D7:N;P-1\\F1:8;P-1\\F2:M;\
    P-1\\F3:NO;P-1\\MF\\N:4;\
    P-1\\MF1:5;P-1\\MF2:48;P-1\\MF4:16;P-1\\MF5:1110101110010000;P-1\\SYNC1:2;P-1\\MFW1-1:2;P-1\\MFW2-1:10;P-1\\ISF\\N:1;\
    P-1\\ISF1-1:ID;P-1\\IDC1-1:1;P-1\\IDC4-1:8;P-1\\IDC5-1:M;P-1\\IDC6-1:0;P-1\\IDC8-1:3;P-1\\IDC10-1:INC;P-2\\DLN:B;P-2\\MF1:3;";

const INSTRUMENTS: &str = "rate_hz = 100\naccelerometer_position_m = [0.4, 0.0, -0.2]\nvane_position_m = [6.5, 0.0, 0.5]\n\
    [channel.p]\nrate_hz = 256\nnoise = 0.001\nbias = 0.002\nbias_std = 0.0005\nscale = 1.01\nlag = 0.02\n\
    delay = 0.01\nbits = 12\n\
    range = [-1.0, 1.0]\ndropouts = { rate = 0.1, mean_length = 0.2 }\n[channel.tas]\nquantum = 0.1\n[dropouts]\nrate = 0.05\n\
    mean_length = 0.3\n[vibration]\nblades = 4\naz = [1.0, 0.3]\n";

const MAPPING: &str = "system = 1\ncomponent = 1\naircraft = \"fixed_wing\"\nreorder_ms = 20\n[sources]\n\
    specific_force = [\"HIGHRES_IMU\", \"SCALED_IMU\"]\nrates = [\"HIGHRES_IMU\", \"ATTITUDE\"]\nattitude = [\"ATTITUDE\"]\n\
    airspeed = [\"VFR_HUD\"]\nflow_angles = [\"AOA_SSA\"]\naltitude = []\ncontrols = [\"SERVO_OUTPUT_RAW\"]\n\
    rotor_speed = [\"RPM\"]\n\
    [controls.rudder]\nchannel = 4\nzero_us = 1500\nfull_us = 500\nfull_deg = -20\n[rpm]\nsensor = 1\nratio = 0.1\n";

const LINEAR: &str = "name = \"seed\"\nkind = \"linear\"\n[trim]\nu = 51.0\ntheta = 0.02\nrotor_speed = 28.0\n[trim.controls]\n\
    pedal = 0.01\n[tolerance]\nderivatives = 0.05\n[tolerance.N]\nr = 0.02\n[derivatives.N]\nv = 0.03\n\
    p = -0.2\nr = -0.5\npedal = -1.2\n\
    \"v*|v|\" = 1e-3\nrotor_speed = 0.01\n[derivatives.L]\np = -1.4\nlat_cyclic = 9.0\n[[effect]]\n\
    kind = \"derivative\"\naxis = \"N\"\n\
    variable = \"p\"\ndelta = -0.1\n";

/// Every seed.
pub(crate) fn seeds() -> Vec<Seed> {
    let mut all = vec![
        ("csv", "run", run_file()),
        (
            "csv",
            "units",
            b"# run = \"1\"\n#\n# note = [1, { a = 2 }]\r\ntime[ms],p[deg/s],egt [degC],x\r\n0,1,,nan\r\n10,-1e3,7,inf\r\n"
                .to_vec(),
        ),
        ("mavlink", "tlog", mavlink(true)),
        ("mavlink", "stream", mavlink(false)),
        ("mavlink_config", "all", MAPPING.into()),
        ("instruments", "all", INSTRUMENTS.into()),
        ("model", "linear", LINEAR.into()),
        ("model", "puma", include_bytes!("../../replay/models/puma.toml").to_vec()),
        ("tmats", "setup", SETUP.into()),
        ("chapter10", "recording", chapter10()),
        ("udp", "full", udp(1)),
        ("udp", "segments", udp(2)),
        ("udp", "stream", udp(3)),
        ("dataflash", "flight", flight().dataflash().unwrap()),
        ("dataflash", "types", dataflash_types()),
        ("ulog", "flight", flight().ulog().unwrap()),
        ("ulog", "kinds", ulog_kinds()),
        ("mcap", "log", mcap(false)),
        ("mcap", "chunks", mcap(true)),
    ];
    for (name, text) in ["bytes", "randomised", "inverted", "short"].into_iter().zip(FORMATS) {
        all.push(("pcm_format", name, text.into()));
    }
    for (choice, name) in (0_u8..).zip(["bytes", "randomised", "inverted", "short"]) {
        all.push(("pcm_stream", name, pcm(choice)));
    }
    all
}

/// A sample with some channels missing.
fn sample(step: u32) -> Sample {
    let time_s = 1.0 + 0.02 * f64::from(step);
    let mut sample = Sample::new(time_s);
    for channel in Channel::ALL.into_iter().filter(|channel| !(step as usize + channel.index()).is_multiple_of(7)) {
        sample.set(channel, 0.1 * libm::sin(time_s * (1.0 + channel.index() as f64)));
    }
    sample
}

fn run_file() -> Vec<u8> {
    let text = "run = \"7\"\naircraft = \"P\u{fc}ma\"\nblades = 4\nvane_position_m = [6.5, 0.0, 0.5]\n[own]\nkey = [1, 2.5]\n";
    let info = RunInfo::from_toml(text).unwrap();
    let mut writer = RunFileWriter::new(Vec::new(), &info, &[Channel::P, Channel::Beta, Channel::Pedal, Channel::Tas]).unwrap();
    for step in 0..12 {
        let sample = sample(step);
        writer.write_row(sample.time_s, |channel| sample.get(channel)).unwrap();
    }
    writer.finish().unwrap()
}

fn mavlink(stamped: bool) -> Vec<u8> {
    let mut encoder = Encoder::new(ME, MavlinkConfig::default(), ControlNames::FixedWing);
    let mut bytes = Vec::new();
    for step in 0..8 {
        let stamp_us = 1_600_000_000_000_000 + u64::from(step) * 20_000;
        encoder
            .sample(&sample(step), |frame| match stamped {
                true => write_record(&mut bytes, stamp_us, frame).unwrap(),
                false => bytes.extend_from_slice(frame),
            })
            .unwrap();
    }
    bytes
}

fn pcm(choice: u8) -> Vec<u8> {
    let format = PcmFormat::from_toml(FORMATS[usize::from(choice)]).unwrap();
    let mut encoder = PcmEncoder::new(&format, 0.0).unwrap();
    let mut bytes = vec![choice];
    for _ in 0..14 {
        encoder.minor_frame(|parameter, time_s| 3.0 * libm::sin(1e4 * time_s) + parameter as f64, &mut bytes).unwrap();
    }
    encoder.finish(&mut bytes);
    bytes
}

fn flight() -> SimulatedFlight {
    SimulatedFlight { duration_s: 0.6, imu_hz: 25.0, attitude_hz: 10.0, air_hz: 5.0 }
}

fn dataflash_types() -> Vec<u8> {
    let mut writer = DataflashWriter::new();
    writer.define(1, "ALL", "QaBbhHiIfdnNcCe", "TimeUS,a,B,b,h,H,i,I,f,d,n,N,c,C,e").unwrap();
    writer.define(2, "MORE", "IELMqQgZ", "TimeMS,E,L,M,q,Q,g,Z").unwrap();
    let number = DataflashCell::Number;
    for step in 0..3_u32 {
        let x = f64::from(step);
        let all = [
            DataflashCell::Whole(u64::from(step) * 1000),
            DataflashCell::Array(std::array::from_fn(|i| i as i16 * -1000)),
            number(x),
            number(-x),
            number(-300.0 * x),
            number(300.0 * x),
            number(-1e5 * x),
            number(1e5 * x),
            number(0.1 * x),
            number(0.1 * x),
            DataflashCell::Text("four"),
            DataflashCell::Text("sixteen bytes 16"),
            number(-0.01 * x),
            number(0.01 * x),
            number(-x),
        ];
        writer.message(1, &all).unwrap();
        let time = DataflashCell::Whole(u64::from(step));
        let more =
            [time, number(x), number(1e-7 * x), number(3.0), number(-9e15), number(x), number(-1.5), DataflashCell::Text("")];
        writer.message(2, &more).unwrap();
    }
    writer.garbage(&[0xA3, 0x95, 9, 0xA3]);
    writer.bytes().to_vec()
}

fn ulog_kinds() -> Vec<u8> {
    let mut writer = UlogWriter::new(5_000_000);
    writer.keyed(b'I', "char[4] sys_name", b"seed").unwrap();
    writer.message(b'M', &[&[0, 10], b"char[2] pe", b"ab"]).unwrap();
    writer.keyed(b'P', "float GAIN", &0.5_f32.to_le_bytes()).unwrap();
    writer.message(b'Q', &[&[1, 10], b"float GAIN", &0.25_f32.to_le_bytes()]).unwrap();
    writer.format("outer:uint64_t timestamp;inner[2] parts;bool ok;uint8_t[7] _padding0;").unwrap();
    writer.format("inner:uint16_t x;int8_t[3] y;double z;").unwrap();
    writer.format("narrow:uint32_t timestamp;char[5] text;").unwrap();
    writer.subscribe(0, 3, "outer").unwrap();
    writer.subscribe(1, 4, "narrow").unwrap();
    for step in 0..4_u64 {
        let time = (5_000_000 + 1000 * step).to_le_bytes();
        writer
            .data(3, &[&time, &[1, 0, 2, 3, 4], &1.5_f64.to_le_bytes(), &[5, 0, 6, 7, 8], &2.5_f64.to_le_bytes(), &[1]])
            .unwrap();
        writer.data(4, &[&time[..4], b"hello"]).unwrap();
    }
    writer.message(b'L', &[b"6", &9_u64.to_le_bytes(), b"a line"]).unwrap();
    writer.message(b'C', &[b"6", &[1, 0], &9_u64.to_le_bytes(), b"a line"]).unwrap();
    writer.sync();
    writer.dropout(20);
    writer.message(b'R', &[&4_u16.to_le_bytes()]).unwrap();
    writer.append();
    writer.data(3, &[&[0; 35]]).unwrap();
    writer.bytes().to_vec()
}

/// A log like the program's, without compression and checksums, so that mutations reach what is inside.
fn mcap(chunks: bool) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let options = mcap::WriteOptions::new().compression(None).calculate_chunk_crcs(false).calculate_data_section_crc(false);
    let mut writer = options.library("seed").use_chunks(chunks).create(&mut file).unwrap();
    let columns = [("ax", "m/s^2"), ("p", "rad/s"), ("fuel", "litre"), ("rudder", "rad")];
    let head = LogHead {
        run_toml: "run = \"1\"\n".to_owned(),
        channels: columns.map(|(name, unit)| (name.to_owned(), unit.to_owned())).to_vec(),
        controls: ControlNames::FixedWing,
        ..LogHead::default()
    };
    writer.write_metadata(&mcap::write::Metadata { name: "run".to_owned(), metadata: head.to_metadata("seed") }).unwrap();
    let channel_id = writer.add_channel(0, "/sample", "json", &BTreeMap::new()).unwrap();
    for sequence in 0..6 {
        let header = mcap::records::MessageHeader { channel_id, sequence, log_time: 0, publish_time: 0 };
        let payload = format!(r#"{{"time":{sequence},"p":1e-3,"fuel":null,"more":[{{"a":"\u00e4"}}],"rudder":-0.25}}"#);
        writer.write_to_known_channel(&header, payload.as_bytes()).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    file.into_inner()
}

/// A packet after the layout in the standard, without a data checksum.
fn packet(channel: u16, data_type: u8, sequence: u8, rtc: u64, body: &[u8]) -> Vec<u8> {
    let mut filled = body.to_vec();
    filled.resize(body.len().next_multiple_of(4), 0);
    let mut bytes = vec![0x25, 0xEB];
    bytes.extend(channel.to_le_bytes());
    bytes.extend((24 + filled.len() as u32).to_le_bytes());
    bytes.extend((body.len() as u32).to_le_bytes());
    bytes.extend([3, sequence, 0, data_type]);
    bytes.extend(&rtc.to_le_bytes()[..6]);
    let sum: u32 = bytes.chunks(2).map(|word| u32::from(word[0]) + 256 * u32::from(word[1])).sum();
    bytes.extend((sum as u16).to_le_bytes());
    bytes.extend(filled);
    bytes
}

fn packets() -> Vec<Vec<u8>> {
    let line = &pcm(0)[1..];
    let swapped: Vec<u8> = line.as_chunks::<2>().0.iter().flat_map(|[high, low]| [*low, *high]).collect();
    let packed: Vec<u8> = (0..3).flat_map(|n| [&[n, 0, 0, 0, 0, 0, 0, 0, 0, 0xF0][..], &swapped[..10]].concat()).collect();
    vec![
        packet(0, 0x01, 0, 0, &[&[8, 0, 0, 0][..], SETUP.as_bytes()].concat()),
        packet(1, 0x11, 0, 1000, &[1, 0, 0, 0, 0, 0x01, 0x02, 0x03, 0x04, 0]),
        packet(7, 0x09, 0, 2000, &[&[0, 0, 0x10, 0][..], &swapped].concat()),
        packet(7, 0x09, 1, 9000, &[&[0, 0, 0x10, 0][..], &swapped].concat()),
        packet(8, 0x09, 0, 9500, &[&[0, 0, 0x08, 0x40][..], &packed].concat()),
        packet(9, 0xAB, 0, 9600, &[1, 2, 3]),
    ]
}

fn chapter10() -> Vec<u8> {
    packets().concat()
}

/// The packets as datagrams of a format, each behind its length.
fn udp(format: u8) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut datagram = |parts: &[&[u8]]| {
        let datagram = parts.concat();
        bytes.extend((datagram.len() as u16).to_le_bytes());
        bytes.extend(datagram);
    };
    let all = packets();
    let mut number = 0_u32;
    match format {
        1 => all.iter().for_each(|packet| {
            datagram(&[&(number << 8 | 1).to_le_bytes(), packet]);
            number += 1;
        }),
        2 => {
            for packet in &all {
                for (part, offset) in packet.chunks(100).zip((0_u32..).step_by(100)) {
                    datagram(&[
                        &(number << 8 | 0x11).to_le_bytes(),
                        &packet[2..4],
                        &[packet[13], 0],
                        &offset.to_le_bytes(),
                        part,
                    ]);
                    number += 1;
                }
            }
        }
        _ => all.concat().chunks(150).for_each(|part| {
            datagram(&[&[0x13, 0, 0xFF, 0xFF], &(0x5000_0000 | number).to_le_bytes(), part]);
            number += 1;
        }),
    }
    bytes
}
