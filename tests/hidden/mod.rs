//! Hidden causes: flights that a seed draws, with an effect in them that only the case knows.
//!
//! `case` has the sealed case, `draw` what is hidden in it and how large, `outside` the causes that no effect describes,
//! `flights` what is flown and through which instruments, `motion` how much that moves, `written` the case as files,
//! `generator` the proof of the generator itself.
//! `off_trim` puts the model elsewhere than the aircraft flies, `background` makes much a little wrong besides,
//! `background_study` scores the diagnosis there.
//! `found` lets the diagnosis look, and scores it; `matched_filter` looks at the same cases by the nearest published method;
//! `live` looks while the flight goes on; `options` hides what the Level-1 simulation can leave out of itself; `real_spoilt`
//! spoils real flights, `real_pairs` holds the model of one against another. Nothing else here imports what looks for causes: the
//! generator shares the vocabulary of models and effects only.

mod background;
mod background_study;
mod case;
mod draw;
mod flights;
mod found;
mod generator;
mod live;
mod matched_filter;
mod motion;
mod off_trim;
mod options;
mod outside;
mod real_pairs;
mod real_spoilt;
mod written;
