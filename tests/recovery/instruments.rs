//! Live estimates from instruments that are at fault: the blamed instrument is the right one or none, and no number is wrong.
//!
//! The built-in Puma's linear model at 100 kn, pedal and lateral cyclic 3211, with faults of unit, sign, freezing and clipping
//! put into the samples. CI flies two seeds of each in still air and in gusts of 0.3 and 1 m/s; the study as many as
//! `SIDESLIP_SEEDS` says. Gusts of 1 m/s can hide a wrong unit of airspeed and the sign of alpha for some seconds: such numbers
//! are wrong but never converged.

use super::instrument_faults::Fault::{self, Clipped, Exchanged, Factor, Frozen, Spiky};
use super::instrument_faults::spoil;
use super::pilot::{KNOT, with_inputs};
use crate::support::asked::seeds;
use crate::support::invented::{glider, light_aircraft};
use crate::support::manoeuvre::{DURATION_S, INPUTS, over_seeds};
use crate::support::transport::transport;
use sideslip::flight::channel::Channel;
use sideslip::flight::effect::Effect;
use sideslip::flight::model::LinearModel;
use sideslip::flight::run::RunGeometry;
use sideslip::flight::unit::{DEGREE, STANDARD_GRAVITY};
use sideslip::realtime::estimation::record::EstimationEvent;
use sideslip::realtime::modes::lateral;
use sideslip::realtime::pipeline::{Pipeline, PipelineConfig};
use sideslip::realtime::regression::record::{LateralDerivatives, Status};
use sideslip::simulation::flight_model::{FlightModel, FlightRequest};
use sideslip::simulation::fly::Flight;
use sideslip::simulation::instrument::InstrumentSet;

use Channel::{Alpha, Ax, Ay, Az, Beta, P, Pedal, Phi, Psi, Q, R, Tas, Theta};

const FAULTS: [(&[Channel], Fault); 39] = [
    (&[], Factor(1.0)),
    (&[Tas], Factor(1.0 / KNOT)),
    (&[Tas], Factor(3.6)),
    (&[Tas], Factor(KNOT)),
    (&[Ax, Ay, Az], Factor(1.0 / STANDARD_GRAVITY)),
    (&[Ay], Factor(1.0 / STANDARD_GRAVITY)),
    (&[Alpha, Beta], Factor(DEGREE)),
    (&[Alpha, Beta], Factor(1.0 / DEGREE)),
    (&[P, Q, R], Factor(1.0 / DEGREE)),
    (&[P, Q, R], Factor(DEGREE)),
    (&[Phi, Theta, Psi], Factor(1.0 / DEGREE)),
    (&[Phi, Theta, Psi], Factor(DEGREE)),
    (&[R], Factor(-1.0)),
    (&[P], Factor(-1.0)),
    (&[Beta], Factor(-1.0)),
    (&[Alpha], Factor(-1.0)),
    (&[Ax], Factor(-1.0)),
    (&[Ay], Factor(-1.0)),
    (&[Az], Factor(-1.0)),
    (&[Ax, Ay], Exchanged),
    (&[Phi], Factor(-1.0)),
    (&[Beta], Frozen(0.0, 100.0)),
    (&[Beta], Frozen(6.0, 100.0)),
    (&[Beta], Frozen(8.0, 10.0)),
    (&[R], Frozen(6.0, 100.0)),
    (&[P], Frozen(5.0, 7.0)),
    (&[Tas], Frozen(5.0, 100.0)),
    (&[Beta], Clipped(0.02)),
    (&[R], Clipped(0.04)),
    (&[Ay], Factor(0.0)),
    (&[Beta], Factor(0.0)),
    (&[Pedal], Factor(1.0 / DEGREE)),
    (&[P, Phi], Factor(-1.0)),
    (&[Q, Theta], Factor(-1.0)),
    (&[R, Psi], Factor(-1.0)),
    (&[Tas], Factor(0.8)),
    (&[Tas], Factor(1.2)),
    (&[Alpha], Spiky(0.2)),
    (&[Phi], Spiky(1.0)),
];

#[derive(Default)]
struct Seen {
    numbers: usize,
    squares: f64,
    beyond_four: usize,
    converged_and_wrong: usize,
    /// Damping ratios and frequencies of the Dutch roll, and spiral roots.
    modes: usize,
    /// Those of them beyond four standard errors.
    modes_beyond_four: usize,
    /// Channels that were blamed.
    blamed: Vec<Channel>,
}

impl Seen {
    /// The numbers of several flights.
    fn of(flights: &[Seen]) -> Seen {
        let mut all = Seen::default();
        for one in flights {
            all.numbers += one.numbers;
            all.squares += one.squares;
            all.beyond_four += one.beyond_four;
            all.converged_and_wrong += one.converged_and_wrong;
            all.modes += one.modes;
            all.modes_beyond_four += one.modes_beyond_four;
            all.blamed.extend(&one.blamed);
        }
        all
    }

    /// Root mean square of the errors in standard errors.
    fn rms(&self) -> f64 {
        (self.squares / self.numbers.max(1) as f64).sqrt()
    }
}

fn seen(model: &LinearModel, inputs: &[&str], gust: f64, (channels, fault): (&[Channel], Fault), seed: u64) -> Seen {
    let mut flight = with_inputs(Flight::of(model.clone()), inputs, DURATION_S);
    flight.instruments = InstrumentSet::flight_quality(1.0);
    flight.seed = 60_000 + seed;
    if gust > 0.0 {
        flight.effects.push(Effect::Turbulence { sigma: gust, length: 150.0 });
    }
    let mut pipeline = Box::new(Pipeline::new(&PipelineConfig::default(), RunGeometry::default()).unwrap());
    let (mut found, mut held) = (Seen::default(), [None; 3]);
    let truth = lateral::modes(0.0, Status::Converged, &LateralDerivatives::of(model)).unwrap();
    for mut sample in flight.fly().unwrap().samples {
        spoil(&mut sample, channels, fault, &mut held);
        let tick = pipeline.step(&sample);
        for event in &tick.estimation_events {
            match event {
                EstimationEvent::GrossError { error, .. } => found.blamed.extend(error.channels()),
                EstimationEvent::StandsStill { channel } => found.blamed.push(*channel),
                _ => {}
            }
        }
        if let Some(modes) = &tick.modes {
            let pairs = modes.dutch_roll.zip(truth.dutch_roll).into_iter().flat_map(|(told, true_pair)| {
                [(told.zeta, told.std_zeta, true_pair.zeta), (told.omega, told.std_omega, true_pair.omega)]
            });
            let spirals = modes.spiral.zip(truth.spiral).map(|(told, true_root)| (told.value, told.std, true_root.value));
            for (value, std, expected) in pairs.chain(spirals) {
                found.modes += 1;
                found.modes_beyond_four += usize::from((value - expected).abs() > 4.0 * std);
            }
        }
        for equation in tick.derivatives.iter().flat_map(|derivatives| &derivatives.equations) {
            for term in &equation.terms {
                let Some(variable) = term.variable else { continue };
                let score = (term.value - model.derivative(equation.axis, variable)) / term.std;
                found.numbers += 1;
                found.squares += score * score;
                found.beyond_four += usize::from(score.abs() > 4.0);
                found.converged_and_wrong += usize::from(equation.status == Status::Converged && score.abs() > 4.0);
            }
        }
    }
    found
}

#[test]
fn the_blamed_instrument_is_the_right_one_or_none_and_no_number_is_wrong() {
    let model = FlightModel::puma(&FlightRequest { speed: Some(100.0 * KNOT), ..FlightRequest::default() }).unwrap();
    let model = model.linear().clone();
    let (each, mut failed) = (seeds(2), Vec::new());
    for gust in [0.0, 0.3, 1.0] {
        let all = over_seeds(each * FAULTS.len() as u64, |n| seen(&model, &INPUTS, gust, FAULTS[(n / each) as usize], n));
        for ((channels, fault), flights) in FAULTS.into_iter().zip(all.chunks(each as usize)) {
            let all = Seen::of(flights);
            let (numbers, rms, beyond, wrong) = (all.numbers, all.rms(), all.beyond_four, all.converged_and_wrong);
            let named = flights.iter().filter(|one| !one.blamed.is_empty()).count();
            let innocent = all.blamed.iter().filter(|blamed| !channels.contains(blamed)).count();
            eprintln!(
                "gusts of {gust} m/s, {channels:?} {fault:?}: named in {named} of {each}, {innocent} others blamed, {numbers} numbers, \
                 rms {rms:.2}, {beyond} beyond 4, {wrong} converged"
            );
            // Left out are spikes of beta: of two that follow each other the first is not known as one, and 69 of 2,487 numbers
            // in still air are beyond four standard errors, none converged.
            // In gusts of 1 m/s a unit can be hidden; an innocent instrument is blamed in none.
            let few = numbers < 100 * each as usize;
            if innocent > 0 || wrong > 0 || gust < 0.1 && !few && rms > 1.3 {
                failed.push((gust, channels, fault));
            }
        }
    }
    assert!(failed.is_empty(), "{failed:?}");
}

/// A fixed wing's side force is small beside what rotation makes of the sideslip, which a wrong ay hardly contradicts; the
/// sideways velocity follows it all the same. Of seven flights of each fault none has a number beyond four standard errors; the
/// few of the transport with an ay reversed or in ft/s^2 have rms 1.30 and 1.38, the latter above the limit.
#[test]
fn a_wrong_ay_of_a_small_side_force_gives_no_wrong_number() {
    const IN_FEET: f64 = 1.0 / 0.3048;
    let faults: [(&[Channel], Fault); 5] = [
        (&[], Factor(1.0)),
        (&[Ax, Ay], Exchanged),
        (&[Ay], Factor(1.0 / STANDARD_GRAVITY)),
        (&[Ay], Factor(IN_FEET)),
        (&[Ay], Factor(-1.0)),
    ];
    let first_pedal = ["pedal:3211:0.05:0.7", "lat_cyclic:3211:0.03:0.7:14"];
    let first_stick = ["lat_cyclic:3211:0.03:0.7", "pedal:3211:0.05:0.7:14"];
    let (each, mut failed) = (seeds(2), Vec::new());
    for (name, model) in [("transport", transport()), ("glider", glider()), ("light aircraft", light_aircraft())] {
        for (channels, fault) in faults {
            let inputs = |n: u64| if n.is_multiple_of(2) { &first_pedal } else { &first_stick };
            let flights = over_seeds(each, |n| seen(&model, inputs(n), 0.0, (channels, fault), n));
            let all = Seen::of(&flights);
            let (numbers, rms, beyond, wrong) = (all.numbers, all.rms(), all.beyond_four, all.converged_and_wrong);
            eprintln!("{name}, {channels:?} {fault:?}: {numbers} numbers, rms {rms:.2}, {beyond} beyond 4, {wrong} converged");
            // Of the right ay, the flight with the pedal first has numbers most of the time, but for a glider's L_v and L_r
            // until its L_p is known.
            let silent = channels.is_empty() && flights[0].numbers <= 1800;
            if wrong > 0 || rms > 1.3 || silent {
                failed.push((name, channels, fault));
            }
        }
    }
    assert!(failed.is_empty(), "{failed:?}");
}

/// Inputs of one plane move the one angle and hardly the other. The rates exchanged would explain a bank that is read as pitch
/// as well, were it not for gravity in the sideslip: of 16 flights of invented aircraft 10 blamed p and q. Of exchanged vanes
/// nothing was named, and an unmanned aircraft's numbers were up to 14 standard errors off. Left out is the glider with bank and
/// pitch exchanged: its sideslip hardly shows the bank, and in one of two flights p and q are blamed, without a number.
#[test]
fn exchanged_angles_are_named_where_one_of_them_hardly_moves() {
    const ATTITUDE: &[Channel] = &[Phi, Theta];
    const VANES: &[Channel] = &[Alpha, Beta];
    let inputs = ["pedal:3211:0.02:0.7", "lat_cyclic:doublet:0.02:1:14"];
    let (each, mut failed) = (seeds(2), Vec::new());
    for (name, model, faults) in [
        ("transport", transport(), [Some(ATTITUDE), Some(VANES)]),
        ("glider", glider(), [None, Some(VANES)]),
        ("light aircraft", light_aircraft(), [Some(ATTITUDE), Some(VANES)]),
    ] {
        for channels in faults.into_iter().flatten() {
            let flights = over_seeds(each, |n| seen(&model, &inputs, 0.0, (channels, Exchanged), n));
            let all = Seen::of(&flights);
            let named = flights.iter().filter(|one| !one.blamed.is_empty()).count();
            eprintln!(
                "{name}, {channels:?} exchanged: named in {named} of {each}: {:?}, {} of {} numbers beyond 4",
                all.blamed, all.beyond_four, all.numbers
            );
            let innocent = all.blamed.iter().any(|blamed| !channels.contains(blamed));
            if innocent || named == 0 || all.converged_and_wrong > 0 || all.beyond_four > 0 {
                failed.push((name, channels));
            }
        }
    }
    assert!(failed.is_empty(), "{failed:?}");
}

/// The damping of the Dutch roll has Y_v in it, whose sign a reversed ay turns and gusts hide; the spiral hangs on the pitch
/// attitude. Before Y_v's doubt was in the errors of the modes, damping ratios were up to 12 standard errors off, and spirals
/// 31, `converged`.
#[test]
fn a_reversed_ay_or_theta_makes_no_mode_wrong() {
    let mut failed = Vec::new();
    for (name, model) in [("transport", transport()), ("glider", glider()), ("light aircraft", light_aircraft())] {
        for (gust, channel) in [(0.3, Ay), (0.6, Ay), (0.0, Theta)] {
            let fault: (&[Channel], Fault) = (&[channel], Factor(-1.0));
            let inputs = ["pedal:3211:0.03:0.6", "lat_cyclic:3211:0.03:0.5:9"];
            let of = |n: u64| seen(&model, &inputs, gust, fault, 9_000 + n);
            let all = Seen::of(&over_seeds(seeds(3), of));
            let (modes, wrong) = (all.modes, all.modes_beyond_four);
            eprintln!("{name}, {channel:?} reversed, gusts of {gust} m/s: {wrong} of {modes} modes beyond 4 standard errors");
            if wrong > 0 {
                failed.push((name, channel, gust, wrong));
            }
        }
    }
    assert!(failed.is_empty(), "{failed:?}");
}
