//! Energy spectrum of an input that is made of straight lines, exactly.
//!
//! Consumes the deviation u(t) as a [`History`] and frequencies (rad/s); produces |U|^2, U = Integral u exp(-j omega t) dt. With
//! the change of slope d_k at the bend t_k, u'' is a row of impulses and
//!     U(omega) = -1/omega^2 Sum_k d_k exp(-j omega t_k),   omega > 0                        (1)
//! whatever the hand's rate. A multistep of clock T has no energy where every pulse is a whole number of periods,
//! omega = 2 pi n / T, if its edges are sharp: the node in Fig 3 of Padfield et al. 1987.
//! For an input that does not return (a step) (1) is the spectrum of its transient.

use crate::flight::signal::piecewise_linear::History;

/// |U(omega)|^2 of the deviation, (unit s)^2; (1). Zero or less gives the square of the area under it.
pub fn energy(deviation: &History, omega: f64) -> f64 {
    let points = deviation.points();
    if !(omega > 0.0) {
        let area: f64 = points.windows(2).map(mean_times_width).sum();
        return area * area;
    }
    let slope = |place: usize| match (points.get(place), points.get(place + 1)) {
        (Some((t0, x0)), Some((t1, x1))) => (x1 - x0) / (t1 - t0),
        _ => 0.0,
    };
    let (mut re, mut im, mut before) = (0.0, 0.0, 0.0);
    for (place, (time_s, _)) in points.iter().enumerate() {
        let after = slope(place);
        let (sin, cos) = libm::sincos(omega * time_s);
        re += (after - before) * cos;
        im -= (after - before) * sin;
        before = after;
    }
    (re * re + im * im) / (omega * omega * omega * omega)
}

fn mean_times_width(pair: &[(f64, f64)]) -> f64 {
    match pair {
        [(t0, x0), (t1, x1)] => 0.5 * (x0 + x1) * (t1 - t0),
        _ => 0.0,
    }
}

/// What stands out in a spectrum.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// Where the energy is largest, rad/s.
    pub peak: f64,
    /// The band that holds all energy above half of the largest, rad/s.
    pub half_power: [f64; 2],
    /// Frequencies with next to no energy between others that have some (a thousandth of the largest at most), rad/s.
    pub nodes: Vec<f64>,
}

/// Outline of a spectrum that was computed at these frequencies, increasing; `None` of one without energy.
pub fn outline(omegas: &[f64], energies: &[f64]) -> Option<Outline> {
    let (peak, largest) = omegas.iter().zip(energies).max_by(|one, other| one.1.total_cmp(other.1)).filter(|(_, e)| **e > 0.0)?;
    let above = || omegas.iter().zip(energies).filter(|(_, energy)| **energy >= 0.5 * largest).map(|(omega, _)| *omega);
    let mut nodes = Vec::new();
    for (three, at) in energies.windows(3).zip(omegas.iter().skip(1)) {
        if let [before, here, after] = three
            && here <= before
            && here < after
            && *here < 1e-3 * largest
        {
            nodes.push(*at);
        }
    }
    Some(Outline { peak: *peak, half_power: [above().next()?, above().next_back()?], nodes })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::input::InputSpec;
    use std::f64::consts::TAU;

    fn omegas() -> Vec<f64> {
        (1..=1200).map(|k| 0.01 * f64::from(k)).collect()
    }

    /// Pulses with sharp edges: (exp(-j w a) - exp(-j w b))/(j w) each, the form of the textbooks.
    fn sharp(pulses: &[(f64, f64, f64)], omega: f64) -> f64 {
        let (mut re, mut im) = (0.0, 0.0);
        for (from, to, level) in pulses {
            re += level * ((omega * to).sin() - (omega * from).sin()) / omega;
            im += level * ((omega * to).cos() - (omega * from).cos()) / omega;
        }
        re * re + im * im
    }

    #[test]
    fn with_sharp_edges_it_is_the_textbooks_and_a_3211_of_one_second_has_its_node_at_two_pi() {
        let pulses = [(0.0, 3.0, 1.0), (3.0, 5.0, -1.0), (5.0, 6.0, 1.0), (6.0, 7.0, -1.0)];
        let mut points = vec![(-1e-7, 0.0)];
        for (from, to, level) in pulses {
            points.extend([(from, level), (to - 1e-7, level)]);
        }
        points.push((7.0, 0.0));
        let history = History::through(points).unwrap();
        for omega in [0.05, 0.9, 1.7, 3.3, 6.0, 11.0] {
            let expected = sharp(&pulses, omega);
            assert!((energy(&history, omega) - expected).abs() < 1e-5 * (1.0 + expected), "{omega}");
        }
        assert!(energy(&history, TAU) < 1e-10);
        let energies: Vec<f64> = omegas().iter().map(|&omega| energy(&history, omega)).collect();
        let outline = outline(&omegas(), &energies).unwrap();
        assert!(outline.nodes.iter().any(|node| (node - TAU).abs() < 0.02), "{outline:?}");
        // The area, as the frequency goes to zero: 3 - 2 + 1 - 1.
        assert!((energy(&history, 0.0) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_hand_of_finite_speed_multiplies_a_doublet_by_the_spectrum_of_its_edge() {
        // Ramps of equal length d are the sharp input averaged over d: sinc^2 of omega d / 2. Edges of a doublet are
        // 1, 2 and 1 amplitudes high, so at a hand's rate the middle one lasts twice as long.
        let slow = InputSpec::parse("pedal:step:0.02").unwrap().deviation(0.0);
        let (omega, d): (f64, f64) = (3.0, 0.02 / 0.5);
        let half = 0.5 * omega * d;
        let expected = (0.02 / omega * half.sin() / half).powi(2);
        assert!((energy(&slow, omega) / expected - 1.0).abs() < 1e-12);
    }
}
