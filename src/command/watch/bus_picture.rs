//! What a reader knows of a root: the newest records of every service, who is there, how the samples come.

use super::sample_flow::SampleFlow;
use sideslip::error::Failure;
use sideslip::flight::channel::ControlNames;
use sideslip::flight::file::run_file::RunInfo;
use sideslip::io::bus::clock::monotonic_ns;
use sideslip::io::bus::error::BusError;
use sideslip::io::bus::payload::{
    EventPayload, FindingPayload, InnovationsPayload, OutputErrorPayload, Payload, SamplePayload, StatePayload,
};
use sideslip::io::bus::reader::{NewestEstimate, Reader};
use sideslip::io::bus::role_holder::RoleHolder;
use sideslip::io::bus::root::BusRole;
use sideslip::io::bus::run_head::newest_head;
use sideslip::io::bus::service::{Bus, Subscriber};
use sideslip::io::outputs::event_ring::EventRing;
use sideslip::postflight::diagnosis::record::{FindingRecord, FindingStatus, FindingsSoFar};
use sideslip::postflight::output_error::record::OutputErrorRecord;
use sideslip::realtime::estimation::record::{AIDS, Innovation, StateRecord};
use std::path::PathBuf;

/// Different events that are kept.
pub(super) const EVENTS: usize = 64;

/// What is known now.
pub(super) struct BusPicture {
    pub(super) root: PathBuf,
    /// Another root where an estimator runs, while there is none in this one.
    pub(super) elsewhere: Option<PathBuf>,
    pub(super) estimator: RoleHolder,
    pub(super) telemetry: RoleHolder,
    pub(super) run: String,
    pub(super) aircraft: Option<String>,
    pub(super) manoeuvre: Option<String>,
    pub(super) controls: ControlNames,
    pub(super) estimate: Option<NewestEstimate>,
    pub(super) output_error: Option<OutputErrorRecord>,
    pub(super) state: Option<StateRecord>,
    pub(super) aids: [AidUse; AIDS],
    pub(super) events: EventRing<EVENTS>,
    pub(super) flow: SampleFlow,
    findings: FindingsSoFar,
    /// Whose findings, events and counts of aids these are.
    incarnations: [u64; 3],
}

/// What one aid did so far.
#[derive(Clone, Copy, Default)]
pub(super) struct AidUse {
    pub(super) newest: Option<Innovation>,
    pub(super) fused: u64,
    pub(super) offered: u64,
}

impl BusPicture {
    /// Of a root of which nothing is known yet.
    pub(super) fn of(root: PathBuf) -> Self {
        BusPicture {
            root,
            elsewhere: None,
            estimator: RoleHolder::Unknown,
            telemetry: RoleHolder::Unknown,
            run: "live".to_owned(),
            aircraft: None,
            manoeuvre: None,
            controls: ControlNames::Rotorcraft,
            estimate: None,
            output_error: None,
            state: None,
            aids: [AidUse::default(); AIDS],
            events: EventRing::new(),
            flow: SampleFlow::default(),
            findings: FindingsSoFar::new(),
            incarnations: [0; 3],
        }
    }

    pub(super) fn findings(&self) -> &[FindingRecord] {
        self.findings.records()
    }

    /// The first word of a run ends those of the run before; so does another estimator.
    pub(super) fn take_finding(&mut self, incarnation: u64, record: &FindingRecord) {
        let [known, ..] = &mut self.incarnations;
        if incarnation != *known || record.standing == FindingStatus::Waiting {
            *known = incarnation;
            self.findings = FindingsSoFar::new();
        }
        self.findings.update(record);
    }

    fn take_event(&mut self, event: &EventPayload) -> Result<(), BusError> {
        let [_, known, _] = &mut self.incarnations;
        if event.header.incarnation != *known {
            *known = event.header.incarnation;
            self.events = EventRing::new();
        }
        self.events.push(&event.record()?);
        Ok(())
    }

    fn take_innovations(&mut self, payload: &InnovationsPayload) -> Result<(), BusError> {
        let [.., known] = &mut self.incarnations;
        if payload.header.incarnation != *known {
            *known = payload.header.incarnation;
            self.aids = [AidUse::default(); AIDS];
        }
        for innovation in payload.records()? {
            if let Some(aid) = self.aids.get_mut(innovation.aid.index()) {
                aid.newest = Some(innovation);
                aid.offered += 1;
                aid.fused += u64::from(innovation.fused);
            }
        }
        Ok(())
    }
}

/// A place on the bus that takes in everything.
pub(super) struct BusListener {
    reader: Reader,
    output_errors: Subscriber<OutputErrorPayload>,
    findings: Subscriber<FindingPayload>,
    /// What the screen shows besides.
    more: Option<MoreServices>,
    bus: Bus,
}

struct MoreServices {
    samples: Subscriber<SamplePayload>,
    states: Subscriber<StatePayload>,
    innovations: Subscriber<InnovationsPayload>,
    events: Subscriber<EventPayload>,
}

impl BusListener {
    /// Listens to estimates, output error and findings, with `more` to samples, states, innovations and events too.
    pub(super) fn on(bus: Bus, more: bool) -> Result<Self, Failure> {
        let listen = || -> Result<MoreServices, BusError> {
            Ok(MoreServices {
                samples: bus.subscriber()?,
                states: bus.subscriber()?,
                innovations: bus.subscriber()?,
                events: bus.subscriber()?,
            })
        };
        Ok(BusListener {
            reader: Reader::on(&bus)?,
            output_errors: bus.subscriber()?,
            findings: bus.subscriber()?,
            more: if more { Some(listen()?) } else { None },
            bus,
        })
    }

    pub(super) fn estimate(&mut self) -> Result<Option<NewestEstimate>, Failure> {
        Ok(self.reader.latest()?)
    }

    /// Takes in what came since.
    pub(super) fn take_in(&mut self, picture: &mut BusPicture) -> Result<(), Failure> {
        picture.estimate = self.reader.latest()?;
        while let Some(newest) = self.output_errors.receive()? {
            picture.output_error = Some(newest.record()?);
        }
        while let Some(newest) = self.findings.receive()? {
            picture.take_finding(newest.header.incarnation, &newest.record()?);
        }
        if let Some(more) = &mut self.more {
            while let Some(sample) = more.samples.receive()? {
                picture.flow.take(&sample);
            }
            picture.flow.missed = more.samples.missed();
            picture.flow.now(monotonic_ns());
            if let Some(state) = newest_of(&mut more.states)? {
                picture.state = Some(state.record()?);
            }
            while let Some(innovations) = more.innovations.receive()? {
                picture.take_innovations(&innovations)?;
            }
            while let Some(event) = more.events.receive()? {
                picture.take_event(&event)?;
            }
        }
        Ok(())
    }

    /// Name, aircraft, manoeuvre and controls of the run that telemetry announced last.
    pub(super) fn name_run(&self, picture: &mut BusPicture) {
        let head = newest_head(self.bus.root()).ok().flatten();
        picture.controls = head.as_ref().map_or(ControlNames::Rotorcraft, |head| head.controls);
        let info = head.and_then(|head| RunInfo::from_toml(&head.run_toml).ok());
        let text = |of: fn(&RunInfo) -> Option<&str>| info.as_ref().and_then(of).map(str::to_owned);
        picture.run = text(RunInfo::run).unwrap_or_else(|| "live".to_owned());
        picture.aircraft = text(RunInfo::aircraft);
        picture.manoeuvre = text(RunInfo::manoeuvre);
    }

    /// Who is there.
    pub(super) fn name_processes(&self, picture: &mut BusPicture) {
        picture.estimator = RoleHolder::of(self.bus.root().path(), BusRole::Estimator);
        picture.telemetry = RoleHolder::of(self.bus.root().path(), BusRole::Telemetry);
    }
}

/// The last of what waits.
fn newest_of<P: Payload>(subscriber: &mut Subscriber<P>) -> Result<Option<P>, BusError> {
    let mut newest = None;
    while let Some(one) = subscriber.receive()? {
        newest = Some(one);
    }
    Ok(newest)
}
