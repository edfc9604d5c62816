//! Wrong calls and recordings: one line that says what was expected, exit status 2, nothing written.

use crate::support::program::{RunFile, ended, folder, path, puma, sideslip};

fn refused(args: &[&str], words: &[&str]) {
    let (status, out, said) = ended(&sideslip(args));
    assert!(status == 2 && out.is_empty() && said.trim_end().lines().count() == 1, "{args:?}: {status} {out} {said}");
    for word in words {
        assert!(said.contains(word), "{args:?}: `{word}` in {said}");
    }
}

#[test]
fn what_cannot_be_identified_is_refused_with_a_line() {
    let (puma, folder) = (puma(), folder("identify-calls"));
    let file = path(&puma);
    refused(&["identify", file, "--states", "p,rr"], &["`rr` is no state"]);
    refused(&["identify", file, "--states", "v,beta"], &["`v` and `beta` are the same"]);
    refused(&["identify", file, "--states", "p,p"], &["twice"]);
    refused(&["identify", file, "--states", "p,r", "--inputs", "rudder"], &["expected a column `rudder`"]);
    refused(&["identify", file, "--states", "p", "--outputs", "az"], &["`az`"]);
    refused(&["identify", file, "--holdout", file], &["--holdout"]);
    let (one, other) = (folder.join("one.csv"), folder.join("other.csv"));
    std::fs::copy(&puma, &one).unwrap();
    std::fs::copy(&puma, &other).unwrap();
    // Every file behind --holdout is one of the hold-out, in both commands.
    for call in [
        &["identify", file, "--holdout", path(&one), path(&other), "--states", "p"][..],
        &["identify", "--fit", file, "--holdout", path(&one), path(&other), "--states", "p"],
    ] {
        refused(call, &["one.csv", "same recording"]);
    }
    for fit in [&[file][..], &["--fit", file]] {
        refused(
            &[&["diagnose", "--model", "puma"], fit, &["--holdout", path(&one), file]].concat(),
            &["not fitted", "--manoeuvre"],
        );
    }
    refused(&["identify", file, "--trim-window", "nan"], &["--trim-window"]);
    refused(&["identify", "no-such.csv"], &["no-such.csv"]);
    refused(&["identify", file, "--response", "Cm", "--candidates", "p"], &["no column `Cm`"]);
    refused(&["identify", file, "--response", "r"], &["--candidates"]);
    refused(&["identify", file, "--response", "r", "--candidates", "p;)"], &["--candidates"]);
    let still = folder.join("still.csv");
    let mut run = RunFile::read(&puma);
    let place = run.place("pedal");
    run.rows.iter_mut().for_each(|row| row[place] = "0.1".to_owned());
    std::fs::write(&still, run.text()).unwrap();
    refused(&["identify", path(&still), "--states", "p,r", "--inputs", "pedal"], &["pedal"]);
    let short = folder.join("short.csv");
    let mut run = RunFile::read(&puma);
    run.rows.truncate(12);
    std::fs::write(&short, run.text()).unwrap();
    // The call is right; the search comes to nothing.
    let (status, out, said) = ended(&sideslip(&["identify", path(&short), "--states", "p,r", "--inputs", "pedal"]));
    assert!(status == 4 && out.is_empty() && said.contains("not identifiable"), "{status} {said}");
    let slow = folder.join("slow.csv");
    let mut run = RunFile::read(&puma);
    let place = run.place("time");
    let mut due = f64::NEG_INFINITY;
    run.rows.retain(|row| {
        let time_s: f64 = row[place].parse().unwrap();
        let kept = time_s >= due;
        due = if kept { time_s + 0.15 } else { due };
        kept
    });
    std::fs::write(&slow, run.text()).unwrap();
    let (status, _, said) = ended(&sideslip(&["identify", path(&slow), "--states", "p,r", "--inputs", "pedal"]));
    assert!(status == 4 && said.contains("slow.csv") && said.contains("expected 8 Hz"), "{status} {said}");
    let copy = folder.join("copy.csv");
    std::fs::copy(&puma, &copy).unwrap();
    for twice in [&[file, path(&copy)][..], &[file, "--holdout", path(&copy)]] {
        refused(&[&["identify"], twice].concat(), &["copy.csv", "same recording"]);
    }
}

#[test]
fn a_trim_that_is_taken_while_the_controls_move_is_said() {
    let (puma, folder) = (puma(), folder("identify-trim"));
    let told = |window: &str| {
        let json = folder.join("answer.json");
        let (status, _, said) =
            ended(&sideslip(&["identify", path(&puma), "--trim-window", window, "--force", "--json", path(&json)]));
        assert_eq!(status, 0, "{said}");
        std::fs::read_to_string(json).unwrap().contains("in the window its trim is taken from")
    };
    assert!(told("8") && !told("1"));
}

/// What is fitted rests on the same readings that the pipeline doubts; and an accelerometer that typed states leave out is named.
#[test]
fn doubted_instruments_and_unused_accelerometers_are_noted() {
    let folder = folder("identify-doubts");
    let mut run = RunFile::read(&puma());
    let place = run.place("tas");
    run.rows.iter_mut().for_each(|row| row[place] = (1.944 * row[place].parse::<f64>().unwrap()).to_string());
    let file = folder.join("knots.csv");
    run.write(&file);
    for (run, words) in
        [(puma(), "ay is recorded and not among the outputs"), (file, "what is fitted here rests on its readings")]
    {
        let (_, told, said) = ended(&sideslip(&["identify", path(&run), "--states", "v,p,phi,r"]));
        assert!(told.replace("\n ", "").replace("    ", " ").contains(words), "{words}: {told}{said}");
    }
}
