//! The answer for a person.

use crate::command::compare::comparison::{ComparedRun, Comparison};
use sideslip::flight::channel::ControlNames;
use sideslip::io::outputs::number::decimals;
use sideslip::io::outputs::tables::terminal::Style;
use sideslip::postflight::validation::improvement::{
    ChannelImprovement, Improvement, ImprovementVerdict, IntervalEstimate, PooledImprovement,
};
use std::fmt::Write;

pub(super) fn text(answer: &Comparison, style: Style) -> String {
    let mut text = String::new();
    for (one, gain) in &answer.runs {
        let _ = writeln!(text, "{}: {}", style.bold(&one.name), flown(one));
        let controls = one.info.geometry().controls;
        figures(&mut text, gain, controls, answer.beside);
        if !one.model.not_predicted.is_empty() {
            let names: Vec<&str> = one.model.not_predicted.iter().map(|channel| channel.name(controls)).collect();
            let _ = writeln!(text, "  not predicted: {} (the model has no derivative of their axis)", names.join(", "));
        }
        text.push('\n');
    }
    if answer.runs.len() > 1 {
        let _ = writeln!(text, "{}", style.bold(format!("all {} runs", answer.runs.len())));
        let controls = answer.runs.first().map_or(ControlNames::Rotorcraft, |(one, _)| one.info.geometry().controls);
        figures(&mut text, &answer.all, controls, answer.beside);
    }
    format!("{}\n", text.trim_end())
}

/// How far the free runs went.
fn flown(one: &ComparedRun) -> String {
    let [start_s, end_s] = one.model.range_s;
    let mut said = format!("free run over {:.1} s", end_s - start_s);
    let beside = one.beside.as_ref().and_then(|beside| beside.diverged_at_s);
    for (who, diverged_at_s) in [("the model", one.model.diverged_at_s), ("the model beside", beside)] {
        if let Some(at_s) = diverged_at_s {
            let _ = write!(said, "; {who} diverges at {at_s:.2} s and is compared up to there");
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
            format!("{:.3} -> {:.3}", tic.value, tic_after.value),
            format!("{} -> {}", share(vaf.value), share(vaf_after.value)),
            ratio(&one.ratio),
        )
    } else {
        let [low, high] = rms.interval;
        let interval = format!("[{} {}]", number(low), number(high));
        writeln!(text, "{head} {interval:>19} {:>7.3} {:>8}{mark}", tic.value, share(vaf.value))
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
    let times = format!("{name}{over}: rms {:.2} [{low:.2} {high:.2}] times the noise", before.value);
    if beside { format!("{times}, beside {:.2}: {}", after.value, ratio(&pooled.ratio)) } else { times }
}

fn ratio(ratio: &IntervalEstimate) -> String {
    let [low, high] = ratio.interval;
    let judged = match ratio.verdict() {
        ImprovementVerdict::Gain => "",
        ImprovementVerdict::NoGain => ", no gain",
        ImprovementVerdict::Loss => ", worse",
    };
    format!("{:.3} [{low:.3} {high:.3}]{judged}", ratio.value)
}

fn number(value: f64) -> String {
    let size = libm::fabs(value);
    if !(size > 0.0) {
        return if size.is_nan() { "-" } else { "0" }.to_owned();
    }
    let digits = decimals(size, 4, 8);
    format!("{value:.digits$}")
}

fn share(value: f64) -> String {
    if !value.is_finite() {
        "-".to_owned()
    } else if value < -99.0 {
        "< -99".to_owned()
    } else {
        format!("{value:.3}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits_and_nothing_is_a_dash() {
        assert_eq!([0.012_345, 123.456, 98_765.4, 1e-12, 0.0].map(number), ["0.01235", "123.5", "98765", "0.00000000", "0"]);
        assert_eq!(
            (number(f64::NAN), share(f64::NAN), share(-1e9), share(0.5)),
            ("-".into(), "-".into(), "< -99".into(), "0.500".into())
        );
    }
}
