//! A wrong instruments file, input or pilot is refused where it is wrong and leaves nothing behind; the example is flown.

use crate::support::program::{ended, folder, own, path, sideslip};

/// `simulate` of the plain linear model with a pedal doublet and these arguments: exit status and standard error.
fn simulated(out: &std::path::Path, more: &[&str]) -> (i32, String) {
    let model = own("replay/models/puma-like.toml");
    let mut args = vec!["simulate", "--model", path(&model), "--input", "pedal:doublet:0.02:1", "--force", "--out", path(out)];
    args.extend(more);
    let (status, printed, said) = ended(&sideslip(&args));
    assert!(printed.is_empty(), "{printed}");
    (status, said)
}

#[test]
fn each_mistake_is_named_with_file_line_and_column_and_no_recording_is_left() {
    let folder = folder("instrument_files");
    let (file, out) = (folder.join("instruments.toml"), folder.join("run.csv"));
    for (text, place, part) in [
        ("rate_hz = 0", "1:11", "0.01 to 10000 Hz"),
        ("[channel.p]\nnoise = 0.1\nbits = 12\n", "3:8", "`range = [least, most]`"),
        ("[channel.torque]\n", "1:10", "that the model gives, found `torque`"),
        ("[channel.rol]\n", "1:10", "nearest is `r`"),
        ("[vibration]\nblades = 4\nbeta = [1, 1]\n", "3:1", "(of ax ay az p q r)"),
        ("[dropouts]\nrate = 1\nmean_length = 'long'\n", "3:15", "finite number"),
        ("[channel.p\n", "1:", "not TOML"),
    ] {
        std::fs::write(&file, text).unwrap();
        let (status, said) = simulated(&out, &["--instruments", path(&file)]);
        let wanted = format!("{}:{place}", path(&file));
        assert!(status == 2 && said.contains(&wanted) && said.contains(part) && said.lines().count() == 1, "{text}: {said}");
        assert!(!out.exists(), "{text}");
    }
    std::fs::write(&file, b"\xff\xfe").unwrap();
    let (status, said) = simulated(&out, &["--instruments", path(&file)]);
    assert!(status == 2 && said.contains("expected an instruments file"), "{said}");
    let (status, said) = simulated(&out, &["--instruments", path(&folder.join("none.toml"))]);
    assert!(status == 2 && said.contains("none.toml"), "{said}");
}

#[test]
fn the_recording_does_not_overwrite_the_instruments_and_vibration_needs_blades() {
    let folder = folder("instrument_files_kept");
    let file = folder.join("instruments.csv");
    std::fs::write(&file, "[vibration]\naz = [1, 0]\n").unwrap();
    let (status, said) = simulated(&file, &["--instruments", path(&file)]);
    assert!(status == 2 && std::fs::read_to_string(&file).unwrap().starts_with("[vibration]"), "{said}");
    let out = folder.join("run.csv");
    let (status, said) = simulated(&out, &["--instruments", path(&file)]);
    assert!(status == 2 && said.contains("number of blades") && !out.exists(), "{said}");
    let (status, said) = simulated(&out, &["--instruments", path(&file), "--set", "blades=4"]);
    assert!(status == 0 && std::fs::read_to_string(&out).unwrap().contains("# blades = 4\n"), "{said}");
}

#[test]
fn the_example_is_flown_and_its_recording_says_where_instruments_stand() {
    let folder = folder("instrument_files_example");
    let (out, example) = (folder.join("run.csv"), own("replay/instruments/flight-test.toml"));
    for noise in [&[][..], &["--noise", "none"]] {
        let mut more = vec!["--instruments", path(&example), "--pilot", "attitude", "--duration", "20"];
        more.extend(noise);
        let (status, said) = simulated(&out, &more);
        let text = std::fs::read_to_string(&out).unwrap();
        assert_eq!(status, 0, "{said}");
        for wanted in ["accelerometer_position_m = [0.35, 0.0, -0.2]", "pilot = \"attitude\"", "blades = 4", "noise = "] {
            assert!(text.contains(wanted), "{wanted}");
        }
    }
    let (status, _, said) = ended(&sideslip(&["inspect", path(&out)]));
    assert!(status == 0, "{said}");
}

#[test]
fn wrong_hands_and_pilots_are_refused() {
    let folder = folder("instrument_files_pilots");
    let out = folder.join("run.csv");
    for (more, part) in [
        (["--hand-rate", "0"], "--hand-rate"),
        (["--hand-rate", "nan"], "--hand-rate"),
        (["--pilot", "auto"], "attitude"),
        (["--input", "pedal:prbs9:0.02:0.5"], "prbs3 to prbs8"),
    ] {
        let (status, said) = simulated(&out, &more);
        assert!(status == 2 && said.contains(part) && !out.exists(), "{more:?}: {said}");
    }
    let model = folder.join("model.toml");
    std::fs::write(&model, "kind = 'linear'\n[trim]\nu = 50.0\ntheta = 0.0\n[derivatives.N]\nr = -0.5\npedal = -9.0\n").unwrap();
    let args = ["simulate", "--model", path(&model), "--input", "pedal:step:0.01", "--pilot", "attitude", "--out", path(&out)];
    let (status, _, said) = ended(&sideslip(&args));
    assert!(status == 2 && said.contains("cannot hold the aircraft with `lat_cyclic`"), "{said}");
}
