//! The unknowns of one run: its initial state, and biases of its state equations and outputs.

use super::discrete::UnknownLayout;

/// One run's own values; 0 where the structure leaves them none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RunParameters {
    /// x(0), by state.
    pub initial_state: Vec<f64>,
    /// b, by state.
    pub state_bias: Vec<f64>,
    /// c, by output.
    pub output_bias: Vec<f64>,
}

impl RunParameters {
    /// All zero.
    pub fn zero(layout: &UnknownLayout) -> Self {
        RunParameters {
            initial_state: vec![0.0; layout.states],
            state_bias: vec![0.0; layout.states],
            output_bias: vec![0.0; layout.outputs],
        }
    }

    /// Moved by the free ones' steps in the order x0, b, c.
    pub(crate) fn moved(&self, layout: &UnknownLayout, step: &[f64]) -> RunParameters {
        let mut run_parameters = self.clone();
        let mut steps = step.iter();
        for (values, places) in [
            (&mut run_parameters.initial_state, &layout.initial),
            (&mut run_parameters.state_bias, &layout.state_bias),
            (&mut run_parameters.output_bias, &layout.output_bias),
        ] {
            for (&place, step) in places.iter().zip(&mut steps) {
                if let Some(value) = values.get_mut(place) {
                    *value += step;
                }
            }
        }
        run_parameters
    }
}
