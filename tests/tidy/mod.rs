//! Tidiness: what a reader relies on in the source tree is checked here, so that it stays true.
//!
//! Everything is read as text below the package's root. Each rule is also tried on a text that breaks it, for a rule that
//! cannot fail proves nothing.

mod cycles;
mod imports;
mod links;
mod reached;
mod sources;
mod standards;
mod type_names;
mod wording;
