//! Pairs of real records: the model of one held against the other, where nothing is known to be wrong but what a short record
//! cannot tell. Every cause that is relied upon has to be argued by what is published of that aircraft.
//!
//! Twin Otter, two elevator manoeuvres of one day; ATTAS, rudder and aileron run, with the positions as published. A model of the
//! rudder run alone does not know N_p, which published regressions of both have at -0.18, and the q gyro has a bias of
//! 0.0034 rad/s. Citation, the Dutch rolls of two years: no vane and no accelerometers, so that a model identified from one has
//! no force; the sideways velocity, which nothing tells, has to stay where it does no harm.

use crate::support::program::{ended, folder, path, real, sideslip};
use serde_json::Value;

/// Probability that a reader relies upon.
const RELIED_UPON: f64 = 0.9;
const POSITIONS: [&str; 4] =
    ["--set", "vane_position_m=[13.08, -0.01, -0.027]", "--set", "accelerometer_position_m=[-1.01, 0.886, 0.103]"];
const LATERAL: [&str; 6] = ["--states", "v,p,phi,r", "--inputs", "aileron,rudder", "--outputs", "beta,p,phi,r,ay"];

/// Causes with their probabilities and sizes that the second record gives of the first one's model; `None` where they are absent.
fn causes(name: &str, [modelled, held]: [&str; 2], identify: &[&str], known: &[&str]) -> Option<Vec<(String, f64, f64)>> {
    let (modelled, held) = (real(modelled)?, real(held)?);
    let folder = folder(name);
    let (status, _, said) = ended(&sideslip(&[&["identify", path(&modelled), "--out", path(&folder)], identify, known].concat()));
    assert!(status == 0 || status == 3, "{said}");
    let model = folder.join("model.toml");
    let call = ["diagnose", "--model", path(&model), "--fit", path(&held), "--json", "-"];
    let (status, answer, said) = ended(&sideslip(&[&call, known].concat()));
    assert!(status == 0 || status == 3, "{said}");
    let answer: Value = serde_json::from_str(&answer).unwrap();
    let one = |finding: &Value| {
        let number = |key: &str| finding[key].as_f64().unwrap_or(f64::NAN);
        (finding["statement"].as_str().unwrap().to_owned(), number("probability"), number("value"))
    };
    let found: Vec<_> = answer["findings"].as_array().unwrap().iter().map(one).collect();
    eprintln!("{name}: {found:#?}");
    Some(found)
}

#[test]
fn of_two_twin_otter_records_no_control_that_nobody_moved_is_a_cause() {
    let records = ["twin-otter-020213f1_019.csv", "twin-otter-020213f1_018.csv"];
    for records in [records, [records[1], records[0]]] {
        let Some(found) = causes("pair-twin-otter", records, &[], &[]) else { return };
        let of_still_controls = |statement: &str| ["rudder", "aileron"].iter().any(|control| statement.contains(control));
        assert!(found.iter().all(|(statement, ..)| !of_still_controls(statement)), "{found:?}");
        // An attitude against vane and accelerometers: no published figure says that there is none.
        let is_argued = |statement: &str| statement.starts_with("theta has a bias");
        assert!(found.iter().all(|(statement, p, _)| *p < RELIED_UPON || is_argued(statement)), "{found:?}");
    }
}

#[test]
fn of_two_attas_records_what_is_relied_upon_is_what_is_published() {
    let records = ["attas-rud1.csv", "attas-ail1.csv"];
    for records in [records, [records[1], records[0]]] {
        let Some(found) = causes("pair-attas", records, &LATERAL, &POSITIONS) else { return };
        for (statement, _, value) in found.iter().filter(|(_, probability, _)| *probability >= RELIED_UPON) {
            let argued = match statement {
                one if one.starts_with("N_p") => true,
                one if one.starts_with("q has a bias") => (value - 0.0034).abs() < 0.001,
                _ => false,
            };
            assert!(argued, "{statement}");
        }
    }
}

/// Published Dutch rolls: 2.04 to 2.09 rad/s in 2018, 1.91 to 1.95 in 2019. Of a model of p and r alone omega^2 is
/// L_p N_r - L_r N_p, and N_p, the larger of the two that the phase leaves open, has to be 0.86 to 0.91 of itself.
#[test]
fn a_model_without_forces_is_held_against_a_record_without_vane_and_accelerometers() {
    let records = ["citation-2018-dutchroll.csv", "citation-2019-dutchroll.csv"];
    let Some(found) = causes("pair-citation", records, &[], &[]) else { return };
    let (statement, probability, _) = found.iter().find(|(statement, ..)| statement.starts_with("N_p")).expect("N_p");
    let shown: f64 = statement.split("flight shows ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap().parse().unwrap();
    assert!(*probability >= RELIED_UPON && (-2.35..-1.95).contains(&shown), "{found:?}");
    assert!(found.iter().all(|(statement, ..)| !statement.contains("gusts")), "no force of this model moves with the air");
}
