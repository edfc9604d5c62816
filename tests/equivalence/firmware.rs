//! The firmware profile, built apart without the standard library's features, gives the same bits as the library here, within
//! its budget of stack.

use crate::support::fingerprint::Fingerprint;
use crate::support::firmware_manoeuvre::ManoeuvreSamples;
use sideslip::flight::run::RunGeometry;
use sideslip::realtime::pipeline::{Pipeline, PipelineConfig};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Cargo in the project's root, with a target folder of its own so that no other build is waited for.
fn cargo(arguments: &[&str]) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo).current_dir(root).args(arguments).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn built() -> PathBuf {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("firmware-profile");
    let folder = target.to_str().unwrap();
    cargo(&["build", "--quiet", "--offline", "--locked", "--package", "firmware-profile", "--target-dir", folder]);
    target.join("debug").join("firmware-profile")
}

/// A number of `budget.toml`.
fn budget(key: &str) -> String {
    let text = include_str!("../../firmware-profile/budget.toml");
    let line = text.lines().find(|line| line.starts_with(&format!("{key} ="))).unwrap();
    line.split(['=', '#']).nth(1).unwrap().trim().replace('_', "")
}

#[test]
fn firmware_and_host_give_the_same_bits_within_the_budget() {
    let mut pipeline = Box::new(Pipeline::new(&PipelineConfig::default(), RunGeometry::default()).unwrap());
    let mut fingerprint = Fingerprint::default();
    for sample in ManoeuvreSamples::default() {
        fingerprint.take(pipeline.step(&sample));
    }
    fingerprint.take(pipeline.finish());

    let program = built();
    let output = Command::new(program).args(["--stack", &budget("step")]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "it allocated in flight or its stack was too small: {output:?}");
    eprintln!("{said}");
    assert!(said.contains(&format!("fingerprint  {:016x}", fingerprint.0)), "host {:016x}", fingerprint.0);
}

#[test]
fn the_profile_is_built_without_the_standard_librarys_features() {
    let tree = cargo(&["tree", "--offline", "--locked", "--package", "firmware-profile", "--edges", "normal,features"]);
    let names: Vec<&str> = tree.lines().map(|line| line.trim_start_matches(|c: char| !c.is_alphanumeric())).collect();
    assert!(names.iter().any(|name| name.starts_with("sideslip v")), "{tree}");
    for line in &names {
        assert!(!line.starts_with("sideslip feature \"std\"") && !line.starts_with("sideslip feature \"default\""), "{tree}");
        assert!(!line.starts_with("serde") && !line.starts_with("mcap") && !line.starts_with("clap"), "{tree}");
        assert!(!line.starts_with("nalgebra feature \"std\"") && !line.starts_with("nalgebra feature \"alloc\""), "{tree}");
    }
}
