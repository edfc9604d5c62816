//! Streams of simulated samples, read back by the decoder of the same format.

use super::super::decoder::PcmDecoder;
use super::super::rows::PcmRows;
use super::*;

/// A flight of 2 s: rates at 256 Hz, forces at 128, airspeed at 32, the attitude where `irregular` says so.
fn flight(irregular: impl Fn(u32) -> bool) -> Vec<Sample> {
    (0..512_u32)
        .map(|at| {
            let mut sample = Sample::new(f64::from(at) / 256.0);
            let value = f64::from(at) / 512.0;
            sample.set(Channel::R, value);
            if at % 2 == 0 {
                sample.set(Channel::Ay, -value);
            }
            if at % 8 == 0 {
                sample.set(Channel::Tas, 50.0 + value);
            }
            if irregular(at) {
                sample.set(Channel::Phi, 2.0 * value);
            }
            sample
        })
        .collect()
}

fn received(stream: &SampleStream) -> (Vec<Sample>, u64) {
    let format = PcmFormat::from_toml(&stream.format).unwrap();
    let (mut decoder, mut rows, mut samples) = (PcmDecoder::new(&format, 0.0), PcmRows::new(&format).unwrap(), Vec::new());
    decoder.feed(&stream.line, |sample| rows.put(&sample, &mut |row| samples.push(row.sample)));
    decoder.finish(|sample| rows.put(&sample, &mut |row| samples.push(row.sample)));
    rows.finish(&mut |row| samples.push(row.sample));
    (samples, rows.unused().no_value)
}

#[test]
fn what_was_sampled_comes_back_and_nothing_else() {
    for (irregular, unused) in [(false, 0), (true, 512 - 74)] {
        let sent = flight(|at| if irregular { at % 7 == 0 && at < 505 || at == 510 } else { at % 4 == 2 });
        let stream = stream_of_samples(&sent, ControlNames::FixedWing, &toml::Table::new()).unwrap();
        let (samples, no_value) = received(&stream);
        assert_eq!((samples.len(), no_value), (sent.len(), unused), "{}", stream.format);
        for (sent, got) in sent.iter().zip(&samples) {
            assert_eq!(sent.present, got.present);
            assert!((0.0..ROW_S).contains(&(got.time_s - sent.time_s)), "{} {}", got.time_s, sent.time_s);
            for channel in Channel::ALL {
                let pair = sent.get(channel).zip(got.get(channel));
                assert!(pair.is_none_or(|(one, other)| (one - other).abs() <= 1e-7 * one.abs()), "{channel:?}");
            }
        }
    }
}

#[test]
fn what_the_run_says_of_itself_stands_in_the_format() {
    let run: toml::Table = "aircraft = \"x\"\nvane_position_m = [1.0, 2.0, 3.0]\n[level1]\nhub = \"exact\"\n".parse().unwrap();
    let stream = stream_of_samples(&flight(|_| false), ControlNames::Rotorcraft, &run).unwrap();
    let file = super::super::format_file::PcmFormatFile::from_toml(&stream.format).unwrap();
    assert_eq!((file.info.aircraft(), file.info.geometry().vane_position_m), (Some("x"), [1.0, 2.0, 3.0]));
}

#[test]
fn times_that_are_no_frames_are_refused() {
    let stream = |samples: &[Sample]| stream_of_samples(samples, ControlNames::Rotorcraft, &toml::Table::new());
    let mut samples = flight(|_| false);
    assert_eq!(stream(&[]), Err(SampleStreamError::Samples(0)));
    assert_eq!(stream(&samples[..1]), Err(SampleStreamError::Samples(1)));
    assert_eq!(stream(&[Sample::new(0.0), Sample::new(1.0)]), Err(SampleStreamError::Samples(0)));
    samples[100].time_s += 0.4 / 256.0;
    assert!(matches!(stream(&samples), Err(SampleStreamError::Time { .. })));
    samples[100].time_s = samples[99].time_s;
    assert!(matches!(stream(&samples), Err(SampleStreamError::Rate(_))));
    // A second without a sample is a second of frames without numbers.
    let mut samples = flight(|_| false);
    samples.drain(100..356);
    let (got, no_value) = received(&stream(&samples).unwrap());
    assert_eq!(got.len(), 256);
    assert_eq!(no_value, 256 + 128 + 32);
    for (got, sent) in got.iter().zip(&samples) {
        assert!((0.0..ROW_S).contains(&(got.time_s - sent.time_s)), "{} {}", got.time_s, sent.time_s);
    }
}
