//! A factored covariance stays symmetric and positive whatever is done to it, in either precision and in any units.
//!
//! The long run takes `SIDESLIP_COVARIANCE_STEPS` steps in each precision and in each of two sets of units: 200,000 unless
//! told, 10,000,000 to be sure.

use crate::support::uniform::Uniform;
use nalgebra::SMatrix;
use proptest::prelude::*;
use sideslip::num::ud::{Real, UdFactor};

const N: usize = 6;
const M: usize = 4;
const K: usize = 2;

/// A scalar that numbers of the test can be brought to and back from.
pub(crate) trait Scalar: Real + std::fmt::Debug {
    const EPSILON: f64;
    fn of(number: f64) -> Self;
    fn number(self) -> f64;
}

impl Scalar for f64 {
    const EPSILON: f64 = f64::EPSILON;
    fn of(number: f64) -> f64 {
        number
    }
    fn number(self) -> f64 {
        self
    }
}

impl Scalar for f32 {
    const EPSILON: f64 = f32::EPSILON as f64;
    fn of(number: f64) -> f32 {
        number as f32
    }
    fn number(self) -> f64 {
        f64::from(self)
    }
}

/// One thing done to a covariance of states of about unit size.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "a few dozen of them, made and read once")]
enum Step {
    Propagate { top: [[f64; N]; M], input: [[f64; K]; M], var: [f64; K] },
    Fuse { row: [f64; N], var: f64 },
    Inflate { state: usize, by: f64 },
}

fn entries<const A: usize, const B: usize>(half: f64) -> impl Strategy<Value = [[f64; A]; B]> {
    prop::collection::vec(-half..half, A * B).prop_map(|flat| std::array::from_fn(|i| std::array::from_fn(|j| flat[i * A + j])))
}

fn any_step() -> impl Strategy<Value = Step> {
    // Noise from a millionth of the states' variance to as much.
    let var = || (-6.0..0.0_f64).prop_map(|exponent| 10_f64.powf(exponent));
    prop_oneof![
        3 => (entries::<N, M>(0.3), entries::<K, M>(1.0), prop::array::uniform2(var())).prop_map(|(mut top, input, var)| {
            for (i, row) in top.iter_mut().enumerate() {
                row[i] += 0.8;
            }
            Step::Propagate { top, input, var }
        }),
        4 => (entries::<N, 1>(1.0), var(), 0..N).prop_map(|([mut row], var, zeros)| {
            row[..zeros].fill(0.0);
            Step::Fuse { row, var }
        }),
        1 => (0..N, var()).prop_map(|(state, by)| Step::Inflate { state, by }),
    ]
}

/// The step done to states measured in units of 1/scale: values are `scale` times as large.
fn take<T: Scalar>(factor: &mut UdFactor<T, N>, step: &Step, scale: &[f64; N]) {
    match step {
        Step::Propagate { top, input, var } => {
            let top = std::array::from_fn(|i| std::array::from_fn(|j| T::of(top[i][j] * scale[i] / scale[j])));
            let input: [[T; K]; M] = std::array::from_fn(|i| std::array::from_fn(|j| T::of(input[i][j] * scale[i])));
            factor.propagate(&top, &input, &var.map(T::of)).unwrap();
        }
        Step::Fuse { row, var } => {
            let row = std::array::from_fn(|i| T::of(row[i] / scale[i]));
            let projection = factor.project(&row, T::of(*var)).unwrap();
            assert!(projection.innovation_var.number() >= *var * (1.0 - 2.0 * T::EPSILON));
            let gain = factor.fuse(&projection).unwrap();
            assert!(gain.iter().all(|entry| entry.finite()));
        }
        Step::Inflate { state, by } => factor.inflate(*state, T::of(by * scale[*state] * scale[*state])).unwrap(),
    }
}

/// Every d positive; the correlation matrix symmetric, with a Cholesky factor once its own rounding is allowed for.
fn check<T: Scalar>(factor: &UdFactor<T, N>) -> SMatrix<f64, N, N> {
    assert!(factor.diagonal().iter().all(|d| *d > T::ZERO && d.finite()), "{factor:?}");
    let p = SMatrix::<f64, N, N>::from_fn(|i, j| factor.covariance(i, j).number());
    assert_eq!(p, p.transpose());
    let mut correlation = SMatrix::<f64, N, N>::from_fn(|i, j| p[(i, j)] / (p[(i, i)] * p[(j, j)]).sqrt());
    assert!(correlation.iter().all(|entry| entry.abs() <= 1.0 + 8.0 * T::EPSILON), "{correlation}");
    for i in 0..N {
        correlation[(i, i)] += 8.0 * N as f64 * T::EPSILON;
    }
    assert!(correlation.cholesky().is_some(), "{correlation}");
    p
}

fn run<T: Scalar>(variances: &[f64; N], steps: &[Step], scale: &[f64; N]) -> SMatrix<f64, N, N> {
    let mut factor = UdFactor::from_variances(std::array::from_fn(|i| T::of(variances[i] * scale[i] * scale[i])));
    for step in steps {
        take(&mut factor, step, scale);
        check(&factor);
    }
    check(&factor)
}

proptest! {
    #![proptest_config(super::cases(256))]

    #[test]
    fn it_stays_symmetric_and_positive_in_any_units(
        variances in prop::array::uniform6(1e-4..1.0_f64),
        steps in prop::collection::vec(any_step(), 1..80),
        exponents in prop::array::uniform6(-4.0..4.0_f64),
    ) {
        let scale = exponents.map(|exponent| 10_f64.powf(exponent));
        let plain = run::<f64>(&variances, &steps, &[1.0; N]);
        let scaled = run::<f64>(&variances, &steps, &scale);
        run::<f32>(&variances, &steps, &[1.0; N]);
        run::<f32>(&variances, &steps, &scale);
        // Units change the numbers and nothing else.
        for i in 0..N {
            for j in 0..N {
                let size = (plain[(i, i)] * plain[(j, j)]).sqrt();
                let back = scaled[(i, j)] / (scale[i] * scale[j]);
                prop_assert!((back - plain[(i, j)]).abs() <= 1e-8 * size, "{i} {j}: {back} and {}", plain[(i, j)]);
            }
        }
    }
}

/// Steps of the long run, and how many of them lie between two whole checks; every d is looked at in each.
const USUAL_STEPS: f64 = 2e5;
const BETWEEN_CHECKS: u64 = 100;

/// A step of the kinds and sizes of [`any_step`].
fn step(uniform: &mut Uniform) -> Step {
    let var = |uniform: &mut Uniform| 10_f64.powf(uniform.between(-6.0, 0.0));
    match uniform.bits() % 8 {
        0..3 => {
            let mut top = [[0.0; N]; M];
            let mut input = [[0.0; K]; M];
            for (i, (top, input)) in top.iter_mut().zip(&mut input).enumerate() {
                top.fill_with(|| uniform.within(0.3));
                input.fill_with(|| uniform.within(1.0));
                top[i] += 0.8;
            }
            Step::Propagate { top, input, var: [var(uniform), var(uniform)] }
        }
        3..7 => {
            let zeros = (uniform.bits() % N as u64) as usize;
            let row = std::array::from_fn(|i| if i < zeros { 0.0 } else { uniform.within(1.0) });
            Step::Fuse { row, var: var(uniform) }
        }
        _ => Step::Inflate { state: (uniform.bits() % N as u64) as usize, by: var(uniform) },
    }
}

fn long_run<T: Scalar>(steps: u64, scale: &[f64; N]) {
    let mut uniform = Uniform(steps);
    let mut factor = UdFactor::from_variances(scale.map(|scale| T::of(scale * scale)));
    for k in 1..=steps {
        take(&mut factor, &step(&mut uniform), scale);
        assert!(factor.diagonal().iter().all(|d| *d > T::ZERO && d.finite()), "step {k}: {factor:?}");
        if k.is_multiple_of(BETWEEN_CHECKS) {
            check(&factor);
        }
    }
    check(&factor);
}

#[test]
fn it_stays_symmetric_and_positive_over_a_long_run() {
    let told = std::env::var("SIDESLIP_COVARIANCE_STEPS").ok().and_then(|text| text.parse::<f64>().ok());
    let steps = told.unwrap_or(USUAL_STEPS) as u64;
    let badly_scaled = [1e4, 1e-4, 1e3, 1e-3, 1e4, 1e-4];
    for scale in [[1.0; N], badly_scaled] {
        long_run::<f64>(steps, &scale);
        long_run::<f32>(steps, &scale);
        eprintln!("{steps} steps each of f64 and f32 with states of size {scale:?}");
    }
}
