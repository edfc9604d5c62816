//! The slow part: whole diagnoses of broken flights.

mod diagnose;

/// With whole searches, on three flights and on a simulation that curves.
#[test]
fn examples_of_diagnose_run_as_they_are_pasted() {
    crate::support::help_examples::run_examples("examples-diagnose", |name| name == "diagnose");
}
