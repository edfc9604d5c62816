//! Output error for a person: status and age, modes, derivatives; plain text that stands below the regression's.

use super::status_text::{DerivativeLabel, derivative_unit};
use crate::flight::channel::ControlNames;
use crate::io::outputs::number::measured;
use crate::io::outputs::tables::terminal::Style;
use crate::postflight::output_error::record::OutputErrorRecord;
use crate::realtime::modes::record::{OscillatoryMode, RealRoot};
use std::fmt;

/// The table.
#[derive(Clone, Copy, Debug)]
pub struct OutputErrorTable<'a> {
    /// What is shown.
    pub record: &'a OutputErrorRecord,
    /// Time of the newest sample, s.
    pub now_s: f64,
    /// How the controls are called.
    pub controls: ControlNames,
    /// Whether it is coloured.
    pub style: Style,
}

/// The oscillatory modes that have numbers, by name.
pub fn oscillatory_modes(record: &OutputErrorRecord) -> impl Iterator<Item = (&'static str, &OscillatoryMode)> {
    let modes = [
        ("Dutch roll", &record.dutch_roll),
        ("lateral phugoid", &record.lateral_phugoid),
        ("Dutch roll whole", &record.coupled),
        ("short period", &record.short_period),
    ];
    modes.into_iter().filter_map(|(name, mode)| Some((name, mode.as_ref()?)))
}

/// The real roots that have numbers, by name.
pub fn real_roots(record: &OutputErrorRecord) -> impl Iterator<Item = (&'static str, &RealRoot)> {
    [("roll", &record.roll), ("spiral", &record.spiral)].into_iter().filter_map(|(name, root)| Some((name, root.as_ref()?)))
}

impl fmt::Display for OutputErrorTable<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let OutputErrorTable { record, now_s, controls, style } = *self;
        let status = record.progress.name();
        if record.fitted_s.is_nan() {
            writeln!(f, "{}", style.bold(format_args!("Output error: {status}")))?;
        } else {
            let heading = format!("Output error at {:.2} s: {status}", record.fitted_s);
            writeln!(f, "{}", style.bold(heading))?;
            let age_s = (now_s - record.fitted_s).max(0.0);
            let dropped = match record.dropped {
                0 => String::new(),
                count => format!(", {count} older ones dropped"),
            };
            let plural = if record.manoeuvres == 1 { "" } else { "s" };
            writeln!(f, "  {age_s:.1} s old; {} manoeuvre{plural}{dropped}, {} samples", record.manoeuvres, record.samples)?;
        }
        if !record.reason.is_empty() {
            writeln!(f, "  {}", record.reason)?;
        }
        for (name, OscillatoryMode { omega, zeta, std_omega, std_zeta, .. }) in oscillatory_modes(record) {
            let ((omega, std_omega), (zeta, std_zeta)) = (measured(*omega, *std_omega), measured(*zeta, *std_zeta));
            writeln!(f, "  {name:<16} omega {omega} +- {std_omega} rad/s, zeta {zeta} +- {std_zeta}")?;
        }
        for (name, root) in real_roots(record) {
            let (value, std) = measured(root.value, root.std);
            writeln!(f, "  {name:<16} root {value} +- {std} 1/s")?;
        }
        for one in &record.parameters {
            let name = DerivativeLabel { axis: one.axis, variable: Some(one.variable), controls }.to_string();
            let (value, std) = measured(one.value, one.std);
            writeln!(f, "     {name:<14} {value:>12} +- {std:<10}  {}", derivative_unit(one.axis, Some(one.variable)))?;
        }
        Ok(())
    }
}
