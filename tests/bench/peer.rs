//! The crate `adskalman` with as many states and measurements: a linear model that stays as it is, all matrices ready.
//!
//! Transition and rows of H are the textbook's about one state of the flight; the readings are deviations from what that
//! state predicts. So it computes no sine, no Jacobian and no rejection, which ours does.

use crate::textbook::{M, N, Readings, Rows, Square, State, Textbook, h, process_noise, transition};
use adskalman::{KalmanFilterNoControl, ObservationModel, StateAndCovariance, TransitionModelLinearNoControl};
use nalgebra::{SMatrix, U13, U25};

pub(crate) type Estimate = StateAndCovariance<f64, U25>;

struct Motion {
    f: Square,
    ft: Square,
    q: Square,
}

impl TransitionModelLinearNoControl<f64, U25> for Motion {
    fn F(&self) -> &Square {
        &self.f
    }
    fn FT(&self) -> &Square {
        &self.ft
    }
    fn Q(&self) -> &Square {
        &self.q
    }
}

struct Instruments {
    h: Rows,
    ht: SMatrix<f64, N, M>,
    r: SMatrix<f64, M, M>,
}

impl ObservationModel<f64, U25, U13> for Instruments {
    fn H(&self) -> &Rows {
        &self.h
    }
    fn HT(&self) -> &SMatrix<f64, N, M> {
        &self.ht
    }
    fn R(&self) -> &SMatrix<f64, M, M> {
        &self.r
    }
}

/// The peer's models.
pub(crate) struct Peer {
    motion: Motion,
    instruments: Instruments,
    /// What the state of linearisation reads.
    pub(crate) reading: Readings,
    /// Where it starts: no deviation.
    pub(crate) start: Estimate,
}

impl Peer {
    /// Linearised where the textbook filter stands.
    pub(crate) fn about(textbook: &Textbook, dt: f64) -> Self {
        let f = transition(&textbook.x, dt);
        let (reading, rows) = h(&textbook.x);
        let q = process_noise(&textbook.intensity, dt) + Square::from_diagonal(&(textbook.walk_var * dt));
        Peer {
            motion: Motion { f, ft: f.transpose(), q },
            instruments: Instruments { h: rows, ht: rows.transpose(), r: SMatrix::from_diagonal(&textbook.r) },
            reading,
            start: Estimate::new(State::zeros(), textbook.p),
        }
    }

    /// The crate's filter.
    pub(crate) fn filter(&self) -> KalmanFilterNoControl<'_, f64, U25, U13> {
        KalmanFilterNoControl::new(&self.motion, &self.instruments)
    }

    /// F, H and Q, for whoever computes the same by other means.
    pub(crate) fn matrices(&self) -> (&Square, &Rows, &Square) {
        (&self.motion.f, &self.instruments.h, &self.motion.q)
    }
}
