//! The answer as a JSON document; corrections are effects as model files have them, each with `std`.

use serde_json::{Map, Value, json};
use sideslip::flight::channel::{Channel, ControlNames};
use sideslip::flight::file::effect_file::DeclaredEffect;
use sideslip::io::outputs::json::effect_json::effect_json;
use sideslip::io::outputs::words::instrument_words::{not_observable, separation, verdict_reason};
use sideslip::postflight::reconstruction::correction::Correction;
use sideslip::postflight::reconstruction::screening::Screened;
use sideslip::postflight::reconstruction::verdict::RunVerdict;

pub(super) fn document(verdicts: &[RunVerdict], controls: ControlNames) -> Value {
    json!({ "runs": verdicts.iter().map(|verdict| run(verdict, controls)).collect::<Vec<_>>() })
}

fn run(verdict: &RunVerdict, controls: ControlNames) -> Value {
    let mut consistency = Map::new();
    for (angle, r2) in ["alpha", "beta"].into_iter().zip(&verdict.consistency) {
        if let Some((before, after)) = r2 {
            consistency.insert(angle.to_owned(), json!({ "r2_before": before, "r2_after": after }));
        }
    }
    json!({
        "run": verdict.run,
        "verdict": verdict.fitness.words(),
        "reason": verdict_reason(&verdict.reason),
        "corrections": verdict.corrections.iter().map(|one| correction(one, controls)).collect::<Vec<_>>(),
        "consistency": consistency,
        "not_observable": verdict.not_observable.iter().map(not_observable).collect::<Vec<_>>(),
        "gaps": verdict.long_gaps.iter().map(|[from_s, to_s]| json!({ "from_s": from_s, "to_s": to_s })).collect::<Vec<_>>(),
        "not_used": verdict.screened.iter().map(|one| screened(one, controls)).collect::<Vec<_>>(),
    })
}

fn screened(one: &Screened, controls: ControlNames) -> Value {
    json!({
        "channel": one.channel.name(controls),
        "samples": one.count,
        "why": one.damage.words(),
        "from_s": one.range_s[0],
        "to_s": one.range_s[1],
    })
}

fn correction(correction: &Correction, controls: ControlNames) -> Value {
    let mut document = effect(&correction.effect, correction.vane, controls);
    if correction.axis_stds_m.iter().any(Option::is_some) {
        document.insert("std_m".to_owned(), json!(correction.axis_stds_m));
    }
    document.insert("partial_f".to_owned(), json!(correction.significance));
    if !correction.alternatives.is_empty() {
        let alternatives: Vec<Value> =
            correction.alternatives.iter().map(|one| Value::Object(effect(&one.effect, one.vane, controls))).collect();
        document.insert("alternatives".to_owned(), Value::Array(alternatives));
        document.insert("split_by".to_owned(), json!(correction.split_by.iter().copied().map(separation).collect::<Vec<_>>()));
    }
    if let Some(angle) = correction.turned {
        document.insert("or_turned_rad".to_owned(), json!(angle));
    }
    if !correction.by_run.is_empty() {
        let by_run = correction.by_run.iter().map(|(run, value, std)| json!({ "run": run, "value": value, "std": std }));
        document.insert("by_run".to_owned(), Value::Array(by_run.collect()));
    }
    Value::Object(document)
}

/// An effect as model files have it, and the one vane that shows it.
fn effect(effect: &DeclaredEffect, vane: Option<Channel>, controls: ControlNames) -> Map<String, Value> {
    let entries = effect_json(effect, controls).into_iter();
    entries.chain(vane.map(|vane| ("shown_by".to_owned(), json!(vane.name(controls))))).collect()
}
