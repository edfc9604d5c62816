//! Whether output error and the regression give one answer: two estimates of one derivative from one flight, compared.
//!
//! In: the newest derivatives and modes of the regression, a fit of output error. Out: the term in which they differ most, and
//! the axes in which they differ by more than four combined standard errors sqrt(s1^2 + s2^2). Both rest on the same
//! samples, so their errors correlate positively where both are right, and the difference is smaller than that of independent
//! estimates. A difference beyond that shows that one of the two models does not hold (the regression's equation, output error's
//! linear model over the whole manoeuvre), and the data do not tell which. From two combined standard errors on, an estimate of
//! output error gets the standard error s1' that covers the difference d,
//!     s1'^2 + s2^2 = (d/2)^2.                                                                                            (1)

use crate::flight::channel::ControlNames;
use crate::flight::derivative::{AXES, Axis, Variable};
use crate::io::outputs::words::status_text::DerivativeLabel;
use crate::postflight::output_error::record::{OutputErrorProgress, OutputErrorRecord};
use crate::realtime::modes::record::{ModesRecord, OscillatoryMode, RealRoot};
use crate::realtime::regression::record::{DerivativesRecord, Reason, Status};
use core::fmt::{self, Display, Formatter};

/// Combined standard errors by which regression and output error may differ and still agree: the largest of some fifty
/// differences is beyond it once in 300 fits where the errors are independent and normal.
const AGREE_WITHIN: f64 = 4.0;
/// Combined standard errors from which on the largest difference is remarked.
const REMARKED_FROM: f64 = 2.0;

/// What is compared.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Compared {
    Derivative(Axis, Variable),
    Omega,
    Zeta,
    Roll,
    Spiral,
}

/// How far output error and the regression are apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MethodAgreement {
    worst: Option<(Compared, f64)>,
    /// By axis, whether a derivative of it differs beyond what both standard errors allow; a lateral mode counts for Y, L and N.
    pub apart: [bool; AXES],
}

impl MethodAgreement {
    /// Nothing has been compared.
    const NONE: MethodAgreement = MethodAgreement { worst: None, apart: [false; AXES] };

    /// Compares what both have numbers of. Biases are left out: each model has its own.
    pub fn new(derivatives: Option<&DerivativesRecord>, modes: Option<&ModesRecord>, fit: &OutputErrorRecord) -> Self {
        let mut agreement = MethodAgreement::NONE;
        for equation in derivatives.iter().flat_map(|record| &record.equations) {
            if equation.status.rank() < Status::Stale.rank() {
                continue;
            }
            for term in &equation.terms {
                let Some(variable) = term.variable else { continue };
                let Some(other) = fit.parameter(equation.axis, variable) else { continue };
                let quantity = Compared::Derivative(equation.axis, variable);
                agreement.compare(quantity, (other.value, other.std), (term.value, term.std));
            }
        }
        let alone = |pair: &OscillatoryMode| [(pair.omega, pair.std_omega), (pair.zeta, pair.std_zeta)];
        if let Some((fitted, regressed)) = fit.dutch_roll.as_ref().zip(modes.and_then(|modes| modes.dutch_roll.as_ref())) {
            let [omega, zeta] = alone(fitted);
            let [regressed_omega, regressed_zeta] = alone(regressed);
            agreement.compare(Compared::Omega, omega, regressed_omega);
            agreement.compare(Compared::Zeta, zeta, regressed_zeta);
        }
        let roots = [
            (Compared::Roll, fit.roll, modes.and_then(|modes| modes.roll)),
            (Compared::Spiral, fit.spiral, modes.and_then(|modes| modes.spiral)),
        ];
        for (quantity, fitted, regressed) in roots {
            if let Some((fitted, regressed)) = fitted.zip(regressed) {
                agreement.compare(quantity, (fitted.value, fitted.std), (regressed.value, regressed.std));
            }
        }
        agreement
    }

    fn compare(&mut self, quantity: Compared, fitted: (f64, f64), regressed: (f64, f64)) {
        let standard_errors = (fitted.0 - regressed.0) / libm::hypot(fitted.1, regressed.1);
        if !standard_errors.is_finite() {
            return;
        }
        if self.worst.is_none_or(|(_, before)| standard_errors.abs() > before.abs()) {
            self.worst = Some((quantity, standard_errors));
        }
        if standard_errors.abs() > AGREE_WITHIN {
            match quantity {
                Compared::Derivative(axis, _) => self.apart[axis.index()] = true,
                Compared::Omega | Compared::Zeta | Compared::Roll | Compared::Spiral => {
                    [Axis::Y, Axis::L, Axis::N].into_iter().for_each(|axis| self.apart[axis.index()] = true)
                }
            }
        }
    }

    /// Whether any difference is beyond what both standard errors allow.
    pub fn is_apart(&self) -> bool {
        self.apart.contains(&true)
    }

    /// Puts the largest difference before the fit's reason, from `REMARKED_FROM` on, so that two numbers of one thing do not
    /// stand beside each other without a word. Beyond what both standard errors allow, a fit that has not failed gets the status
    /// `disagree`, whatever its age.
    pub fn mark(&self, fit: &mut OutputErrorRecord, controls: ControlNames) {
        let Some((quantity, standard_errors)) = self.worst else { return };
        if standard_errors.abs() < REMARKED_FROM {
            return;
        }
        if self.is_apart() && fit.progress != OutputErrorProgress::Failed {
            fit.progress = OutputErrorProgress::Disagree;
        }
        let before = fit.reason.clone();
        let separator = if before.is_empty() { "" } else { "; " };
        let (quantity, how_far) = (InWords { quantity, controls }, standard_errors.abs());
        fit.explain(format_args!("{quantity}: {how_far:.1} combined standard errors from the regression's{separator}{before}"));
    }
}

/// What is compared, as a person reads it.
struct InWords {
    quantity: Compared,
    controls: ControlNames,
}

impl Display for InWords {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self.quantity {
            Compared::Derivative(axis, variable) => {
                write!(f, "{}", DerivativeLabel { axis, variable: Some(variable), controls: self.controls })
            }
            Compared::Omega => f.write_str("Dutch roll omega"),
            Compared::Zeta => f.write_str("Dutch roll zeta"),
            Compared::Roll => f.write_str("roll mode"),
            Compared::Spiral => f.write_str("spiral mode"),
        }
    }
}

/// Widens the standard errors of a fit where it differs from the regression, by (1).
pub fn cover_difference(derivatives: Option<&DerivativesRecord>, modes: Option<&ModesRecord>, fit: &mut OutputErrorRecord) {
    for equation in derivatives.iter().flat_map(|record| &record.equations) {
        if equation.status.rank() < Status::Stale.rank() {
            continue;
        }
        for one in fit.parameters.iter_mut().filter(|one| one.axis == equation.axis) {
            if let Some(term) = equation.term(one.variable) {
                one.std = covering((one.value, one.std), (term.value, term.std));
            }
        }
    }
    let Some(modes) = modes else { return };
    let pairs = [
        (&mut fit.dutch_roll, modes.dutch_roll),
        (&mut fit.coupled, modes.coupled),
        (&mut fit.lateral_phugoid, modes.lateral_phugoid),
    ];
    for (own, other) in pairs {
        if let Some((own, other)) = own.as_mut().zip(other) {
            own.std_omega = covering((own.omega, own.std_omega), (other.omega, other.std_omega));
            own.std_zeta = covering((own.zeta, own.std_zeta), (other.zeta, other.std_zeta));
        }
    }
    for (own, other) in [(&mut fit.roll, modes.roll), (&mut fit.spiral, modes.spiral)] {
        if let Some((own, other)) = own.as_mut().zip(other) {
            own.std = covering((own.value, own.std), (other.value, other.std));
        }
    }
}

/// The larger of the standard error of the first and that by (1).
fn covering(fitted: (f64, f64), regressed: (f64, f64)) -> f64 {
    let half = (fitted.0 - regressed.0) / REMARKED_FROM;
    let needed = half * half - regressed.1 * regressed.1;
    if needed > fitted.1 * fitted.1 { libm::sqrt(needed) } else { fitted.1 }
}

/// Limits the lateral modes of a fit by the regression's, whose standard errors cover curvature and disturbances: those of the
/// fit are not below them, and a mode that the regression has no number of has none unless the fit has converged.
pub fn limit_modes(regression: Option<&ModesRecord>, fit: &mut OutputErrorRecord) {
    let settled = fit.progress == OutputErrorProgress::Converged;
    let pair = |own: &mut Option<OscillatoryMode>, other: Option<OscillatoryMode>| {
        *own = own.filter(|_| settled || other.is_some()).map(|own| {
            let (omega, zeta) = other.map_or((0.0, 0.0), |other| (other.std_omega, other.std_zeta));
            OscillatoryMode { std_omega: own.std_omega.max(omega), std_zeta: own.std_zeta.max(zeta), ..own }
        });
    };
    let root = |own: &mut Option<RealRoot>, other: Option<RealRoot>| {
        *own = own.filter(|_| settled || other.is_some());
        *own = own.map(|own| RealRoot { std: own.std.max(other.map_or(0.0, |other| other.std)), ..own });
    };
    pair(&mut fit.dutch_roll, regression.and_then(|modes| modes.dutch_roll));
    pair(&mut fit.coupled, regression.and_then(|modes| modes.coupled));
    pair(&mut fit.lateral_phugoid, regression.and_then(|modes| modes.lateral_phugoid));
    root(&mut fit.roll, regression.and_then(|modes| modes.roll));
    root(&mut fit.spiral, regression.and_then(|modes| modes.spiral));
}

/// Takes the derivatives of the axes out that the regression withholds because of an instrument, or because the air may move
/// them, and the modes that they make: both methods rest on the same readings.
pub fn withhold_axes(derivatives: Option<&DerivativesRecord>, fit: &mut OutputErrorRecord) {
    let Some(derivatives) = derivatives else { return };
    let withheld = |axis: Axis| match derivatives.equations[axis.index()].status {
        Status::NotIdentifiable(reason) => reason.is_of_an_instrument() || reason == Reason::NoInput,
        _ => false,
    };
    let had_numbers = !fit.parameters.is_empty();
    fit.parameters.retain(|one| !withheld(one.axis));
    let (lateral, longitudinal) =
        ([Axis::Y, Axis::L, Axis::N].into_iter().any(withheld), [Axis::Z, Axis::M].into_iter().any(withheld));
    if lateral {
        (fit.dutch_roll, fit.lateral_phugoid, fit.roll, fit.spiral) = (None, None, None, None);
    }
    if longitudinal {
        fit.short_period = None;
    }
    if lateral || longitudinal || withheld(Axis::X) {
        fit.coupled = None;
    }
    if had_numbers && fit.parameters.is_empty() && fit.progress != OutputErrorProgress::Waiting {
        fit.progress = OutputErrorProgress::Failed;
        fit.explain("the regression withholds the equations that it would have derivatives of, for the reasons given there");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::channel::Channel;
    use crate::postflight::output_error::record::ParameterRecord;
    use crate::realtime::regression::record::{EquationRecord, TermRecord};

    fn derivatives(status: Status, value: f64, std: f64) -> DerivativesRecord {
        let mut record = DerivativesRecord {
            time_s: 10.0,
            equations: Axis::ALL.map(|axis| EquationRecord::empty(axis, Status::Waiting)),
            lateral: None,
            excited: true,
        };
        let equation = &mut record.equations[Axis::N.index()];
        equation.status = status;
        for variable in [None, Some(Variable::V)] {
            let term = TermRecord { variable, value, std, std_white: std, step: 0, primary: true, frequency: None };
            equation.terms.push(term).unwrap();
        }
        record
    }

    fn fit(value: f64, std: f64, progress: OutputErrorProgress) -> OutputErrorRecord {
        let mut record = OutputErrorRecord { fitted_s: 10.0, progress, ..OutputErrorRecord::EMPTY };
        let parameter = ParameterRecord { axis: Axis::N, variable: Variable::V, value, std, std_cramer_rao: std };
        record.parameters.push(parameter).unwrap();
        record
    }

    fn pair(omega: f64, zeta: f64) -> OscillatoryMode {
        OscillatoryMode { real: 0.0, imag: omega, omega, zeta, std_omega: 0.03, std_zeta: 0.01 }
    }

    #[test]
    fn axes_that_an_instrument_keeps_from_the_regression_have_no_number_here_either() {
        let mut regression = derivatives(Status::Converged, 0.04, 0.004);
        let mut kept = fit(0.04, 0.003, OutputErrorProgress::Converged);
        kept.dutch_roll = Some(pair(1.0, 0.1));
        regression.equations[Axis::X.index()].status = Status::NotIdentifiable(Reason::NotConfirmed { channel: Channel::Ax });
        regression.equations[Axis::L.index()].status = Status::NotIdentifiable(Reason::Unresolved);
        withhold_axes(Some(&regression), &mut kept);
        assert!(kept.parameters.len() == 1 && kept.dutch_roll.is_some());
        regression.equations[Axis::N.index()].status = Status::NotIdentifiable(Reason::NoRates);
        withhold_axes(Some(&regression), &mut kept);
        assert!(kept.parameters.is_empty() && kept.dutch_roll.is_none() && kept.progress == OutputErrorProgress::Failed);
        // One that never had numbers keeps its own reason.
        let mut never = OutputErrorRecord { parameters: heapless::Vec::new(), progress: OutputErrorProgress::Failed, ..kept };
        never.explain("a gap");
        withhold_axes(Some(&derivatives(Status::Converged, 0.04, 0.004)), &mut never);
        assert_eq!(never.reason.as_str(), "a gap");
    }

    #[test]
    fn a_difference_is_measured_in_combined_standard_errors() {
        // Combined standard error 0.005: 3.9 of them agree, 4.1 do not.
        for (difference, apart) in [(0.0095, false), (0.0195, false), (-0.0195, false), (0.0205, true), (-0.0205, true)] {
            let mut fit = fit(0.04 + difference, 0.003, OutputErrorProgress::Converged);
            let agreement = MethodAgreement::new(Some(&derivatives(Status::Converged, 0.04, 0.004)), None, &fit);
            assert_eq!(agreement.apart, Axis::ALL.map(|axis| apart && axis == Axis::N), "{difference}");
            fit.explain("a note");
            agreement.mark(&mut fit, ControlNames::FixedWing);
            let (progress, reason) = match apart {
                false if difference.abs() < 0.01 => (OutputErrorProgress::Converged, "a note"),
                false => (OutputErrorProgress::Converged, "N_v: 3.9 combined standard errors from the regression's; a note"),
                true => (OutputErrorProgress::Disagree, "N_v: 4.1 combined standard errors from the regression's; a note"),
            };
            assert_eq!((fit.progress, fit.reason.as_str()), (progress, reason));
        }
    }

    #[test]
    fn a_difference_is_covered_by_the_errors_of_the_fit() {
        for (difference, std) in [(0.0095, 0.003), (0.0205, (0.01025_f64 * 0.01025 - 0.000016).sqrt())] {
            let mut fit = fit(0.04 + difference, 0.003, OutputErrorProgress::Converged);
            let regression = derivatives(Status::Converged, 0.04, 0.004);
            cover_difference(Some(&regression), None, &mut fit);
            assert!((fit.parameters[0].std - std).abs() < 1e-12, "{}", fit.parameters[0].std);
            let apart = (fit.parameters[0].value - 0.04).abs() / fit.parameters[0].std.hypot(0.004);
            assert!(apart < REMARKED_FROM + 1e-9);
            cover_difference(Some(&derivatives(Status::Waiting, 9.0, 0.004)), None, &mut fit);
            assert!((fit.parameters[0].std - std).abs() < 1e-12, "no number to differ from");
        }
    }

    #[test]
    fn only_numbers_of_both_are_compared() {
        let far = fit(1.0, 0.003, OutputErrorProgress::Converged);
        for silent in [Status::Waiting, Status::Exciting] {
            assert!(!MethodAgreement::new(Some(&derivatives(silent, 0.04, 0.004)), None, &far).is_apart());
        }
        assert_eq!(MethodAgreement::new(None, None, &far), MethodAgreement::NONE);
        assert!(!MethodAgreement::new(Some(&derivatives(Status::Converged, f64::NAN, 0.004)), None, &far).is_apart());
        assert!(MethodAgreement::new(Some(&derivatives(Status::Stale, 0.04, 0.004)), None, &far).is_apart());
    }

    #[test]
    fn an_old_fit_disagrees_too_and_a_failed_one_stays_failed() {
        for (progress, expected) in [
            (OutputErrorProgress::Stale, OutputErrorProgress::Disagree),
            (OutputErrorProgress::Failed, OutputErrorProgress::Failed),
        ] {
            let mut fit = fit(1.0, 0.003, progress);
            MethodAgreement::new(Some(&derivatives(Status::Converged, 0.04, 0.004)), None, &fit)
                .mark(&mut fit, ControlNames::FixedWing);
            assert_eq!(fit.progress, expected);
            assert!(fit.reason.starts_with("N_v: "), "{}", fit.reason);
        }
    }

    #[test]
    fn modes_are_no_better_known_than_the_regression_s() {
        let modes = |dutch_roll| ModesRecord {
            time_s: 10.0,
            status: Status::Converging,
            dutch_roll,
            roll: None,
            spiral: None,
            lateral_phugoid: None,
            coupled: None,
        };
        let wide = OscillatoryMode { std_omega: 0.2, std_zeta: 0.005, ..pair(1.5, 0.12) };
        let roll = Some(RealRoot { value: -2.0, std: 0.1 });
        let fitted =
            |progress| OutputErrorRecord { dutch_roll: Some(pair(1.4, 0.1)), roll, progress, ..OutputErrorRecord::EMPTY };
        let mut fit = fitted(OutputErrorProgress::Converging);
        limit_modes(Some(&modes(Some(wide))), &mut fit);
        let limited = OscillatoryMode { std_omega: 0.2, ..pair(1.4, 0.1) };
        assert_eq!((fit.dutch_roll, fit.roll), (Some(limited), None));
        limit_modes(None, &mut fit);
        assert_eq!(fit.dutch_roll, None);
        let mut settled = fitted(OutputErrorProgress::Converged);
        limit_modes(None, &mut settled);
        assert_eq!((settled.dutch_roll, settled.roll), (Some(pair(1.4, 0.1)), roll));
    }

    #[test]
    fn a_dutch_roll_that_differs_marks_the_lateral_equations() {
        let modes = ModesRecord {
            time_s: 10.0,
            status: Status::Converged,
            dutch_roll: Some(pair(1.5, 0.12)),
            roll: None,
            spiral: None,
            lateral_phugoid: None,
            coupled: None,
        };
        let mut fit = OutputErrorRecord { dutch_roll: Some(pair(1.5, 0.29)), ..OutputErrorRecord::EMPTY };
        fit.progress = OutputErrorProgress::Converging;
        let agreement = MethodAgreement::new(None, Some(&modes), &fit);
        assert_eq!(agreement.apart, Axis::ALL.map(Axis::is_lateral));
        agreement.mark(&mut fit, ControlNames::FixedWing);
        assert_eq!(fit.reason.as_str(), "Dutch roll zeta: 12.0 combined standard errors from the regression's");
    }
}
