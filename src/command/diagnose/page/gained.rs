//! Improvement on hold-out runs, channel by channel, and the roots of both models.

use crate::command::diagnose::answer::{Answer, Flights};
use crate::command::diagnose::page::parts::{curve, plot};
use crate::command::diagnose::roots::modes;
use crate::command::diagnose::verdict::judged;
use sideslip::flight::file::effect_file::DeclaredEffect;
use sideslip::io::outputs::charts::chart::{ChartError, Figure, Mark, Marks, Panel};
use sideslip::io::outputs::number::decimals;
use sideslip::postflight::validation::improvement::{Improvement, ImprovementVerdict, IntervalEstimate};
use std::fmt::Write;

pub(super) fn section(page: &mut String, answer: &Answer, flights: &Flights<'_>) -> Result<(), ChartError> {
    page.push_str("<h2>Improvement on the hold-out runs</h2>\n");
    match &answer.diagnosis.gain {
        Some((gain, _)) => channels(page, answer, gain, flights.holdout.len()),
        None => page.push_str("<p>There is no hold-out run.</p>\n"),
    }
    page.push_str("<h2>Roots</h2>\n");
    roots(page, answer)
}

fn number(value: f64) -> String {
    let size = libm::fabs(value);
    if !value.is_finite() {
        "-".to_owned()
    } else if size >= 1e4 {
        format!("{value:.1e}")
    } else {
        let digits = decimals(size.max(1e-6), 3, 6);
        format!("{value:.digits$}")
    }
}

fn with_interval(one: &IntervalEstimate) -> String {
    let [low, high] = one.interval;
    format!("{} <span class=\"interval\">[{}, {}]</span>", number(one.value), number(low), number(high))
}

/// The same within a sentence.
fn in_line(one: &IntervalEstimate) -> String {
    let [low, high] = one.interval;
    format!("{} [{}, {}]", number(one.value), number(low), number(high))
}

fn channels(page: &mut String, answer: &Answer, gain: &Improvement, runs: usize) {
    let _ = writeln!(
        page,
        "<p class=\"faint\">Free runs of {runs} hold-out run(s); in brackets 95 % of the moving-block bootstrap. Theil's coefficient: 0 perfect \
         to 1; VAF: variance accounted for, 1 perfect, negative where the mean predicts better.</p>\n<div class=\"wide\">\
         <table class=\"gain\" aria-label=\"gain\"><tr><th class=\"words\">channel</th><th class=\"words\">unit</th><th>noise</th><th>rms before</th>\
         <th>rms after</th><th>Theil before</th><th>after</th><th>VAF before</th><th>after</th><th>rms ratio</th></tr>"
    );
    let class = |ratio: &IntervalEstimate| match ratio.verdict() {
        ImprovementVerdict::Gain => " class=\"better\"",
        ImprovementVerdict::NoGain => "",
        ImprovementVerdict::Loss => " class=\"worse\"",
    };
    for one in &gain.channels {
        let _ = write!(
            page,
            "<tr><td class=\"words\">{}</td><td class=\"words\">{}</td><td>{}</td>",
            one.channel.name(answer.controls),
            one.channel.si_unit(),
            number(one.noise_std)
        );
        for estimate in one.rms.iter().chain(&one.theil).chain(&one.vaf) {
            let _ = write!(page, "<td>{}</td>", with_interval(estimate));
        }
        let _ = writeln!(page, "<td{}>{}</td></tr>", class(&one.ratio), with_interval(&one.ratio));
    }
    page.push_str("</table></div>\n<ul>\n");
    for (name, pooled) in
        [("All but airspeed and altitude", &gain.pooled), ("Airspeed", &gain.airspeed), ("Altitude", &gain.altitude)]
    {
        if let Some(pooled) = pooled {
            let [before, after] = &pooled.rms;
            let _ = writeln!(
                page,
                "<li>{name}: error over noise {} before, {} after; ratio {}: {}.</li>",
                in_line(before),
                in_line(after),
                in_line(&pooled.ratio),
                judged(pooled)
            );
        }
    }
    page.push_str("</ul>\n");
}

/// A root with the name of its mode.
type Root = (String, (f64, f64));

fn named(answer: &Answer, extension: &[DeclaredEffect]) -> Vec<Root> {
    let Some(modes) = modes(answer, extension) else { return Vec::new() };
    let mut roots: Vec<Root> = Vec::new();
    let own = |name: &str, re: f64, im: f64| (name.to_owned(), (re, im));
    roots.extend(modes.dutch_roll.map(|root| own("Dutch roll", root.re, root.im)));
    roots.extend(modes.roll.map(|root| own("roll", root, 0.0)));
    roots.extend(modes.spiral.map(|root| own("spiral", root, 0.0)));
    for root in &modes.others {
        let name = modes.name_of(root).replace('_', " ");
        roots.push(own(if name.is_empty() { "no name" } else { &name }, root.re, root.im));
    }
    roots
}

fn roots(page: &mut String, answer: &Answer) -> Result<(), ChartError> {
    let before = named(answer, &[]);
    if before.is_empty() {
        page.push_str("<p>The roots of this model cannot be computed.</p>\n");
        return Ok(());
    }
    let mut after = if answer.extension.is_empty() { Vec::new() } else { named(answer, &answer.extension) };
    let extended = !after.is_empty();
    let marks = |name: &str, roots: &[Root]| Marks {
        name: name.to_owned(),
        marks: roots.iter().map(|(_, point)| Mark { point: *point, either_way: 0.0 }).collect(),
    };
    let mut sets = vec![marks("model as given", &before)];
    if extended {
        sets.push(marks("model extended", &after));
    }
    let top = before.iter().chain(&after).map(|(_, (_, im))| *im).fold(0.5, f64::max);
    let panel = Panel {
        title: "Roots, upper half of the s-plane".to_owned(),
        x: "real part, 1/s".to_owned(),
        y: "imaginary part, rad/s".to_owned(),
        curves: vec![curve("limit of stability", vec![(0.0, 0.0), (0.0, 1.1 * top)])],
    };
    page.push_str("<div class=\"side\">\n");
    plot(page, &panel, &sets, &Figure { size: (560, 360), ..Figure::OF_A_PAGE })?;
    page.push_str("<div class=\"wide\"><table class=\"roots\" aria-label=\"roots\"><tr><th class=\"words\">mode</th><th>model as given, 1/s</th>");
    page.push_str(if extended { "<th>model extended, 1/s</th></tr>\n" } else { "</tr>\n" });
    let complex = |(re, im): (f64, f64)| if im > 0.0 { format!("{re:+.4} \u{b1} {im:.4} i") } else { format!("{re:+.4}") };
    for (name, root) in &before {
        let _ = write!(page, "<tr><td class=\"words\">{name}</td><td>{}</td>", complex(*root));
        if extended {
            let same = after.iter().position(|(other, _)| other == name);
            let found = same.map(|place| after.remove(place).1);
            let _ = write!(page, "<td>{}</td>", found.map_or("-".to_owned(), complex));
        }
        page.push_str("</tr>\n");
    }
    for (name, root) in &after {
        let _ = writeln!(page, "<tr><td class=\"words\">{name}</td><td>-</td><td>{}</td></tr>", complex(*root));
    }
    page.push_str("</table></div>\n</div>\n");
    Ok(())
}
