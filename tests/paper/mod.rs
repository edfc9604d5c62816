//! The paper's own story on flights of its models: Dutch roll against flight path.

mod collapse;
mod diagnosis;
mod flown;
mod monte_carlo;
mod path;
mod story;
