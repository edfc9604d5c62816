//! Which numbers are due: values with standard errors while they have a status with numbers, and a word where they end.
//!
//! Consumes the newest records; produces [`StationMessage`]s once a period. A number that there is none of any more is sent
//! once as NaN, with its standard error, and then not again. Statuses are sent every time, as -1 where no run goes on, or where
//! no record has come for [`SILENCE`]: numbers of before are not sent as if they were of now.

use super::message::StationMessage;
use super::names::{NUMBERS, NUMBERS_NAMED, SILENT, STANDARD_ERROR, STATUSES};
use crate::flight::channel::ControlNames;
use crate::realtime::modes::record::ModesRecord;
use crate::realtime::regression::record::DerivativesRecord;
use std::time::{Duration, Instant};

/// Records come at 10 Hz or more while samples do; after so long there are none.
pub const SILENCE: Duration = Duration::from_millis(1500);

/// The newest records and what was sent of them.
#[derive(Debug)]
pub struct StationNumbers {
    controls: ControlNames,
    modes: Option<ModesRecord>,
    derivatives: Option<Box<DerivativesRecord>>,
    heard: Option<Instant>,
    time_s: f64,
    /// Which numbers stand at the other end.
    standing: [bool; NUMBERS_NAMED],
    /// Whether records came since they were sent last.
    fresh: bool,
}

impl StationNumbers {
    /// Nothing yet.
    pub fn new() -> Self {
        StationNumbers {
            controls: ControlNames::Rotorcraft,
            modes: None,
            derivatives: None,
            heard: None,
            time_s: 0.0,
            standing: [false; NUMBERS_NAMED],
            fresh: false,
        }
    }

    /// A run begins whose controls are called so; what stood under other names ends first.
    pub fn begin_run(&mut self, controls: ControlNames, send: &mut impl FnMut(StationMessage)) {
        self.end_run();
        if controls != self.controls {
            self.messages(send);
        }
        self.controls = controls;
    }

    /// The run has ended: nothing of it is of now.
    pub fn end_run(&mut self) {
        (self.modes, self.derivatives, self.heard, self.fresh) = (None, None, None, false);
    }

    /// Takes the newest modes.
    pub fn take_modes(&mut self, record: &ModesRecord, now: Instant) {
        self.modes = Some(*record);
        self.heard_at(record.time_s, now);
    }

    /// Takes the newest derivatives.
    pub fn take_derivatives(&mut self, record: &DerivativesRecord, now: Instant) {
        match &mut self.derivatives {
            Some(kept) => kept.as_mut().clone_from(record),
            None => self.derivatives = Some(Box::new(record.clone())),
        }
        self.heard_at(record.time_s, now);
    }

    /// Whether records came that were not sent yet.
    pub fn is_fresh(&self) -> bool {
        self.fresh
    }

    /// Everything that is due now.
    pub fn due(&mut self, now: Instant, send: &mut impl FnMut(StationMessage)) {
        if self.heard.is_some_and(|heard| now.saturating_duration_since(heard) > SILENCE) {
            self.end_run();
        }
        self.messages(send);
    }

    fn messages(&mut self, send: &mut impl FnMut(StationMessage)) {
        let (modes, derivatives) = (self.modes.as_ref(), self.derivatives.as_deref());
        let ms = (self.time_s * 1000.0).clamp(0.0, f64::from(u32::MAX)) as u32;
        for (name, source) in STATUSES {
            let code = if self.heard.is_some() { source.code(modes, derivatives) } else { SILENT };
            send(StationMessage::named(name, code, ms));
        }
        for (number, standing) in NUMBERS.iter().zip(&mut self.standing) {
            let found = number.source.find(modes, derivatives);
            if found.is_some() || *standing {
                let [value, error] = found.unwrap_or([f32::NAN; 2]);
                let name = number.name(self.controls);
                send(StationMessage::named(name, value, ms));
                send(StationMessage::named(&format!("{name}{STANDARD_ERROR}"), error, ms));
            }
            *standing = found.is_some();
        }
        self.fresh = false;
    }

    fn heard_at(&mut self, time_s: f64, now: Instant) {
        self.heard = Some(now);
        self.fresh = true;
        if time_s.is_finite() {
            self.time_s = time_s;
        }
    }
}

impl Default for StationNumbers {
    fn default() -> Self {
        StationNumbers::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::derivative::{Axis, Variable};
    use crate::realtime::modes::record::{OscillatoryMode, RealRoot};
    use crate::realtime::regression::record::{EquationRecord, Status, TermRecord};
    use std::collections::BTreeMap;

    fn term(variable: Variable, value: f64, std: f64) -> TermRecord {
        TermRecord { variable: Some(variable), value, std, std_white: std, step: 1, primary: true, frequency: None }
    }

    fn derivatives(time_s: f64, status: Status) -> DerivativesRecord {
        let mut equations = Axis::ALL.map(|axis| EquationRecord::empty(axis, Status::Waiting));
        let yaw = &mut equations[Axis::N.index()];
        yaw.status = status;
        for one in [term(Variable::V, 0.03, 0.001), term(Variable::P, -0.2, 0.25), term(Variable::Pedal, -1.5, 0.3)] {
            yaw.terms.push(one).unwrap();
        }
        yaw.unresolved = 1 << Variable::P.index();
        DerivativesRecord { time_s, equations, lateral: None, excited: true }
    }

    fn modes(time_s: f64, status: Status) -> ModesRecord {
        let dutch_roll = OscillatoryMode { real: -0.1, imag: 1.5, omega: 1.503, zeta: 0.067, std_omega: 0.01, std_zeta: 0.02 };
        let spiral = Some(RealRoot { value: -0.01, std: f64::NAN });
        ModesRecord { time_s, status, dutch_roll: Some(dutch_roll), roll: None, spiral, lateral_phugoid: None, coupled: None }
    }

    /// Names and values of what is due then; NaN as `None`.
    fn due(numbers: &mut StationNumbers, now: Instant) -> BTreeMap<String, Option<f32>> {
        let mut sent = BTreeMap::new();
        numbers.due(now, &mut |message| {
            let StationMessage::NamedValue { name, value, .. } = message else { panic!("{message:?}") };
            let name = String::from_utf8(name.into_iter().filter(|letter| *letter != 0).collect()).unwrap();
            assert_eq!(sent.insert(name, (!value.is_nan()).then_some(value)), None);
        });
        sent
    }

    fn names(sent: &BTreeMap<String, Option<f32>>) -> Vec<&str> {
        sent.keys().filter(|name| !name.ends_with("_status")).map(String::as_str).collect()
    }

    #[test]
    fn numbers_go_with_their_errors_while_their_status_has_numbers_and_end_with_one_nan() {
        let begun = Instant::now();
        let mut numbers = StationNumbers::new();
        let sent = due(&mut numbers, begun);
        assert_eq!((sent.len(), sent["DR_status"], names(&sent)), (7, Some(SILENT), vec![]));
        numbers.begin_run(ControlNames::FixedWing, &mut |_| {});
        numbers.take_modes(&modes(1.0, Status::Converging), begun);
        numbers.take_derivatives(&derivatives(1.0, Status::Converged), begun);
        assert!(numbers.is_fresh());
        let sent = due(&mut numbers, begun);
        // Neither what is not resolved nor what has no standard error.
        assert_eq!(names(&sent), ["DR_wn", "DR_wn_se", "DR_zeta", "DR_zeta_se", "N_rud", "N_rud_se", "N_v", "N_v_se"]);
        assert_eq!((sent["N_v"], sent["N_v_se"], sent["DR_wn"]), (Some(0.03), Some(0.001), Some(1.503)));
        assert_eq!((sent["N_status"], sent["DR_status"], sent["X_status"]), (Some(7.0), Some(6.0), Some(1.0)));
        assert!(!numbers.is_fresh());
        for status in [Status::Disagree, Status::DependsOnAmplitude, Status::Stale] {
            numbers.take_derivatives(&derivatives(2.0, status), begun);
            let sent = due(&mut numbers, begun);
            assert_eq!((sent["N_v"], sent["N_status"]), (Some(0.03), Some(f32::from(status.rank()))));
        }
        numbers.take_derivatives(&derivatives(2.0, Status::Exciting), begun);
        let sent = due(&mut numbers, begun);
        assert_eq!((sent["N_v"], sent["N_v_se"], sent["N_status"]), (None, None, Some(2.0)), "once, that there is none");
        assert_eq!(names(&due(&mut numbers, begun)), ["DR_wn", "DR_wn_se", "DR_zeta", "DR_zeta_se"]);
    }

    #[test]
    fn where_samples_stop_and_where_a_run_ends_no_number_goes_on() {
        let begun = Instant::now();
        let mut numbers = StationNumbers::new();
        numbers.take_derivatives(&derivatives(1.0, Status::Converged), begun);
        assert_eq!(due(&mut numbers, begun + SILENCE)["N_v"], Some(0.03));
        let sent = due(&mut numbers, begun + SILENCE + Duration::from_millis(1));
        assert_eq!((sent["N_v"], sent["N_status"]), (None, Some(SILENT)));
        assert_eq!(names(&due(&mut numbers, begun + SILENCE * 2)), [""; 0]);
        // Another run, of another kind of aircraft: what stood under the names of before ends under them.
        numbers.take_derivatives(&derivatives(9.0, Status::Converged), begun);
        due(&mut numbers, begun);
        let mut ended = 0;
        numbers.begin_run(ControlNames::FixedWing, &mut |message| {
            let StationMessage::NamedValue { name, value, .. } = message else { panic!("{message:?}") };
            ended += u32::from(name.starts_with(b"N_ped") && value.is_nan());
        });
        assert_eq!(ended, 2, "value and standard error");
    }
}
