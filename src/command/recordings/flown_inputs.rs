//! What `simulate` flies: the controls of a run, or test inputs, about a model's trim.

use super::run_controls::ControlHistory;
use crate::command::message;
use sideslip::error::Failure;
use sideslip::flight::channel::{Channel, ControlNames};
use sideslip::flight::control::Control;
use sideslip::flight::effect::Effect;
use sideslip::flight::model::LinearModel;
use sideslip::simulation::fly::Inputs;
use sideslip::simulation::input::InputSpec;
use sideslip::simulation::instrument::InstrumentSet;
use sideslip::simulation::level1::trim::MOST_PITCH;
use std::path::Path;

/// The run's controls; one that it lacks stays at the model's trim, and it is said.
pub(crate) fn inputs_of_run(path: &Path, run: ControlHistory, model: &LinearModel) -> Inputs {
    let mut inputs = Inputs::at_trim(model);
    for ((control, place), history) in Control::ALL.into_iter().zip(&mut inputs.controls).zip(run.controls) {
        match history {
            Some(history) => *place = history,
            None => {
                let name = control.name(ControlNames::Rotorcraft);
                message(format_args!("note: {} has no `{name}`; it stays at the model's trim", path.display()));
            }
        }
    }
    inputs.rotor_speed = run.rotor_speed.filter(|_| model.trim.rotor_speed.is_some());
    inputs
}

/// Test inputs, the first after the lead unless it has its own start, by a hand of that rate, rad/s.
pub(crate) fn inputs_of_specs(specs: &[InputSpec], lead_s: f64, hand_rate: f64, model: &LinearModel) -> Result<Inputs, Failure> {
    let mut inputs = Inputs::at_trim(model);
    for spec in specs {
        let deviation = spec.deviation_by_hand(lead_s, hand_rate);
        let reached = deviation.points().iter().map(|(_, value)| libm::fabs(*value)).fold(0.0, f64::max);
        if reached < 0.999 * libm::fabs(spec.amplitude) {
            message(format_args!("note: {spec}: the hand reaches {reached:.4} only (see --hand-rate)"));
        }
        if spec.channel == Channel::RotorSpeed {
            let at_trim = model.trim.rotor_speed.ok_or_else(|| {
                Failure::Input(format!("--input: {spec}: an input of rotor speed needs `rotor_speed` in the model's [trim]"))
            })?;
            inputs.rotor_speed = Some(match inputs.rotor_speed.take() {
                None => deviation.clone().shifted(at_trim),
                Some(earlier) => earlier.plus(1.0, &deviation),
            });
        }
        for (control, history) in Control::ALL.into_iter().zip(&mut inputs.controls) {
            if control.channel() == spec.channel {
                *history = history.plus(1.0, &deviation);
            }
        }
    }
    Ok(inputs)
}

/// Says so where the rotor speed matters and nothing moves it.
pub(crate) fn warn_of_still_rotor(effects: &[Effect], model: &LinearModel, inputs: &Inputs) {
    let matters = model.rotor_speed.iter().any(|&derivative| derivative != 0.0)
        || effects.iter().any(|effect| matches!(effect, Effect::RotorSpeed { .. }));
    if matters && inputs.rotor_speed.is_none() {
        message(format_args!(
            "note: the rotor speed stays at trim, so its effect does nothing (fly --input rotor_speed:... or a run that has it)"
        ));
    }
}

/// Says so where an effect is on an instrument that the run does not have.
pub(crate) fn warn_of_unread_channels(effects: &[Effect], instruments: &InstrumentSet) {
    for effect in effects {
        let Some(channel) = effect.sensor_channel() else { continue };
        if !instruments.channels.iter().any(|instrument| instrument.channel == channel) {
            let name = channel.name(ControlNames::Rotorcraft);
            message(format_args!(
                "note: the effect `{}` on `{name}` does nothing: the run has no such channel (an instruments file with \
                 [channel.{name}] gives it)",
                effect.kind().name()
            ));
        }
    }
}

/// Says so where a blade is taken beyond what the equations of a Level-1 rotor hold for.
pub(crate) fn warn_of_stall(inputs: &Inputs) {
    for (control, history) in Control::ALL.into_iter().zip(&inputs.controls) {
        let most = history.points().iter().map(|(_, value)| libm::fabs(*value)).fold(0.0, f64::max);
        if most > MOST_PITCH {
            let name = control.name(ControlNames::Rotorcraft);
            message(format_args!(
                "note: {name} goes to {most:.2} rad; beyond {MOST_PITCH} rad blades stall, which the model does not know"
            ));
        }
    }
}
