//! Time to an answer: how long after the first input the live regression has its first number of N_v, N_r and L_p within 20 % of
//! the truth, and when the equation is first `converged`.
//!
//! The published Puma's linear model at 100 kn in still air: 3211 of pedal, then of lateral cyclic; doublets of both.

use super::sheet::Sheet;
use crate::support::asked::seeds;
use crate::support::manoeuvre::{INPUTS, LEAD_S, fly, over_seeds};
use crate::support::puma::puma_100kn;
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::flight::run::RunGeometry;
use sideslip::realtime::pipeline::{Pipeline, PipelineConfig};
use sideslip::realtime::regression::record::Status;
use sideslip::simulation::instrument::InstrumentSet;

const ASKED: [(&str, Axis, Variable); 3] =
    [("N_v", Axis::N, Variable::V), ("N_r", Axis::N, Variable::R), ("L_p", Axis::L, Variable::P)];
const WITHIN: f64 = 0.2;
const FLOWN: [(&str, [&str; 2]); 2] =
    [("3211", INPUTS), ("doublets", ["pedal:doublet:0.02:0.8", "lat_cyclic:doublet:0.01:0.8:8"])];

/// First number within [`WITHIN`], and first one that is converged, s after the first input, infinite where there is none; how
/// far the latter is from the truth, standard errors.
type Times = [f64; 3];

#[test]
fn time_to_the_first_number_and_to_convergence() {
    let Some(model) = puma_100kn() else { return };
    let (instruments, count) = (InstrumentSet::flight_quality(1.0), seeds(8));
    let geometry = RunGeometry {
        accelerometer_position_m: instruments.accelerometer_position_m,
        vane_position_m: instruments.vane_position_m,
        ..RunGeometry::default()
    };
    let mut sheet = Sheet::new(
        "time-to-answer",
        &["inputs", "derivative", "seeds", "first_median_s", "converged_median_s", "z_rms_converged", "never"],
    );
    for (inputs_name, inputs) in FLOWN {
        let all: Vec<[Times; 3]> = over_seeds(count, |seed| {
            let mut pipeline = Box::new(Pipeline::new(&PipelineConfig::default(), geometry).unwrap());
            let mut found = [[f64::INFINITY; 3]; 3];
            for sample in &fly(&model, &inputs, &instruments, seed).samples {
                let Some(derivatives) = &pipeline.step(sample).derivatives else { continue };
                let now_s = sample.time_s - LEAD_S;
                for ((_, axis, variable), [first, converged, z]) in ASKED.into_iter().zip(&mut found) {
                    let equation = &derivatives.equations[axis.index()];
                    let Some(term) = equation.term(variable) else { continue };
                    if (term.value / model.derivative(axis, variable) - 1.0).abs() < WITHIN {
                        *first = first.min(now_s);
                    }
                    if equation.status == Status::Converged && converged.is_infinite() {
                        *converged = now_s;
                        *z = (term.value - model.derivative(axis, variable)) / term.std;
                    }
                }
            }
            found
        });
        for (k, (name, ..)) in ASKED.into_iter().enumerate() {
            let median = |which: usize| {
                let mut times: Vec<f64> = all.iter().map(|one| one[k][which]).collect();
                times.sort_by(f64::total_cmp);
                times[times.len() / 2]
            };
            let never = all.iter().filter(|one| one[k][1].is_infinite()).count();
            let (first, converged) = (median(0), median(1));
            let of_converged: Vec<f64> = all.iter().map(|one| one[k][2]).filter(|z| z.is_finite()).collect();
            let z = (of_converged.iter().map(|z| z * z).sum::<f64>() / of_converged.len() as f64).sqrt();
            sheet.row(&[inputs_name, name], &[count as f64, first, converged, z, never as f64]);
            eprintln!(
                "{inputs_name}, {name}: first number after {first:.2} s, converged after {converged:.2} s, then {z:.2} standard errors \
                 off (rms), never {never} of {count}"
            );
            assert!(first < 6.0 && converged < 12.5, "{name}: first after {first} s, converged after {converged} s");
            assert!(10 * never as u64 <= count, "{name}: never {never} of {count}");
        }
    }
    sheet.write();
}
