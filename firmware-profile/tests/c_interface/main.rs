//! The C interface: its header is that of the code, and a program in C has the same bits as one in Rust.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use firmware_profile::c_interface::header::header;
use firmware_profile::c_interface::{SideslipEstimates, SideslipSample};
use firmware_profile::manoeuvre::ManoeuvreSamples;
use firmware_profile::{Profile, SETTINGS};
use sideslip::flight::run::RunGeometry;
use std::path::{Path, PathBuf};
use std::process::Command;

fn folder() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn done(command: &mut Command) -> String {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{command:?}: {output:?}");
    String::from_utf8(output.stdout).unwrap()
}

/// The profile as a static library, in a target folder that no other build waits for.
fn library() -> PathBuf {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("firmware-profile");
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let arguments = ["rustc", "--quiet", "--offline", "--locked", "--lib", "--features", "hosted", "--crate-type", "staticlib"];
    done(Command::new(cargo).current_dir(folder()).args(arguments).arg("--target-dir").arg(&target));
    target.join("debug").join("libfirmware_profile.a")
}

fn samples() -> Vec<SideslipSample> {
    ManoeuvreSamples::default().map(|sample| SideslipSample::from(&sample)).collect()
}

/// The numbers of a structure without padding, as its bytes.
fn bytes_of(estimates: &SideslipEstimates) -> Vec<u8> {
    let mut bytes: Vec<u8> = estimates.time_s.to_ne_bytes().to_vec();
    let tables = [&estimates.derivatives, &estimates.standard_errors];
    let modes = estimates.dutch_roll.omega.iter().chain(&estimates.dutch_roll.zeta);
    let numbers = tables.into_iter().flatten().flatten().chain(modes);
    bytes.extend(numbers.flat_map(|number| number.to_ne_bytes()));
    let codes = estimates.status.iter().chain(&estimates.reason).chain([&estimates.modes_status, &estimates.modes_reason]);
    bytes.extend(codes.flat_map(|code| code.to_ne_bytes()));
    bytes
}

#[test]
fn the_header_is_that_of_the_code() {
    let mut text = String::new();
    header(&mut text).unwrap();
    let file = folder().join("include/sideslip.h");
    let written = std::fs::read_to_string(&file).unwrap_or_default();
    assert!(text == written, "renew it: cargo run -p firmware-profile -- --c-header > firmware-profile/include/sideslip.h");
}

#[test]
fn a_program_in_c_has_the_same_bits() {
    let mut profile = Box::new(Profile::new(&SETTINGS, RunGeometry::DEFAULT));
    let (mut estimates, mut published, mut fingerprint) = (SideslipEstimates::NONE, 0, 0xcbf2_9ce4_8422_2325_u64);
    for sample in ManoeuvreSamples::default() {
        if estimates.take(profile.step(&sample)) {
            published += 1;
            for byte in bytes_of(&estimates) {
                fingerprint = (fingerprint ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
            }
        }
    }
    let folder_of_run = Path::new(env!("CARGO_TARGET_TMPDIR")).join("c-interface");
    std::fs::create_dir_all(&folder_of_run).unwrap();
    let (program, file) = (folder_of_run.join("flight"), folder_of_run.join("samples"));
    let bytes = |sample: SideslipSample| [vec![sample.time_s], sample.channels.to_vec()].concat();
    let numbers = samples().into_iter().flat_map(bytes);
    std::fs::write(&file, numbers.flat_map(f64::to_ne_bytes).collect::<Vec<u8>>()).unwrap();
    let mut compiler = Command::new("cc");
    compiler.args(["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O1", "-I"]).arg(folder().join("include"));
    compiler
        .arg(folder().join("tests/c_interface/flight.c"))
        .arg(library())
        .args(["-lpthread", "-ldl", "-lm", "-o"])
        .arg(&program);
    done(&mut compiler);
    let said = done(Command::new(&program).arg(&file));
    let n_pedal = estimates.derivatives[5][9];
    let expected: Vec<String> =
        [published.to_string(), format!("{fingerprint:016x}"), estimates.status[5].to_string()].into_iter().collect();
    let lines: Vec<Vec<&str>> = said.lines().map(|line| line.split(' ').collect()).collect();
    assert_eq!(lines.len(), 2, "{said}");
    for line in lines {
        assert_eq!(line[..3], expected, "{said}");
        assert_eq!(line[3].parse::<f64>().unwrap().to_bits(), n_pedal.to_bits());
        assert_eq!(line[4].parse::<f64>().unwrap().to_bits(), estimates.dutch_roll.zeta[0].to_bits());
    }
    assert!(published > 300 && n_pedal < -4.0, "{said}");
}
