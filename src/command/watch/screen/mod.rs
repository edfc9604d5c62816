//! The screen: pages drawn from what is known of the bus, keys, resizes.

mod derivatives;
mod event_lines;
mod help;
mod ink;
mod instruments;
mod link_words;
mod mode_lines;
mod modes;
pub(super) mod open_screen;
mod overview;
mod page;
#[cfg(test)]
mod screen_tests;

use super::bus_picture::{BusListener, BusPicture};
use super::nobody::running_elsewhere;
use super::repetition::Repetition;
use ink::Ink;
use open_screen::OpenScreen;
use page::{Page, View};
use ratatui::crossterm::event::{Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers, poll, read};
use sideslip::error::{Failure, Outcome};
use sideslip::io::bus::role_holder::RoleHolder;
use sideslip::io::outputs::tables::terminal::Style;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Interval of the output where none is named.
const EVERY: Duration = Duration::from_millis(250);

/// The longest between two looks at the bus, whose queues are short, and at the signals.
const SLICE: Duration = Duration::from_millis(50);

/// How often is asked who is there.
const PROCESSES: Duration = Duration::from_millis(500);

/// Shows until `q`, ctrl-C or a signal.
pub(super) fn run(
    screen: &mut OpenScreen,
    mut listener: BusListener,
    picture: &mut BusPicture,
    repetition: Repetition,
    stop: &AtomicBool,
) -> Result<Outcome, Failure> {
    let every = repetition.every.unwrap_or(EVERY);
    let mut view = View::new(Ink { colour: Style::of_stream(&std::io::stdout()) == Style::Colour });
    let (mut due, mut ask) = (Instant::now(), Instant::now());
    let mut outputs = 0;
    while !stop.load(Ordering::Relaxed) && repetition.more_after(outputs) {
        match screen.stop_and_go_on() {
            Ok(anew) => view.changed |= anew,
            Err(_) => break,
        }
        let now = Instant::now();
        listener.take_in(picture)?;
        if now >= ask {
            ask = now + PROCESSES;
            listener.name_run(picture);
            listener.name_processes(picture);
            let alone = picture.estimator == RoleHolder::Nobody;
            picture.elsewhere = if alone { running_elsewhere(&picture.root) } else { None };
        }
        if now >= due {
            due = (due + every).max(now);
            outputs += 1;
            view.changed = true;
        }
        if std::mem::take(&mut view.changed) && screen.terminal.draw(|frame| view.draw(frame, picture)).is_err() {
            // A terminal that has gone is no failure of the reader.
            break;
        }
        match keys(screen, &mut view, SLICE.min(due.saturating_duration_since(Instant::now()))) {
            Ok(true) => {}
            Ok(false) | Err(_) => break,
        }
    }
    Ok(Outcome::Done)
}

/// Waits that long for keys and takes those that are there; whether to go on.
fn keys(screen: &mut OpenScreen, view: &mut View, wait: Duration) -> std::io::Result<bool> {
    if !screen.wait_for_keys(wait)? {
        return Ok(false);
    }
    while poll(Duration::ZERO)? {
        match read()? {
            Event::Key(key) if key.kind != KeyEventKind::Release => {
                if ends(key) {
                    return Ok(false);
                }
                if key.code == KeyCode::Char('z') && key.modifiers.contains(KeyModifiers::CONTROL) {
                    screen.stop();
                    return Ok(true);
                }
                if key.code == KeyCode::Char('l') && key.modifiers.contains(KeyModifiers::CONTROL) {
                    screen.terminal.clear()?;
                }
                press(view, key);
                view.changed = true;
            }
            Event::Resize(..) => view.changed = true,
            _ => {}
        }
    }
    Ok(true)
}

fn ends(key: KeyEvent) -> bool {
    match key.code {
        KeyCode::Char('c' | 'd') => key.modifiers.contains(KeyModifiers::CONTROL),
        KeyCode::Char('q' | 'Q') => true,
        _ => false,
    }
}

/// What a key does that does not end it.
fn press(view: &mut View, key: KeyEvent) {
    let half = view.height.max(1);
    match key.code {
        KeyCode::Char('?' | 'h') | KeyCode::F(1) => view.turn_to(Page::Help),
        KeyCode::Char(digit @ '1'..='9') => {
            let place = digit as usize - '1' as usize;
            if let Some(page) = Page::ALL.get(place) {
                view.turn_to(*page);
            }
        }
        KeyCode::Esc => view.turn_to(Page::Overview),
        KeyCode::Tab | KeyCode::Right => view.turn_by(1),
        KeyCode::BackTab | KeyCode::Left => view.turn_by(Page::ALL.len() - 1),
        KeyCode::Up | KeyCode::Char('k') => view.scroll = view.scroll.saturating_sub(1),
        KeyCode::Down | KeyCode::Char('j') => view.scroll = view.scroll.saturating_add(1),
        KeyCode::PageUp => view.scroll = view.scroll.saturating_sub(half),
        KeyCode::PageDown | KeyCode::Char(' ') => view.scroll = view.scroll.saturating_add(half),
        KeyCode::Home => view.scroll = 0,
        KeyCode::End => view.scroll = usize::MAX,
        _ => {}
    }
}
