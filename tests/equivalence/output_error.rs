//! Output error against a slow fit from the book: Runge-Kutta in small steps, central differences, one dense system of equations.

use crate::support::short_period::{Noise, TRUTH, normal, parameters, record, structure};
use crate::support::uniform::Uniform;
use sideslip::postflight::output_error::{FitParameter, NoiseCovariance as NoiseModel};
use sideslip::postflight::output_error::{
    FitResult, FitSettings, InputDelay, InputOutputRecord, MatrixEntry, ModelStructure, OutputErrorFitError, RunParameters, fit,
    fit_run_parameters, predict,
};

const SUBSTEPS: usize = 24;
const TIGHT: FitSettings =
    FitSettings { iterations: 100, tolerance: 1e-9, noise: NoiseModel::Diagonal, delay_grid: true, watch: None };

/// x' and y of the short period, written out.
fn motion(theta: &[f64], bias: f64, x: [f64; 2], u: f64) -> [f64; 2] {
    [theta[0] * x[0] + x[1] + theta[1] * u, theta[2] * x[0] + theta[3] * x[1] + theta[4] * u + bias]
}

/// Outputs of one run, `own` being w(0), q(0), the bias of q' and that of az.
fn slow_outputs(theta: &[f64], own: &[f64], record: &InputOutputRecord) -> Vec<[f64; 3]> {
    let mut x = [own[0], own[1]];
    let mut out = Vec::new();
    for k in 0..record.times_s.len() {
        let u = record.inputs[0][k];
        out.push([x[0], x[1], theta[5] * x[0] + 0.2 * x[1] + (0.1 + 2.0 * theta[1]) * u + own[3]]);
        if k + 1 == record.times_s.len() {
            break;
        }
        let (h, slope) = (record.times_s[k + 1] - record.times_s[k], record.inputs[0][k + 1] - u);
        let d = h / SUBSTEPS as f64;
        for i in 0..SUBSTEPS {
            let at = |part: f64| u + slope * (i as f64 + part) / SUBSTEPS as f64;
            let moved = |k: [f64; 2], by: f64| [x[0] + by * k[0], x[1] + by * k[1]];
            let k1 = motion(theta, own[2], x, at(0.0));
            let k2 = motion(theta, own[2], moved(k1, 0.5 * d), at(0.5));
            let k3 = motion(theta, own[2], moved(k2, 0.5 * d), at(0.5));
            let k4 = motion(theta, own[2], moved(k3, d), at(1.0));
            for j in 0..2 {
                x[j] += d / 6.0 * (k1[j] + 2.0 * k2[j] + 2.0 * k3[j] + k4[j]);
            }
        }
    }
    out
}

/// All residuals that were measured, with their outputs.
fn slow_residuals(unknowns: &[f64], records: &[InputOutputRecord]) -> Vec<(usize, f64)> {
    let mut all = Vec::new();
    for (run, record) in records.iter().enumerate() {
        let outputs = slow_outputs(&unknowns[..6], &unknowns[6 + 4 * run..10 + 4 * run], record);
        for (k, y) in outputs.iter().enumerate() {
            for (o, y) in y.iter().enumerate() {
                if record.outputs[o][k].is_finite() {
                    all.push((o, record.outputs[o][k] - y));
                }
            }
        }
    }
    all
}

/// Gaussian elimination with pivots; the inverse beside the solution.
fn solve(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> (Vec<f64>, Vec<Vec<f64>>) {
    let n = b.len();
    let mut inverse: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect()).collect();
    for i in 0..n {
        let pivot = (i..n).max_by(|&x, &y| a[x][i].abs().total_cmp(&a[y][i].abs())).unwrap();
        a.swap(i, pivot);
        b.swap(i, pivot);
        inverse.swap(i, pivot);
        let d = a[i][i];
        a[i].iter_mut().for_each(|x| *x /= d);
        inverse[i].iter_mut().for_each(|x| *x /= d);
        b[i] /= d;
        for k in (0..n).filter(|&k| k != i) {
            let f = a[k][i];
            for j in 0..n {
                a[k][j] -= f * a[i][j];
                inverse[k][j] -= f * inverse[i][j];
            }
            b[k] -= f * b[i];
        }
    }
    (b, inverse)
}

/// Unknowns and their Cramer-Rao standard errors by Gauss-Newton, `prior` on theta_3.
fn slow_fit(start: &[f64], records: &[InputOutputRecord], prior: Option<(f64, f64)>) -> (Vec<f64>, Vec<f64>) {
    let mut unknowns: Vec<f64> = start.iter().copied().chain(vec![0.0; 4 * records.len()]).collect();
    let n = unknowns.len();
    let mut inverse = Vec::new();
    for _ in 0..25 {
        let v = slow_residuals(&unknowns, records);
        let r: Vec<f64> = (0..3)
            .map(|o| {
                let of = || v.iter().filter(|(output, _)| *output == o);
                of().map(|(_, v)| v * v).sum::<f64>() / of().count() as f64
            })
            .collect();
        let s: Vec<Vec<f64>> = (0..n)
            .map(|j| {
                let step = 1e-5 * unknowns[j].abs().max(0.1);
                let at = |by: f64| {
                    let mut moved = unknowns.clone();
                    moved[j] += by;
                    slow_residuals(&moved, records)
                };
                at(-step).iter().zip(at(step)).map(|(down, up)| (down.1 - up.1) / (2.0 * step)).collect()
            })
            .collect();
        let sum = |one: &[f64], two: &dyn Fn(usize) -> f64| -> f64 {
            one.iter().enumerate().map(|(k, x)| x * two(k) / r[v[k].0]).sum()
        };
        let mut m: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|j| sum(&s[i], &|k| s[j][k])).collect()).collect();
        let mut g: Vec<f64> = (0..n).map(|i| sum(&s[i], &|k| v[k].1)).collect();
        if let Some((mean, std)) = prior {
            m[3][3] += 1.0 / (std * std);
            g[3] -= (unknowns[3] - mean) / (std * std);
        }
        let (step, found) = solve(m, g);
        unknowns.iter_mut().zip(&step).for_each(|(x, step)| *x += step);
        inverse = found;
        if step.iter().all(|step| step.abs() < 1e-11) {
            break;
        }
    }
    (unknowns, (0..n).map(|i| inverse[i][i].sqrt()).collect())
}

fn own(w: f64, q: f64, bias: f64, az: f64) -> RunParameters {
    RunParameters { initial_state: vec![w, q], state_bias: vec![0.0, bias], output_bias: vec![0.0, 0.0, az] }
}

const WHITE: Noise = Noise { std: [0.002, 0.003, 0.02], colour: 0.0 };

/// Two runs: one even, one whose clock is uneven and whose w is sampled at every other instant.
fn two_runs(seed: u64) -> Vec<InputOutputRecord> {
    let mut uniform = Uniform(seed);
    let even = (0..160).map(|k| 0.05 * f64::from(k)).collect();
    let mut t = 0.0;
    let uneven = (0..140).map(|_| {
        t += uniform.between(0.03, 0.07);
        t
    });
    let uneven = uneven.collect();
    let first = record(even, 0.5, &own(0.01, -0.02, 0.03, 0.1), &WHITE, &mut uniform);
    let mut second = record(uneven, 0.7, &own(-0.02, 0.01, -0.02, -0.2), &WHITE, &mut uniform);
    second.outputs[0].iter_mut().skip(1).step_by(2).for_each(|z| *z = f64::NAN);
    vec![first, second]
}

fn relative(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs() / b.abs()).fold(0.0, f64::max)
}

fn fitted(parameters: &[FitParameter], records: &[InputOutputRecord]) -> FitResult {
    let fitted = fit(&structure(), parameters, &[], records, &TIGHT).unwrap();
    assert!(fitted.converged);
    fitted
}

#[test]
fn two_runs_are_the_dense_slow_answer() {
    let records = two_runs(7);
    let mut parameters = parameters(0.2);
    parameters[3].prior = Some((-1.5, 0.05));
    let start: Vec<f64> = parameters.iter().map(|parameter| parameter.start).collect();
    let (unknowns, std) = slow_fit(&start, &records, parameters[3].prior);
    let ours = fitted(&parameters, &records);
    let apart = [relative(&ours.theta, &unknowns[..6]), relative(&ours.std_cramer_rao, &std[..6])];
    eprintln!("estimates and Cramer-Rao errors apart by {:.1e} and {:.1e} of themselves", apart[0], apart[1]);
    assert!(apart.iter().all(|apart| *apart < 1e-6), "{apart:?}");
    for (run, found) in ours.runs.iter().enumerate() {
        let values = [
            found.run_parameters.initial_state.clone(),
            vec![found.run_parameters.state_bias[1], found.run_parameters.output_bias[2]],
        ]
        .concat();
        assert!(relative(&values, &unknowns[6 + 4 * run..10 + 4 * run]) < 1e-6, "{values:?}");
    }
}

#[test]
fn one_state_without_noise_is_the_closed_form() {
    let (a, b) = (-1.3, 2.0);
    let times_s: Vec<f64> = (0..80).map(|k| 0.05 * f64::from(k)).collect();
    // The response to a ramp u = t.
    let output: Vec<f64> = times_s.iter().map(|t| b * ((a * t).exp() - 1.0 - a * t) / (a * a)).collect();
    let structure = ModelStructure {
        states: vec!["x".into()],
        inputs: vec!["u".into()],
        outputs: vec!["x".into()],
        a: vec![vec![MatrixEntry::free(0)]],
        b: vec![vec![MatrixEntry::free(1)]],
        c: vec![vec![MatrixEntry::fixed(1.0)]],
        d: vec![vec![MatrixEntry::fixed(0.0)]],
        state_bias: vec![false],
        output_bias: vec![false],
        initial_state: vec![false],
    };
    let named = |name: &str, start: f64| FitParameter { name: name.into(), start, prior: None };
    let records =
        [InputOutputRecord { inputs: vec![times_s.clone()], times_s, outputs: vec![output], input_noise_std: Vec::new() }];
    let found = fit(&structure, &[named("a", -0.5), named("b", 1.0)], &[], &records, &FitSettings::default()).unwrap();
    assert!((found.theta[0] - a).abs() < 1e-8 && (found.theta[1] - b).abs() < 1e-8, "{:?}", found.theta);
    assert!(found.runs[0].vaf[0] > 0.999_999 && found.runs[0].theil[0] < 1e-6);
}

#[test]
fn a_full_noise_covariance_is_found_and_a_run_left_out_is_followed() {
    let mut uniform = Uniform(11);
    let times = |n: usize| (0..n).map(|k| 0.02 * k as f64).collect::<Vec<f64>>();
    let quiet = Noise { std: [1e-9; 3], colour: 0.0 };
    let mut records = [record(times(600), 0.5, &own(0.0, 0.0, 0.0, 0.0), &quiet, &mut uniform)];
    for k in 0..600 {
        let both = 0.003 * normal(&mut uniform);
        records[0].outputs[0][k] += both + 0.001 * normal(&mut uniform);
        records[0].outputs[1][k] += both + 0.001 * normal(&mut uniform);
        records[0].outputs[2][k] += 0.02 * normal(&mut uniform);
    }
    let settings = FitSettings { noise: NoiseModel::Full, ..TIGHT };
    let found = fit(&structure(), &parameters(0.2), &[], &records, &settings).unwrap();
    let r = &found.noise_cov;
    let rho = r[(0, 1)] / (r[(0, 0)] * r[(1, 1)]).sqrt();
    assert!((rho - 0.9).abs() < 0.03, "{rho}");
    let diagonal = fit(&structure(), &parameters(0.2), &[], &records, &TIGHT).unwrap();
    for (j, truth) in TRUTH.iter().enumerate() {
        assert!((found.theta[j] - truth).abs() < 4.0 * found.std[j], "{j}: {} {}", found.theta[j], found.std[j]);
        // What w tells of the noise in q is not lost.
        assert!(found.std_cramer_rao[j] < 1.05 * diagonal.std_cramer_rao[j]);
    }
    let other = record(times(500), 0.8, &own(0.02, 0.01, -0.01, 0.3), &WHITE, &mut uniform);
    let followed = fit_run_parameters(&structure(), &found.theta, &[], &found.noise_cov, &other).unwrap();
    assert!(followed.vaf.iter().all(|vaf| *vaf > 0.97), "{:?}", followed.vaf);
    assert!(
        (followed.run_parameters.output_bias[2] - 0.3).abs() < 4.0 * followed.run_parameters_std.output_bias[2],
        "{:?}",
        followed.run_parameters
    );
}

#[test]
fn a_delay_is_found_from_no_delay() {
    let smooth = |t: f64| 0.03 * (1.1 * t).sin() + 0.02 * (2.7 * t).sin() + 0.01 * (6.0 * t).sin();
    for delay_s in [0.013, 0.087, 0.15] {
        let mut uniform = Uniform(3);
        let times_s: Vec<f64> = (0..700).map(|k| 0.02 * f64::from(k)).collect();
        let mut late = record(times_s.clone(), 0.5, &own(0.0, 0.0, 0.0, 0.0), &WHITE, &mut uniform);
        // What was flown is the input of that much earlier; what is recorded is the input of now.
        let noise: Vec<Vec<f64>> = late.outputs.clone();
        let quiet = |record: &InputOutputRecord| predict(&structure(), &TRUTH, &[], record, &own(0.0, 0.0, 0.0, 0.0)).unwrap();
        let before = quiet(&late);
        late.inputs[0] = times_s.iter().map(|t| smooth((t - delay_s).max(0.0))).collect();
        late.outputs = quiet(&late);
        for o in 0..3 {
            for k in 0..700 {
                late.outputs[o][k] += noise[o][k] - before[o][k];
            }
        }
        late.inputs[0] = times_s.iter().map(|&t| smooth(t)).collect();
        let mut parameters = parameters(0.2);
        parameters.push(FitParameter { name: "delay".into(), start: 0.0, prior: None });
        let found =
            fit(&structure(), &parameters, &[InputDelay { input: 0, parameter: 6 }], &[late], &FitSettings::default()).unwrap();
        eprintln!("delay {delay_s}: {:.4} +- {:.4}", found.theta[6], found.std[6]);
        let within = (found.theta[6] - delay_s).abs() < 4.0 * found.std[6] && found.std[6] < 0.003;
        assert!(within, "{delay_s}: {} +- {}", found.theta[6], found.std[6]);
        assert!((0..6).all(|j| (found.theta[j] / TRUTH[j] - 1.0).abs() < 0.05), "{:?}", found.theta);
    }
}

#[test]
fn what_is_not_in_the_motion_does_not_belong() {
    let mut structure = structure();
    let mut parameters = parameters(0.2);
    parameters.push(FitParameter { name: "az_q".into(), start: 0.0, prior: None });
    structure.c[2][1].terms.push((6, 1.0));
    let found = fit(&structure, &parameters, &[], &two_runs(5), &FitSettings::default()).unwrap();
    assert_eq!(found.insignificant, [6], "F {:?}, cost {:?}", found.f_corrected, found.cost_rise);
    assert!(found.cost_rise[6] < 2.0);
}

#[test]
fn hopeless_data_are_refused_with_their_values() {
    let records = two_runs(9);
    let refused = |structure: &ModelStructure, parameters: &[FitParameter], records: &[InputOutputRecord]| {
        fit(structure, parameters, &[], records, &FitSettings::default()).unwrap_err()
    };
    let (model, unknown) = (structure(), parameters(0.2));
    let mut still = records.clone();
    still.iter_mut().for_each(|record| record.inputs[0].fill(0.02));
    let said = refused(&model, &unknown, &still).to_string();
    assert!(said.contains("elevator") && said.contains("0.02") && said.contains("M_elevator"), "{said}");
    let mut back = records.clone();
    back[1].times_s[7] = back[1].times_s[6];
    assert!(matches!(refused(&model, &unknown, &back), OutputErrorFitError::TimesNotIncreasing { run: 1, sample: 7, .. }));
    let mut holed = records.clone();
    holed[0].inputs[0][3] = f64::NAN;
    assert!(matches!(refused(&model, &unknown, &holed), OutputErrorFitError::NotFinite { run: 0, sample: 3, .. }));
    let mut blind = records.clone();
    blind.iter_mut().for_each(|record| record.outputs[1].fill(f64::NAN));
    assert_eq!(refused(&model, &unknown, &blind), OutputErrorFitError::NeverSampled { output: "q".into() });
    let mut dead = records.clone();
    dead.iter_mut().for_each(|record| record.outputs[2].fill(1.5));
    assert_eq!(refused(&model, &unknown, &dead), OutputErrorFitError::StillOutput { output: "az".into(), value: 1.5 });
    let short = |record: &InputOutputRecord| {
        let cut = |series: &Vec<Vec<f64>>| series.iter().map(|one| one[..3].to_vec()).collect();
        InputOutputRecord {
            times_s: record.times_s[..3].to_vec(),
            inputs: cut(&record.inputs),
            outputs: cut(&record.outputs),
            input_noise_std: Vec::new(),
        }
    };
    let shortened: Vec<InputOutputRecord> = records.iter().map(short).collect();
    assert!(matches!(refused(&model, &unknown, &shortened[..1]), OutputErrorFitError::TooFewSamples { values: 9, unknowns: 10 }));
    // A twin of a parameter: nothing tells the two apart.
    let (mut twins, mut doubled) = (model.clone(), unknown.clone());
    doubled.push(FitParameter { name: "M_q_again".into(), start: 0.0, prior: None });
    twins.a[1][1].terms.push((6, 1.0));
    let OutputErrorFitError::Singular { names, .. } = refused(&twins, &doubled, &records) else { panic!("singular") };
    assert_eq!(names, ["M_q", "M_q_again"]);
    // A model that runs away.
    let mut wild = unknown.clone();
    wild[3].start = 1e4;
    assert_eq!(refused(&model, &wild, &records), OutputErrorFitError::Diverges { run: 0 });
}
