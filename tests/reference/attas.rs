//! ATTAS, rudder doublet: the Dutch roll that output error on the record gives, and the vane that is not where it says.

use crate::program::{real, replayed, warns};

const VANE: [&str; 2] = ["--set", "vane_position_m=[13.08,0,0]"];

#[test]
fn the_dutch_roll_is_that_of_output_error() {
    let Some(flight) = real("attas-rud1.csv") else { return };
    let (status, run, said) = replayed(&flight, &VANE);
    assert_eq!(status, 0, "{said}");
    let pair = &run["modes"]["dutch_roll"];
    let number = |key: &str| pair[key].as_f64().unwrap();
    let (omega, zeta) = (number("omega"), number("zeta"));
    assert!((1.70..=1.90).contains(&omega) && (0.070..=0.105).contains(&zeta), "{pair}");
    assert!((omega - 1.806).abs() < 3.0 * number("std_omega"), "{pair}");
    assert!((zeta - 0.087).abs() < 3.0 * number("std_zeta"), "{pair}");
}

#[test]
fn the_misplaced_vane_is_told_by_the_kinematics() {
    let Some(flight) = real("attas-rud1.csv") else { return };
    let words = ["sideslip (beta)", "kinematics"];
    let (_, as_recorded, _) = replayed(&flight, &[]);
    assert!(warns(&as_recorded, &words), "{}", as_recorded["warnings"]);
    let r2 = as_recorded["consistency"]["beta"]["r2"].as_f64().unwrap();
    assert!((r2 - 0.965).abs() < 0.005, "{r2}");
    assert!(warns(&as_recorded, &[&format!("R2 {r2:.3}")]), "the warning has the R2 of the whole run");
    let (_, brought_back, _) = replayed(&flight, &VANE);
    assert!(!warns(&brought_back, &words), "{}", brought_back["warnings"]);
    assert!(brought_back["consistency"]["beta"]["r2"].as_f64().unwrap() > 0.99);
}

#[test]
fn what_a_run_cannot_tell_is_said_in_words() {
    for (name, words) in [
        ("citation-2018-dutchroll.csv", "nothing observes v; the channel beta would"),
        ("twin-otter-020213f1_018.csv", "has no numbers for v, p, r"),
    ] {
        let Some(flight) = real(name) else { return };
        let (_, run, table) = replayed(&flight, &[]);
        assert!(run["modes"]["dutch_roll"].is_null() && run["modes"]["roll"].is_null(), "{name}");
        assert!(run["modes"]["status"].as_str().unwrap().starts_with("not identifiable"), "{name}: {}", run["modes"]);
        assert!(table.contains(words), "{name}:\n{table}");
    }
}
