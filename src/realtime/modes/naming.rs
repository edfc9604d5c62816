//! Names of the eigenvalues of a linearised aircraft: Dutch roll, roll, spiral, heave, pitch, short period, phugoid.
//!
//! Consumes A [8 x 8] in the order of `linear::STATES`, or A [n x n] of some of these states; produces every eigenvalue (1/s),
//! named by its participation factors. P_k is the participation factor of state k, (3) of `num::eigen`; zero where the model has
//! no such state. The names, for real modes and for oscillations:
//!     heave         P_w at least 1/2               short period  P_w + P_q at least 0.6
//!     pitch         P_q at least 1/2               phugoid       P_u + P_theta at least 1/2
//!     roll          P_p at least 0.4, the largest  Dutch roll    P_v at least 0.3, more than P_phi, P_v + P_r at least 0.4
//!     spiral        P_phi + P_r at least 0.6, P_phi at least 1/4
//! Where none of them is Dutch roll, roll or spiral in forward flight (`FORWARD`), the lateral share P_v + P_p + P_phi + P_r
//! decides if it is at least 1/2: the oscillation with the largest is the Dutch roll; a real mode that no other outruns in
//! damping is the roll if P_p is at least 1/4; the slowest real one is the spiral if it has more P_phi + P_r than P_p. So it is
//! at any speed in a model of the lateral plane alone, where all shares are lateral and the faster oscillation is the Dutch roll;
//! another oscillation whose lateral share is at least 1/2 is the lateral phugoid of an identified model.
//! Any other mode has no name (near hover roll and pitch are damped in one pair, yaw alone in a real mode); where two
//! fit a name it goes to the one with the larger share.
//! The thresholds are ours.

use crate::num::eigen::{eigenvalues_8, participation};
use nalgebra::{Complex, DMatrix, SMatrix};

/// Eigenvalues with names, 1/s.
#[derive(Clone, Debug, PartialEq)]
pub struct Eigenmodes {
    /// The Dutch roll, imaginary part positive.
    pub dutch_roll: Option<Complex<f64>>,
    /// The roll subsidence.
    pub roll: Option<f64>,
    /// The spiral mode.
    pub spiral: Option<f64>,
    /// The heave subsidence.
    pub heave: Option<f64>,
    /// The pitch subsidence.
    pub pitch: Option<f64>,
    /// The short period, imaginary part positive.
    pub short_period: Option<Complex<f64>>,
    /// The phugoid, imaginary part positive.
    pub phugoid: Option<Complex<f64>>,
    /// All but Dutch roll, roll and spiral, with a name or without; of a pair the one with positive imaginary part.
    pub others: Vec<Complex<f64>>,
}

/// Sideways acceleration by yaw rate, m/s: about the airspeed ahead. Below, motions mix and only their shares name them.
const FORWARD: f64 = 18.0;

/// u w q theta v p phi r.
type Shares = [f64; 8];

/// States by their place among the shares; with the flow angles, which take the place of the velocities across.
const STATES: [(&str, usize); 10] =
    [("u", 0), ("w", 1), ("alpha", 1), ("q", 2), ("theta", 3), ("v", 4), ("beta", 4), ("p", 5), ("phi", 6), ("r", 7)];

/// Upper halves of pairs, and reals, with their shares.
type RootShares = [(Complex<f64>, Option<Shares>)];

/// When the lateral share names what the other rules do not.
#[derive(Clone, Copy, PartialEq, Eq)]
enum ByLateralShare {
    Never,
    /// Forward flight.
    Forward,
    /// No other plane is in the model.
    LateralAlone,
}

/// Eigenvalues of A with names; `None` where they cannot be computed.
pub fn eigenmodes(a: &SMatrix<f64, 8, 8>) -> Option<Eigenmodes> {
    let entries = core::array::from_fn(|row| core::array::from_fn(|column| a[(row, column)]));
    let whole = eigenvalues_8(&entries)?.into_iter().filter(|mode| mode.im >= 0.0);
    let mut modes: Vec<(Complex<f64>, Option<Shares>)> =
        whole.map(|mode| (mode, participation(a, mode).map(Shares::from))).collect();
    let by_share = if -a[(4, 7)] >= FORWARD { ByLateralShare::Forward } else { ByLateralShare::Never };
    let found = named(&modes, by_share);
    modes.retain(|(mode, _)| {
        let own = if mode.im > 0.0 { found.dutch_roll } else { None };
        let real = if mode.im > 0.0 { [None; 2] } else { [found.roll, found.spiral] };
        own != Some(*mode) && !real.contains(&Some(mode.re))
    });
    Some(Eigenmodes { others: modes.into_iter().map(|(mode, _)| mode).collect(), ..found })
}

/// Names of the roots of a model with these states (by their channels; others than the eight and the flow angles take part in no
/// name), imaginary parts zero or more: `dutch_roll`, `roll`, `spiral`, `lateral_phugoid` where p, r and sideslip are states,
/// `short_period`, `phugoid` where q and incidence are.
pub fn mode_names(states: &[String], a: &DMatrix<f64>, roots: &[Complex<f64>]) -> Vec<Option<&'static str>> {
    let place = |state: &String| STATES.iter().find(|(name, _)| name == state).map(|(_, place)| *place);
    let places: Vec<Option<usize>> = states.iter().map(place).collect();
    let at = |wanted: usize| places.iter().position(|place| *place == Some(wanted));
    let is_longitudinal = at(1).is_some() && at(2).is_some();
    let sideways = match (at(4), at(5), at(7)) {
        (Some(v), Some(_), Some(r)) => Some((v, r)),
        _ => None,
    };
    let by_share = match sideways {
        Some(_) if !is_longitudinal => ByLateralShare::LateralAlone,
        // Sideslip as an angle has no meaning but in forward flight.
        Some((v, r)) if states[v] == "beta" || -a[(v, r)] >= FORWARD => ByLateralShare::Forward,
        _ => ByLateralShare::Never,
    };
    let shares = |root: Complex<f64>| {
        let mut sums = [0.0; 8];
        for (place, share) in places.iter().zip(participation(a, root)?.iter()) {
            if let Some(place) = *place {
                sums[place] += share;
            }
        }
        Some(sums)
    };
    let modes: Vec<(Complex<f64>, Option<Shares>)> = roots.iter().map(|&root| (root, shares(root))).collect();
    let found = named(&modes, by_share);
    let name = |(mode, shares): &(Complex<f64>, Option<Shares>)| {
        let lateral_pair = || shares.as_ref().and_then(lateral).map(|_| *mode);
        let of_plane = |is_there: bool, names: [(&'static str, Option<Complex<f64>>); 2]| {
            names.into_iter().find(|(_, named)| is_there && *named == Some(*mode)).map(|(name, _)| name)
        };
        let real = |root: Option<f64>| root.map(Complex::from);
        if mode.im > 0.0 {
            of_plane(sideways.is_some(), [("dutch_roll", found.dutch_roll), ("lateral_phugoid", lateral_pair())])
                .or_else(|| of_plane(is_longitudinal, [("short_period", found.short_period), ("phugoid", found.phugoid)]))
        } else {
            of_plane(sideways.is_some(), [("roll", real(found.roll)), ("spiral", real(found.spiral))])
        }
    };
    modes.iter().map(name).collect()
}

/// The modes by name; `others` is left empty.
fn named(modes: &RootShares, by_share: ByLateralShare) -> Eigenmodes {
    let best = |oscillates: bool, score: fn(&Shares) -> Option<f64>| {
        let fits = modes.iter().filter(|(mode, _)| (mode.im > 0.0) == oscillates);
        let scored = fits.filter_map(|(mode, shares)| Some((*mode, score(shares.as_ref()?)?)));
        scored.max_by(|(_, a), (_, b)| a.total_cmp(b)).map(|(mode, _)| mode)
    };
    let real = |score| best(false, score).map(|mode| mode.re);
    let mut found = Eigenmodes {
        dutch_roll: best(true, |&[.., v, _, phi, r]| (v >= 0.3 && v > phi && v + r >= 0.4).then_some(v + r)),
        roll: real(|p @ &[_, _, _, _, _, roll, _, _]| (roll >= 0.4 && roll >= largest(p)).then_some(roll)),
        spiral: real(|&[.., phi, r]| (phi + r >= 0.6 && phi >= 0.25).then_some(phi)),
        heave: real(|&[_, w, ..]| (w >= 0.5).then_some(w)),
        pitch: real(|&[_, _, q, ..]| (q >= 0.5).then_some(q)),
        short_period: best(true, |&[_, w, q, ..]| (w + q >= 0.6).then_some(w + q)),
        phugoid: best(true, |&[u, _, _, theta, ..]| (u + theta >= 0.5).then_some(u + theta)),
        others: Vec::new(),
    };
    if by_share != ByLateralShare::Never {
        let named = [found.roll, found.spiral, found.heave, found.pitch];
        let free = |mode: &Complex<f64>| !named.contains(&Some(mode.re));
        let reals = || modes.iter().filter(|(mode, _)| mode.im <= 0.0);
        let speed = |mode: &Complex<f64>| libm::fabs(mode.re);
        let fastest = modes.iter().max_by(|(a, _), (b, _)| speed(a).total_cmp(&speed(b))).filter(|(mode, _)| mode.im <= 0.0);
        let slowest = reals().min_by(|(a, _), (b, _)| speed(a).total_cmp(&speed(b)));
        let is_roll = |shares: &Shares| lateral(shares).is_some() && shares[5] >= 0.25;
        let is_spiral = |shares: &Shares| lateral(shares).is_some() && shares[6] + shares[7] > shares[5];
        let only_if = |(mode, shares): &(Complex<f64>, Option<Shares>), fits: &dyn Fn(&Shares) -> bool| {
            (free(mode) && shares.as_ref().is_some_and(fits)).then_some(mode.re)
        };
        let fastest_pair = || {
            let pairs = modes.iter().map(|(mode, _)| *mode).filter(|mode| mode.im > 0.0);
            pairs.max_by(|a, b| a.norm_sqr().total_cmp(&b.norm_sqr()))
        };
        found.dutch_roll = found.dutch_roll.or_else(|| match by_share {
            ByLateralShare::LateralAlone => fastest_pair(),
            _ => best(true, lateral),
        });
        found.roll = found.roll.or_else(|| only_if(fastest?, &is_roll));
        found.spiral = found.spiral.or_else(|| only_if(slowest?, &is_spiral).filter(|&re| Some(re) != found.roll));
    }
    found
}

impl Eigenmodes {
    /// Name of one of the others; `other` where it has none.
    pub fn name_of(&self, mode: &Complex<f64>) -> &'static str {
        let names = if mode.im > 0.0 {
            [("short period", self.short_period), ("phugoid", self.phugoid)]
        } else {
            [("heave", self.heave.map(Complex::from)), ("pitch", self.pitch.map(Complex::from))]
        };
        names.into_iter().find(|(_, named)| *named == Some(*mode)).map_or("other", |(name, _)| name)
    }
}

/// P_v + P_p + P_phi + P_r where that is at least 1/2.
fn lateral(&[_, _, _, _, v, p, phi, r]: &Shares) -> Option<f64> {
    let share = v + p + phi + r;
    (share >= 0.5).then_some(share)
}

fn largest(shares: &Shares) -> f64 {
    shares.iter().copied().fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::linear::state_matrix;
    use crate::simulation::flight_model::{FlightModel, FlightRequest};

    #[test]
    fn an_uncoupled_aircraft_has_its_modes_by_name() {
        // Longitudinal: diagonal -1, -2, -3, -4. Lateral: blocks with eigenvalues -0.1 +- 1.5i, -2.5 and -0.05.
        let mut a = SMatrix::<f64, 8, 8>::zeros();
        for (place, value) in [-1.0, -2.0, -3.0, -4.0].into_iter().enumerate() {
            a[(place, place)] = value;
        }
        a[(4, 4)] = -0.1;
        a[(7, 7)] = -0.1;
        a[(4, 7)] = -1.5;
        a[(7, 4)] = 1.5;
        a[(5, 5)] = -2.5;
        a[(6, 6)] = -0.05;
        let modes = eigenmodes(&a).unwrap();
        assert!((modes.dutch_roll.unwrap() - Complex::new(-0.1, 1.5)).norm_sqr() < 1e-24);
        assert!((modes.roll.unwrap() + 2.5).abs() < 1e-12 && (modes.spiral.unwrap() + 0.05).abs() < 1e-12);
        assert!((modes.heave.unwrap() + 2.0).abs() < 1e-12 && (modes.pitch.unwrap() + 3.0).abs() < 1e-12);
        assert_eq!((modes.others.len(), modes.short_period, modes.phugoid), (4, None, None));
        assert_eq!(modes.others.iter().filter(|mode| modes.name_of(mode) == "other").count(), 2);
        a[(0, 0)] = f64::NAN;
        assert_eq!(eigenmodes(&a), None);
    }

    fn names_of(states: &[&str], a: &DMatrix<f64>, roots: &[Complex<f64>]) -> Vec<Option<&'static str>> {
        let states: Vec<String> = states.iter().map(|&state| state.to_owned()).collect();
        mode_names(&states, a, roots)
    }

    #[test]
    fn a_model_of_some_states_names_its_roots_by_the_same_rule() {
        // Blocks with known eigenvalues: the states that they are made of name them, in whatever order they stand.
        let (pair, roll, spiral) = (Complex::new(-0.1, 1.5), Complex::from(-2.5), Complex::from(-0.05));
        let mut a = DMatrix::from_diagonal(&nalgebra::DVector::from_vec(vec![-2.5, -0.1, -0.1, -0.05]));
        (a[(1, 2)], a[(2, 1)]) = (1.5, -1.5);
        let three = [Some("roll"), Some("dutch_roll"), Some("spiral")];
        assert_eq!(names_of(&["p", "r", "beta", "phi"], &a, &[roll, pair, spiral]), three);
        assert_eq!(names_of(&["p", "r", "v", "phi"], &a, &[roll, pair, spiral]), three, "slow flight");
        assert_eq!(names_of(&["q", "alpha", "w", "theta"], &a, &[pair]), [Some("short_period")]);
        assert_eq!(names_of(&["p", "r"], &a.clone().resize(2, 2, 0.0), &[roll]), [None], "no sideslip, no plane");
        // Roll and spiral joined: the slower of two lateral pairs; a heading takes part in no name.
        let mut a = DMatrix::zeros(5, 5);
        for (from, real, imag) in [(0, -0.1, 1.5), (2, -0.4, 0.3)] {
            (a[(from, from)], a[(from + 1, from + 1)], a[(from, from + 1)], a[(from + 1, from)]) = (real, real, imag, -imag);
        }
        let roots = [pair, Complex::new(-0.4, 0.3), Complex::from(0.0)];
        let found = names_of(&["beta", "r", "p", "phi", "psi"], &a, &roots);
        assert_eq!(found, [Some("dutch_roll"), Some("lateral_phugoid"), None]);
    }

    #[test]
    fn eight_states_have_the_names_of_the_whole_aircraft() {
        let states = ["u", "w", "q", "theta", "v", "p", "phi", "r"];
        for knots in [20.0, 60.0, 100.0, 140.0] {
            let asked = FlightRequest { speed: Some(knots * 0.514_444), ..FlightRequest::default() };
            let a = state_matrix(FlightModel::puma(&asked).unwrap().linear());
            let (known, dense) = (all_named(&a), DMatrix::from_fn(8, 8, |i, j| a[(i, j)]));
            let roots: Vec<Complex<f64>> = known.iter().map(|(_, root)| *root).collect();
            for ((own, root), found) in known.iter().zip(names_of(&states, &dense, &roots)) {
                let own = own.to_lowercase().replace(' ', "_");
                assert_eq!(found.unwrap_or("other"), if own == "heave" { "other" } else { &own }, "{knots} kn: {root}");
            }
        }
    }

    type Wanted = &'static [(&'static str, f64, f64)];

    /// Every mode of A with its name, reals and upper halves of pairs.
    fn all_named(a: &SMatrix<f64, 8, 8>) -> Vec<(&'static str, Complex<f64>)> {
        let modes = eigenmodes(a).unwrap();
        let real = |mode: Option<f64>| mode.map(Complex::from);
        let three = [("Dutch roll", modes.dutch_roll), ("roll", real(modes.roll)), ("spiral", real(modes.spiral))];
        let mut all: Vec<_> = three.into_iter().filter_map(|(name, mode)| Some((name, mode?))).collect();
        all.extend(modes.others.iter().map(|mode| (modes.name_of(mode), *mode)));
        all
    }

    fn assert_named(what: &str, a: &SMatrix<f64, 8, 8>, wanted: Wanted) {
        let found = all_named(a);
        assert_eq!(found.len(), wanted.len(), "{what}: {found:?}");
        for &(name, re, im) in wanted {
            let near = |mode: &Complex<f64>| (mode.re - re).hypot(mode.im - im) < 6e-4;
            assert!(found.iter().any(|(own, mode)| *own == name && near(mode)), "{what}: {name} {re} {im} is not in {found:?}");
        }
    }

    /// Eigenvalues and shares of another program (LAPACK's eigenvectors) for the same A. Shares that decide, by speed:
    /// 0 kn: w 0.97 at -0.326, r 0.92 at -0.266, v 0.26 with phi 0.26 and r 0.04 at -0.044, u 0.22 and theta 0.23 at 0.280.
    /// 20 kn: w 0.79, phi 0.41 with r 0.42, v 0.36 with r 0.18, u 0.32 with theta 0.33; q 0.32 and p 0.41 in one pair.
    /// 60 to 140 kn: p 0.57 to 0.42, w + q 0.72 to 0.83, v 0.41 to 0.36, phi 0.65 to 0.30, u 0.43 to 0.39 with theta the same.
    #[test]
    fn the_pumas_modes_are_named_by_what_takes_part() {
        let cases: [(f64, Wanted); 5] = [
            (
                0.0,
                &[
                    ("other", -1.2988, 0.2091),
                    ("heave", -0.3256, 0.0),
                    ("other", -0.2655, 0.0),
                    ("other", -0.0440, 0.5687),
                    ("other", 0.2796, 0.4988),
                ],
            ),
            (
                20.0,
                &[
                    ("other", -1.2652, 0.2559),
                    ("heave", -0.4651, 0.0),
                    ("spiral", -0.1131, 0.0),
                    ("Dutch roll", -0.0641, 0.6941),
                    ("phugoid", 0.1201, 0.4448),
                ],
            ),
            (
                60.0,
                &[
                    ("roll", -1.3859, 0.0),
                    ("short period", -0.8917, 0.7303),
                    ("Dutch roll", -0.1994, 1.0135),
                    ("spiral", -0.1253, 0.0),
                    ("phugoid", 0.0015, 0.2510),
                ],
            ),
            (
                100.0,
                &[
                    ("roll", -1.6622, 0.0),
                    ("short period", -1.0040, 1.2936),
                    ("spiral", -0.1797, 0.0),
                    ("Dutch roll", -0.0882, 0.9908),
                    ("phugoid", -0.0091, 0.1752),
                ],
            ),
            (
                140.0,
                &[
                    ("roll", -1.9851, 0.0),
                    ("short period", -1.1303, 1.6779),
                    ("spiral", -0.3701, 0.0),
                    ("phugoid", 0.0025, 0.1402),
                    ("Dutch roll", 0.1636, 0.7387),
                ],
            ),
        ];
        for (knots, wanted) in cases {
            let asked = FlightRequest { speed: Some(knots * 0.514_444), ..FlightRequest::default() };
            assert_named(&format!("{knots} kn"), &state_matrix(FlightModel::puma(&asked).unwrap().linear()), wanted);
        }
    }

    #[test]
    fn so_are_those_of_a_linear_model_and_of_an_aeroplane() {
        let like = FlightModel::parse(include_str!("../../../replay/models/puma-like.toml"), &FlightRequest::default()).unwrap();
        assert_named(
            "puma-like",
            &state_matrix(like.linear()),
            &[
                ("roll", -1.6652, 0.0),
                ("short period", -1.0047, 1.2947),
                ("spiral", -0.1815, 0.0),
                ("Dutch roll", -0.0852, 0.9861),
                ("phugoid", -0.0090, 0.1751),
            ],
        );
        // A light aeroplane at 53.6 m/s (the Navion's derivatives, in SI); shares of 0.9 and more within each name.
        let u = 53.6448;
        let mut a = SMatrix::<f64, 8, 8>::zeros();
        for (row, column, value) in [
            (0, 0, -0.045),
            (0, 1, 0.036),
            (0, 3, -9.80665),
            (1, 0, -0.369),
            (1, 1, -2.024),
            (1, 2, u),
            (2, 0, 0.00617421),
            (2, 1, -0.13017585),
            (2, 2, -2.9476),
            (3, 2, 1.0),
            (4, 4, -0.254),
            (4, 6, 9.80665),
            (4, 7, -u),
            (5, 4, -16.02 / u),
            (5, 5, -8.4),
            (5, 7, 2.19),
            (6, 5, 1.0),
            (7, 4, 4.49 / u),
            (7, 5, -0.35),
            (7, 7, -0.76),
        ] {
            a[(row, column)] = value;
        }
        assert_named(
            "aeroplane",
            &a,
            &[
                ("roll", -8.4329, 0.0),
                ("short period", -2.4912, 2.6008),
                ("Dutch roll", -0.4861, 2.3343),
                ("phugoid", -0.0171, 0.2132),
                ("spiral", -0.0089, 0.0),
            ],
        );
    }

    /// Shares: 100 kn -2000 ft/min v 0.28 p 0.18 phi 0.09 r 0.16, beside a pair with 0.55 in all; 140 kn +1000 v 0.36 phi 0.38.
    #[test]
    fn in_climb_and_descent_the_lateral_share_names_what_no_other_rule_does() {
        let at = |knots: f64, feet_per_minute: f64| {
            let (speed, climb) = (Some(knots * 0.514_444), Some(feet_per_minute * 0.00508));
            let a =
                state_matrix(FlightModel::puma(&FlightRequest { speed, climb, ..FlightRequest::default() }).unwrap().linear());
            (-a[(4, 7)], eigenmodes(&a).unwrap())
        };
        let near = |found: Option<f64>, wanted: Option<f64>| match (found, wanted) {
            (Some(found), Some(wanted)) => (found - wanted).abs() < 6e-4,
            (found, wanted) => found == wanted,
        };
        for (knots, climb, (re, im), roll, spiral) in [
            (100.0, -2000.0, (-0.1213, 0.8783), Some(-1.7046), None),
            (100.0, -1000.0, (-0.0874, 0.9708), Some(-1.6501), Some(-0.1453)),
            (100.0, 1000.0, (-0.1134, 0.9634), Some(-1.6600), Some(-0.2260)),
            (100.0, 2000.0, (-0.2080, 0.9707), Some(-1.3979), Some(-0.3619)),
            (140.0, -2000.0, (0.2407, 0.8508), Some(-2.0930), Some(-0.1641)),
            (140.0, -1000.0, (0.1948, 0.8172), Some(-2.0399), Some(-0.2493)),
            (140.0, 1000.0, (0.1631, 0.6129), Some(-1.9003), Some(-0.6085)),
            (140.0, 2000.0, (0.2238, 0.4440), None, None),
        ] {
            let modes = at(knots, climb).1;
            let pair = modes.dutch_roll.unwrap();
            assert!((pair.re - re).hypot(pair.im - im) < 6e-4, "{knots} kn {climb}: {modes:?}");
            assert!(near(modes.roll, roll) && near(modes.spiral, spiral), "{knots} kn {climb}: {modes:?}");
        }
        // A yaw mode, and a heave mode with some roll, are no roll; slow flight has no such rule.
        assert_eq!((at(60.0, -1000.0).1.roll, at(60.0, 2000.0).1.roll), (None, None));
        for knots in [0.0, 10.0, 20.0, 30.0] {
            assert!([-1000.0, 0.0, 1000.0].into_iter().all(|climb| at(knots, climb).0 < FORWARD), "{knots} kn");
        }
    }
}
