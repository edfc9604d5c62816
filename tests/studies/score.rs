//! Estimates over seeds against the truth: bias, scatter, and what the reported standard errors are worth.

/// An estimate and its reported standard error.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Estimate {
    pub(crate) value: f64,
    pub(crate) std: f64,
    /// Whether the pipeline said that it has converged.
    pub(crate) converged: bool,
}

/// Estimates of one quantity.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Score {
    /// Estimates that there are.
    pub(crate) count: usize,
    /// Mean error.
    pub(crate) bias: f64,
    /// Standard deviation about the mean.
    pub(crate) scatter: f64,
    /// Root mean square of the reported standard errors.
    pub(crate) reported: f64,
    /// Mean of z = error/standard error: 0 is right.
    pub(crate) z_mean: f64,
    /// Standard deviation of z about its mean: 1 is right.
    pub(crate) z_spread: f64,
    /// Share of |z| below 2: 0.954 is right.
    pub(crate) within_two: f64,
    /// Share of |z| below 3: 0.997 is right.
    pub(crate) within_three: f64,
    /// How many the pipeline called converged.
    pub(crate) converged: usize,
    /// Standard deviation of z among those.
    pub(crate) z_spread_converged: f64,
}

fn mean(numbers: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = numbers.clone().count() as f64;
    numbers.sum::<f64>() / count
}

/// Standard deviation about the mean, one degree of freedom used up.
fn deviation(numbers: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = numbers.clone().count() as f64;
    let middle = mean(numbers.clone());
    (numbers.map(|x| (x - middle) * (x - middle)).sum::<f64>() / (count - 1.0)).sqrt()
}

impl Score {
    /// Of those estimates; a seed without one is left out and shows in `count`.
    pub(crate) fn of(estimates: impl IntoIterator<Item = Option<Estimate>>, truth: f64) -> Self {
        let there: Vec<Estimate> = estimates.into_iter().flatten().collect();
        let z = there.iter().map(|estimate| (estimate.value - truth) / estimate.std);
        let settled = there.iter().filter(|estimate| estimate.converged);
        let settled_z = settled.clone().map(|estimate| (estimate.value - truth) / estimate.std);
        let values = there.iter().map(|estimate| estimate.value);
        Score {
            count: there.len(),
            bias: mean(values.clone()) - truth,
            scatter: deviation(values),
            reported: mean(there.iter().map(|estimate| estimate.std * estimate.std)).sqrt(),
            z_mean: mean(z.clone()),
            z_spread: deviation(z.clone()),
            within_two: mean(z.clone().map(|z| f64::from(u8::from(z.abs() < 2.0)))),
            within_three: mean(z.map(|z| f64::from(u8::from(z.abs() < 3.0)))),
            converged: settled.count(),
            z_spread_converged: deviation(settled_z),
        }
    }
}

#[test]
fn a_score_is_that_computed_by_hand() {
    let one = |value: f64, std: f64| Some(Estimate { value, std, converged: value > 1.5 });
    let score = Score::of([one(1.0, 0.5), None, one(2.0, 0.5), one(3.0, 2.0)], 1.0);
    // Errors 0, 1, 2; z 0, 2, 1.
    assert_eq!(score.count, 3);
    let near = |found: f64, wanted: f64| assert!((found - wanted).abs() < 1e-12, "{found} for {wanted}");
    near(score.bias, 1.0);
    near(score.scatter, 1.0);
    near(score.reported, 1.5_f64.sqrt());
    near(score.z_mean, 1.0);
    near(score.z_spread, 1.0);
    near(score.within_two, 2.0 / 3.0);
    near(score.within_three, 1.0);
    near(score.z_spread_converged, 0.5_f64.sqrt());
    assert_eq!(score.converged, 2);
}
