//! The recursive regression against the slow obvious one: every vector stored, least squares by singular values.

use crate::support::uniform::Uniform;
use nalgebra::{DMatrix, DVector};
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::realtime::estimation::record::{AIDS, Confirmation, Instrumentation, SignalNoise, SmoothedRecord, TrimRecord};
use sideslip::realtime::regression::candidate::{BIAS, REGRESSORS, SIGNALS, regressor, response, signals, variable};
use sideslip::realtime::regression::coloured_errors;
use sideslip::realtime::regression::config::RegressionConfig;
use sideslip::realtime::regression::endogeneity::independent_samples;
use sideslip::realtime::regression::information::{Information, LAGS};
use sideslip::realtime::regression::record::{DerivativesRecord, LATERAL, LateralDerivatives};
use sideslip::realtime::regression::recursive::Recursive;
use sideslip::realtime::regression::stepwise::{Offer, Thresholds, fit};

const TOLERANCE: f64 = 1e-9;
const GRID_S: f64 = 0.08;

/// Everything that was ever seen on the grid; `None` where the instant was skipped.
struct Stored {
    vectors: Vec<Option<[f64; SIGNALS]>>,
    /// Weight of each: lambda to the number of vectors that came after it.
    weights: Vec<f64>,
}

/// Least squares of one response on chosen regressors, from the stored vectors.
struct Batch {
    places: Vec<usize>,
    theta: DVector<f64>,
    /// (X'WX)^-1.
    dispersion: DMatrix<f64>,
    /// Residual at each instant of the grid, where there is one.
    residual: Vec<Option<f64>>,
    squares: f64,
    response_squares: f64,
}

impl Stored {
    fn new(vectors: Vec<Option<[f64; SIGNALS]>>, lambda: f64) -> Self {
        let mut weights = vec![0.0; vectors.len()];
        let mut weight = 1.0;
        for (z, place) in vectors.iter().zip(&mut weights).rev() {
            if z.is_some() {
                *place = weight;
                weight *= lambda;
            }
        }
        Stored { vectors, weights }
    }

    /// sum over k of w_k^power f(z_k).
    fn sum(&self, power: i32, f: impl Fn(&[f64; SIGNALS]) -> f64) -> f64 {
        let terms = self.vectors.iter().zip(&self.weights);
        terms.map(|(z, w)| z.as_ref().map_or(0.0, |z| w.powi(power) * f(z))).sum()
    }

    fn weight2(&self) -> f64 {
        self.sum(2, |_| 1.0)
    }

    fn effective(&self) -> f64 {
        let weight = self.sum(1, |_| 1.0);
        weight * weight / self.weight2()
    }

    /// sum over k of w_k w_(k-lag) f(k, k - lag).
    fn lagged(&self, lag: usize, f: impl Fn(usize, usize) -> f64) -> f64 {
        (lag..self.vectors.len())
            .filter(|&k| self.vectors[k].is_some() && self.vectors[k - lag].is_some())
            .map(|k| self.weights[k] * self.weights[k - lag] * f(k, k - lag))
            .sum()
    }

    fn z(&self, k: usize) -> &[f64; SIGNALS] {
        self.vectors[k].as_ref().unwrap()
    }

    fn fit(&self, places: &[usize], response: usize) -> Batch {
        let used: Vec<(&[f64; SIGNALS], f64)> =
            self.vectors.iter().zip(&self.weights).filter_map(|(z, &w)| z.as_ref().map(|z| (z, w))).collect();
        let x = DMatrix::from_fn(used.len(), places.len(), |k, j| used[k].1.sqrt() * used[k].0[places[j]]);
        let y = DVector::from_fn(used.len(), |k, _| used[k].1.sqrt() * used[k].0[response]);
        let svd = x.svd(true, true);
        let theta = svd.solve(&y, 0.0).unwrap();
        let v_t = svd.v_t.as_ref().unwrap();
        let inverse = DMatrix::from_diagonal(&svd.singular_values.map(|s| 1.0 / (s * s)));
        let dispersion = v_t.transpose() * inverse * v_t;
        let predicted = |z: &[f64; SIGNALS]| places.iter().zip(theta.iter()).map(|(&place, t)| t * z[place]).sum::<f64>();
        let residual: Vec<Option<f64>> = self.vectors.iter().map(|z| z.as_ref().map(|z| z[response] - predicted(z))).collect();
        let squares = residual.iter().zip(&self.weights).map(|(v, w)| v.map_or(0.0, |v| w * v * v)).sum();
        let mean = self.sum(1, |z| z[response]) / self.sum(1, |_| 1.0);
        let response_squares = self.sum(1, |z| (z[response] - mean) * (z[response] - mean));
        Batch { places: places.to_vec(), theta, dispersion, residual, squares, response_squares }
    }

    /// Covariance of residual a at k with residual b at k - lag, with the fitted parameters made good.
    fn residual_covariance(&self, a: &Batch, b: &Batch, lag: usize) -> f64 {
        let (n, parameters) = (self.effective(), a.places.len().max(b.places.len()) as f64);
        let sum = self.lagged(lag, |k, before| a.residual[k].unwrap() * b.residual[before].unwrap());
        sum / self.weight2() * n / (n - parameters)
    }

    /// Covariance of the estimates of a with those of b for residuals of that many lags, tapered linearly.
    fn covariance(&self, a: &Batch, b: &Batch, lags: usize) -> DMatrix<f64> {
        self.covariance_of(a, b, |lag| (self.residual_covariance(a, b, lag), self.residual_covariance(b, a, lag)), lags)
    }

    /// The same from covariances of the errors at each lag: a at k with b at k - lag, and b with a.
    fn covariance_of(&self, a: &Batch, b: &Batch, of: impl Fn(usize) -> (f64, f64), lags: usize) -> DMatrix<f64> {
        let mut middle = DMatrix::zeros(a.places.len(), b.places.len());
        for lag in 0..=lags {
            let taper = 1.0 - lag as f64 / (LAGS + 1) as f64;
            let (ahead, behind) = of(lag);
            for (i, &row) in a.places.iter().enumerate() {
                for (j, &column) in b.places.iter().enumerate() {
                    let at = self.lagged(lag, |k, before| self.z(k)[row] * self.z(before)[column]);
                    let across = self.lagged(lag, |k, before| self.z(before)[row] * self.z(k)[column]);
                    middle[(i, j)] += taper * (ahead * at + if lag > 0 { behind * across } else { 0.0 });
                }
            }
        }
        &a.dispersion * middle * &b.dispersion
    }

    /// The autocovariance of the equation error behind a fitted residual: the sums of its lagged products, less what the fit
    /// took out of them, solved for; `None` where that cannot be.
    fn error_covariance(&self, batch: &Batch) -> Option<DVector<f64>> {
        let p = batch.places.len();
        let g = |lag: usize| {
            DMatrix::from_fn(p, p, |i, j| {
                self.lagged(lag, |k, before| self.z(k)[batch.places[i]] * self.z(before)[batch.places[j]])
            })
        };
        let g: Vec<DMatrix<f64>> = (0..=LAGS).map(g).collect();
        let d = &batch.dispersion;
        let t = |lag: usize| if lag <= LAGS { (d * &g[lag]).trace() } else { 0.0 };
        let w3 = self.sum(3, |_| 1.0) / self.weight2();
        let expected = DMatrix::from_fn(LAGS + 1, LAGS + 1, |l, m| {
            let (twice, both) = if m > 0 { (t(l + m), &g[m] + g[m].transpose()) } else { (0.0, g[0].clone()) };
            let own = if l == m { self.lagged(l, |_, _| 1.0) } else { 0.0 };
            own - 2.0 * w3 * (t(l.abs_diff(m)) + twice) + (g[l].transpose() * d * both * d).trace()
        });
        let r = expected.lu().solve(&self.residual_sums(batch))?;
        (r.iter().all(|entry| entry.is_finite()) && r[0] > 0.0).then_some(r)
    }

    /// What the terms left out may hide: each fitted beside those in, by how much it moves them, and all of them together.
    fn omitted(&self, batch: &Batch, axis: Axis) -> DMatrix<f64> {
        let p = batch.places.len();
        let mut hidden = DMatrix::zeros(p, p);
        let mut add = |besides: &[usize], alone: bool| {
            let places: Vec<usize> = batch.places.iter().chain(besides).copied().collect();
            let wider = self.fit(&places, response(axis));
            let mut shift = DVector::from_fn(p, |i, _| wider.theta[i] - batch.theta[i]);
            // A motion alone may be what its standard error says.
            if alone && !variable(besides[0]).unwrap().is_control() {
                let f = wider.theta[p] * wider.theta[p] / self.covariance(&wider, &wider, LAGS)[(p, p)];
                shift /= f.min(1.0).sqrt();
            }
            hidden += &shift * shift.transpose();
        };
        let left: Vec<usize> = (1..REGRESSORS).filter(|place| !batch.places.contains(place)).collect();
        left.iter().for_each(|&place| add(&[place], true));
        add(&left, false);
        hidden
    }

    fn residual_sums(&self, batch: &Batch) -> DVector<f64> {
        let sum = |lag| self.lagged(lag, |k, before| batch.residual[k].unwrap() * batch.residual[before].unwrap());
        DVector::from_fn(LAGS + 1, |lag, _| sum(lag))
    }

    /// Covariance of one equation's estimates as it is published: with the error's autocovariance, else the residual's.
    fn own_covariance(&self, batch: &Batch) -> DMatrix<f64> {
        if let Some(error) = self.error_covariance(batch) {
            let cov = self.covariance_of(batch, batch, |lag| (error[lag], error[lag]), LAGS);
            if cov.diagonal().iter().all(|&var| var > 0.0) {
                return cov;
            }
        }
        self.covariance(batch, batch, LAGS)
    }
}

fn assert_close(found: f64, expected: f64, scale: f64, what: &str) {
    assert!(found.is_finite() && expected.is_finite(), "{what}: {found} and {expected}");
    assert!((found - expected).abs() <= TOLERANCE * scale, "{what}: recursive {found}, batch {expected}");
}

/// Vectors with coloured signals; every response depends on the regressors and has a coloured residual.
fn vectors(uniform: &mut Uniform, count: usize, skip_one_in: u64) -> Vec<Option<[f64; SIGNALS]>> {
    let mut slow = [0.0; SIGNALS];
    let mut theta: [[f64; REGRESSORS]; SIGNALS] = std::array::from_fn(|_| std::array::from_fn(|_| uniform.within(2.0)));
    // No aircraft has a side force along its sideslip: the stage takes it for a reversed accelerometer.
    let y_v = &mut theta[response(Axis::Y)][regressor(Variable::V)];
    *y_v = -y_v.abs();
    let mut one = || {
        let mut z = [0.0; SIGNALS];
        z[BIAS] = 1.0;
        for i in 1..SIGNALS {
            slow[i] = 0.9 * slow[i] + uniform.within(1.0);
            z[i] = slow[i];
        }
        for (response, theta) in z.into_iter().zip(theta).enumerate().skip(REGRESSORS).map(|(i, (_, theta))| (i, theta)) {
            z[response] += (0..REGRESSORS).map(|j| theta[j] * z[j]).sum::<f64>();
        }
        (!uniform.bits().is_multiple_of(skip_one_in)).then_some(z)
    };
    (0..count).map(|_| one()).collect()
}

#[test]
fn sums_and_lagged_products_are_those_of_the_stored_vectors() {
    let mut uniform = Uniform(61);
    for (lambda, skip_one_in) in [(1.0, u64::MAX), (1.0, 5), (0.99, u64::MAX), (0.99, 5), (0.9, 2)] {
        let stored = Stored::new(vectors(&mut uniform, 400, skip_one_in), lambda);
        let mut information = Information::<SIGNALS>::default();
        for z in &stored.vectors {
            match z {
                Some(z) => information.add(z, lambda),
                None => information.skip(),
            }
        }
        let what = format!("lambda {lambda}, skips 1 in {skip_one_in}");
        assert_close(information.weight(), stored.sum(1, |_| 1.0), information.weight(), &what);
        assert_close(information.weight2(), stored.weight2(), information.weight2(), &what);
        for i in 0..SIGNALS {
            for j in 0..SIGNALS {
                let (si, sj) = (stored.sum(1, |z| z[i] * z[i]), stored.sum(1, |z| z[j] * z[j]));
                let sum = stored.sum(1, |z| z[i] * z[j]);
                assert_close(information.sums()[i][j], sum, (si * sj).sqrt(), &format!("S {i} {j}, {what}"));
                for lag in [0, 1, 2, 7, LAGS] {
                    let sum = stored.lagged(lag, |k, before| stored.z(k)[i] * stored.z(before)[j]);
                    let found = information.lagged(lag)[i][j];
                    assert_close(found, sum, (si * sj).sqrt(), &format!("G {lag} {i} {j}, {what}"));
                }
            }
        }
    }
}

#[test]
fn estimates_and_their_covariances_are_those_of_the_stored_vectors() {
    let mut uniform = Uniform(62);
    for (lambda, skip_one_in) in [(1.0, u64::MAX), (1.0, 5), (0.99, u64::MAX), (0.99, 5)] {
        let stored = Stored::new(vectors(&mut uniform, 400, skip_one_in), lambda);
        let mut information = Information::<SIGNALS>::default();
        for z in &stored.vectors {
            match z {
                Some(z) => information.add(z, lambda),
                None => information.skip(),
            }
        }
        for axis in [Axis::X, Axis::L, Axis::N] {
            let mut primary = [false; REGRESSORS];
            for place in primary.iter_mut().skip(1) {
                *place = !uniform.bits().is_multiple_of(3);
            }
            let offer = Offer { primary, ..Offer::NONE };
            let found = fit(&information, response(axis), &offer, &Thresholds { f_enter: 12.0, f_remove: 8.0 }).unwrap();
            let places: Vec<usize> = (0..REGRESSORS).filter(|&place| place == BIAS || primary[place]).collect();
            assert_eq!(found.order.len(), places.len());
            let batch = stored.fit(&places, response(axis));
            let what = format!("{axis:?}, lambda {lambda}, skips 1 in {skip_one_in}, terms {places:?}");
            assert_close(found.squares, batch.squares, batch.squares, &what);
            assert_close(found.response_squares, batch.response_squares, batch.response_squares, &what);

            let n = places.len();
            let forward = coloured_errors::residual_covariance(&information, &found.residual, &found.residual, n);
            let variance = stored.residual_covariance(&batch, &batch, 0);
            for (lag, &r) in forward.iter().enumerate() {
                assert_close(r, stored.residual_covariance(&batch, &batch, lag), variance, &format!("R {lag}, {what}"));
            }
            let mut white = [0.0; LAGS + 1];
            white[0] = forward[0];
            let dispersion = &found.dispersion;
            let pairs = [
                (
                    coloured_errors::covariance(&information, dispersion, dispersion, &forward, &forward),
                    stored.covariance(&batch, &batch, LAGS),
                ),
                (
                    coloured_errors::covariance(&information, dispersion, dispersion, &white, &white),
                    stored.covariance(&batch, &batch, 0),
                ),
            ];
            for (i, &row) in places.iter().enumerate() {
                let std = pairs[1].1[(i, i)].sqrt();
                assert_close(found.theta[row], batch.theta[i], batch.theta[i].abs().max(std), &format!("theta {row}, {what}"));
                for (j, &column) in places.iter().enumerate() {
                    let scale = (batch.dispersion[(i, i)] * batch.dispersion[(j, j)]).sqrt();
                    assert_close(dispersion[row][column], batch.dispersion[(i, j)], scale, &format!("D {row} {column}, {what}"));
                    for (found, expected) in &pairs {
                        let scale = (expected[(i, i)] * expected[(j, j)]).sqrt();
                        assert_close(found[row][column], expected[(i, j)], scale, &format!("cov {row} {column}, {what}"));
                    }
                }
            }
        }
    }
}

fn instruments() -> Instrumentation {
    Instrumentation {
        running: true,
        rate_hz: 25.0,
        gyros: true,
        accelerometers: [true; 3],
        aids: [true; AIDS],
        trusted: [true; AIDS],
        as_expected: [true; AIDS],
        vanes_disagree: [false; 2],
        vanes_contradict: [false; 2],
        controls_stood: [false; 4],
        inertial_stood: [false; 6],
        confirmations: [Confirmation::Confirmed; Confirmation::CHANNELS.len()],
        doubt: None,
        // All residuals are the instruments' noise: the stage is least squares.
        noise: SignalNoise { specific_force: [1e3; 3], angular_acceleration: [1e3; 3], ..SignalNoise::NONE },
    }
}

/// A smoothed record at that time whose z is that vector.
fn smoothed(time_s: f64, z: &[f64; SIGNALS]) -> SmoothedRecord {
    SmoothedRecord {
        time_s,
        interval_s: GRID_S,
        velocity: [z[1], z[2], z[3]],
        rates: [z[4], z[5], z[6]],
        attitude: [0.0; 2],
        specific_force: [z[11], z[12], z[13]],
        angular_acceleration: [z[14], z[15], z[16]],
        controls: [z[7], z[8], z[9], z[10]],
        controls_present: [true; 4],
    }
}

/// Instants that the stage never hears of: one, a few, more than there are lags.
const SILENCE: [std::ops::Range<usize>; 3] = [100..101, 150..154, 200..230];

/// Every number that the stage publishes, for the terms that it chose itself.
fn assert_published(record: &DerivativesRecord, stored: &Stored) {
    let (mut batches, mut covariances) = (Vec::new(), Vec::new());
    for equation in &record.equations {
        // A term that has no number is in the fit all the same.
        let in_fit = equation.terms.iter().map(|term| term.variable.map_or(BIAS, regressor));
        let places: Vec<usize> = in_fit.chain(equation.unresolved_variables().map(regressor)).collect();
        assert!(equation.terms.len() > 2 && places[0] == BIAS, "{equation:?}");
        let batch = stored.fit(&places, response(equation.axis));
        let (samples, parameters) = (stored.effective(), places.len() as f64);
        let factor = coloured_errors::small_sample_factor(samples, independent_samples(samples, GRID_S), parameters);
        let cov = (stored.own_covariance(&batch) + stored.omitted(&batch, equation.axis)) * factor;
        let white = stored.covariance(&batch, &batch, 0);
        for (i, term) in equation.terms.iter().enumerate() {
            let what = format!("{:?} {:?}", equation.axis, term.variable);
            assert_close(term.value, batch.theta[i], batch.theta[i].abs().max(white[(i, i)].sqrt()), &what);
            assert_close(term.std, cov[(i, i)].sqrt(), cov[(i, i)].sqrt(), &what);
            assert_close(term.std_white, white[(i, i)].sqrt(), white[(i, i)].sqrt(), &what);
            let f = batch.theta[i] * batch.theta[i] / white[(i, i)];
            assert_close(term.partial_f_white(), f, 10.0 * f.max(1.0), &what);
        }
        let (n, p) = (stored.effective(), places.len() as f64);
        let r2 = 1.0 - batch.squares / batch.response_squares;
        let what = format!("{:?} as a whole", equation.axis);
        assert_close(equation.samples, n, n, &what);
        assert_close(equation.r_squared, r2, 1.0, &what);
        let f_total = r2 / (p - 1.0) * (n - p) / (1.0 - r2);
        assert_close(equation.f_total, f_total, f_total, &what);
        let residual_std = stored.residual_covariance(&batch, &batch, 0).sqrt();
        assert_close(equation.residual_std, residual_std, residual_std, &what);
        let x = DMatrix::from_fn(stored.vectors.len(), places.len(), |k, j| {
            stored.vectors[k].map_or(0.0, |z| stored.weights[k].sqrt() * z[places[j]])
        });
        let unit = DMatrix::from_columns(&x.column_iter().map(|column| column.normalize()).collect::<Vec<_>>());
        let singular = unit.singular_values();
        assert_close(equation.condition_index, singular.max() / singular.min(), singular.max() / singular.min(), &what);
        batches.push(batch);
        covariances.push(cov);
    }
    let lateral = record.lateral.unwrap();
    let find = |axis: Axis, variable: Variable| {
        let batch = &batches[axis.index()];
        batch.places.iter().position(|&place| place == regressor(variable)).map(|i| (batch, i))
    };
    for a in 0..LATERAL {
        for b in 0..LATERAL {
            let [(axis_a, row), (axis_b, column)] = [LateralDerivatives::NAMES[a], LateralDerivatives::NAMES[b]];
            let what = format!("covariance of {axis_a:?}_{row:?} and {axis_b:?}_{column:?}");
            let (Some((batch_a, i)), Some((batch_b, j))) = (find(axis_a, row), find(axis_b, column)) else {
                assert_close(lateral.cov[a][b], 0.0, 0.0, &what);
                continue;
            };
            let own = |axis: Axis| &covariances[axis.index()];
            let joint = if axis_a == axis_b { own(axis_a)[(i, j)] } else { stored.covariance(batch_a, batch_b, LAGS)[(i, j)] };
            assert_close(lateral.cov[a][b], joint, (own(axis_a)[(i, i)] * own(axis_b)[(j, j)]).sqrt(), &what);
        }
        let (axis, variable) = LateralDerivatives::NAMES[a];
        let expected = find(axis, variable).map_or(0.0, |(batch, i)| batch.theta[i]);
        assert_close(lateral.values[a], expected, expected.abs().max(1e-3), "lateral value");
    }
}

#[test]
fn what_the_stage_publishes_is_what_the_stored_vectors_give() {
    let mut uniform = Uniform(68);
    let trim = TrimRecord {
        velocity: [0.0; 3],
        velocity_std: [0.0; 3],
        rates: [0.0; 3],
        attitude: [0.0; 2],
        specific_force: [0.0; 3],
        controls: [0.0; 4],
    };
    for forgetting_s in [1e9, 60.0, 8.0] {
        let config = RegressionConfig { forgetting_s, ..RegressionConfig::default() };
        let mut recursive = Recursive::new(config).unwrap();
        recursive.begin(trim);
        let mut seen = Vec::new();
        for (k, z) in vectors(&mut uniform, 350, 7).into_iter().enumerate() {
            // Instants of silence never come of age: the stage is not even told of them.
            if SILENCE.iter().any(|silence| silence.contains(&k)) {
                seen.push(None);
                continue;
            }
            let before = recursive.information().weight2();
            let mut record = smoothed(GRID_S * k as f64, &z.unwrap_or([0.0; SIGNALS]));
            if z.is_none() {
                record.velocity[1] = f64::NAN;
            }
            recursive.step(&record);
            // Quiet instants (the first ones) are skipped: the stage's own choice.
            let taken = recursive.information().weight2().to_bits() != before.to_bits();
            assert!(z.is_some() || !taken);
            seen.push(z.filter(|_| taken).map(|_| signals(&record, &trim).unwrap()));
        }
        let lambda = libm::exp(-GRID_S / forgetting_s);
        assert_published(&recursive.record(28.0, 28.0, &instruments()), &Stored::new(seen, lambda));
    }
}
