//! ATTAS, rudder doublet: the Dutch roll that output error on the record gives, and the vane that is not where it says.

use crate::support::program::{real, replayed, warns};

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
    let words = ["sideslip (beta)", "inconsistent with the motion"];
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
        ("citation-2018-dutchroll.csv", "v is not observable; the channel beta would make it so"),
        ("twin-otter-020213f1_018.csv", "no input moved this plane of motion"),
    ] {
        let Some(flight) = real(name) else { return };
        let (_, run, table) = replayed(&flight, &[]);
        assert!(run["modes"]["dutch_roll"].is_null() && run["modes"]["roll"].is_null(), "{name}");
        assert!(run["modes"]["status"].as_str().unwrap().starts_with("not identifiable"), "{name}: {}", run["modes"]);
        assert!(table.contains(words), "{name}:\n{table}");
    }
}

/// The author's ten derivatives are of beta and alpha as recorded, 13.08 m ahead of the centre of mass. At it, beta of the
/// vane is beta + 13.08 r/V and alpha of the vane alpha - 13.08 q/V, so that N_r = N_r' + N_beta' 13.08/V and so on.
#[test]
fn the_other_records_agree_with_the_authors_output_error() {
    let v: f64 = 129.0;
    let arm = 13.08 / v;
    let term = |run: &serde_json::Value, axis: &str, name: &str| {
        let terms = run["equations"][axis]["terms"].as_array().unwrap();
        let term = terms.iter().find(|term| term["name"] == name).unwrap_or_else(|| panic!("{name} in {terms:?}"));
        (term["value"].as_f64().unwrap(), term["std"].as_f64().unwrap())
    };
    // What two short records of the same aircraft may differ by, beside the standard errors: the author's own answer from
    // fewer records moves by as much (README of the recordings).
    let agree = |run: &serde_json::Value, axis: &str, name: &str, published: f64| {
        let (value, std) = term(run, axis, name);
        eprintln!("{name} {value:.4} +- {std:.4}, published {published:.4}");
        assert!(
            (value - published).abs() < 3.0 * std + 0.06 * published.abs(),
            "{name}: {value} +- {std}, published {published}"
        );
    };
    let Some(flight) = real("attas-ail1.csv") else { return };
    let (_, ail1, _) = replayed(&flight, &VANE);
    agree(&ail1, "L", "L_p", -2.067);
    agree(&ail1, "L", "L_aileron", -6.306);
    agree(&ail1, "L", "L_v", -3.844 / v);
    agree(&ail1, "L", "L_r", 1.029 - 3.844 * arm);
    agree(&ail1, "N", "N_v", 3.031 / v);
    agree(&ail1, "N", "N_p", -0.1839);
    agree(&ail1, "N", "N_r", -0.4856 + 3.031 * arm);
    let Some(flight) = real("attas-elv1.csv") else { return };
    let (_, elv1, _) = replayed(&flight, &VANE);
    agree(&elv1, "M", "M_w", -4.926 / v);
    agree(&elv1, "M", "M_q", -2.006 + 4.926 * arm);
    agree(&elv1, "M", "M_elevator", -7.208);
}
