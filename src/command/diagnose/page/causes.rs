//! Each cause's evidence: the residual over its regressor, and how it ranks among its rivals.

use super::answer::said;
use crate::command::diagnose::answer::Answer;
use crate::command::diagnose::page::parts::{axis_unit, curve, plot, variable_unit};
use sideslip::io::outputs::charts::chart::{ChartError, Figure, Mark, Marks, Panel};
use sideslip::postflight::diagnosis::evidence::regressor_plot::{MEAN_S, Ordinate, Regressor, RegressorPlot};
use sideslip::postflight::diagnosis::evidence::residual_coherence::Signal;
use sideslip::postflight::diagnosis::record::RankedCause;
use std::fmt::Write;

const RIVALS: usize = 8;
const BINS: usize = 12;
/// Fewest points of a bin that has a mean.
const FEWEST: usize = 4;

pub(super) fn section(page: &mut String, answer: &Answer) -> Result<(), ChartError> {
    let diagnosis = &answer.diagnosis;
    for (place, finding) in diagnosis.findings.iter().enumerate() {
        let _ = writeln!(page, "<h2>Evidence for cause {}</h2>\n<p>{}</p>", place + 1, said(answer, &finding.cause));
        if let Some(plot_data) = &finding.regressor_plot {
            scatter(page, answer, plot_data)?;
        }
        ranking(page, answer, &finding.ranking);
    }
    if diagnosis.findings.is_empty() {
        page.push_str("<h2>Closest hypotheses</h2>\n");
        ranking(page, answer, &diagnosis.none.1);
    }
    Ok(())
}

fn ranking(page: &mut String, answer: &Answer, ranking: &[RankedCause]) {
    let most = ranking.iter().map(|one| libm::fabs(one.odds)).fold(1e-9, f64::max);
    page.push_str(
        "<h3>Ranking</h3>\n<p class=\"faint\">Bars: logarithm of the posterior odds against no cause, with a penalty for free \
         numbers and for the count of hypotheses; negative means less probable than no cause.</p>\n<div class=\"wide\"><table \
         class=\"ranking\" aria-label=\"ranking\"><tr><th class=\"words\">hypothesis, as fitted</th><th class=\"words\">log odds</th><th>probability\
         </th></tr>\n",
    );
    for one in ranking.iter().take(RIVALS) {
        let width = 11.0 * libm::fabs(one.odds) / most;
        let less = if one.odds < 0.0 { " less" } else { "" };
        let _ = writeln!(
            page,
            "<tr><td class=\"words\">{}</td><td class=\"odds\"><span class=\"bar{less}\" style=\"width:{width:.2}em\"></span> \
             {:.0}</td><td>{:.3}</td></tr>",
            said(answer, one),
            0.5 * one.odds,
            one.probability
        );
    }
    page.push_str("</table></div>\n");
}

fn scatter(page: &mut String, answer: &Answer, plot_data: &RegressorPlot) -> Result<(), ChartError> {
    let names = answer.controls;
    let (y, unit) = match plot_data.ordinate {
        Ordinate::Axis(axis) => (format!("residual {}", axis.name()), axis_unit(axis)),
        Ordinate::Channel(channel) => (format!("{}, measured less expected", channel.name(names)), channel.si_unit()),
    };
    let x = match plot_data.regressor {
        Regressor::Signal(Signal::Of(variable)) => {
            format!("{}, deviation from trim, {}", variable.name(names), variable_unit(variable))
        }
        Regressor::Signal(Signal::Read(channel)) => {
            format!("{}, deviation from trim, {}", channel.name(names), channel.si_unit())
        }
        Regressor::Term(term) => format!("{term}, SI units"),
        Regressor::True => format!("true value, {unit}"),
        Regressor::Added => format!("contribution of the cause, {unit}"),
        Regressor::Time => "time, s".to_owned(),
    };
    let (low, high) = range(&plot_data.before);
    let (at_zero, slope) = plot_data.line;
    let line = vec![(low, at_zero + slope * low), (high, at_zero + slope * high)];
    let _ = writeln!(
        page,
        "<h3>Residual against its regressor</h3>\n<p class=\"faint\">Means over {MEAN_S} s of all fitted runs; large dots are \
         means of bins along x, with \u{b1} 2 standard errors. If the cause is right, the left plot lies on the line \
         and the right one on zero.</p>\n<div class=\"side\">"
    );
    for (title, points, name, line) in [
        ("Without the cause", &plot_data.before, "the cause's line", line),
        ("With the cause", &plot_data.after, "zero", vec![(low, 0.0), (high, 0.0)]),
    ] {
        let panel = Panel { title: title.to_owned(), x: x.clone(), y: format!("{y}, {unit}"), curves: vec![curve(name, line)] };
        let dot = |&point: &(f64, f64)| Mark { point, either_way: 0.0 };
        let dots = Marks { name: "residual".to_owned(), marks: points.iter().map(dot).collect() };
        let means = Marks { name: "means along x".to_owned(), marks: means(points) };
        plot(page, &panel, &[dots, means], &Figure { size: (560, 330), ..Figure::OF_A_PAGE })?;
    }
    page.push_str("</div>\n");
    Ok(())
}

/// Means of the points in bins of x, with two standard errors; bins of few points have none.
fn means(points: &[(f64, f64)]) -> Vec<Mark> {
    let (low, high) = range(points);
    let width = ((high - low) / BINS as f64).max(1e-300);
    let bin_of = |x: f64| (((x - low) / width) as usize).min(BINS - 1);
    let of = |bin: usize| {
        let own: Vec<&(f64, f64)> = points.iter().filter(|point| bin_of(point.0) == bin).collect();
        let count = own.len() as f64;
        let mean = |of: &dyn Fn(&(f64, f64)) -> f64| own.iter().map(|point| of(point)).sum::<f64>() / count;
        let (x, y) = (mean(&|point| point.0), mean(&|point| point.1));
        let variance = mean(&|point| (point.1 - y) * (point.1 - y)) / (count - 1.0);
        (own.len() >= FEWEST).then(|| Mark { point: (x, y), either_way: 2.0 * libm::sqrt(variance) })
    };
    (0..BINS).filter_map(of).collect()
}

/// Smallest and largest x.
fn range(points: &[(f64, f64)]) -> (f64, f64) {
    points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (x, _)| (low.min(*x), high.max(*x)))
}
