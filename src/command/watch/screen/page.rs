//! A page on the screen: a bar with the run and its state, the pages' names, the page, the keys.

use super::super::bus_picture::BusPicture;
use super::ink::Ink;
use super::{derivatives, event_lines, help, instruments, link_words, modes, overview};
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;
use sideslip::io::outputs::words::printable::printable;

/// Width from which forces and moments stand beside each other.
const TWO_COLUMNS: u16 = 116;

/// Rows below which there is only the page.
const FRAMED: u16 = 6;

/// What can be shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Page {
    Overview,
    Derivatives,
    Modes,
    Instruments,
    Events,
    Help,
}

impl Page {
    pub(super) const ALL: [Page; 6] =
        [Page::Overview, Page::Derivatives, Page::Modes, Page::Instruments, Page::Events, Page::Help];

    const fn name(self) -> &'static str {
        match self {
            Page::Overview => "1 overview",
            Page::Derivatives => "2 derivatives",
            Page::Modes => "3 modes",
            Page::Instruments => "4 instruments",
            Page::Events => "5 events",
            Page::Help => "? help",
        }
    }
}

/// What is shown of the picture.
pub(super) struct View {
    pub(super) page: Page,
    /// First line that is shown.
    pub(super) scroll: usize,
    /// Lines of the page that had room when it was drawn last.
    pub(super) height: usize,
    pub(super) changed: bool,
    ink: Ink,
}

impl View {
    pub(super) fn new(ink: Ink) -> Self {
        View { page: Page::Overview, scroll: 0, height: 1, changed: true, ink }
    }

    pub(super) fn turn_to(&mut self, page: Page) {
        (self.page, self.scroll) = (page, 0);
    }

    pub(super) fn turn_by(&mut self, places: usize) {
        let place = Page::ALL.iter().position(|page| *page == self.page).unwrap_or(0);
        if let Some(page) = Page::ALL.get((place + places) % Page::ALL.len()) {
            self.turn_to(*page);
        }
    }

    /// Draws it, whatever the size.
    pub(super) fn draw(&mut self, frame: &mut Frame<'_>, picture: &BusPicture) {
        let whole = frame.area();
        if whole.height < FRAMED {
            let lines = self.lines(picture, whole);
            self.show(frame, whole, lines);
            return;
        }
        let layout = [Constraint::Length(1), Constraint::Length(1), Constraint::Min(1), Constraint::Length(1)];
        let [top, names, body, foot] = Layout::vertical(layout).areas(whole);
        let body = Rect { y: body.y + 1, height: body.height.saturating_sub(1), ..body };
        frame.render_widget(Paragraph::new(top_bar(picture, top.width)).style(Ink::bar()), top);
        frame.render_widget(Paragraph::new(self.names()), names);
        let hidden = if self.page == Page::Derivatives && body.width >= TWO_COLUMNS {
            self.two_columns(frame, body, picture)
        } else {
            let lines = self.lines(picture, body);
            self.show(frame, body, lines)
        };
        let more = if hidden > 0 { format!("   {hidden} more lines below") } else { String::new() };
        let keys = format!(" q: quit  ?: help  1-5: pages  up down: scroll{more}");
        frame.render_widget(Paragraph::new(keys).style(Ink::bar()), foot);
    }

    fn lines(&self, picture: &BusPicture, area: Rect) -> Vec<Line<'static>> {
        let (width, ink) = (usize::from(area.width), self.ink);
        match self.page {
            Page::Overview => overview::lines(picture, width, ink),
            Page::Derivatives => derivatives::one_column(derivatives::page(picture, width, ink)),
            Page::Modes => modes::lines(picture, width, ink),
            Page::Instruments => instruments::lines(picture, width, ink),
            Page::Events => event_lines::event_lines(picture, width, ink),
            Page::Help => help::lines(width),
        }
    }

    /// The part of the lines that has room; how many come after it.
    fn show(&mut self, frame: &mut Frame<'_>, area: Rect, lines: Vec<Line<'static>>) -> usize {
        self.height = usize::from(area.height);
        self.scroll = self.scroll.min(lines.len().saturating_sub(self.height));
        let after = lines.len().saturating_sub(self.scroll + self.height);
        let shown: Vec<Line<'static>> = lines.into_iter().skip(self.scroll).take(self.height).collect();
        frame.render_widget(Paragraph::new(shown), area);
        after
    }

    fn two_columns(&mut self, frame: &mut Frame<'_>, area: Rect, picture: &BusPicture) -> usize {
        let [head, axes] = Layout::vertical([Constraint::Length(1), Constraint::Min(0)]).areas(area);
        let [left, right] = Layout::horizontal([Constraint::Fill(1), Constraint::Fill(1)]).spacing(2).areas(axes);
        let page = derivatives::page(picture, usize::from(left.width), self.ink);
        frame.render_widget(Paragraph::new(page.head), head);
        let longest = page.moments.len().max(page.forces.len());
        self.height = usize::from(axes.height);
        self.scroll = self.scroll.min(longest.saturating_sub(self.height));
        for (lines, area) in [(page.moments, left), (page.forces, right)] {
            let shown: Vec<Line<'static>> = lines.into_iter().skip(self.scroll).take(self.height).collect();
            frame.render_widget(Paragraph::new(shown), area);
        }
        longest.saturating_sub(self.scroll + self.height)
    }

    fn names(&self) -> Line<'static> {
        let name = |page: Page| {
            let style = if page == self.page { Ink::bar().patch(Ink::bold()) } else { ratatui::style::Style::new() };
            [Span::styled(format!(" {} ", page.name()), style), Span::raw(" ")]
        };
        Line::from_iter(Page::ALL.into_iter().flat_map(name))
    }
}

/// The run on the left, its time and whether the numbers are of now on the right.
fn top_bar(picture: &BusPicture, width: u16) -> Line<'static> {
    let state = match &picture.estimate {
        None => "NO ESTIMATE ".to_owned(),
        Some(estimate) => {
            let word = if link_words::is_current(picture) { "CURRENT" } else { "STALE" };
            format!("{:.2} s  {word} ", estimate.derivatives.time_s)
        }
    };
    let room = usize::from(width).saturating_sub(state.chars().count() + 1);
    let mut left = format!(" sideslip watch  {}", printable(&picture.run));
    for more in [&picture.aircraft, &picture.manoeuvre].into_iter().flatten() {
        let longer = format!("{left}, {}", printable(more));
        if longer.chars().count() <= room {
            left = longer;
        }
    }
    let left: String = left.chars().take(room).collect();
    Line::from(format!("{left:<room$} {state}"))
}
