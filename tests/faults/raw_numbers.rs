//! Numbers that no table shows raw: NaN, infinities, rows of digits; from models and recordings that hold such.

use crate::support::program::{RunFile, ended, folder, own, path, puma, sideslip};
use std::path::{Path, PathBuf};

/// What a table must not have: the words of a floating point number that is none, and more digits than it has.
fn raw(text: &str) -> Option<&str> {
    let is_raw = |word: &&str| {
        let digits = word.bytes().filter(u8::is_ascii_digit).count();
        matches!(*word, "NaN" | "inf" | "-inf" | "+inf") || digits > 20
    };
    text.split(|c: char| !(c.is_alphanumeric() || "+-.".contains(c))).find(is_raw)
}

/// The run of the Puma with that cell in every row of a channel.
fn spoilt(folder: &Path, name: &str, channel: &str, cell: &str) -> PathBuf {
    let mut run = RunFile::read(&puma());
    let place = run.place(channel);
    run.rows.iter_mut().for_each(|row| row[place] = cell.to_owned());
    let file = folder.join(format!("{name}.csv"));
    run.write(&file);
    file
}

#[test]
fn a_model_with_huge_derivatives_has_them_as_powers_of_ten() {
    let folder = folder("raw-numbers");
    let text = std::fs::read_to_string(own("replay/models/puma-like.toml")).unwrap();
    for huge in ["1e6", "-1e300", "1.7e308"] {
        let model = folder.join("huge.toml");
        std::fs::write(&model, text.replace("p = -1.4939", &format!("p = {huge}"))).unwrap();
        let (status, out, said) = ended(&sideslip(&["linearise", "--model", path(&model)]));
        let shown = ["e6", "e300", "e308", "infinite"].iter().any(|power| out.contains(power));
        assert!(status == 1 || shown, "{status} {out} {said}");
        assert_eq!(raw(&format!("{out}{said}")), None, "{out}{said}");
    }
}

/// Numbers of a user in what is said, not in tables: 1e300 written in full has 301 digits.
#[test]
fn no_message_writes_a_huge_number_in_full() {
    let folder = folder("raw-messages");
    let spoilt = |name: &str, channel: &str, cell: &str| spoilt(&folder, name, channel, cell);
    let (fast, late) = (spoilt("fast", "tas", "1e300"), spoilt("late", "time", "1e300"));
    let (puma, digits) = (puma(), "9".repeat(300));
    let (run, fast, late) = (path(&puma), path(&fast), path(&late));
    let lateral = ["--states", "v,p,phi,r", "--inputs", "lat_cyclic,pedal"];
    let calls: [&[&str]; 8] = [
        &[&["identify", run, "--holdout", fast, "--model", "puma"], &lateral[..]].concat(),
        &["replay", late],
        &["inspect", late],
        &["check", late],
        &["replay", run, "--from", "1e300"],
        &["check", run, "--from", "1e300", "--to", "1e299"],
        &["identify", run, "--trim-window", &format!("-{digits}")],
        &["design", "--model", "puma", "--control", "pedal", "--clock", &digits],
    ];
    for call in calls {
        let (_, out, said) = ended(&sideslip(call));
        let all = format!("{out}{said}");
        let longest = all.split(|c: char| !(c.is_ascii_digit() || c == '.')).map(str::len).max();
        assert!(longest <= Some(40), "{call:?}: {all}");
    }
}

#[test]
fn recordings_of_huge_constant_and_missing_values_leave_no_raw_number_in_any_table() {
    let folder = folder("raw-recordings");
    let spoilt = |name: &str, channel: &str, cell: &str| spoilt(&folder, name, channel, cell);
    let runs = [spoilt("huge", "beta", "1e300"), spoilt("still", "r", "0"), spoilt("level", "ay", "1e-300")];
    let model = own("replay/models/puma-like.toml");
    for run in &runs {
        let run = path(run);
        for call in [
            ["replay", run].as_slice(),
            &["check", run],
            &["inspect", run],
            &["compare", run, "--model", path(&model)],
            &["identify", run, "--states", "v,p,r", "--inputs", "pedal,lat_cyclic"],
            &["identify", run, "--response", "r"],
        ] {
            let (_, out, _) = ended(&sideslip(call));
            // The sentence of an event that a value was none is no table.
            let all = out.replace("(NaN or infinity)", "");
            assert_eq!(raw(&all), None, "{call:?}\n{all}");
        }
    }
}
