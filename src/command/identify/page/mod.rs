//! `report.html`: what was identified, in tables and pictures with units; no scripts, fonts or network.
//!
//! Consumes the result and its runs; produces the page in the look of `diagnose`'s: the answer first, then its evidence. Names
//! come from files and are made safe wherever they stand.

mod flights;
mod tables;
mod test_point_charts;
mod test_point_tables;

use super::frequency_domain::FrequencyDomainResult;
use super::table::{method, stability};
use super::test_point_result::TestPointResult;
use super::test_point_text::heading;
use sideslip::io::outputs::charts::chart::ChartError;
use sideslip::io::outputs::html::page::{FOOT, escaped, head, words};
use sideslip::io::outputs::number::{Fixed, measured_text};
use sideslip::io::outputs::words::control_scale::PER_COMMAND;
use sideslip::postflight::identification::identify::IdentificationResult;
use sideslip::postflight::identification::nondimensional::NondimensionalDerivatives;
use std::f64::consts::TAU;
use std::fmt::Write;

/// The page of one test point.
pub(super) fn of_model(
    identified: &IdentificationResult,
    nondimensional: Option<&NondimensionalDerivatives>,
    in_band: Option<&FrequencyDomainResult>,
) -> Result<String, ChartError> {
    let mut page = head("Identification");
    page.push_str("<h1>Identification</h1>\n");
    named_runs(&mut page, identified);
    answer(&mut page, identified);
    results(&mut page, identified, nondimensional, 2);
    flights::section(&mut page, identified)?;
    in_band.map_or(Ok(()), |in_band| in_band.section(&mut page))?;
    page.push_str(FOOT);
    Ok(page)
}

/// The page of several: against the flight path first, then each.
pub(super) fn of_test_points(points: &[TestPointResult], in_band: Option<&FrequencyDomainResult>) -> Result<String, ChartError> {
    let title = if points.len() > 1 { "Derivatives against flight path" } else { "Identification beside a simulation" };
    let mut page = head(title);
    let _ = writeln!(page, "<h1>{title}</h1>");
    test_point_tables::dutch_roll(&mut page, points);
    test_point_charts::section(&mut page, points)?;
    for point in points {
        let _ = writeln!(page, "<h2>{}</h2>", escaped(&heading(point)));
        named_runs(&mut page, &point.identified);
        answer(&mut page, &point.identified);
        test_point_tables::beside(&mut page, point);
        results(&mut page, &point.identified, point.nondimensional.as_ref(), 3);
        flights::section(&mut page, &point.identified)?;
    }
    in_band.map_or(Ok(()), |in_band| in_band.section(&mut page))?;
    page.push_str(FOOT);
    Ok(page)
}

fn named_runs(page: &mut String, identified: &IdentificationResult) {
    let names = |runs: &[sideslip::postflight::identification::run_prediction::RunPrediction]| match runs {
        [] => "none".to_owned(),
        runs => runs.iter().map(|flown| escaped(&flown.run)).collect::<Vec<_>>().join(", "),
    };
    let (choice, structure) = (&identified.linear.choice, &identified.linear.structure);
    let mut method = method(identified).to_owned();
    if let Some(first) = method.get_mut(..1) {
        first.make_ascii_uppercase();
    }
    let trim = &identified.linear.reference_trim;
    let _ = writeln!(
        page,
        "<p class=\"faint\">Fitted runs: {}. Hold-out runs: {}.<br>{method}: states {}; inputs {}; outputs {}. Trim: true airspeed \
         {} m/s, incidence {} deg, pitch {} deg, bank {} deg.</p>",
        names(&identified.fit),
        names(&identified.holdout),
        escaped(&choice.states.join(", ")),
        escaped(&choice.inputs.join(", ")),
        escaped(&structure.outputs.join(", ")),
        Fixed(trim.airspeed, 1),
        Fixed(trim.alpha.to_degrees(), 1),
        Fixed(trim.theta.to_degrees(), 1),
        Fixed(trim.phi.to_degrees(), 1),
    );
}

/// Whether the fit has ended, the oscillation that the runs are about, and what is doubtful.
fn answer(page: &mut String, identified: &IdentificationResult) {
    page.push_str("<section class=\"answer\" aria-label=\"Answer\">\n");
    if !identified.fitted.converged {
        let _ = writeln!(
            page,
            "<p class=\"cause\">NOT converged after {} iterations: these numbers are no estimates.</p>",
            identified.fitted.iterations
        );
    }
    match &identified.modes {
        Err(reason) => {
            let _ = writeln!(page, "<p class=\"cause\">No modes: {}.</p>", words(reason));
        }
        Ok(roots) => {
            let mut said = roots.iter().filter(|root| root.imag > 0.0 && root.name.is_some()).peekable();
            if said.peek().is_none() {
                page.push_str("<p class=\"cause\">No oscillation among the roots that has a name.</p>\n");
            }
            for root in said {
                let _ = writeln!(
                    page,
                    "<p class=\"cause\">{}: {} rad/s ({} Hz), damping ratio {}; {}.</p>",
                    tables::mode_name(root),
                    words(&measured_text(root.omega, root.std_omega)),
                    words(&measured_text(root.omega / TAU, root.std_omega / TAU)),
                    words(&measured_text(root.zeta, root.std_zeta)),
                    stability(root)
                );
            }
        }
    }
    tables::separability(page, identified);
    let assumed = &identified.linear.assumed_scale;
    let commands = (!assumed.is_empty()).then(|| format!("derivatives by {}: {PER_COMMAND}", assumed.join(", ")));
    if commands.is_some() || !identified.linear.notes.is_empty() {
        page.push_str("<ul>\n");
        for note in commands.iter().chain(&identified.linear.notes) {
            let _ = writeln!(page, "<li>{}</li>", words(note));
        }
        page.push_str("</ul>\n");
    }
    page.push_str("</section>\n");
}

fn results(page: &mut String, identified: &IdentificationResult, formed: Option<&NondimensionalDerivatives>, level: u8) {
    let _ = writeln!(page, "<h{level}>Modes</h{level}>\n{}{}", tables::modes(identified), tables::roots(identified));
    let _ = writeln!(page, "<h{level}>Derivatives</h{level}>\n{}", tables::derivatives(identified));
    tables::instruments(page, identified);
    tables::gusts(page, identified);
    tables::nondimensional(page, formed, level);
    let _ = writeln!(page, "<h{level}>Fit and prediction</h{level}>\n{}", tables::scores(identified));
}
