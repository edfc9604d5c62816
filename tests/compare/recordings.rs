//! Real recordings: the Citation against its a-priori model, the ATTAS against a model identified from another of its runs.

use crate::support::program::{ended, folder, path, real, sideslip};
use serde_json::Value;

/// A model identified from the rudder doublet predicts the aileron's record; the picture and figures are there.
#[test]
fn an_identified_model_predicts_another_run() {
    let (Some(rudder), Some(aileron)) = (real("attas-rud1.csv"), real("attas-ail1.csv")) else { return };
    let folder = folder("compare-attas");
    let (status, _, said) = ended(&sideslip(&["identify", path(&rudder), path(&aileron), "--out", path(&folder), "--json", "-"]));
    assert!(status == 0 || status == 3, "{said}");
    let Some(model) = Some(folder.join("model.toml")).filter(|model| model.is_file()) else {
        eprintln!("SKIPPED: no model was identified: {said}");
        return;
    };
    let (status, out, said) = ended(&sideslip(&["compare", path(&rudder), "--model", path(&model), "--json", "-"]));
    assert!(status == 0 || status == 3, "{said}");
    let answer: Value = serde_json::from_str(&out).unwrap();
    // A lateral model says nothing of the others.
    assert_eq!(answer["runs"][0]["not_predicted"].as_array().unwrap().len(), 7, "{answer:#}");
    for channel in ["p", "r"] {
        let of = |key: &str| answer["runs"][0]["channels"][channel][key].as_f64().unwrap();
        eprintln!("{channel}: TIC {:.3}, VAF {:.3}", of("theil"), of("vaf"));
        assert!(of("vaf") > 0.8 && of("theil") < 0.3, "{answer:#}");
    }
}
