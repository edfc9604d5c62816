//! Instrumental variables: two-stage least squares from lagged products, for equations whose disturbance moves the aircraft.
//!
//! Gusts enter an equation of motion through its disturbance and, an instant later, through every regressor: least squares is
//! then biased however long the record. Inputs are independent of the gusts. Consumes an information matrix; produces estimates
//! of any equation from that part of the regressors which past inputs predict:
//!     d_k = sum_m (a_m d_(k-m) + c_m' x_(k-m)) + e_k,   m = 2, 4, 6                                  (1)
//!     Z_k = [1, e_k, e_(k-2), .. e_(k-10)]                                                           (2)
//!     X^ = Z Pi,  Pi = (Z'Z)^-1 Z'X,   theta = (X^'X)^-1 X^'y                                        (3)
//!     Sigma = D [ sum_l w_l R_l (X^'X^_l + X^_l'X^) ] D,   D = (X^'X)^-1   (l = 0 counted once)      (4)
//! | symbol | shape | meaning |
//! | --- | --- | --- |
//! | d, e | 1 | a control that moves, and its innovation |
//! | x | 4 or 5 | v p r ay for lat_cyclic and pedal, u w q ax az for lon_cyclic and collective |
//! | Z | n x k | instruments: k = 1 + 6 for every control that moves |
//! | X, y | n x p, n | regressors and response of the equation |
//! | X^_l | n x p | X^ of l instants before |
//! | R_l, w_l | 1 | autocovariance of the residual y - X theta, and the taper, as in `coloured_errors` (1) |
//!
//! An innovation is what neither the control's own past nor that of the motion predicts, so what no pilot and no augmentation
//! system does in answer to a gust. All sums are G_l of `information` (2): an instrument of lag m against a signal is an entry
//! of G_m, two instruments one of their difference, as if the signals were stationary. Products of innovations further apart
//! than ten instants count as zero in (4).
//! Source: two-stage least squares and its standard errors: J. M. Wooldridge, Econometric Analysis of Cross Section and Panel
//! Data, 2nd ed., 2010, ch. 5; instruments in a closed loop: L. Ljung, System Identification, 2nd ed., 1999, ch. 13; (1) is ours.
//! Numerics: normal matrices scaled to unit diagonal, with `RIDGE` added: directions that no instrument moves (with fewer
//! instruments than terms there are some) get a variance of 1/RIDGE, not a failure. Refused (`None`): no control that moves.

use super::candidate::{BIAS, Coefficients, REGRESSORS, SIGNALS, STILL, regressor, response};
use super::coloured_errors::{residual_covariance, taper};
use super::information::{Information, LAGS};
use crate::flight::control::{CONTROLS, Control};
use crate::flight::derivative::{Axis, Variable};
use heapless::Vec;
use nalgebra::SMatrix;

/// Spacing of the lags of (1) and (2).
const SPACING: usize = 2;
/// Lags of (1).
const PAST: usize = 3;
/// Innovations of one control in (2).
const PER_CONTROL: usize = 6;
/// Instruments of all controls, the constant among them.
const INSTRUMENTS: usize = 1 + CONTROLS * PER_CONTROL;
/// Signals in (1) at most, the constant and the control itself among them.
const PREDICTORS: usize = 1 + PAST * 6;
/// Largest difference of lags of two instruments.
const REACH: usize = SPACING * (PER_CONTROL - 1);
const RIDGE: f64 = 1e-8;

const _: () = assert!(SPACING * PAST + REACH <= LAGS);

/// A signal of z some instants ago, and its weight in an innovation.
#[derive(Clone, Copy, Debug)]
struct Tap {
    place: usize,
    lag: usize,
    weight: f64,
}

type ControlInnovation = Vec<Tap, { PREDICTORS + 1 }>;
type Normal = SMatrix<f64, INSTRUMENTS, INSTRUMENTS>;
type FirstStage = SMatrix<f64, INSTRUMENTS, SIGNALS>;
type RegressorProducts = SMatrix<f64, REGRESSORS, REGRESSORS>;

/// Instruments of a record, and every signal's regression on them.
#[derive(Clone, Debug)]
pub struct Instruments {
    /// Pi of (3), a column for every signal of z.
    first_stage: FirstStage,
    /// Z'X, a column for every signal of z.
    against: FirstStage,
    /// Controls that move.
    controls: usize,
    /// Products of the innovations of two controls, by control, control and lag of the second less that of the first + REACH.
    products: [[[f64; 2 * REACH + 1]; CONTROLS]; CONTROLS],
}

/// An equation's estimate by instrumental variables.
#[derive(Clone, Debug)]
pub struct InstrumentalEstimate {
    /// Estimates by place; zero where a term is not in.
    pub theta: [f64; REGRESSORS],
    /// (4) by place.
    pub cov: [[f64; REGRESSORS]; REGRESSORS],
}

/// The motion that a pilot or an augmentation system answers with the control.
fn answered_motion(control: Control) -> Vec<usize, 5> {
    let (variables, forces): (&[Variable], &[Axis]) = match control {
        Control::LatCyclic | Control::Pedal => (&[Variable::V, Variable::P, Variable::R], &[Axis::Y]),
        Control::LonCyclic | Control::Collective => (&[Variable::U, Variable::W, Variable::Q], &[Axis::X, Axis::Z]),
    };
    let places = variables.iter().map(|&variable| regressor(variable)).chain(forces.iter().map(|&axis| response(axis)));
    places.collect()
}

/// (1) for one control.
fn innovation(information: &Information<SIGNALS>, control: Control) -> Option<ControlInnovation> {
    let own = regressor(control.variable());
    let mut taps = ControlInnovation::new();
    taps.push(Tap { place: own, lag: 0, weight: 1.0 }).ok()?;
    taps.push(Tap { place: BIAS, lag: 0, weight: 0.0 }).ok()?;
    for lag in (1..=PAST).map(|n| n * SPACING) {
        for place in answered_motion(control).into_iter().chain([own]) {
            taps.push(Tap { place, lag, weight: 0.0 }).ok()?;
        }
    }
    let predictors = taps.get(1..)?;
    let product = |a: &Tap, b: &Tap| information.shifted(a.place, a.lag, b.place, b.lag);
    let size = |tap: &Tap| libm::sqrt(information.squared()[tap.place][tap.place]);
    let scaled = |a: &Tap, b: &Tap| {
        let both = size(a) * size(b);
        if both > 0.0 { product(a, b) / both } else { 0.0 }
    };
    // Rows that are not used are those of the identity.
    let normal = SMatrix::<f64, PREDICTORS, PREDICTORS>::from_fn(|i, j| match (predictors.get(i), predictors.get(j)) {
        (Some(a), Some(b)) => scaled(a, b) + if i == j { RIDGE } else { 0.0 },
        _ => f64::from(u8::from(i == j)),
    });
    let against = SMatrix::<f64, PREDICTORS, 1>::from_fn(|i, _| predictors.get(i).map_or(0.0, |tap| scaled(tap, &taps[0])));
    let solution = normal.cholesky()?.solve(&against);
    let own_size = size(&taps[0]);
    for (tap, solved) in taps.iter_mut().skip(1).zip(&solution) {
        let its_size = libm::sqrt(information.squared()[tap.place][tap.place]);
        tap.weight = if its_size > 0.0 { -solved * own_size / its_size } else { 0.0 };
    }
    Some(taps)
}

impl Instruments {
    /// Instruments of the record so far; `None` without a control that moves, or where they cannot be told apart.
    #[inline(never)]
    pub fn new(information: &Information<SIGNALS>) -> Option<Self> {
        let mut innovations: Vec<ControlInnovation, CONTROLS> = Vec::new();
        for control in Control::ALL {
            let variable = control.variable();
            if information.deviation(regressor(variable)) > STILL[variable.index()] {
                innovations.push(innovation(information, control)?).ok()?;
            }
        }
        if innovations.is_empty() {
            return None;
        }
        let mut instruments = Instruments {
            first_stage: FirstStage::zeros(),
            against: FirstStage::zeros(),
            controls: innovations.len(),
            products: [[[0.0; 2 * REACH + 1]; CONTROLS]; CONTROLS],
        };
        instruments.multiply(information, &innovations);
        for signal in 0..SIGNALS {
            instruments.against[(0, signal)] = information.squared()[BIAS][signal];
            for (c, taps) in innovations.iter().enumerate() {
                for n in 0..PER_CONTROL {
                    let products =
                        taps.iter().map(|tap| tap.weight * information.shifted(tap.place, tap.lag + n * SPACING, signal, 0));
                    instruments.against[(1 + c * PER_CONTROL + n, signal)] = products.sum();
                }
            }
        }
        let normal = instruments.normal();
        let size: [f64; INSTRUMENTS] = core::array::from_fn(|i| libm::sqrt(normal[(i, i)]));
        let scaled = Normal::from_fn(|i, j| normal[(i, j)] / (size[i] * size[j]) + if i == j { RIDGE } else { 0.0 });
        let against = FirstStage::from_fn(|i, j| instruments.against[(i, j)] / size[i]);
        let solution = scaled.cholesky()?.solve(&against);
        instruments.first_stage = FirstStage::from_fn(|i, j| solution[(i, j)] / size[i]);
        Some(instruments)
    }

    /// Products of the innovations of every two controls.
    fn multiply(&mut self, information: &Information<SIGNALS>, innovations: &[ControlInnovation]) {
        for (c, first) in innovations.iter().enumerate() {
            for (d, second) in innovations.iter().enumerate() {
                for (apart, product) in self.products[c][d].iter_mut().enumerate() {
                    // Lags are counted from REACH before, so that none is negative.
                    let pairs = first.iter().flat_map(|a| second.iter().map(move |b| (a, b)));
                    let products = pairs
                        .map(|(a, b)| a.weight * b.weight * information.shifted(a.place, a.lag + REACH, b.place, b.lag + apart));
                    *product = products.sum();
                }
            }
        }
    }

    /// Product of instruments i and j, the second `later` instants further back; zero beyond reach.
    fn product(&self, i: usize, j: usize, later: usize) -> f64 {
        let (Some(i), Some(j)) = (i.checked_sub(1), j.checked_sub(1)) else { return 0.0 };
        let (n, m) = (i % PER_CONTROL * SPACING, j % PER_CONTROL * SPACING + later);
        let products = &self.products[i / PER_CONTROL][j / PER_CONTROL];
        (m + REACH).checked_sub(n).and_then(|place| products.get(place)).copied().unwrap_or(0.0)
    }

    /// Number of instruments, the constant among them.
    fn count(&self) -> usize {
        1 + self.controls * PER_CONTROL
    }

    /// Z'Z, the identity in rows that are not used.
    fn normal(&self) -> Normal {
        let count = self.count();
        Normal::from_fn(|i, j| match (i.min(j), i.max(j)) {
            (_, larger) if larger >= count => f64::from(u8::from(i == j)),
            (0, larger) => self.against[(larger, BIAS)],
            _ => self.product(i, j, 0),
        })
    }

    /// (3) and (4) of the equation with those terms, the response at that place of z; `None` where they cannot be computed.
    #[inline(never)]
    pub fn estimate(&self, information: &Information<SIGNALS>, order: &[usize], response: usize) -> Option<InstrumentalEstimate> {
        let count = self.count();
        let size = |place: usize| libm::sqrt(information.squared()[place][place]).max(f64::MIN_POSITIVE);
        let projected = |i: usize, j: usize| {
            (0..count).map(|k| self.against[(k, i)] * self.first_stage[(k, j)]).sum::<f64>() / (size(i) * size(j))
        };
        let normal = RegressorProducts::from_fn(|i, j| match (order.get(i), order.get(j)) {
            (Some(&a), Some(&b)) => projected(a, b) + if i == j { RIDGE } else { 0.0 },
            _ => f64::from(u8::from(i == j)),
        });
        let inverse = normal.cholesky()?.inverse();
        let against: Vec<f64, REGRESSORS> = order.iter().map(|&place| projected(place, response)).collect();
        let mut estimate = InstrumentalEstimate { theta: [0.0; REGRESSORS], cov: [[0.0; REGRESSORS]; REGRESSORS] };
        let mut residual: Coefficients = [0.0; SIGNALS];
        residual[response] = 1.0;
        for (i, &place) in order.iter().enumerate() {
            let sum: f64 = against.iter().enumerate().map(|(j, product)| inverse[(i, j)] * product).sum();
            estimate.theta[place] = sum * size(response) / size(place);
            residual[place] = -estimate.theta[place];
        }
        let autocovariance = residual_covariance(information, &residual, &residual, order.len());
        let mut middle = self.middle(information, &autocovariance, order, size);
        // What no instrument moves is known from the ridge alone, which knows nothing.
        (0..order.len()).for_each(|i| middle[(i, i)] += RIDGE * autocovariance[0]);
        let cov = inverse * middle * inverse;
        for (i, &a) in order.iter().enumerate() {
            for (j, &b) in order.iter().enumerate() {
                estimate.cov[a][b] = cov[(i, j)] / (size(a) * size(b));
            }
        }
        let usable = order.iter().all(|&place| estimate.cov[place][place] > 0.0 && estimate.theta[place].is_finite());
        usable.then_some(estimate)
    }

    /// The bracket of (4), scaled as the normal matrix.
    fn middle(
        &self,
        information: &Information<SIGNALS>,
        autocovariance: &[f64; LAGS + 1],
        order: &[usize],
        size: impl Fn(usize) -> f64,
    ) -> RegressorProducts {
        let count = self.count();
        let weights: [f64; LAGS + 1] = core::array::from_fn(|lag| taper(lag) * autocovariance[lag]);
        let entry = |i: usize, j: usize| {
            let by_lag = weights.iter().enumerate().map(|(lag, weight)| {
                let both = match (i, j, lag) {
                    (0, 0, 0) => information.shifted(BIAS, 0, BIAS, 0),
                    (0, 0, _) => 2.0 * information.shifted(BIAS, 0, BIAS, lag),
                    (0, ..) | (_, 0, _) => 0.0,
                    (.., 0) => self.product(i, j, 0),
                    _ => self.product(i, j, lag) + self.product(j, i, lag),
                };
                weight * both
            });
            by_lag.sum::<f64>()
        };
        // sum_l w_l R_l (Z'Z_l + Z_l'Z): symmetric.
        let mut weighted = Normal::zeros();
        for k in 0..count {
            for m in 0..=k {
                weighted[(k, m)] = entry(k, m);
                weighted[(m, k)] = weighted[(k, m)];
            }
        }
        let mut middle = RegressorProducts::zeros();
        for k in 0..count {
            let mut row = [0.0; REGRESSORS];
            for m in 0..count {
                let product = weighted[(k, m)];
                row.iter_mut().zip(order).for_each(|(entry, &place)| *entry += product * self.first_stage[(m, place)]);
            }
            for (i, &a) in order.iter().enumerate() {
                for (j, entry) in row.iter().enumerate().take(order.len()) {
                    middle[(i, j)] += self.first_stage[(k, a)] * entry;
                }
            }
        }
        RegressorProducts::from_fn(|i, j| match (order.get(i), order.get(j)) {
            (Some(&a), Some(&b)) => middle[(i, j)] / (size(a) * size(b)),
            _ => 0.0,
        })
    }
}
