//! The answer for a person.

use super::rejection::{explained, holdout_word, ratio_text, rejection, share_of_error};
use super::roots::dutch_roll;
use super::verdict::judged;
use crate::command::diagnose::answer::Answer;
use sideslip::io::outputs::number::{Fixed, band_text};
use sideslip::io::outputs::tables::terminal::Style;
use sideslip::io::outputs::words::cause_sentence::{manoeuvre, statement, unknown};
use sideslip::io::outputs::words::trim_difference::trim_differences;
use sideslip::postflight::diagnosis::evidence::residual_coherence::{AxisSpectrum, DominantSignal};
use sideslip::postflight::diagnosis::holdout::horizon_prediction::HORIZON_S;
use sideslip::postflight::diagnosis::record::RankedCause;
use std::fmt::Write;

/// Of more causes than these each has a line only.
const MANY: usize = 5;

/// Findings, what remains, the gain.
pub(super) fn text(answer: &Answer, style: Style) -> String {
    let mut text = String::new();
    let diagnosis = &answer.diagnosis;
    let say = |one: &RankedCause| statement(one, answer.model.linear(), answer.controls);
    if let Some(one) = &diagnosis.unknown {
        let _ = writeln!(text, "{}", style.bold(format_args!("Unknown: {}", unknown(one))));
        if !diagnosis.findings.is_empty() {
            let _ = writeln!(text, "Closest hypotheses, which do not explain it:");
        }
    } else if diagnosis.findings.is_empty() {
        let words = explained(diagnosis);
        let _ = writeln!(text, "{}", style.bold(format_args!("{words} (probability {})", Fixed(diagnosis.none.0, 2))));
    } else {
        let _ = writeln!(text, "{}", style.bold("What the model gets wrong:"));
    }
    for (number, finding) in diagnosis.findings.iter().enumerate() {
        let (probability, share) = (finding.cause.probability, share_of_error(finding, &diagnosis.findings));
        let _ = writeln!(
            text,
            "  {}. {} (probability {probability}; {share})",
            number + 1,
            say(&finding.cause),
            probability = Fixed(probability, 2)
        );
        let held_out = diagnosis.judged().is_some() && diagnosis.findings.len() <= MANY;
        if held_out && finding.held_out.is_none() {
            let _ = writeln!(text, "     on the hold-out runs: not excited there");
        }
        if let Some(own) = finding.held_out.filter(|_| held_out) {
            let (word, ratio) = (holdout_word(&own), ratio_text(&own.ratio));
            let (channel, of_channel) = (own.channel.name(answer.controls), ratio_text(&own.channel_ratio));
            let _ = writeln!(
                text,
                "     on the hold-out runs: {word} (error with it over error without: {ratio}; of {channel} {of_channel})"
            );
        }
        let class = finding.plausible();
        if let [first, second, ..] = class.as_slice() {
            for rival in class.iter().skip(1) {
                let _ = writeln!(text, "     or {} (probability {})", say(rival), Fixed(rival.probability, 2));
            }
            let _ = writeln!(text, "     to distinguish: {}", manoeuvre(&first.effect, &second.effect));
        }
    }
    for one in &diagnosis.rejected {
        let _ = writeln!(text, "  not relied upon: {} ({})", say(&one.finding.cause), rejection(one, answer.controls));
    }
    if !diagnosis.trim_differences.is_empty() {
        let words = "runs do not begin in the model's trim, which is no cause; forces are taken about their own trim";
        let _ = writeln!(text, "  note: {words}: {}", trim_differences(&diagnosis.trim_differences, answer.controls));
    }
    if !diagnosis.unmodelled.is_empty() {
        let names: Vec<&str> = diagnosis.unmodelled.iter().map(|axis| axis.name()).collect();
        let words = "the measured motion is used there";
        let _ = writeln!(text, "  note: the model has no derivatives of {}: {words}", names.join(", "));
    }
    let _ = writeln!(text, "\n  axis  residual rms   after   noise  explained  mostly in");
    for one in &diagnosis.discrepancy {
        let unit = if one.axis.is_force() { "m/s^2" } else { "rad/s^2" };
        let band = band_text(one.band_hz);
        let explained =
            if one.rms > 0.2 * one.noise { format!("{:>6} %", Fixed(100.0 * one.explained, 0)) } else { "       -".to_owned() };
        let _ = writeln!(
            text,
            "  {:<4} {:>9} {:>9} {:>7} {explained:>10}  {band} Hz  {unit}",
            one.axis.name(),
            Fixed(one.rms, 4),
            Fixed(one.rms_after, 4),
            Fixed(one.noise, 4)
        );
    }
    for own in &diagnosis.spectra {
        if let Some(line) = companion(answer, own) {
            let _ = writeln!(text, "  {line}");
        }
    }
    if let Some((gain, pairs)) = &diagnosis.gain {
        if let Some(pooled) = &gain.pooled
            && diagnosis.findings.is_empty()
        {
            let _ = writeln!(
                text,
                "\nHold-out runs, predicted {HORIZON_S} s ahead: error over noise {}",
                Fixed(pooled.rms[0].value, 2)
            );
        } else if let Some(pooled) = &gain.pooled {
            let [before, after] = &pooled.rms;
            let [low, high] = pooled.ratio.interval;
            let _ = writeln!(
                text,
                "\nHold-out runs, predicted {HORIZON_S} s ahead: error over noise {} before, {} after; ratio {} [{low} {high}]: {}",
                Fixed(before.value, 2),
                Fixed(after.value, 2),
                Fixed(pooled.ratio.value, 3),
                judged(pooled),
                low = Fixed(low, 3),
                high = Fixed(high, 3)
            );
        }
        for (which, diverged) in pairs.iter().enumerate().flat_map(|(run, (before, after))| {
            [("the model", before.diverged_at_s), ("the extended model", after.diverged_at_s)]
                .map(|(which, at)| (format!("{which} on hold-out run {}", run + 1), at))
        }) {
            if let Some(at_s) = diverged {
                let _ = writeln!(text, "  {which} diverges at {at_s} s and is compared up to there", at_s = Fixed(at_s, 1));
            }
        }
        let root = |extension: &[_]| {
            let root = dutch_roll(answer, extension);
            Some((root.get("real")?.as_f64()?, root.get("imag")?.as_f64()?))
        };
        if let (Some((a, b)), Some((c, d))) = (root(&[]), root(&answer.extension)) {
            let _ = write!(text, "Dutch roll: {a:+} +- {b}i 1/s in the model", a = Fixed(a, 4), b = Fixed(b, 4));
            let _ = match answer.extension.as_slice() {
                [] => writeln!(text),
                _ => writeln!(text, ", {c:+} +- {d}i with the extension", c = Fixed(c, 4), d = Fixed(d, 4)),
            };
        }
    }
    if let Some(path) = &answer.extended {
        let _ = writeln!(text, "extended model: {}", path.display());
    }
    text
}

/// `residual N correlates with pedal (coherence 0.93, 0.25-1.50 Hz); after the causes with nothing`.
fn companion(answer: &Answer, own: &AxisSpectrum) -> Option<String> {
    let said = |one: &DominantSignal| {
        let (name, band) = (one.signal.name(answer.controls), band_text(one.band_hz));
        format!("{name} (coherence {}, {band} Hz)", Fixed(one.coherence, 2))
    };
    let axis = own.axis.name();
    match (own.dominant_signal(false), own.dominant_signal(true)) {
        (None, None) => None,
        (Some(before), None) => {
            Some(format!("residual {axis} correlates with {}; after the causes with no signal", said(&before)))
        }
        (None, Some(after)) => Some(format!("residual {axis} correlates with no signal; after the causes with {}", said(&after))),
        (Some(before), Some(after)) => {
            Some(format!("residual {axis} correlates with {}; after the causes still with {}", said(&before), said(&after)))
        }
    }
}
