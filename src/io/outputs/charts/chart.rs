//! Charts as SVG: curves and points with error bars over a common axis, panels below each other.
//!
//! Consumes numbers with names and units; produces a self-contained SVG without fonts, scripts or network access, or a [`figure`]
//! for a page, whose style sheet sets font and colours. Values that are not finite are left out of a curve. The colours differ in
//! lightness too (after Okabe and Ito), for readers and printers that do not distinguish hues.

use crate::io::outputs::html::page::{escaped, words};
use plotters::prelude::*;
use std::fmt::Write;

/// Distinguishable also without colour vision: Okabe and Ito, Color Universal Design (2008).
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(0, 0, 0),
];

const PANEL: (u32, u32) = (900, 330);

/// Width of a legend beside a panel, pixels.
const LEGEND: u32 = 230;

/// A curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Its name in the legend.
    pub name: String,
    /// Its points.
    pub points: Vec<(f64, f64)>,
}

/// Curves over one pair of axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// Above it.
    pub title: String,
    /// What is along x, with its unit.
    pub x: String,
    /// What is along y, with its unit.
    pub y: String,
    /// The curves.
    pub curves: Vec<Curve>,
}

/// A point with its error bar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// Where it stands, and its value.
    pub point: (f64, f64),
    /// Half the length of its bar; what is not finite or not more than zero draws none.
    pub either_way: f64,
}

/// Points with error bars, in the colour of the curve of the same name where there is one.
#[derive(Clone, Debug, PartialEq)]
pub struct Marks {
    /// Their name in the legend.
    pub name: String,
    /// The points.
    pub marks: Vec<Mark>,
}

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
#[error("the picture cannot be drawn: {0}")]
pub struct ChartError(String);

/// The panels, one below the other.
///
/// # Errors
/// [`ChartError`] where a panel holds no finite point.
pub fn svg(panels: &[Panel]) -> Result<String, ChartError> {
    let bare: Vec<(Panel, Vec<Marks>)> = panels.iter().map(|panel| (panel.clone(), Vec::new())).collect();
    stacked(&bare, 0)
}

/// The panels with points on them, one below the other; the legend stands beside each.
///
/// # Errors
/// [`ChartError`] where a panel holds no finite point.
pub fn svg_with_marks(panels: &[(Panel, Vec<Marks>)]) -> Result<String, ChartError> {
    stacked(panels, LEGEND)
}

/// The panels with so much room for a legend beside them; without any it stands inside.
fn stacked(panels: &[(Panel, Vec<Marks>)], legend: u32) -> Result<String, ChartError> {
    let mut text = String::new();
    {
        let height = PANEL.1 * u32::try_from(panels.len().max(1)).unwrap_or(1);
        let area = SVGBackend::with_string(&mut text, (PANEL.0 + legend, height)).into_drawing_area();
        area.fill(&WHITE).map_err(|error| ChartError(error.to_string()))?;
        for (part, panel) in area.split_evenly((panels.len().max(1), 1)).iter().zip(panels) {
            let (panel, marks) = panel;
            let layout = PanelLayout { fine: 1, caption: true, legend, inside: legend == 0, powers: false, reach: [f64::NAN; 2] };
            let entries = draw(part, panel, marks, layout)?;
            if legend > 0 {
                beside(part, &entries)?;
            }
        }
        area.present().map_err(|error| ChartError(error.to_string()))?;
    }
    Ok(text)
}

/// How a figure for a page is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    /// Its size, pixels.
    pub size: (u32, u32),
    /// Whether y is a logarithm to the base of ten, its ticks to be written as what they stand for.
    pub powers: bool,
    /// Values that the y axis reaches in any case; none where it is not finite.
    pub reach: [f64; 2],
}

impl Figure {
    /// Two stand beside each other.
    pub const OF_A_PAGE: Figure = Figure { size: (560, 260), powers: false, reach: [f64::NAN; 2] };
}

/// More points are drawn smaller.
const MANY: usize = 60;

/// Dots to a pixel of a figure: coordinates are whole numbers.
const FINE: u32 = 4;

/// A panel as a figure of a page: its title and legend as text above a picture without ground, in the page's font and colours.
///
/// # Errors
/// [`ChartError`] where the panel holds no finite point.
pub fn figure(panel: &Panel, marks: &[Marks], figure: &Figure) -> Result<String, ChartError> {
    let (width, height) = figure.size;
    let mut drawn = String::new();
    let layout = PanelLayout { fine: FINE, caption: false, legend: 0, inside: false, powers: figure.powers, reach: figure.reach };
    let entries = {
        let area = SVGBackend::with_string(&mut drawn, (FINE * width, FINE * height)).into_drawing_area();
        let entries = draw(&area, panel, marks, layout)?;
        area.present().map_err(|error| ChartError(error.to_string()))?;
        entries
    };
    // Within a page the picture needs no name of its language, and its size is the page's to give.
    let body = drawn.split_once('>').map_or("", |(_, body)| body);
    let mut text = format!("<figure style=\"max-width:{width}px\"><figcaption><b>{}</b>", escaped(&panel.title));
    for (name, colour, is_point) in &entries {
        let place = COLOURS.iter().position(|one| one == colour).unwrap_or(0);
        let kind = if *is_point { "dot" } else { "line" };
        let _ = write!(text, " <span class=\"key {kind} c{place}\">{}</span>", words(name));
    }
    let (view_x, view_y) = (FINE * width, FINE * height);
    let title = if panel.y.starts_with(&panel.title) { String::new() } else { format!("{}: ", panel.title) };
    let label = escaped(&format!("{title}{} over {}", panel.y, panel.x));
    let _ =
        write!(text, "</figcaption><svg viewBox=\"0 0 {view_x} {view_y}\" role=\"img\" aria-label=\"{label}\">{body}</figure>");
    Ok(text)
}

#[derive(Clone, Copy)]
struct PanelLayout {
    fine: u32,
    caption: bool,
    legend: u32,
    inside: bool,
    powers: bool,
    reach: [f64; 2],
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

fn finite(point: &&(f64, f64)) -> bool {
    point.0.is_finite() && point.1.is_finite()
}

/// The ends of a mark's bar, or its point twice.
fn ends(mark: &Mark) -> [(f64, f64); 2] {
    let (x, y) = mark.point;
    let half = if mark.either_way.is_finite() { mark.either_way.max(0.0) } else { 0.0 };
    [(x, y - half), (x, y + half)]
}

fn range(numbers: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let (low, high) = numbers.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    (low <= high).then_some((low, high))
}

/// An entry of the legend: its name and colour, and whether it is a point.
type Entry<'p> = (&'p str, RGBColor, bool);

/// The legend, from the top of its column down.
fn beside(area: &Area<'_>, entries: &[Entry<'_>]) -> Result<(), ChartError> {
    let (width, _) = area.dim_in_pixel();
    let x = i32::try_from(width.saturating_sub(LEGEND)).unwrap_or(0) + 14;
    let wrong = |error: &dyn std::fmt::Display| ChartError(error.to_string());
    for ((name, colour, is_point), y) in entries.iter().zip((50..).step_by(20)) {
        let sign = if *is_point {
            area.draw(&Circle::new((x + 9, y), 3, colour.filled()))
        } else {
            area.draw(&PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(2)))
        };
        sign.map_err(|error| wrong(&error))?;
        area.draw(&Text::new(*name, (x + 26, y - 5), ("sans-serif", 12))).map_err(|error| wrong(&error))?;
    }
    Ok(())
}

/// Draws a panel and gives the entries of its legend; where no room is left for those, it has the legend inside.
fn draw<'p>(area: &Area<'_>, panel: &'p Panel, marks: &'p [Marks], layout: PanelLayout) -> Result<Vec<Entry<'p>>, ChartError> {
    let wrong = |error: &dyn std::fmt::Display| ChartError(format!("{}: {error}", panel.title));
    let bars: Vec<(f64, f64)> = marks.iter().flat_map(|marks| &marks.marks).flat_map(ends).collect();
    let points = || panel.curves.iter().flat_map(|curve| &curve.points).chain(&bars).filter(finite);
    let (Some((left, right)), Some((bottom, top))) = (range(points().map(|point| point.0)), range(points().map(|point| point.1)))
    else {
        return Err(wrong(&"expected a finite point, found none"));
    };
    let [low, high] = layout.reach;
    let (bottom, top) = (bottom.min(low), top.max(high));
    let margin = if top > bottom { 0.05 * (top - bottom) } else { 0.5 };
    let right = if right > left { right } else { left + 1.0 };
    // A point on the very edge would stand on the axis.
    let aside = if marks.is_empty() { 0.0 } else { 0.02 * (right - left) };
    let fine = layout.fine;
    let mut builder = ChartBuilder::on(area);
    if layout.caption {
        builder.caption(&panel.title, ("sans-serif", 18 * fine));
    }
    let mut chart = builder
        .margin(if layout.caption { 12 } else { 4 } * fine)
        .margin_top(if layout.caption { 12 } else { 9 } * fine)
        .margin_right(12 * fine + layout.legend)
        .x_label_area_size(42 * fine)
        .y_label_area_size(74 * fine)
        .build_cartesian_2d(left - aside..right + aside, bottom - margin..top + margin)
        .map_err(|error| wrong(&error))?;
    let mut mesh = chart.configure_mesh();
    mesh.x_desc(&panel.x).y_desc(&panel.y);
    let (plain_x, plain_y) = (|x: &f64| plain(*x), |y: &f64| plain(*y));
    let power = |y: &f64| format!("{:.0e}", libm::pow(10.0, *y));
    if layout.caption {
        mesh.light_line_style(WHITE);
    } else {
        let font = ("sans-serif", 15 * fine);
        mesh.light_line_style(TRANSPARENT).label_style(font).axis_desc_style(font).x_labels(8).y_labels(5);
        mesh.x_label_formatter(&plain_x).y_label_formatter(&plain_y);
        mesh.axis_style(BLACK.stroke_width(fine)).set_all_tick_mark_size(4 * fine as i32);
    }
    if layout.powers {
        mesh.y_label_formatter(&power);
    }
    mesh.draw().map_err(|error| wrong(&error))?;
    let mut colours = COLOURS.iter().cycle();
    let mut drawn_as: Vec<Entry<'p>> = Vec::new();
    for (curve, colour) in panel.curves.iter().zip(&mut colours) {
        drawn_as.push((&curve.name, *colour, false));
        let style = colour.stroke_width(if layout.caption { 2 } else { 3 * fine / 2 });
        let line = LineSeries::new(curve.points.iter().filter(finite).copied(), style);
        let drawn = chart.draw_series(line).map_err(|error| wrong(&error))?;
        drawn.label(&curve.name).legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], style));
    }
    let sets = marks.len();
    for (set, Marks { name, marks }) in marks.iter().enumerate() {
        let of_curve = drawn_as.iter().find(|(curve, ..)| curve == name).map(|&(_, colour, _)| colour);
        let colour = of_curve.or_else(|| colours.next().copied()).unwrap_or(BLACK);
        let there = || marks.iter().filter(|mark| finite(&&mark.point));
        let barred = there().filter(|mark| mark.either_way > 0.0);
        let bars = barred.map(|mark| PathElement::new(ends(mark), colour.stroke_width(fine)));
        chart.draw_series(bars).map_err(|error| wrong(&error))?;
        // In a figure what comes later does not hide what is there.
        let under = if layout.caption { 0 } else { 2 * u32::try_from(sets - 1 - set).unwrap_or(0) };
        let radius = if marks.len() > MANY { 3 * fine / 2 } else { (3 + under) * fine };
        let dots = there().map(|mark| Circle::new(mark.point, radius, colour.filled()));
        chart.draw_series(dots).map_err(|error| wrong(&error))?;
        if of_curve.is_none() {
            drawn_as.push((name, colour, true));
        }
    }
    if layout.inside {
        let inside = chart.configure_series_labels().background_style(WHITE.mix(0.8)).border_style(BLACK).draw();
        inside.map_err(|error| wrong(&error))?;
    }
    Ok(drawn_as)
}

/// A tick's number, four digits at most and nothing twice: `0`, `-0.15`.
fn plain(tick: f64) -> String {
    let rounded: f64 = format!("{tick:.3e}").parse().unwrap_or(tick);
    if libm::fabs(rounded) < 1e-12 { "0".to_owned() } else { rounded.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_names_its_axes_and_curves_and_leaves_out_what_is_no_number() {
        let curve = |name: &str, points: &[(f64, f64)]| Curve { name: name.into(), points: points.to_vec() };
        let panel = Panel {
            title: "Response".into(),
            x: "time, s".into(),
            y: "r, rad/s".into(),
            curves: vec![
                curve("measured", &[(0.0, 1.0), (1.0, f64::NAN), (2.0, 3.0)]),
                curve("a < b", &[(0.0, 2.0), (2.0, 2.0)]),
            ],
        };
        let text = svg(&[panel.clone(), panel.clone()]).unwrap();
        for word in ["Response", "time, s", "r, rad/s", "measured", "a &lt; b"] {
            assert_eq!(text.matches(word).count(), 2, "{word}");
        }
        assert!(text.starts_with("<svg") && text.trim_end().ends_with("</svg>") && !text.contains("NaN"));
        let empty = Panel { curves: vec![curve("none", &[(f64::NAN, 1.0)])], ..panel };
        assert!(svg(&[empty]).unwrap_err().to_string().contains("expected a finite point"));
    }

    #[test]
    fn a_figure_leaves_its_font_and_ground_to_the_page_and_marks_that_come_later_hide_nothing() {
        let curve = Curve { name: "a < b".into(), points: vec![(0.0, -2.0), (4.0, -1.0)] };
        let panel = Panel { title: "T & U".into(), x: "x, s".into(), y: "y, 1".into(), curves: vec![curve] };
        let mark = Mark { point: (1.0, -1.5), either_way: 0.0 };
        let marks = ["first", "second"].map(|name| Marks { name: name.into(), marks: vec![mark] });
        let layout = Figure { powers: true, reach: [-2.0, 0.0], ..Figure::OF_A_PAGE };
        let text = figure(&panel, &marks, &layout).unwrap();
        assert!(!text.contains("http") && !text.contains("#FFFFFF") && text.contains("T &amp; U") && text.contains("a &lt; b"));
        // Powers of ten on the ticks, up to what the axis is to reach.
        assert!(["1e-2", "1e0"].iter().all(|tick| text.contains(tick)), "{text}");
        let radii: Vec<u32> = text.split(" r=\"").skip(1).map(|rest| rest.split('"').next().unwrap().parse().unwrap()).collect();
        assert_eq!(radii, [5 * FINE, 3 * FINE]);
        assert_eq!([-0.15000000000000002, -0.0, 1e-17, 2.0, 1500.0].map(plain), ["-0.15", "0", "0", "2", "1500"]);
        assert!(figure(&Panel { curves: Vec::new(), ..panel }, &[], &layout).is_err());
    }

    #[test]
    fn marks_stand_within_the_axes_with_their_bars_and_share_the_colour_of_their_curve() {
        let line = Curve { name: "known".into(), points: vec![(0.0, 0.0), (1.0, 1.0)] };
        let mark = |x: f64, y: f64, either_way: f64| Mark { point: (x, y), either_way };
        let marks = |name: &str, marks: Vec<Mark>| Marks { name: name.into(), marks };
        let panel = Panel { title: "T".into(), x: "x".into(), y: "y".into(), curves: vec![line] };
        let known = marks("known", vec![mark(0.5, 0.5, 0.1), mark(0.6, f64::NAN, 0.1)]);
        let found = marks("found", vec![mark(0.5, 50.0, 100.0), mark(1.0, 0.0, f64::NAN)]);
        let text = svg_with_marks(&[(panel.clone(), vec![known, found])]).unwrap();
        // Two marks of the second set, one of the first, and the legend's.
        assert_eq!(text.matches("<circle").count(), 4);
        assert_eq!(text.matches("known").count(), 1, "one entry in the legend for curve and marks");
        assert_eq!(text.matches("found").count(), 1);
        assert!(text.contains("150.0"), "the axis reaches the end of the bar: {text}");
        assert!(!text.contains("NaN"));
        let empty = Panel { curves: Vec::new(), ..panel };
        assert!(svg_with_marks(&[(empty.clone(), vec![marks("one", vec![mark(0.0, 1.0, 0.0)])])]).is_ok());
        assert!(svg_with_marks(&[(empty, Vec::new())]).is_err());
    }
}
