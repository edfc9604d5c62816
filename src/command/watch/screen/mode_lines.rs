//! Modes as lines: number with standard error, period, time to half, and whether the mode decays.

use super::ink::{Ink, heading, line, sentence};
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use sideslip::io::outputs::number::{Digits, measured_text};
use sideslip::io::outputs::tables::terminal::half_or_double;
use sideslip::io::outputs::words::output_error_text::{oscillatory_modes, real_roots};
use sideslip::io::outputs::words::stability_text::LateralStability;
use sideslip::postflight::output_error::record::OutputErrorRecord;
use sideslip::realtime::modes::record::{ModeStability, ModesRecord, OscillatoryMode, RealRoot};
use std::f64::consts::TAU;

/// Columns of the names.
const NAMES: usize = 18;

fn word(stability: ModeStability, ink: Ink) -> Span<'static> {
    match stability {
        ModeStability::Stable => Span::styled("decays", ink.verdict(LateralStability::Stable)),
        ModeStability::Unstable => Span::styled("GROWS", ink.verdict(LateralStability::Unstable)),
        ModeStability::Unclear => Span::styled("not clear", ink.stale()),
    }
}

/// An oscillation, in two lines.
pub(super) fn oscillation(name: &str, pair: &OscillatoryMode, style: Style, ink: Ink) -> [Line<'static>; 2] {
    let numbers =
        format!("omega {} rad/s, zeta {}  ", measured_text(pair.omega, pair.std_omega), measured_text(pair.zeta, pair.std_zeta));
    let times = format!("{:NAMES$}period {} s, {}", "", Digits(TAU / pair.imag, 3), half_or_double(pair.real));
    [
        Line::from(vec![
            Span::styled(format!("{name:<NAMES$}"), Ink::bold()),
            Span::styled(numbers, style),
            word(pair.stability(), ink),
        ]),
        line(&times, style),
    ]
}

/// A real root.
pub(super) fn real_root(name: &str, root: &RealRoot, style: Style, ink: Ink) -> Line<'static> {
    let numbers = format!("root {} 1/s, {}  ", measured_text(root.value, root.std), half_or_double(root.value));
    Line::from(vec![
        Span::styled(format!("{name:<NAMES$}"), Ink::bold()),
        Span::styled(numbers, style),
        word(root.stability(), ink),
    ])
}

/// Roll, spiral and what they join into.
pub(super) fn slow_modes(modes: &ModesRecord, style: Style, ink: Ink) -> Vec<Line<'static>> {
    let mut lines = Vec::new();
    if let Some(pair) = &modes.lateral_phugoid {
        lines.extend(oscillation("lateral phugoid", pair, style, ink));
    }
    let roots = [("roll", &modes.roll), ("spiral", &modes.spiral)];
    lines.extend(roots.iter().filter_map(|(name, root)| Some(real_root(name, root.as_ref()?, style, ink))));
    lines
}

/// Output error: how far it is and its modes.
pub(super) fn output_error(record: &OutputErrorRecord, now_s: f64, width: usize, ink: Ink) -> Vec<Line<'static>> {
    let status = record.progress.name();
    if record.fitted_s.is_nan() {
        let mut lines = vec![heading(&format!("Output error: {status}"))];
        lines.extend(reason(record, width, ink));
        return lines;
    }
    let age_s = (now_s - record.fitted_s).max(0.0);
    let mut lines = vec![heading(&format!(
        "Output error at {:.2} s ({age_s:.1} s old): {status}, {} manoeuvre(s), {} samples",
        record.fitted_s, record.manoeuvres, record.samples
    ))];
    lines.extend(reason(record, width, ink));
    lines.extend(oscillatory_modes(record).flat_map(|(name, pair)| oscillation(name, pair, Style::new(), ink)));
    lines.extend(real_roots(record).map(|(name, root)| real_root(name, root, Style::new(), ink)));
    lines
}

/// Why it is no further.
fn reason(record: &OutputErrorRecord, width: usize, ink: Ink) -> Vec<Line<'static>> {
    match record.reason.as_str() {
        "" => Vec::new(),
        reason => sentence(&format!("  {reason}"), ink.stale(), width, 2),
    }
}
