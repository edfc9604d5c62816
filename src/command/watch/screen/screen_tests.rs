//! The pages drawn without a terminal: every size, and the terminal given back by a program that panics.

#[path = "../../../../tests/support/patience.rs"]
mod patience;
#[path = "../../../../tests/support/pseudo_terminal.rs"]
#[allow(dead_code, reason = "tests of processes use the rest")]
mod pseudo_terminal;

use super::ink::Ink;
use super::page::{Page, View};
use crate::command::watch::bus_picture::BusPicture;
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use sideslip::flight::channel::{Channel, ControlNames};
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::flight::sample::Sample;
use sideslip::io::bus::payload::{SAMPLE, SamplePayload};
use sideslip::io::bus::reader::NewestEstimate;
use sideslip::io::bus::role_holder::RoleHolder;
use sideslip::io::outputs::record::{EventKind, EventRecord};
use sideslip::realtime::estimation::record::EstimationEvent;
use sideslip::realtime::modes::record::{ModesRecord, OscillatoryMode, RealRoot};
use sideslip::realtime::regression::record::{DerivativesRecord, EquationRecord, Reason, Status, TermRecord};
use std::time::Duration;

fn picture(age: Duration, spiral: f64) -> BusPicture {
    let mut picture = BusPicture::of("root".into());
    (picture.run, picture.aircraft) = ("flight \x1b[2J 7".to_owned(), Some("Puma\u{202e}".to_owned()));
    (picture.estimator, picture.telemetry) = (RoleHolder::Process(41), RoleHolder::Process(42));
    let mut equations = Axis::ALL.map(|axis| EquationRecord::empty(axis, Status::NotIdentifiable(Reason::NoRates)));
    for equation in &mut equations {
        equation.status = Status::Converged;
        for variable in [None, Some(Variable::V), Some(Variable::P), Some(Variable::Pedal)] {
            let (value, std) = if variable.is_none() { (f64::NAN, f64::INFINITY) } else { (-1.234e300, 0.01) };
            let term = TermRecord { variable, value, std, std_white: 0.01, step: 1, primary: true, frequency: None };
            equation.terms.push(term).unwrap();
        }
    }
    let pair = OscillatoryMode { real: -0.16, imag: 1.8, omega: 1.807, zeta: 0.0885, std_omega: 0.02, std_zeta: 0.01 };
    let modes = ModesRecord {
        time_s: 12.4,
        status: Status::Converged,
        dutch_roll: Some(pair),
        roll: Some(RealRoot { value: -2.0, std: 0.1 }),
        spiral: Some(RealRoot { value: spiral, std: 0.004 }),
        lateral_phugoid: None,
        coupled: Some(pair),
    };
    picture.estimate = Some(NewestEstimate {
        derivatives: DerivativesRecord { time_s: 12.4, equations, lateral: None, excited: true },
        modes,
        age,
        sequence: 600,
        incarnation: 1,
        missed: 0,
        status: Status::Converged,
        valid_until_ns: 0,
    });
    for time_s in 0..70_u8 {
        let event = EstimationEvent::OutOfRange { channel: Channel::ALL[usize::from(time_s) % 16], value: 45.0 };
        picture.events.push(&EventRecord { time_s: time_s.into(), kind: EventKind::Estimation(event) });
    }
    let mut sample = Sample::new(12.4);
    Channel::ALL.into_iter().for_each(|channel| sample.set(channel, f64::NAN));
    picture.flow.take(&SamplePayload::new(&sample, std::iter::empty(), SAMPLE));
    picture.controls = ControlNames::FixedWing;
    picture
}

fn drawn(picture: &BusPicture, page: Page, (columns, rows): (u16, u16), scroll: usize) -> String {
    let mut terminal = Terminal::new(TestBackend::new(columns, rows)).unwrap();
    let mut view = View::new(Ink { colour: true });
    view.turn_to(page);
    view.scroll = scroll;
    terminal.draw(|frame| view.draw(frame, picture)).unwrap();
    // The backend cannot say what stands on nothing.
    if columns == 0 || rows == 0 { String::new() } else { terminal.backend().to_string() }
}

#[test]
fn every_page_can_be_drawn_at_every_size_and_scrolled_beyond_its_end() {
    let pictures = [BusPicture::of("nobody".into()), picture(Duration::from_millis(10), -0.02)];
    for picture in &pictures {
        for page in Page::ALL {
            for size in [(0, 0), (1, 1), (3, 5), (5, 3), (20, 6), (40, 7), (79, 23), (115, 8), (116, 8), (500, 2), (300, 200)] {
                for scroll in [0, 3, usize::MAX] {
                    drawn(picture, page, size, scroll);
                }
            }
        }
    }
}

#[test]
fn the_verdict_comes_first_and_what_is_stale_says_so() {
    let first = |age_ms, spiral| drawn(&picture(Duration::from_millis(age_ms), spiral), Page::Overview, (80, 24), 0);
    for (shown, expected) in [
        (first(10, -0.02), "Stability   STABLE: Dutch roll, roll and spiral decay"),
        (first(10, 0.02), "Stability   UNSTABLE: spiral grows, time to double 34.7 s"),
        (
            first(10, 0.001),
            "Stability   NOT KNOWN YET, because spiral is within three standard errors of neutral; Dutch roll and roll decay",
        ),
        (first(3100, -0.02), "Stability   STALE, 3.10 s old: last STABLE, Dutch roll, roll and spiral decay"),
    ] {
        let words: Vec<&str> = expected.split(' ').filter(|word| !word.is_empty()).collect();
        let found: Vec<&str> = shown.split([' ', '\n', '"']).filter(|word| !word.is_empty()).collect();
        assert!(found.windows(words.len()).any(|some| some == words), "{expected}\n{shown}");
    }
    assert!(first(10, -0.02).contains("12.40 s  CURRENT") && first(3100, -0.02).contains("12.40 s  STALE"));
}

#[test]
fn names_cannot_steer_the_terminal_and_no_number_is_shown_raw() {
    let picture = picture(Duration::from_millis(10), -0.02);
    for page in Page::ALL {
        for scroll in [0, usize::MAX] {
            let shown = drawn(&picture, page, (120, 50), scroll);
            assert!(shown.contains("flight \\x1b[2J 7, Puma\\u{202e}"), "{shown}");
            assert!(!shown.contains("NaN") && !shown.contains("inf ") && !shown.contains("000000000"), "{shown}");
        }
    }
}

#[test]
fn a_panic_gives_the_terminal_back_before_it_says_why() {
    let mut program = std::process::Command::new(std::env::current_exe().unwrap());
    let test = "command::watch::screen::open_screen::tests::a_screen_that_panics";
    program.args(["--ignored", "--exact", "--nocapture", "--test-threads=1", test]);
    let mut terminal = pseudo_terminal::PseudoTerminal::start(program, (80, 24));
    assert_eq!(terminal.ended(), 101);
    let written = terminal.bytes();
    let closed = written.find("\x1b[?1049l").unwrap();
    let said = written.find("on purpose").unwrap();
    assert!(written.contains("\x1b[?1049h") && written.contains("still") && closed < said, "{written:?}");
}
