//! `sideslip convert` as a user runs it: every format comes back as it was, clocks are joined, nothing is overwritten.

use crate::support::program::{ended, folder, path, sideslip};
use sideslip::io::telemetry::pcm::encoder::PcmEncoder;
use sideslip::io::telemetry::pcm::layout::PcmFormat;
use std::fmt::Write as _;

const RUN: &str =
    "# manoeuvre = \"doublet\"\n# run = \"7\"\ntime,p,pedal,oil[K]\n0,0.1,,300.5\n0.01,-0.25,0.001,\n0.02,,0.002,301\n";

#[test]
fn a_run_file_by_way_of_a_log_comes_back_bit_for_bit() {
    let folder = folder("convert-there-and-back");
    let (csv, mcap, back) = (folder.join("a.csv"), folder.join("a.mcap"), folder.join("b.csv"));
    std::fs::write(&csv, RUN).unwrap();
    for (from, to) in [(&csv, &mcap), (&mcap, &back)] {
        let (status, _, said) = ended(&sideslip(&["convert", path(from), path(to)]));
        assert_eq!(status, 0, "{said}");
        assert!(said.contains("3 samples"), "{said}");
    }
    assert_eq!(std::fs::read_to_string(&back).unwrap(), RUN);
    // What is there is kept, unless it is said otherwise.
    let (status, _, said) = ended(&sideslip(&["convert", path(&csv), path(&back)]));
    assert!(status == 2 && said.contains("exists already"), "{said}");
    let (status, ..) = ended(&sideslip(&["convert", path(&csv), path(&back), "--force", "--from", "0.005"]));
    assert_eq!(status, 0);
    assert_eq!(std::fs::read_to_string(&back).unwrap(), RUN.replace("0,0.1,,300.5\n", ""));
}

const FORMAT: &str = "bit_rate = 100_000\nwords = 5\nword_bits = 16\n[sync]\npattern = 0xFE6B_2840\nbits = 32\n[[parameter]]\n\
    name = \"p\"\nunit = \"deg/s\"\nword = 1\nencoding = \"twos_complement\"\n\
    calibration = { kind = \"polynomial\", coefficients = [0, 0.01] }\n[run]\naircraft = \"Test\"\n";

#[test]
fn a_stream_of_pcm_is_read_with_the_format_of_its_frames() {
    let folder = folder("convert-pcm");
    let (pcm, format, csv) = (folder.join("a.pcm"), folder.join("frame.toml"), folder.join("a.csv"));
    let mut encoder = PcmEncoder::new(&PcmFormat::from_toml(FORMAT).unwrap(), 0.0).unwrap();
    let mut bytes = vec![0x5A; 3];
    for frame in 0..50 {
        encoder.minor_frame(|_, _| f64::from(frame), &mut bytes).unwrap();
    }
    encoder.finish(&mut bytes);
    std::fs::write(&pcm, bytes).unwrap();
    std::fs::write(&format, FORMAT).unwrap();
    let url = format!("pcm+file://{}?format={}", path(&pcm), path(&format));
    let (status, _, said) = ended(&sideslip(&["convert", &url, path(&csv)]));
    assert_eq!(status, 0, "{said}");
    let text = std::fs::read_to_string(&csv).unwrap();
    assert!(text.starts_with("# aircraft = \"Test\"\n# run = \"a\"\ntime,p\n"), "{text}");
    let rates: Vec<f64> = text.lines().skip(3).map(|line| line.split(',').nth(1).unwrap().parse().unwrap()).collect();
    assert_eq!(rates.len(), 50);
    rates.iter().zip(0..).for_each(|(rate, frame)| assert!((rate.to_degrees() - f64::from(frame)).abs() < 1e-9));
    let (status, table, _) = ended(&sideslip(&["inspect", &url]));
    assert!(status == 0 && table.contains("PCM") && table.contains("50 rows"), "{table}");
    // Without its format, or with another pattern, it is no recording.
    let (status, _, said) = ended(&sideslip(&["inspect", &format!("pcm+file://{}", path(&pcm))]));
    assert!(status == 2 && said.contains("?format="), "{said}");
    std::fs::write(&format, FORMAT.replace("FE6B_2840", "1ACF_FC1D")).unwrap();
    let (status, _, said) = ended(&sideslip(&["convert", &url, path(&csv), "--force"]));
    assert!(status == 2 && said.contains("sync pattern 1ACFFC1D"), "{said}");
    assert_eq!(std::fs::read_to_string(&csv).unwrap(), text, "what stood there stays");
    std::fs::write(&format, FORMAT.replace("word = 1", "wrod = 1")).unwrap();
    let (status, _, said) = ended(&sideslip(&["convert", &url, path(&csv), "--force"]));
    assert!(status == 2 && said.contains("nearest is `word`"), "{said}");
}

/// A broad-band signal without a period, the same at the same time whatever the clock.
fn signal(time_s: f64) -> f64 {
    let line = |k: f64| (0.07 * k.powf(1.37) * time_s + k * k).sin() * 0.1 / k.sqrt();
    (1..60).map(|k| line(f64::from(k))).sum()
}

fn two_recordings(folder: &std::path::Path, theirs: impl Fn(f64) -> f64) -> (std::path::PathBuf, std::path::PathBuf) {
    let (one, two) = (folder.join("one.csv"), folder.join("two.csv"));
    let (mut first, mut second) = ("time,q,p\n".to_owned(), "time,q,tas\n".to_owned());
    for n in 0..6000 {
        let time_s = 0.02 * f64::from(n);
        let noise = f64::from((n * 7919 + 13) % 101 - 50) * 1e-4;
        writeln!(first, "{time_s},{},0.5", signal(time_s) + noise).unwrap();
        let their_s = 0.02 * f64::from(n) + 0.007;
        let noise = f64::from((n * 104_729 + 7) % 103 - 51) * 1e-4;
        writeln!(second, "{their_s},{},50", theirs(their_s) + noise).unwrap();
    }
    std::fs::write(&one, first).unwrap();
    std::fs::write(&two, second).unwrap();
    (one, two)
}

#[test]
fn a_second_recording_is_put_on_the_clock_of_the_first() {
    let folder = folder("convert-merge");
    let (one, two) = two_recordings(&folder, |their_s| signal(3.25 + their_s * (1.0 + 50e-6)));
    let out = folder.join("both.csv");
    let (status, _, said) = ended(&sideslip(&["convert", path(&one), path(&out), "--merge", path(&two), "--shared", "q"]));
    assert_eq!(status, 0, "{said}");
    let numbers: Vec<f64> = said.split_whitespace().filter_map(|word| word.trim_end_matches(',').parse().ok()).collect();
    let [offset, offset_std, drift, drift_std, ..] = numbers[..] else { panic!("{said}") };
    assert!((offset - 3.25).abs() < 4.0 * offset_std && offset_std < 0.01, "{said}");
    assert!((drift - 50.0).abs() < 4.0 * drift_std && drift_std < 50.0, "{said}");
    let text = std::fs::read_to_string(&out).unwrap();
    assert!(text.contains("time,q,p,tas\n"), "{}", &text[..200]);
    // A relation that is given is used as it is.
    let given = ["--clock-offset", "3.25", "--clock-drift", "50", "--force"];
    let call = [&["convert", path(&one), path(&out), "--merge", path(&two)], &given[..]].concat();
    let (status, _, said) = ended(&sideslip(&call));
    assert_eq!(status, 0, "{said}");
    let with_tas = std::fs::read_to_string(&out).unwrap();
    let first = with_tas.lines().find(|line| line.ends_with(",50")).unwrap();
    let time_s: f64 = first.split(',').next().unwrap().parse().unwrap();
    assert!((time_s - (3.25 + 0.007 * (1.0 + 50e-6))).abs() < 1e-9, "{first}");
}

#[test]
fn clocks_without_a_relation_are_not_joined() {
    let folder = folder("convert-unrelated");
    let (one, two) = two_recordings(&folder, |their_s| signal(1e5 - 1.7 * their_s));
    let out = folder.join("both.csv");
    let (status, _, said) = ended(&sideslip(&["convert", path(&one), path(&out), "--merge", path(&two), "--shared", "q"]));
    assert!(status == 4 && said.contains("not known, because") && !out.exists(), "{said}");
    for (more, words) in [
        (&["--merge", path(&two)][..], "--shared CHANNEL or --clock-offset"),
        (&["--merge", path(&two), "--shared", "beta"], "expected a column `beta`"),
    ] {
        let (status, _, said) = ended(&sideslip(&[&["convert", path(&one), path(&out)], more].concat()));
        assert!(status == 2 && said.contains(words) && !out.exists(), "{said}");
    }
}
