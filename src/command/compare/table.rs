//! The answer for a person.

use crate::command::compare::comparison::{ComparedRun, Comparison};
use sideslip::flight::channel::ControlNames;
use sideslip::io::outputs::number::{Fixed, decimals};
use sideslip::io::outputs::tables::terminal::Style;
use sideslip::io::outputs::words::printable::printable;
use sideslip::postflight::validation::improvement::{
    ChannelImprovement, Improvement, ImprovementVerdict, IntervalEstimate, PooledImprovement,
};
use std::fmt::Write;

pub(super) fn text(answer: &Comparison, style: Style) -> String {
    let mut text = String::new();
    for (one, gain) in &answer.runs {
        let _ = writeln!(text, "{}: {}", style.bold(printable(&one.name)), flown(one));
        let controls = one.info.geometry().controls;
        if one.scored {
            figures(&mut text, gain, controls, answer.beside);
        }
        if !one.model.not_predicted.is_empty() {
            let names: Vec<&str> = one.model.not_predicted.iter().map(|channel| channel.name(controls)).collect();
            let _ = writeln!(text, "  not predicted: {} (the model has no derivative of their axis)", names.join(", "));
        }
        text.push('\n');
    }
    if answer.runs.len() > 1 {
        let scored = answer.runs.iter().filter(|(one, _)| one.scored).count();
        let all = answer.runs.len();
        let heading = match all - scored {
            0 => format!("all {all} runs"),
            without => format!("{scored} of {all} runs; {without} without a score, where a model diverges at once"),
        };
        let _ = writeln!(text, "{}", style.bold(heading));
        let controls = answer.runs.first().map_or(ControlNames::Rotorcraft, |(one, _)| one.info.geometry().controls);
        if scored > 0 {
            figures(&mut text, &answer.all, controls, answer.beside);
        }
    }
    format!("{}\n", text.trim_end())
}

/// How far the free runs went.
fn flown(one: &ComparedRun) -> String {
    let [start_s, end_s] = one.model.range_s;
    let mut said = format!("free run over {:.1} s", end_s - start_s);
    let beside = one.beside.as_ref().and_then(|beside| beside.diverged_at_s);
    for (who, diverged_at_s) in [("the model", one.model.diverged_at_s), ("the model beside", beside)] {
        match diverged_at_s {
            Some(at_s) if one.scored => {
                let _ = write!(said, "; {who} diverges at {at_s:.2} s and is compared up to there");
            }
            Some(at_s) => {
                let _ = write!(said, "; {who} DIVERGES at {at_s:.2} s, before its trim window ends: no score");
            }
            None => {}
        }
    }
    said
}

fn figures(text: &mut String, gain: &Improvement, controls: ControlNames, beside: bool) {
    let _ = if beside {
        writeln!(
            text,
            "  {:<10} {:>7} {:>10} {:>10} {:>10} {:>15} {:>15}   after/before",
            "channel", "unit", "noise", "rms", "beside", "TIC", "VAF"
        )
    } else {
        writeln!(text, "  {:<10} {:>7} {:>10} {:>10} {:>19} {:>7} {:>8}", "channel", "unit", "noise", "rms", "95 %", "TIC", "VAF")
    };
    for one in &gain.channels {
        channel(text, one, controls, beside);
    }
    for (name, pooled) in [("pooled", &gain.pooled), ("airspeed", &gain.airspeed), ("altitude", &gain.altitude)] {
        if let Some(pooled) = pooled {
            let _ = writeln!(text, "  {}", over_noise(name, pooled, beside));
        }
    }
}

fn channel(text: &mut String, one: &ChannelImprovement, controls: ControlNames, beside: bool) {
    let (name, unit) = (one.channel.name(controls), one.channel.si_unit());
    let [rms, after] = one.rms;
    let [tic, tic_after] = one.theil;
    let [vaf, vaf_after] = one.vaf;
    let mark = if one.absolute { " (absolute)" } else { "" };
    let head = format!("  {name:<10} {unit:>7} {:>10} {:>10}", number(one.noise_std), number(rms.value));
    let _ = if beside {
        writeln!(
            text,
            "{head} {:>10} {:>15} {:>15}   {}{mark}",
            number(after.value),
            format!("{} -> {}", Fixed(tic.value, 3), Fixed(tic_after.value, 3)),
            format!("{} -> {}", share(vaf.value), share(vaf_after.value)),
            ratio(&one.ratio),
        )
    } else {
        let [low, high] = rms.interval;
        let interval = format!("[{} {}]", number(low), number(high));
        writeln!(text, "{head} {interval:>19} {:>7} {:>8}{mark}", Fixed(tic.value, 3), share(vaf.value))
    };
}

/// `pooled over p q r: 2.1 times noise`.
fn over_noise(name: &str, pooled: &PooledImprovement, beside: bool) -> String {
    let [before, after] = pooled.rms;
    let over = match pooled.channels.as_slice() {
        [_] => String::new(),
        several => format!(" over {} channels", several.len()),
    };
    let [low, high] = before.interval;
    if before.value.is_nan() {
        return format!("{name}{over}: no score, for nothing was predicted long enough");
    }
    let (value, low, high) = (Fixed(before.value, 2), Fixed(low, 2), Fixed(high, 2));
    let times = format!("{name}{over}: rms {value} [{low} {high}] times the noise");
    if beside { format!("{times}, beside {}: {}", Fixed(after.value, 2), ratio(&pooled.ratio)) } else { times }
}

fn ratio(ratio: &IntervalEstimate) -> String {
    let [low, high] = ratio.interval;
    let judged = match ratio.verdict() {
        ImprovementVerdict::Gain => "",
        ImprovementVerdict::NoGain => ", no gain",
        ImprovementVerdict::Loss => ", worse",
    };
    if ratio.value.is_nan() {
        return "none".to_owned();
    }
    format!("{} [{} {}]{judged}", Fixed(ratio.value, 3), Fixed(low, 3), Fixed(high, 3))
}

fn number(value: f64) -> String {
    let size = libm::fabs(value);
    match size {
        0.0 => "0".to_owned(),
        _ if size.is_finite() => Fixed(value, decimals(size, 4, 8)).to_string(),
        _ => Fixed(value, 0).to_string(),
    }
}

fn share(value: f64) -> String {
    if value < -99.0 { "< -99".to_owned() } else { Fixed(value, 3).to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits_and_what_is_none_is_a_word() {
        assert_eq!([0.012_345, 123.456, 98_765.4, 1e-12, 0.0].map(number), ["0.01235", "123.5", "98765", "0.00000000", "0"]);
        assert_eq!(
            (number(f64::NAN), share(f64::NAN), share(-1e9), share(0.5)),
            ("none".into(), "none".into(), "< -99".into(), "0.500".into())
        );
        assert_eq!([1e300, f64::INFINITY, -1e9].map(number), ["1.00e300", "infinite", "-1.00e9"]);
    }
}
