//! The slow part: whole diagnoses of broken flights.

mod diagnose;
