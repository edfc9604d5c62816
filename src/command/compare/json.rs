//! The answer as a JSON document; what is no number is null.

use crate::command::compare::comparison::Comparison;
use serde_json::{Map, Value, json};
use sideslip::flight::channel::ControlNames;
use sideslip::postflight::validation::improvement::{
    ChannelImprovement, Improvement, ImprovementVerdict, IntervalEstimate, PooledImprovement,
};

/// The whole answer: each run, and all together.
pub(super) fn document(answer: &Comparison) -> Value {
    let controls = answer.runs.first().map_or(ControlNames::Rotorcraft, |(one, _)| one.info.geometry().controls);
    let runs: Vec<Value> = answer
        .runs
        .iter()
        .map(|(one, gain)| {
            let not_predicted: Vec<&str> = one.model.not_predicted.iter().map(|channel| channel.name(controls)).collect();
            let mut run = json!({ "run": one.name, "diverged_at_s": one.model.diverged_at_s, "scored": one.scored, "not_predicted": not_predicted });
            if let Some(beside) = &one.beside {
                run["beside_diverged_at_s"] = json!(beside.diverged_at_s);
            }
            figures(&mut run, gain, controls, answer.beside);
            run
        })
        .collect();
    let mut all = json!({});
    figures(&mut all, &answer.all, controls, answer.beside);
    json!({ "runs": runs, "all": all })
}

fn figures(to: &mut Value, gain: &Improvement, controls: ControlNames, beside: bool) {
    let channels = gain.channels.iter().map(|one| (one.channel.name(controls).to_owned(), channel(one, beside)));
    to["channels"] = Value::Object(channels.collect::<Map<_, _>>());
    for (name, pooled) in [("pooled", &gain.pooled), ("airspeed", &gain.airspeed), ("altitude", &gain.altitude)] {
        to[name] = pooled.as_ref().map_or(Value::Null, |pooled| of_pooled(pooled, controls, beside));
    }
}

fn channel(one: &ChannelImprovement, beside: bool) -> Value {
    let mut channel =
        json!({ "unit": one.channel.si_unit(), "samples": one.samples, "noise_std": one.noise_std, "absolute": one.absolute });
    for (name, [before, after]) in [("rms", &one.rms), ("theil", &one.theil), ("vaf", &one.vaf)] {
        if beside {
            put(&mut channel, &format!("{name}_before"), before);
            put(&mut channel, &format!("{name}_after"), after);
        } else {
            put(&mut channel, name, before);
        }
    }
    if beside {
        ratio(&mut channel, &one.ratio);
    }
    channel
}

fn of_pooled(one: &PooledImprovement, controls: ControlNames, beside: bool) -> Value {
    let names: Vec<&str> = one.channels.iter().map(|channel| channel.name(controls)).collect();
    let mut pooled = json!({ "channels": names });
    let [before, after] = &one.rms;
    if beside {
        put(&mut pooled, "over_noise_before", before);
        put(&mut pooled, "over_noise_after", after);
        ratio(&mut pooled, &one.ratio);
    } else {
        put(&mut pooled, "over_noise", before);
    }
    pooled
}

fn put(to: &mut Value, name: &str, estimate: &IntervalEstimate) {
    to[name] = json!(estimate.value);
    to[format!("{name}_interval")] = json!(estimate.interval);
}

fn ratio(to: &mut Value, estimate: &IntervalEstimate) {
    put(to, "ratio", estimate);
    let judged = match estimate.verdict() {
        ImprovementVerdict::Gain => "gain",
        ImprovementVerdict::NoGain => "no gain",
        ImprovementVerdict::Loss => "loss",
    };
    to["judged"] = json!(estimate.value.is_finite().then_some(judged));
}
