//! Why the diagnosis sets a run aside, or gives no result, in words.

use super::instrument_words::verdict_reason;
use crate::flight::channel::ControlNames;
use crate::flight::file::effect_file::DeclaredEffect;
use crate::io::outputs::number::estimate_text;
use crate::postflight::diagnosis::record::{InstrumentDisagreement, LENGTH_MIN_S, Unusable};
use std::fmt;

/// Why a run is not used.
pub fn reason(unusable: &Unusable) -> String {
    match unusable {
        Unusable::Instruments(disagreement) => {
            format!("its instruments do not agree with each other: {}", disagree(disagreement))
        }
        Unusable::NoControl(name) => format!("expected a column `{name}`, a control that the model answers to, found none"),
        Unusable::Back { sample, before_s, time_s } => {
            format!("sample {sample}: expected a time not before {before_s:.4} s, found {time_s:.4} s")
        }
        Unusable::Unit { channels, controls, unit } => format!(
            "reads like {} in {unit}: the model then fits far better; the header should name that unit, as in \
             `pedal[deg]`",
            channels.iter().map(|channel| channel.name(*controls)).collect::<Vec<_>>().join(", ")
        ),
        Unusable::NoRates(name) => format!("expected the rates p, q and r, found no samples of `{name}`"),
        Unusable::Short(length_s) => format!("expected at least {LENGTH_MIN_S} s with rates, found {length_s:.2} s"),
        Unusable::Seldom(interval_s) => format!("expected rates at 8 Hz or more, found one in {interval_s:.2} s"),
        Unusable::Gap(from_s, to_s) => {
            format!("expected rates without gaps, found none from {from_s:.2} s to {to_s:.2} s: cut the run there")
        }
    }
}

impl fmt::Display for Unusable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&reason(self))
    }
}

fn disagree(disagreement: &InstrumentDisagreement) -> String {
    let errors = |all: &[DeclaredEffect]| match all {
        [] => "none".to_owned(),
        all => all.iter().map(error).collect::<Vec<_>>().join(", "),
    };
    match disagreement {
        InstrumentDisagreement::NotFit(reason) => verdict_reason(reason),
        InstrumentDisagreement::OtherRuns { own, others } => {
            format!("errors found in it: {}; in the other runs: {}", errors(own), errors(others))
        }
    }
}

/// An instrument's error: its kind, the channel where it is on one, the number.
fn error(declared: &DeclaredEffect) -> String {
    let DeclaredEffect { effect, std } = declared;
    let channel = effect.sensor_channel().map(|channel| channel.name(ControlNames::Rotorcraft).to_owned());
    let number = effect.main_number().map(|number| estimate_text(number, std.unwrap_or(0.0)));
    let parts = [Some(effect.kind().name().to_owned()), channel, number];
    parts.into_iter().flatten().collect::<Vec<_>>().join(" ")
}
