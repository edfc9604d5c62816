//! The answer as a JSON document; what is no number is null.

use super::rejection::{holdout_word, rejection};
use super::roots::dutch_roll;
use super::verdict::judged;
use crate::command::diagnose::answer::Answer;
use serde_json::{Map, Value, json};
use sideslip::flight::effect::Effect;
use sideslip::flight::file::effect_file::DeclaredEffect;
use sideslip::io::outputs::json::effect_json::effect_json;
use sideslip::io::outputs::words::cause_sentence::{manoeuvre, statement, unknown};
use sideslip::io::outputs::words::set_aside::reason;
use sideslip::postflight::diagnosis::diagnose::Finding;
use sideslip::postflight::diagnosis::diagnose::RejectedCause;
use sideslip::postflight::diagnosis::evidence::residual_coherence::{AxisSpectrum, CHANCE};
use sideslip::postflight::diagnosis::holdout::horizon_prediction::HORIZON_S;
use sideslip::postflight::diagnosis::record::{RankedCause, TrimDifference};
use sideslip::postflight::validation::improvement::{Improvement, IntervalEstimate, PooledImprovement};

pub(super) fn document(answer: &Answer) -> Value {
    let diagnosis = &answer.diagnosis;
    let ranking: Vec<Value> = match diagnosis.findings.first() {
        Some(first) => first.ranking.iter().map(|one| ranked(answer, one)).collect(),
        None => diagnosis.none.1.iter().map(|one| ranked(answer, one)).collect(),
    };
    let findings: Vec<Value> = diagnosis
        .findings
        .iter()
        .map(|finding| {
            let mut document = cause(answer, &finding.cause);
            document.insert("share".to_owned(), json!(finding.error_share));
            document.insert("motion_share".to_owned(), json!(finding.motion_share));
            holdout(&mut document, answer, finding);
            let class = finding.plausible();
            if let [first, second, ..] = class.as_slice() {
                document.insert("class".to_owned(), class.iter().map(|one| ranked(answer, one)).collect());
                document.insert("split_by".to_owned(), json!(manoeuvre(&first.effect, &second.effect)));
            }
            Value::Object(document)
        })
        .collect();
    let discrepancy: Map<String, Value> = diagnosis
        .discrepancy
        .iter()
        .map(|one| {
            let unit = if one.axis.is_force() { "m/s^2" } else { "rad/s^2" };
            let mut of = json!({ "rms": one.rms, "unit": unit, "explained": one.explained, "rms_after": one.rms_after,
                "noise": one.noise, "motion": one.motion, "band_hz": [one.band_hz.0, one.band_hz.1] });
            if let Some(own) = diagnosis.spectra.iter().find(|own| own.axis == one.axis) {
                of["spectrum"] = spectrum(own, unit);
                of["coherence"] = json!({ "before": together(answer, own, false), "after": together(answer, own, true),
                    "level": own.level, "chance": CHANCE, "segments": own.segments });
            }
            (one.axis.name().to_owned(), of)
        })
        .collect();
    let extended: Vec<Value> = answer.extension.iter().map(|one| Value::Object(effect_json(one, answer.controls))).collect();
    let set_aside: Vec<Value> =
        diagnosis.set_aside.iter().map(|(run, why)| json!({ "run": run, "reason": reason(why) })).collect();
    json!({
        "verdict": verdict(answer),
        "ranking": ranking,
        "findings": findings,
        "rejected": rejected(answer),
        "discrepancy": discrepancy,
        "gain": diagnosis.gain.as_ref().map_or(Value::Null, |(gain, _)| gained(answer, gain)),
        "extended_model": answer.extended.as_ref().map(|path| path.display().to_string()),
        "extended_effects": extended,
        "trim_difference": trim_difference(answer),
        "silent": diagnosis.unmodelled.iter().map(|axis| axis.name()).collect::<Vec<_>>(),
        "set_aside": set_aside,
    })
}

/// What the hold-out runs say of a cause.
fn holdout(document: &mut Map<String, Value>, answer: &Answer, finding: &Finding) {
    let Some(own) = &finding.held_out else { return };
    document.insert("holdout".to_owned(), json!(holdout_word(own)));
    document.insert("holdout_ratio".to_owned(), json!(own.ratio.value));
    document.insert("holdout_ratio_interval".to_owned(), json!(own.ratio.interval));
    let (channel, ratio) = (own.channel.name(answer.controls), &own.channel_ratio);
    let of = json!({ "channel": channel, "ratio": ratio.value, "interval": ratio.interval, "predicted": own.channel_expected });
    document.insert("holdout_channel".to_owned(), of);
}

/// Causes that fit and are not relied upon.
fn rejected(answer: &Answer) -> Value {
    let one = |one: &RejectedCause| {
        let mut document = Map::new();
        document.insert("effect".to_owned(), Value::Object(effect_json(&declared(&one.finding.cause), answer.controls)));
        document.insert("why".to_owned(), json!(rejection(one, answer.controls)));
        document.insert("share".to_owned(), json!(one.finding.error_share));
        holdout(&mut document, answer, &one.finding);
        Value::Object(document)
    };
    answer.diagnosis.rejected.iter().map(one).collect()
}

/// Where trim and model differ.
fn trim_difference(answer: &Answer) -> Value {
    let one = |one: &TrimDifference| {
        let unit = one.channel.si_unit();
        (one.channel.name(answer.controls).to_owned(), json!({ "value": one.value, "std": one.std, "unit": unit }))
    };
    Value::Object(answer.diagnosis.trim_differences.iter().map(one).collect())
}

/// The strongest lines, not the whole spectrum.
fn spectrum(own: &AxisSpectrum, unit: &str) -> Value {
    let lines = own.strongest().into_iter().map(|line| {
        let at = |list: &[f64]| list.get(line).copied();
        json!({ "hz": at(&own.hz), "before": at(&own.before), "after": at(&own.after), "noise": at(&own.noise) })
    });
    json!({ "unit": format!("({unit})^2/Hz"), "lines": lines.collect::<Vec<_>>() })
}

/// The most coherent signal, null where none is.
fn together(answer: &Answer, own: &AxisSpectrum, after: bool) -> Value {
    own.dominant_signal(after).map_or(Value::Null, |one| {
        json!({ "signal": one.signal.name(answer.controls), "coherence": one.coherence,
            "band_hz": [one.band_hz.0, one.band_hz.1] })
    })
}

fn declared(one: &RankedCause) -> DeclaredEffect {
    DeclaredEffect { effect: one.effect, std: Some(one.std).filter(|std| std.is_finite()) }
}

fn ranked(answer: &Answer, one: &RankedCause) -> Value {
    let effect = effect_json(&declared(one), answer.controls);
    json!({ "effect": effect, "probability": one.probability })
}

fn cause(answer: &Answer, one: &RankedCause) -> Map<String, Value> {
    let mut document = effect_json(&declared(one), answer.controls);
    document.insert("probability".to_owned(), json!(one.probability));
    document.insert("statement".to_owned(), json!(statement(one, answer.model.linear(), answer.controls)));
    document
}

fn verdict(answer: &Answer) -> Value {
    let diagnosis = &answer.diagnosis;
    if let Some(one) = &diagnosis.unknown {
        return json!({ "kind": "unknown", "axis": one.axis.name(), "band_hz": [one.band_hz.0, one.band_hz.1],
            "statement": unknown(one), "probability": 1.0 - diagnosis.none.0 });
    }
    match diagnosis.findings.first() {
        Some(first) => Value::Object(cause(answer, &first.cause)),
        None => {
            let none = RankedCause { effect: Effect::None, std: f64::NAN, probability: diagnosis.none.0, odds: 0.0 };
            Value::Object(cause(answer, &none))
        }
    }
}

fn gained(answer: &Answer, gain: &Improvement) -> Value {
    let mut channels = Map::new();
    for one in &gain.channels {
        let [rms_before, rms_after] = &one.rms;
        let [theil_before, theil_after] = &one.theil;
        let [vaf_before, vaf_after] = &one.vaf;
        let mut of = json!({});
        for (name, estimate) in [
            ("rms_before", rms_before),
            ("rms_after", rms_after),
            ("theil_before", theil_before),
            ("theil_after", theil_after),
            ("vaf_before", vaf_before),
            ("vaf_after", vaf_after),
            ("ratio", &one.ratio),
        ] {
            put(&mut of, name, estimate);
        }
        channels.insert(one.channel.name(answer.controls).to_owned(), of);
    }
    let pooled = |pooled: &Option<PooledImprovement>| {
        pooled.as_ref().map_or(Value::Null, |pooled| {
            let names: Vec<&str> = pooled.channels.iter().map(|channel| channel.name(answer.controls)).collect();
            let [before, after] = &pooled.rms;
            let mut of = json!({ "channels": names, "judged": judged(pooled) });
            put(&mut of, "over_noise_before", before);
            put(&mut of, "over_noise_after", after);
            put(&mut of, "ratio", &pooled.ratio);
            of
        })
    };
    let all = gain.pooled.as_ref();
    let ratio = all.map(|pooled| &pooled.ratio);
    json!({
        "horizon_s": HORIZON_S,
        "ratio": ratio.map(|ratio| ratio.value),
        "interval": ratio.map(|ratio| ratio.interval),
        "verdict": all.map(judged),
        "holdout": { "channels": channels, "pooled": pooled(&gain.pooled), "airspeed": pooled(&gain.airspeed),
            "altitude": pooled(&gain.altitude) },
        "dutch_roll": { "model": dutch_roll(answer, &[]), "extended": dutch_roll(answer, &answer.extension) },
    })
}

fn put(to: &mut Value, name: &str, estimate: &IntervalEstimate) {
    to[name] = json!(estimate.value);
    to[format!("{name}_interval")] = json!(estimate.interval);
}
