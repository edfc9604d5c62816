//! Several test points: each identified by itself, beside the simulation trimmed there, with the effective damping of both.
//!
//! Consumes runs by test point; produces for each the derivatives as recorded, those with the measured tail pitch in place of
//! the pedal, static derivatives of steady sideslips, the simulation's, and from a fit without N_p and L_r the N_p that (27) and
//! (29) of `effective_damping` derive, with the roots of the lateral subsystem that follows.

use super::refusals::not_identified;
use sideslip::dynamics::linear::state_matrix;
use sideslip::error::Failure;
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::flight::model::LinearModel;
use sideslip::postflight::identification::columns::Columns;
use sideslip::postflight::identification::effective_damping::{EffectiveDamping, with_std};
use sideslip::postflight::identification::identify::{IdentificationRequest, IdentificationResult, identify};
use sideslip::postflight::identification::nondimensional::{NondimensionalDerivatives, nondimensional};
use sideslip::postflight::identification::steady_sideslip::{SteadySideslips, steady_sideslips};
use sideslip::postflight::identification::test_condition::TestCondition;
use sideslip::postflight::output_error::FitSettings;
use sideslip::realtime::modes::lateral;
use sideslip::realtime::modes::naming::eigenmodes;
use sideslip::realtime::regression::record::{LateralDerivatives, Status};

/// A value with its standard error.
pub(super) type ValueAndStd = (f64, f64);

/// A complex root, real and imaginary part.
pub(super) type ComplexRoot = (f64, f64);

/// What the runs of one test point say.
pub(super) struct TestPointResult {
    pub(super) condition: TestCondition,
    pub(super) identified: IdentificationResult,
    /// With the measured tail pitch in place of the pedal, where every run has it.
    pub(super) by_tail_pitch: Option<IdentificationResult>,
    pub(super) simulation: Option<SimulatedModes>,
    /// N_v and L_v of steady sideslips, or why there are none; `None` where none were given.
    pub(super) static_derivatives: Option<Result<StaticDerivatives, String>>,
    pub(super) explained: Option<LateralDampingAnalysis>,
    /// Where its runs state reference dimensions.
    pub(super) nondimensional: Option<NondimensionalDerivatives>,
}

/// The simulation in this flight.
pub(super) struct SimulatedModes {
    pub(super) name: String,
    pub(super) model: LinearModel,
    /// Dutch roll of the lateral subsystem and of the whole aircraft.
    pub(super) lateral: Option<ComplexRoot>,
    pub(super) whole: Option<ComplexRoot>,
}

pub(super) struct StaticDerivatives {
    pub(super) sideslips: SteadySideslips,
    pub(super) controls: Vec<String>,
    pub(super) n_v: ValueAndStd,
    pub(super) l_v: ValueAndStd,
}

/// Section 4's argument at this test point.
pub(super) struct LateralDampingAnalysis {
    /// N_r of a fit without N_p and L_r.
    pub(super) n_r_effective: ValueAndStd,
    /// (25) and (26) with the derivatives of the whole fit, and twice the real part of its Dutch roll.
    pub(super) by_25: f64,
    pub(super) by_26: f64,
    pub(super) twice_real: Option<f64>,
    /// (27) and (29); `None` without a simulation, whose N_r they take.
    pub(super) n_p: Option<[ValueAndStd; 2]>,
    /// Dutch roll of the simulation's lateral subsystem with L_v, L_p, N_v of the fit and these N_p.
    pub(super) roots: [Option<ComplexRoot>; 2],
}

impl SimulatedModes {
    pub(super) fn of(name: String, model: LinearModel) -> Self {
        let whole = eigenmodes(&state_matrix(&model)).and_then(|modes| modes.dutch_roll).map(|root| (root.re, root.im));
        SimulatedModes { name, lateral: lateral_root(&model), whole, model }
    }

    /// Its derivative by the name that the identified model has for it; tail pitch is what the model's pedal moves.
    pub(super) fn derivative(&self, identified: &IdentificationResult, axis: char, variable: &str) -> Option<f64> {
        let speed = identified.linear.reference_trim.airspeed;
        let (variable, column) = match variable {
            "beta" => (Variable::V, speed),
            "alpha" => (Variable::W, speed),
            "tail_pitch" => (Variable::Pedal, 1.0),
            own => (Variable::from_name(own)?, 1.0),
        };
        let axis = Axis::from_name(&axis.to_string())?;
        Some(self.model.derivative(axis, variable) * column / row(identified, axis))
    }
}

fn lateral_root(model: &LinearModel) -> Option<ComplexRoot> {
    let modes = lateral::modes(0.0, Status::Converged, &LateralDerivatives::of(model))?;
    modes.dutch_roll.map(|pair| (pair.real, pair.imag))
}

/// What a force's row is over: airspeed where its state is a flow angle.
fn row(identified: &IdentificationResult, axis: Axis) -> f64 {
    let is_angle = |name: &str| identified.linear.choice.states.iter().any(|state| state == name);
    match axis {
        Axis::Y if is_angle("beta") => identified.linear.reference_trim.airspeed,
        Axis::Z if is_angle("alpha") => identified.linear.reference_trim.airspeed,
        _ => 1.0,
    }
}

/// Place of a derivative among the parameters, and what makes it one over v in m/s.
fn place(identified: &IdentificationResult, axis: Axis, variable: Variable) -> Option<(usize, f64)> {
    let wanted = |name: &str| match name {
        "beta" => variable == Variable::V,
        own => Variable::from_name(own) == Some(variable),
    };
    let named = |(own, name): &(char, String)| axis.name() == own.to_string() && wanted(name);
    let found = identified.linear.derivatives.iter().position(named)?;
    let over_beta = identified.linear.derivatives.get(found).is_some_and(|(_, name)| name == "beta");
    let column = if over_beta { 1.0 / identified.linear.reference_trim.airspeed } else { 1.0 };
    Some((found, row(identified, axis) * column))
}

/// Its value, over v in m/s; zero where it is not in the model.
fn value(identified: &IdentificationResult, axis: Axis, variable: Variable) -> f64 {
    let of = |(place, factor): (usize, f64)| identified.fitted.theta.get(place).map_or(0.0, |value| value * factor);
    place(identified, axis, variable).map_or(0.0, of)
}

fn damping(identified: &IdentificationResult) -> EffectiveDamping {
    let at = |axis, variable| value(identified, axis, variable);
    EffectiveDamping {
        y_v: at(Axis::Y, Variable::V),
        l_v: at(Axis::L, Variable::V),
        l_p: at(Axis::L, Variable::P),
        l_r: at(Axis::L, Variable::R),
        n_p: at(Axis::N, Variable::P),
        n_r: at(Axis::N, Variable::R),
        speed: identified.linear.reference_trim.airspeed,
    }
}

pub(super) fn test_point(
    (runs, holdout, sideslips): (&[Columns], &[Columns], &[&Columns]),
    wanted: &IdentificationRequest,
    simulation: Option<SimulatedModes>,
    settings: &FitSettings,
) -> Result<TestPointResult, Failure> {
    let identified = identify(runs, holdout, wanted.clone(), settings).map_err(not_identified)?;
    let conditions: Vec<TestCondition> = runs.iter().map(TestCondition::of).collect();
    let has_tail = runs.iter().all(|run| run.has("tail_pitch"));
    let pedals = |name: &String| matches!(name.as_str(), "pedal" | "rudder");
    let by_tail_pitch = if has_tail && wanted.choice.inputs.iter().any(pedals) {
        let mut other = wanted.clone();
        let only = other.only.iter_mut().flatten().map(|(_, variable)| variable);
        other.choice.inputs.iter_mut().chain(only).filter(|name| pedals(name)).for_each(|name| "tail_pitch".clone_into(name));
        Some(identify(runs, &[], other, settings).map_err(not_identified)?)
    } else {
        None
    };
    let explained = explained(runs, wanted, &identified, simulation.as_ref());
    let static_derivatives = (!sideslips.is_empty()).then(|| of_sideslips(sideslips, &identified));
    Ok(TestPointResult {
        condition: TestCondition::mean(&conditions),
        nondimensional: nondimensional(&identified, runs),
        identified,
        by_tail_pitch,
        simulation,
        static_derivatives,
        explained,
    })
}

/// (2) of `steady_sideslip` with the control derivatives that were identified.
fn of_sideslips(runs: &[&Columns], identified: &IdentificationResult) -> Result<StaticDerivatives, String> {
    let is_control = |name: &&String| Variable::CONTROLS.iter().any(|control| Variable::from_name(name) == Some(*control));
    let controls: Vec<String> = identified.linear.choice.inputs.iter().filter(is_control).cloned().collect();
    let sideslips = steady_sideslips(runs, &controls)?;
    let of = |axis: Axis| -> Result<ValueAndStd, String> {
        let places = controls.iter().map(|name| {
            Variable::from_name(name)
                .and_then(|variable| place(identified, axis, variable))
                .map(|(place, _)| place)
                .ok_or_else(|| format!("expected {}_{name} among the derivatives", axis.name()))
        });
        let places = places.collect::<Result<Vec<_>, _>>()?;
        let power: Vec<f64> = places.iter().filter_map(|&place| identified.fitted.theta.get(place).copied()).collect();
        let at = |i: usize| places.get(i).copied().unwrap_or_default();
        Ok(sideslips.derivative(&power, |i, j| identified.fitted.cov[(at(i), at(j))]))
    };
    let (n_v, l_v) = (of(Axis::N)?, of(Axis::L)?);
    Ok(StaticDerivatives { sideslips, controls, n_v, l_v })
}

/// The argument of section 4; `None` where the model is none of v p phi r, or the smaller one cannot be fitted.
fn explained(
    runs: &[Columns],
    wanted: &IdentificationRequest,
    identified: &IdentificationResult,
    simulation: Option<&SimulatedModes>,
) -> Option<LateralDampingAnalysis> {
    let lateral = [(Axis::N, Variable::V), (Axis::N, Variable::P), (Axis::L, Variable::P), (Axis::L, Variable::R)];
    if lateral.iter().any(|(axis, variable)| place(identified, *axis, *variable).is_none()) {
        return None;
    }
    let kept = |(axis, name): &(char, String)| !matches!((axis, name.as_str()), ('N', "p") | ('L', "r"));
    let only: Vec<_> = identified.linear.derivatives.iter().filter(|one| kept(one)).cloned().collect();
    let smaller = IdentificationRequest { only: Some(only), ..wanted.clone() };
    let reduced = identify(runs, &[], smaller, &FitSettings::default()).ok()?;
    let places = [(Axis::N, Variable::R), (Axis::L, Variable::V), (Axis::L, Variable::P)];
    let [n_r, l_v, l_p] = places.map(|(axis, variable)| place(&reduced, axis, variable));
    let places = [n_r?, l_v?, l_p?];
    let at = places.map(|(place, factor)| reduced.fitted.theta.get(place).map_or(f64::NAN, |value| value * factor));
    let cov = |i: usize, j: usize| match (places.get(i), places.get(j)) {
        (Some((i, fi)), Some((j, fj))) => reduced.fitted.cov[(*i, *j)] * fi * fj,
        _ => 0.0,
    };
    let n_r_effective = with_std(at, cov, |[n_r, ..]| n_r);
    let whole = damping(identified);
    let pair = identified.modes.as_ref().ok().and_then(|roots| roots.iter().find(|root| root.name == Some("dutch_roll")));
    let small = reduced.modes.as_ref().ok().and_then(|roots| roots.iter().find(|root| root.name == Some("dutch_roll")));
    let with = |simulation: &SimulatedModes, [_, l_v, l_p]: [f64; 3]| {
        let of = |axis, variable| simulation.model.derivative(axis, variable);
        EffectiveDamping {
            y_v: of(Axis::Y, Variable::V),
            l_v,
            l_p,
            l_r: of(Axis::L, Variable::R),
            n_p: 0.0,
            n_r: of(Axis::N, Variable::R),
            ..whole
        }
    };
    let n_p = simulation.map(|simulation| {
        let by_27 = with_std(at, cov, |at| with(simulation, at).n_p_of(at[0]));
        let by_29 = small.map_or((f64::NAN, f64::NAN), |small| {
            with_std(at, cov, |at| with(simulation, at).n_p_of_root(small.real, small.omega))
        });
        [by_27, by_29]
    });
    let root = |n_p: f64| {
        let mut model = simulation?.model.clone();
        let flight = [(Axis::L, Variable::V), (Axis::L, Variable::P), (Axis::N, Variable::V)];
        for (axis, variable) in flight {
            *model.derivative_mut(axis, variable) = value(&reduced, axis, variable);
        }
        *model.derivative_mut(Axis::N, Variable::P) = n_p;
        lateral_root(&model)
    };
    Some(LateralDampingAnalysis {
        n_r_effective,
        by_25: whole.effective(),
        by_26: whole.effective_by_dihedral(),
        twice_real: pair.map(|pair| 2.0 * pair.real),
        roots: n_p.map_or([None; 2], |n_p| n_p.map(|(n_p, _)| root(n_p))),
        n_p,
    })
}
