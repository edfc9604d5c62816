//! The answer for a person.

use sideslip::flight::channel::{Channel, ControlNames};
use sideslip::flight::effect::{Effect, PositionedSensor};
use sideslip::flight::file::effect_file::DeclaredEffect;
use sideslip::flight::file::run_file::RunInfo;
use sideslip::flight::unit::DEGREE;
use sideslip::io::outputs::number::{Fixed, measured_text};
use sideslip::io::outputs::tables::terminal::Style;
use sideslip::io::outputs::tables::wrapped::wrapped_list;
use sideslip::io::outputs::words::instrument_words::{detection_limit, not_observable, separation, verdict_reason};
use sideslip::io::outputs::words::printable::printable;
use sideslip::postflight::reconstruction::correction::Correction;
use sideslip::postflight::reconstruction::verdict::RunVerdict;
use sideslip::realtime::estimation::screening::gross_error::speed_unit;
use std::fmt::Write;

const WIDTH: usize = 110;

pub(super) fn text(verdicts: &[RunVerdict], infos: &[&RunInfo], controls: ControlNames, style: Style) -> String {
    let mut text = String::new();
    for (verdict, info) in verdicts.iter().zip(infos) {
        if !text.is_empty() {
            text.push('\n');
        }
        let heading = format!("{}: {}", printable(&verdict.run), verdict.fitness.words());
        let _ = writeln!(text, "{}\n  {}", style.bold(heading), verdict_reason(&verdict.reason));
        if let Some(gaps) = long_gaps(&verdict.long_gaps) {
            let _ = writeln!(text, "  {gaps}");
        }
        for one in &verdict.corrections {
            correction(&mut text, one, info, controls);
        }
        for (angle, r2) in ["alpha", "beta"].into_iter().zip(&verdict.consistency) {
            if let Some((before, after)) = r2 {
                let after = after.map_or("-".to_owned(), |after| Fixed(after, 3).to_string());
                let _ = writeln!(
                    text,
                    "  consistency of {angle}: R2 {before} as recorded, {after} after",
                    before = Fixed(*before, 3)
                );
            }
        }
        if !verdict.not_observable.is_empty() {
            let _ = writeln!(text, "  not observable in this run:");
            for one in verdict.not_observable.iter().filter(|one| detection_limit(one).is_none()) {
                let _ = writeln!(text, "    {}", not_observable(one));
            }
            let mut limits: Vec<String> = verdict.not_observable.iter().filter_map(detection_limit).collect();
            if let Some(first) = limits.first_mut() {
                first.insert_str(0, "not detectable below: ");
                for (place, line) in wrapped_list(&limits, WIDTH - 6).into_iter().enumerate() {
                    let _ = writeln!(text, "{}{line}", if place == 0 { "    " } else { "      " });
                }
            }
        }
    }
    text
}

fn long_gaps(gaps: &[[f64; 2]]) -> Option<String> {
    let [from_s, to_s] = gaps.iter().copied().max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))?;
    let count = gaps.len();
    let (gap, longest) = if count == 1 { ("gap", "") } else { ("gaps", ", the longest") };
    Some(format!(
        "{count} {gap} without any sample{longest} from {from_s} to {to_s} s: the stretches between are followed each from a new start",
        from_s = Fixed(from_s, 2),
        to_s = Fixed(to_s, 2)
    ))
}

fn correction(text: &mut String, one: &Correction, info: &RunInfo, controls: ControlNames) {
    let _ = writeln!(text, "  * {}", sentence(&one.effect, one.axis_stds_m, one.vane, controls));
    for other in &one.alternatives {
        let _ = writeln!(text, "      or {}", sentence(&other.effect, [None; 3], other.vane, controls));
    }
    if let (Effect::SensorScale { channel: Channel::Tas, factor }, Some(std)) = (one.effect.effect, one.effect.std)
        && let Some(unit) = speed_unit(factor, std)
    {
        let _ = writeln!(text, "      consistent with a speed in {unit} recorded as m/s");
    }
    if let Some(angle) = one.turned {
        let _ = writeln!(text, "      or the accelerometers are misaligned by {} deg", Fixed((angle / DEGREE).abs(), 1));
        let _ = writeln!(
            text,
            "      distinguished by: steep turns and pull-ups, where the error of misaligned accelerometers grows with load factor"
        );
    }
    for pair in &one.split_by {
        let _ = writeln!(text, "      distinguished by: {}", separation(*pair));
    }
    for (run, value, std) in &one.by_run {
        let _ = writeln!(text, "      {run} alone, with the same corrections: {}", measured_text(*value, *std));
    }
    if let Effect::SensorPosition { sensor, offset_m } = one.effect.effect {
        let (key, stands) = match sensor {
            PositionedSensor::Vane => ("vane_position_m", info.geometry().vane_position_m),
            PositionedSensor::Accelerometer => ("accelerometer_position_m", info.geometry().accelerometer_position_m),
        };
        let [x, y, z] = [0, 1, 2].map(|axis| stands[axis] + offset_m[axis]);
        let both = one.vane.map_or("", |_| " (moves both vanes; the data do not show it of the other one)");
        let _ = writeln!(
            text,
            "      correct it by: --set {key}=[{x},{y},{z}]{both}",
            x = Fixed(x, 2),
            y = Fixed(y, 2),
            z = Fixed(z, 2)
        );
    }
}

/// A value and its standard error.
fn with_error(value: f64, std: f64, unit: &str) -> String {
    format!("{} {unit}", measured_text(value, std)).trim_end().to_owned()
}

fn sentence(declared: &DeclaredEffect, axis_stds_m: [Option<f64>; 3], vane: Option<Channel>, controls: ControlNames) -> String {
    let std = declared.std.unwrap_or(f64::NAN);
    let with = |value: f64, factor: f64, unit: &str| with_error(value * factor, std * factor, unit);
    let scaled = |channel: Channel| match channel.si_unit() {
        "rad" => (1.0 / DEGREE, "deg"),
        "rad/s" => (1.0 / DEGREE, "deg/s"),
        unit => (1.0, unit),
    };
    match declared.effect {
        Effect::SensorBias { channel, value } => {
            let (factor, unit) = scaled(channel);
            format!("{} has a bias of {}", channel.name(controls), with(value, factor, unit))
        }
        Effect::SensorScale { channel, factor } => {
            format!("{} has a scale factor of {}", channel.name(controls), with(factor, 1.0, ""))
        }
        Effect::SensorLag { channel, tau } => {
            format!("{} has a first-order lag with a time constant of {}", channel.name(controls), with(tau, 1.0, "s"))
        }
        Effect::SensorDelay { channel, delay } if delay < 0.0 => {
            format!("{} leads the other channels by {}", channel.name(controls), with(-delay, 1.0, "s"))
        }
        Effect::SensorDelay { channel, delay } => format!("{} is delayed by {}", channel.name(controls), with(delay, 1.0, "s")),
        Effect::SensorPosition { sensor, offset_m } => {
            let what = match (sensor, vane) {
                (PositionedSensor::Vane, Some(channel)) => format!("{} is", channel.name(controls)),
                (PositionedSensor::Vane, None) => "alpha and beta are".to_owned(),
                (PositionedSensor::Accelerometer, _) => "ax ay az are".to_owned(),
            };
            let ways = [("ahead of", "behind"), ("right of", "left of"), ("below", "above")];
            let largest = offset_m.iter().fold(0.0f64, |most, part| most.max(part.abs()));
            let mut parts: Vec<String> = Vec::new();
            let axes = offset_m.iter().zip(axis_stds_m).zip(ways).filter(|((part, _), _)| part.abs() > 0.0);
            for ((part, own), (positive, negative)) in axes {
                let way = if *part > 0.0 { positive } else { negative };
                let known = own.or((part.abs() >= largest).then_some(std));
                let size = known.map_or_else(|| format!("{} m", Fixed(part.abs(), 1)), |std| with_error(part.abs(), std, "m"));
                parts.push(format!("{size} {way}"));
            }
            format!("{what} measured {} where the run says", parts.join(", "))
        }
        other => other.kind().name().to_owned(),
    }
}
