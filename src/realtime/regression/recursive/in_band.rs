//! The equations estimated in the frequency band alone, with terms selected there: a record after its flight.
//!
//! Consumes the transforms of all excited instants; produces a [`DerivativesRecord`] of the same form as that over time. Primary
//! terms enter whatever their F; then, one a step, the term with the largest F on its standard error in the band, while that is
//! above `f_enter`, and terms leave that fall below `f_remove`, to stay out. With K of `transforms` (4),
//!     samples = 2 (sum_i K_ii)^2/sum_ij |K_ij|^2                                                       (1)
//! real numbers in the band are independent of each other; R2 and the total F are of the response in the band.
//! A standard deviation of the residual is that of its part in the band, sqrt(2 S (to - from)).
//! Refused: an equation with fewer such numbers than twice its terms.

use crate::flight::derivative::{AXES, Axis};
use crate::num::eigen::condition_index;
use crate::realtime::estimation::record::Instrumentation;
use crate::realtime::regression::candidate;
use crate::realtime::regression::candidate::{BIAS, REGRESSORS, regressor};
use crate::realtime::regression::frequency::estimate::{InFull, Shared};
use crate::realtime::regression::record::{
    DerivativesRecord, EquationRecord, LATERAL, LateralDerivatives, Reason, Status, TermRecord,
};
use crate::realtime::regression::recursive::Recursive;
use crate::realtime::regression::stepwise::Offer;
use heapless::Vec;

type Order = Vec<usize, REGRESSORS>;

impl Recursive {
    /// All equations from the band, as they stand.
    pub fn in_band(&self, time_s: f64, instruments: &Instrumentation) -> DerivativesRecord {
        let mut fits: [Option<InFull>; AXES] = [const { None }; AXES];
        let shared = Shared::new(&self.transforms, &[true; REGRESSORS]);
        let samples = self.independent();
        let equations = Axis::ALL.map(|axis| {
            if let Some(reason) = self.refusal(axis, instruments) {
                return EquationRecord::empty(axis, Status::NotIdentifiable(reason));
            }
            if let Some(status) = self.too_short(axis) {
                return EquationRecord::empty(axis, status);
            }
            let offer = match self.offer(axis, instruments) {
                Ok(offer) => offer,
                Err(reason) => return EquationRecord::empty(axis, Status::NotIdentifiable(reason)),
            };
            let order = self.selected(&shared, axis, &offer, samples);
            let Some(fit) = shared.fit_in_full(&self.transforms, axis, &order) else {
                let condition_index = condition_index(shared.gram(), &order);
                return EquationRecord::empty(axis, Status::NotIdentifiable(Reason::Collinear { condition_index }));
            };
            let equation = self.equation_record(axis, &fit, &order, &offer, samples, &shared);
            fits[axis.index()] = Some(fit);
            equation
        });
        let lateral = self.lateral_in_band(&fits, &equations);
        DerivativesRecord { time_s, equations, lateral, excited: self.excited }
    }

    /// (1).
    fn independent(&self) -> f64 {
        let count = self.transforms.band().count();
        let (mut trace, mut squares) = (0.0, 0.0);
        for i in 0..count {
            trace += self.transforms.kept_difference(i, i).re;
            squares += (0..count).map(|j| self.transforms.kept_difference(i, j).norm_sqr()).sum::<f64>();
        }
        if squares > 0.0 { 2.0 * trace * trace / squares } else { 0.0 }
    }

    fn selected(&self, shared: &Shared, axis: Axis, offer: &Offer, samples: f64) -> Order {
        let mut order = Order::new();
        let mut out = [false; REGRESSORS];
        let offered = |flags: &[bool; REGRESSORS]| (0..REGRESSORS).filter(|&place| flags[place]).collect::<Order>();
        let _ = order.push(BIAS);
        for place in offered(&offer.primary) {
            // Terms that are collinear in the band do not all enter.
            if shared.fit(&self.transforms, axis, &with(&order, place)).is_some() {
                let _ = order.push(place);
            }
        }
        loop {
            let room = 2.0 * (order.len() as f64 + 1.0) < samples;
            let candidates = offered(&offer.optional);
            let open = candidates.iter().copied().filter(|place| room && !out[*place] && !order.contains(place));
            let strengths = open.filter_map(|place| Some((place, self.strength(shared, axis, &with(&order, place), place)?)));
            let best = strengths.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, f)| *f > self.config.f_enter);
            let Some((best, _)) = best else { return order };
            let _ = order.push(best);
            loop {
                let inside = order.iter().copied().filter(|&place| place != BIAS && !offer.primary[place]);
                let strengths = inside.filter_map(|place| Some((place, self.strength(shared, axis, &order, place)?)));
                let worst = strengths.min_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, f)| *f < self.config.f_remove);
                let Some((worst, _)) = worst else { break };
                out[worst] = true;
                order.retain(|&place| place != worst);
            }
        }
    }

    /// Partial F of a term among those.
    fn strength(&self, shared: &Shared, axis: Axis, order: &[usize], place: usize) -> Option<f64> {
        let fit = shared.fit(&self.transforms, axis, order)?;
        let ratio = fit.theta[place] / fit.std[place];
        Some(ratio * ratio).filter(|f| f.is_finite())
    }

    fn equation_record(
        &self,
        axis: Axis,
        fit: &InFull,
        order: &Order,
        offer: &Offer,
        samples: f64,
        shared: &Shared,
    ) -> EquationRecord {
        let mut equation = EquationRecord::empty(axis, Status::Converged);
        let parameters = order.len() as f64;
        let band = self.transforms.band();
        equation.r_squared = 1.0 - fit.unexplained;
        equation.f_total = (1.0 - fit.unexplained) / (parameters - 1.0) * (samples - parameters) / fit.unexplained;
        equation.samples = samples;
        equation.residual_std = libm::sqrt(2.0 * fit.intensity * (band.to_hz - band.from_hz));
        equation.condition_index = condition_index(shared.gram(), order);
        for (step, &place) in order.iter().enumerate() {
            let (value, std) = (fit.estimate.theta[place], fit.estimate.std[place]);
            let variable = candidate::variable(place);
            let primary = offer.primary[place];
            if primary && !(std < self.config.known_relative * value.abs()) {
                equation.status = Status::Converging;
            }
            let term = TermRecord { variable, value, std, std_white: std, step: step as u8, primary, frequency: None };
            let _ = equation.terms.push(term);
        }
        if samples < 2.0 * parameters {
            return EquationRecord::empty(axis, Status::Exciting);
        }
        equation
    }

    /// The lateral derivatives; errors of different equations are taken as independent.
    fn lateral_in_band(&self, fits: &[Option<InFull>; AXES], equations: &[EquationRecord; AXES]) -> Option<LateralDerivatives> {
        let trim = self.trim.as_ref()?;
        if LateralDerivatives::NEEDED.iter().any(|&(axis, variable)| equations[axis.index()].term(variable).is_none()) {
            return None;
        }
        debug_assert!(LateralDerivatives::NAMES.iter().all(|(axis, _)| axis.is_lateral()));
        let (mut values, mut cov) = ([0.0; LATERAL], [[0.0; LATERAL]; LATERAL]);
        for (i, (axis, variable)) in LateralDerivatives::NAMES.into_iter().enumerate() {
            let fit = fits[axis.index()].as_ref()?;
            values[i] = fit.estimate.theta[regressor(variable)];
            for (j, (other, with)) in LateralDerivatives::NAMES.into_iter().enumerate() {
                if other == axis {
                    cov[i][j] = fit.cov[regressor(variable)][regressor(with)];
                }
            }
        }
        let [u0, _, w0] = trim.velocity;
        let [phi0, theta0] = trim.attitude;
        let trim_std = [trim.velocity_std[0], trim.velocity_std[2]];
        Some(LateralDerivatives { values, cov, u0, w0, trim_std, phi0, theta0 })
    }
}

fn with(order: &Order, place: usize) -> Order {
    let mut longer = order.clone();
    let _ = longer.push(place);
    longer
}
