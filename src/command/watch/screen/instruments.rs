//! Page of the instruments: what each channel reads, how the filter uses each aid, and the biases of the inertial sensors.

use super::super::bus_picture::{AidUse, BusPicture};
use super::ink::{Ink, heading, labelled, line};
use super::link_words::{self, SILENT};
use ratatui::style::Style;
use ratatui::text::Line;
use sideslip::flight::channel::Channel;
use sideslip::io::outputs::number::{Digits, measured};
use sideslip::io::outputs::words::status_text::aid_name;
use sideslip::realtime::estimation::record::{Aid, StateRecord};

/// The page.
pub(super) fn lines(picture: &BusPicture, width: usize, ink: Ink) -> Vec<Line<'static>> {
    let mut lines = Vec::new();
    lines.extend(link_words::link(picture).labelled("Link", width, ink));
    lines.extend(link_words::estimate(picture).labelled("Estimate", width, ink));
    lines.push(heading("Aid         samples  used %  test ratio   (above 1: rejected)"));
    let aids = Aid::ALL.into_iter().zip(&picture.aids);
    lines.extend(aids.filter(|(_, aid)| aid.offered > 0).map(|(name, aid)| aid_line(name, aid, ink)));
    if let Some(state) = &picture.state {
        lines.push(heading("Bias of the sensors"));
        lines.extend(bias_lines(state));
    }
    lines.push(heading("Channel          reads        unit       age"));
    for channel in Channel::ALL {
        let name = channel.name(picture.controls);
        let Some((value, age)) = picture.flow.reading(channel) else { continue };
        let (silent, unit) = (age > SILENT, channel.si_unit());
        let word = if silent { "  STALE" } else { "" };
        let text = format!("{name:<14} {:>10}  {unit:<9} {:>8.2} s{word}", Digits(value, 4).to_string(), age.as_secs_f64());
        lines.push(line(&text, ink.numbers(!silent)));
    }
    let missing = Channel::ALL.into_iter().filter(|channel| picture.flow.reading(*channel).is_none());
    let missing: Vec<&str> = missing.map(|channel| channel.name(picture.controls)).collect();
    if !missing.is_empty() {
        lines.extend(labelled("not sampled", &missing.join(" "), Style::new(), width));
    }
    lines
}

fn aid_line(name: Aid, aid: &AidUse, ink: Ink) -> Line<'static> {
    let used = 100.0 * aid.fused as f64 / aid.offered.max(1) as f64;
    let (ratio, rejected) = aid.newest.map_or((f64::NAN, false), |newest| (newest.test_ratio, !newest.fused));
    let word = if rejected { "  REJECTED" } else { "" };
    let text = format!("{:<11} {:>7}  {used:>6.1}  {:>10}{word}", aid_name(name), aid.offered, Digits(ratio, 2).to_string());
    line(&text, if rejected { ink.stale() } else { Style::new() })
}

fn bias_lines(state: &StateRecord) -> Vec<Line<'static>> {
    let of = |names: [&str; 3], values: [f64; 3], stds: [f64; 3], unit: &str| {
        let each = names.into_iter().zip(values.into_iter().zip(stds)).map(|(name, (value, std))| {
            let (value, std) = measured(value, std);
            format!("{name} {value} +- {std}")
        });
        line(&format!("  {} {unit}", each.collect::<Vec<_>>().join(", ")), Style::new())
    };
    vec![
        of(["p", "q", "r"], state.gyro_bias, state.gyro_bias_std, "rad/s"),
        of(["ax", "ay", "az"], state.accelerometer_bias, state.accelerometer_bias_std, "m/s^2"),
    ]
}
