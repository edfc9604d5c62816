//! The demo as a user runs it: it says what is true, the log repeats its numbers, the front page shows what it prints.

use crate::support::program::{ended, folder, own, path, replayed, sideslip};
use serde_json::Value;
use std::process::{Command, Stdio};

#[test]
fn the_demo_ends_with_section_4_and_its_logs_give_the_same_numbers() {
    let _turn = crate::alone();
    let out = folder("live-demo").join("trial");
    let (status, printed, said) = ended(&sideslip(&["demo", "--speed", "8", "--out", path(&out)]));
    assert_eq!(status, 0, "{said}");
    let points: Vec<&str> = printed.split("flight path ").skip(1).collect();
    assert_eq!(points.len(), 3, "{printed}");
    // Simulation, estimate, extended model, truth; the roots are those that the paper prints.
    let cells = |point: &str, name: &str| -> Vec<f64> {
        let row = point.lines().find(|line| line.trim_start().starts_with(name)).unwrap();
        let cells = row.trim_start().trim_start_matches(name).split("  ").map(str::trim).filter(|cell| !cell.is_empty());
        cells.map(|cell| cell.split_whitespace().next().unwrap().parse().unwrap()).collect()
    };
    for (point, (real, imag)) in points.iter().zip([(-0.17, 1.37), (-0.118, 1.53), (0.052, 1.45)]) {
        for (name, printed, near) in [("Dutch roll real", real, 0.05), ("Dutch roll imag", imag, 0.1)] {
            let row = cells(point, name);
            let [simulation, estimate, extended, truth] = row[..] else { panic!("{row:?}") };
            assert!((truth - printed).abs() < 0.006 && (estimate - truth).abs() < 0.02, "{name}: {row:?}");
            assert!(
                (extended - truth).abs() < near && (simulation - truth).abs() > (extended - truth).abs() - 0.05,
                "{name}: {row:?}"
            );
        }
        assert!(cells(point, "N_v")[0] < 0.5 * cells(point, "N_v")[3], "N_v is too low in the simulation");
        let kept = point.lines().find(|line| line.contains("hold-out")).unwrap();
        let ratio: f64 = kept.rsplit_once(": ").unwrap().1.split_whitespace().next().unwrap().parse().unwrap();
        assert!(ratio < 0.5, "{kept}");
    }
    // The simulation misses that the climb is unstable.
    let climb = cells(points[2], "Dutch roll real");
    assert!(climb[0] < 0.0 && climb[1] > 0.0 && climb[2] > 0.0, "{climb:?}");
    for page in 1..=3 {
        assert!(out.join(format!("report-{page}.html")).metadata().unwrap().len() > 10_000);
    }
    let numbers = std::fs::read_to_string(out.join("climb-fit/derivatives.json")).unwrap();
    let numbers: Value = serde_json::from_str(&numbers).unwrap();
    let (status, again, said) = replayed(&out.join("climb-fit/live.mcap"), &[]);
    assert_eq!(status, 0, "{said}");
    for part in ["equations", "modes"] {
        assert_eq!(numbers["runs"][0][part], again[part], "live and its log");
    }
    // The front page.
    let page = std::fs::read_to_string(own("README.md")).unwrap();
    let shown = page.split("```text\n").nth(1).unwrap().split("```").next().unwrap();
    for line in shown.lines().filter(|line| *line != "...") {
        assert!(printed.lines().any(|found| found == line), "{line:?} is not in\n{printed}");
    }
}

/// In a folder where one has been before: what stands there is not touched, and the command of the README needs no other words.
#[test]
fn a_demo_that_is_stopped_leaves_a_whole_log_and_no_process() {
    let _turn = crate::alone();
    let here = folder("live-demo-stopped");
    let (before, out) = (here.join("sideslip-demo/diagnosis.json"), here.join("sideslip-demo-2"));
    std::fs::create_dir(before.parent().unwrap()).unwrap();
    std::fs::write(&before, "mine").unwrap();
    let mut demo = Command::new(env!("CARGO_BIN_EXE_sideslip"));
    demo.args(["demo", "--speed", "1"]).current_dir(&here).stdout(Stdio::null()).stderr(Stdio::null());
    let mut demo = demo.spawn().unwrap();
    let log = out.join("descent-fit/live.mcap");
    crate::support::patience::until("a log", || super::stage::times(&log).len() > 50);
    let processes = std::fs::read_to_string(out.join("descent-fit/processes.log")).unwrap();
    assert!(super::stage::signal("INT", demo.id()));
    assert_eq!(demo.wait().unwrap().code(), Some(1));
    let numbers: Vec<u32> = processes.lines().filter_map(|line| line.rsplit_once(" is process ")?.1.parse().ok()).collect();
    assert_eq!(numbers.len(), 2);
    assert!(numbers.iter().all(|number| !super::stage::signal("0", *number)), "nobody is left");
    assert_eq!(std::fs::read_to_string(&before).unwrap(), "mine");
    assert_eq!(std::fs::read_dir(before.parent().unwrap()).unwrap().count(), 1);
    assert_eq!(ended(&sideslip(&["inspect", path(&log), "--json", "-"])).0, 0);
}
