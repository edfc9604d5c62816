//! Charts as SVG text: curves over a common axis, panels below each other.
//!
//! Consumes numbers with names and units; produces one self-contained SVG, no fonts, no scripts, no network. What is not finite
//! is left out of a curve. The colours differ in lightness too, for eyes and printers that see no hue (after Okabe and Ito).

use plotters::prelude::*;

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

/// Size of a panel, pixels.
const PANEL: (u32, u32) = (900, 330);

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

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
#[error("the picture cannot be drawn: {0}")]
pub struct ChartError(String);

/// The panels, one below the other.
///
/// # Errors
/// [`ChartError`] where a panel holds no finite point.
pub fn svg(panels: &[Panel]) -> Result<String, ChartError> {
    let mut text = String::new();
    {
        let height = PANEL.1 * u32::try_from(panels.len().max(1)).unwrap_or(1);
        let area = SVGBackend::with_string(&mut text, (PANEL.0, height)).into_drawing_area();
        area.fill(&WHITE).map_err(|error| ChartError(error.to_string()))?;
        for (part, panel) in area.split_evenly((panels.len().max(1), 1)).iter().zip(panels) {
            draw(part, panel)?;
        }
        area.present().map_err(|error| ChartError(error.to_string()))?;
    }
    Ok(text)
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

fn draw(area: &Area<'_>, panel: &Panel) -> Result<(), ChartError> {
    let wrong = |error: &dyn std::fmt::Display| ChartError(format!("{}: {error}", panel.title));
    let finite = |point: &&(f64, f64)| point.0.is_finite() && point.1.is_finite();
    let points = || panel.curves.iter().flat_map(|curve| &curve.points).filter(finite);
    let range = |of: fn(&(f64, f64)) -> f64| {
        let (low, high) = points().map(of).fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        (low <= high).then_some((low, high))
    };
    let (Some((left, right)), Some((bottom, top))) = (range(|point| point.0), range(|point| point.1)) else {
        return Err(wrong(&"expected a finite point, found none"));
    };
    let margin = if top > bottom { 0.05 * (top - bottom) } else { 0.5 };
    let right = if right > left { right } else { left + 1.0 };
    let mut chart = ChartBuilder::on(area)
        .caption(&panel.title, ("sans-serif", 18))
        .margin(12)
        .x_label_area_size(42)
        .y_label_area_size(74)
        .build_cartesian_2d(left..right, bottom - margin..top + margin)
        .map_err(|error| wrong(&error))?;
    chart.configure_mesh().x_desc(&panel.x).y_desc(&panel.y).light_line_style(WHITE).draw().map_err(|error| wrong(&error))?;
    for (curve, colour) in panel.curves.iter().zip(COLOURS.iter().cycle()) {
        let style = colour.stroke_width(2);
        let line = LineSeries::new(curve.points.iter().filter(finite).copied(), style);
        let drawn = chart.draw_series(line).map_err(|error| wrong(&error))?;
        drawn.label(&curve.name).legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], style));
    }
    let legend = chart.configure_series_labels().background_style(WHITE.mix(0.8)).border_style(BLACK).draw();
    legend.map_err(|error| wrong(&error))
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
}
