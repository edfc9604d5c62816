//! The demo as a user runs it: it says what is true, the log repeats its numbers, the front page shows what it prints.

use crate::program::{ended, folder, own, path, replayed, sideslip};
use serde_json::Value;
use std::process::{Command, Stdio};

#[test]
fn the_demo_ends_with_truth_and_estimate_and_its_log_gives_the_same_numbers() {
    let out = folder("live-demo").join("trial");
    let (status, printed, said) = ended(&sideslip(&["demo", "--speed", "4", "--out", path(&out)]));
    assert_eq!(status, 0, "{said}");
    let rows: Vec<&str> = printed.lines().filter(|line| line.ends_with("  converged")).collect();
    assert_eq!(rows.len(), 25, "{printed}");
    assert!(printed.contains("25 of 25 estimates are within 3 standard errors"), "{printed}");
    // Roots of the model's matrices, computed elsewhere: -0.0852 +- 0.9861i of the whole, -0.155 +- 1.043i of the lateral one.
    for (row, name, (real, imag)) in
        [(rows[0], "Dutch roll omega", (0.0852_f64, 0.9861)), (rows[2], "lateral omega", (0.155, 1.043))]
    {
        let truth: f64 = row.trim_start().trim_start_matches(name).split_whitespace().next().unwrap().parse().unwrap();
        assert!((truth - real.hypot(imag)).abs() < 5e-4, "{row}");
    }
    let numbers = std::fs::read_to_string(out.join("derivatives.json")).unwrap();
    let numbers: Value = serde_json::from_str(&numbers).unwrap();
    let (status, again, said) = replayed(&out.join("live.mcap"), &[]);
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

#[test]
fn a_demo_that_is_stopped_leaves_a_whole_log_and_no_process() {
    let out = folder("live-demo-stopped");
    let mut demo = Command::new(env!("CARGO_BIN_EXE_sideslip"));
    demo.args(["demo", "--speed", "1", "--out", path(&out)]).stdout(Stdio::null()).stderr(Stdio::null());
    let mut demo = demo.spawn().unwrap();
    let log = out.join("live.mcap");
    crate::stage::soon("a log", std::time::Duration::from_secs(10), || crate::stage::times(&log).len() > 50);
    let processes = std::fs::read_to_string(out.join("processes.log")).unwrap();
    assert!(crate::stage::signal("INT", demo.id()));
    assert_eq!(demo.wait().unwrap().code(), Some(1));
    let numbers: Vec<u32> = processes.lines().filter_map(|line| line.rsplit_once(" is process ")?.1.parse().ok()).collect();
    assert_eq!(numbers.len(), 2);
    assert!(numbers.iter().all(|number| !crate::stage::signal("0", *number)), "nobody is left");
    assert_eq!(ended(&sideslip(&["inspect", path(&log), "--json", "-"])).0, 0);
}
