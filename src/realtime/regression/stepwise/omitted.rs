//! What the terms that were left out of an equation may hide, and what noise hides of the motions of a plane without an input.
//!
//! Consumes a selection and its fit; produces the fit with that added to its covariance Sigma:
//!     Sigma <- Sigma + sum_j d_j d_j',  d_j = (theta_j/rho_j) (X'X)^-1 X'x_j, over the j left out   (1)
//!     rho_j = 1 - W (n_j + sum_i b_i^2 n_i)/|x_j - sum_i b_i x_i|^2                                 (2)
//!     Sigma <- Sigma + d d',  d = theta_all - theta,  theta_all with all that were left out in      (3)
//!     Sigma <- Sigma + sum_j e_j e_j',  e_j = theta_j (1/rho_j - 1) D_j/D_jj of that equation       (4)
//! Standard errors conditional on the selection, as if the terms out were known to be zero, can be ten times too small. (1)
//! restores those of the full equation, in the mean, where the terms out are zero. rho_j is the reliability of what term j has
//! beyond its regression b on the others: the part of it that is motion, not noise of the variances n. The noise makes the
//! estimate of j, and its standard error, too small by it; in (1) it is 1 for motions of the other plane. What several terms hide
//! together (3) may be more than what each does: of a roll rate that follows v, r and q neither q nor w alone corrects the
//! estimate. (4), of a plane that no input moved: there the roll rate may be a combination of all the others but for its noise;
//! its estimate is then near zero with all of them in, and the others have what it does. D is (X'X)^-1, D_j its column j.
//! Source: (1) after S. T. Buckland, K. P. Burnham and N. H. Augustin, Biometrics 53, 1997 (uncertainty of the model itself); (2)
//! and (4): W. A. Fuller, Measurement Error Models, 1987, (1.1.11), of the partial regression; (3) after J. A. Hausman,
//! Econometrica 46, 1978, the contrast of a selected with a consistent estimate.

use super::{Fit, Offer, PIVOT_MIN, PIVOT_SECOND, SweptSelection};
use crate::realtime::regression::candidate::REGRESSORS;

/// Part of its squares that a term of the equation's own plane has beyond those in, below which its own estimate says nothing:
/// the rate of a fast roll mode follows v, r and the controls, and what is left of it is as much the filter's error and the
/// gusts' as its own. With 0.1 one of 108 flights of such aircraft in still air has numbers beyond four standard errors, with
/// 0.25 none.
const OWN_MIN: f64 = 0.25;

/// F of an estimate that is as good as zero.
const F_MIN: f64 = 1e-6;

impl SweptSelection<'_> {
    /// The fit with (1) to (4); the selection ends with all terms in.
    pub(super) fn add_omitted(&mut self, fit: &mut Fit, offer: &Offer) {
        for place in (0..REGRESSORS).filter(|&place| self.is_out(place, offer) && self.swept.at(place, place) > PIVOT_MIN) {
            let scaled_theta = self.swept.at(place, self.response) / self.swept.at(place, place) * self.scale[self.response];
            // An undetermined one may be what its standard error says, where that is larger than its estimate.
            let least_f = if offer.undetermined[place] { self.corrected_f_of_entry(place).clamp(F_MIN, 1.0) } else { 1.0 };
            let scaled_theta = scaled_theta / libm::sqrt(least_f);
            let scaled_theta = if offer.belongs[place] { self.unattenuated(scaled_theta, place, offer) } else { scaled_theta };
            fit.add_shift(|i| -scaled_theta * self.swept.at(i, place) / self.scale[i]);
        }
        self.enter_all(offer);
        let theta = fit.theta;
        fit.add_shift(|i| self.theta(i) - theta[i]);
        if offer.follows {
            let motions = (1..REGRESSORS).filter(|&place| offer.noise_vars[place] > 0.0 && self.swept.is_inside(place));
            motions.for_each(|place| self.add_attenuation(place, offer, fit));
        }
    }

    /// Whether the term was offered, or belongs to the equation, and is not in.
    fn is_out(&self, place: usize, offer: &Offer) -> bool {
        (offer.optional[place] || offer.undetermined[place]) && !self.swept.is_inside(place)
    }

    /// All terms enter but combinations of others.
    fn enter_all(&mut self, offer: &Offer) {
        for place in 0..REGRESSORS {
            if self.is_out(place, offer) && self.swept.at(place, place) > PIVOT_SECOND {
                let _ = self.enter(place);
            }
        }
    }

    /// What a motion of the equation's own plane that is left out may account for, given its own estimate, both in units of the
    /// response's root of squares: divided by (2). Of one that hardly differs from a combination of the terms in nothing is
    /// known, but that it does not account for more than there is.
    fn unattenuated(&self, scaled_theta: f64, place: usize, offer: &Offer) -> f64 {
        let own = self.swept.at(place, place);
        let of_others = self.order.iter().map(|&other| {
            let coefficient = self.swept.at(other, place) * self.scale[place] / self.scale[other];
            coefficient * coefficient * offer.noise_vars[other]
        });
        let noise: f64 = offer.noise_vars[place] + of_others.sum::<f64>();
        let reliability = 1.0 - self.information.weight() * noise / (own * self.scale[place] * self.scale[place]);
        let most = self.scale[self.response];
        let known = reliability > 0.0 && own >= OWN_MIN;
        if known { (scaled_theta / reliability).clamp(-most, most) } else { most }
    }

    /// (4) for one motion that is in. One that is all noise may account for the whole response.
    fn add_attenuation(&self, place: usize, offer: &Offer, fit: &mut Fit) {
        let dispersion = |i: usize| -self.swept.at(i, place) / (self.scale[i] * self.scale[place]);
        let own = dispersion(place);
        let per_unit = |i: usize| dispersion(i) / own;
        let noise: f64 = self.order.iter().map(|&i| per_unit(i) * per_unit(i) * offer.noise_vars[i]).sum();
        let reliability = 1.0 - self.information.weight() * noise * own;
        let most = self.scale[self.response] / self.scale[place];
        let theta = self.theta(place);
        let hidden = if reliability > 0.0 { (theta / reliability - theta).clamp(-most, most) } else { most };
        fit.add_shift(|i| hidden * per_unit(i));
    }
}
