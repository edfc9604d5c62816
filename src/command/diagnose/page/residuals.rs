//! Residuals of every axis: size, spectrum before and after against noise, and the signals that they correlate with.

use crate::command::diagnose::answer::Answer;
use crate::command::diagnose::page::parts::{axes_at_stake, axis_unit, curve, plot};
use sideslip::flight::derivative::Axis;
use sideslip::io::outputs::charts::chart::{ChartError, Curve, Figure, Panel};
use sideslip::io::outputs::html::page::escaped;
use sideslip::io::outputs::number::band_text;
use sideslip::postflight::diagnosis::evidence::residual_coherence::{AxisSpectrum, CHANCE, DominantSignal};
use std::fmt::Write;

/// Signals whose coherence is drawn.
const SIGNALS: usize = 4;

pub(super) fn section(page: &mut String, answer: &Answer) -> Result<(), ChartError> {
    page.push_str(
        "<h2>Residual forces and moments</h2>\n<p class=\"faint\">Measured force or moment less the model's at the measured \
         motion and controls; noise is that of the instruments.</p>\n",
    );
    table(page, answer);
    let at_stake = axes_at_stake(answer);
    let rest = Axis::ALL.into_iter().filter(|axis| !at_stake.contains(axis));
    page.push_str("<div class=\"side\">\n");
    for axis in at_stake.iter().copied().chain(rest) {
        let Some(own) = answer.diagnosis.spectra.iter().find(|own| own.axis == axis) else { continue };
        spectrum(page, own)?;
        if at_stake.contains(&axis) {
            coherence(page, answer, own, false)?;
            coherence(page, answer, own, true)?;
        }
    }
    page.push_str("</div>\n");
    Ok(())
}

fn table(page: &mut String, answer: &Answer) {
    page.push_str(
        "<div class=\"wide\"><table class=\"residuals\" aria-label=\"residuals\"><tr><th class=\"words\">axis</th><th>rms before</th><th>after</th><th>noise\
         </th><th class=\"words\">unit</th><th>explained</th><th>mostly in, Hz</th><th class=\"words\">correlates with, before</th>\
         <th class=\"words\">after</th></tr>\n",
    );
    for one in &answer.diagnosis.discrepancy {
        let own = answer.diagnosis.spectra.iter().find(|own| own.axis == one.axis);
        let with = |after: bool| {
            let said = |one: DominantSignal| {
                let (name, band) = (one.signal.name(answer.controls), band_text(one.band_hz));
                format!("{name} ({:.2}, {band} Hz)", one.coherence)
            };
            own.and_then(|own| own.dominant_signal(after)).map_or("nothing".to_owned(), said)
        };
        let explained = if one.rms > 0.2 * one.noise { format!("{:.0} %", 100.0 * one.explained) } else { "-".to_owned() };
        let _ = writeln!(
            page,
            "<tr><td class=\"words\">{}</td><td>{:.4}</td><td>{:.4}</td><td>{:.4}</td><td class=\"words\">{}</td><td>{explained}</td>\
             <td>{}</td><td class=\"words\">{}</td><td class=\"words\">{}</td></tr>",
            one.axis.name(),
            one.rms,
            one.rms_after,
            one.noise,
            axis_unit(one.axis),
            band_text(one.band_hz),
            escaped(&with(false)),
            escaped(&with(true)),
        );
    }
    page.push_str("</table></div>\n");
}

fn spectrum(page: &mut String, own: &AxisSpectrum) -> Result<(), ChartError> {
    let axis = own.axis.name();
    let line = |name: &str, density: &[f64]| {
        let points = own.hz.iter().zip(density).filter(|(_, density)| **density > 0.0);
        curve(name, points.map(|(hz, density)| (*hz, libm::log10(libm::sqrt(*density)))).collect())
    };
    let panel = Panel {
        title: format!("Spectrum of the residual {axis}"),
        x: "frequency, Hz".to_owned(),
        y: format!("{}/sqrt(Hz)", axis_unit(own.axis)),
        curves: vec![line("instrument noise", &own.noise), line("before", &own.before), line("after", &own.after)],
    };
    if panel.curves.iter().all(|curve| curve.points.is_empty()) {
        let _ = writeln!(page, "<p>No spectrum of {axis}: no run has its instrument long enough.</p>");
        return Ok(());
    }
    // Whole decades: noise is not to fill the picture.
    let points = || panel.curves.iter().flat_map(|curve| &curve.points).map(|point| point.1);
    let reach = [libm::floor(points().fold(f64::INFINITY, f64::min)), libm::ceil(points().fold(f64::NEG_INFINITY, f64::max))];
    plot(page, &panel, &[], &Figure { powers: true, reach, ..Figure::OF_A_PAGE })
}

/// The signals of largest coherence with the residual.
fn coherence(page: &mut String, answer: &Answer, own: &AxisSpectrum, after: bool) -> Result<(), ChartError> {
    let (first, last) = (own.hz.first().copied().unwrap_or(0.0), own.hz.last().copied().unwrap_or(1.0));
    let mut signals: Vec<(f64, Curve)> = own
        .signals
        .iter()
        .map(|one| {
            let (values, power) = if after { (&one.after, &own.after) } else { (&one.before, &own.before) };
            // By the share of the residual's power that is coherent with it.
            let carried = values.iter().zip(power).map(|(value, power)| value * power).sum();
            (carried, curve(one.signal.name(answer.controls), own.hz.iter().copied().zip(values.iter().copied()).collect()))
        })
        .collect();
    signals.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut curves: Vec<Curve> = signals.into_iter().take(SIGNALS).map(|(_, curve)| curve).collect();
    let chance = format!("chance, once in {:.0}", 1.0 / CHANCE);
    curves.push(curve(chance, vec![(first, own.level), (last, own.level)]));
    let when = if after { "after" } else { "before" };
    let panel = Panel {
        title: format!("Coherence of the residual {} {when}", own.axis.name()),
        x: "frequency, Hz".to_owned(),
        y: "coherence, 1".to_owned(),
        curves,
    };
    plot(page, &panel, &[], &Figure { reach: [0.0, 1.0], ..Figure::OF_A_PAGE })
}
