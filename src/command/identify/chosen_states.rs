//! Why a model has the states that nobody asked for, in a sentence.

use sideslip::postflight::identification::columns::Columns;
use sideslip::postflight::identification::model_variables::{ModelVariables, is_control};
use sideslip::postflight::identification::usual_variables::{ModelPlanes, UsualVariables};

/// What was chosen, by which runs, and how to choose otherwise.
pub(super) fn note(usual: &UsualVariables, variables: &ModelVariables, runs: &[Columns]) -> String {
    let of = |longitudinal: bool| -> String {
        let plane = usize::from(!longitudinal);
        let names = runs.iter().zip(&usual.excited).filter(|(_, excited)| excited.get(plane) == Some(&true));
        let names: Vec<&str> = names.map(|(run, _)| run.run.as_str()).collect();
        if names.is_empty() { "no run".to_owned() } else { names.join(", ") }
    };
    let states = variables.states.join(" ");
    let (why, other) = match usual.planes {
        ModelPlanes::Coupled => {
            ("a helicopter, whose planes of motion are coupled".to_owned(), "--states v,p,phi,r takes the lateral motion alone")
        }
        ModelPlanes::Separate => (
            format!(
                "both planes of motion: the longitudinal one excited in {}, the lateral one in {}; derivatives from one to the other \
                 are taken as zero",
                of(true),
                of(false)
            ),
            "--states and --inputs with the runs of one plane take it alone",
        ),
        ModelPlanes::Lateral => (
            format!("the lateral motion, excited in {}; the longitudinal controls excited {}", of(false), of(true)),
            "--states w,q takes the longitudinal motion",
        ),
        ModelPlanes::Longitudinal => (
            format!("the longitudinal motion, excited in {}; the lateral controls excited {}", of(true), of(false)),
            "--states v,p,phi,r takes the lateral motion",
        ),
    };
    let controls: Vec<&str> = variables.inputs.iter().map(String::as_str).filter(|name| is_control(name)).collect();
    format!("the states {states} with the inputs {} were chosen by what moved: {why}; {other}", controls.join(" "))
}

/// That accelerometers were recorded which would tell the forces of these states, and are no outputs.
pub(super) fn unused_accelerometers(variables: &ModelVariables, runs: &[Columns]) -> Option<String> {
    let has = |name: &str| runs.iter().all(|run| run.has(name));
    let tells = |(state, force): &(&str, &str)| {
        variables.states.iter().any(|own| own == state) && !variables.outputs.iter().any(|own| own == force) && has(force)
    };
    let unused: Vec<&str> =
        [("u", "ax"), ("v", "ay"), ("w", "az")].iter().filter(|one| tells(one)).map(|(_, force)| *force).collect();
    if unused.is_empty() {
        return None;
    }
    let outputs: Vec<&str> = variables.outputs.iter().map(String::as_str).chain(unused.iter().copied()).collect();
    Some(format!(
        "{} recorded and not among the outputs, so the force derivatives rest on the air data alone; --outputs {} uses what was recorded",
        if let [one] = unused[..] { format!("{one} is") } else { format!("{} are", unused.join(" and ")) },
        outputs.join(",")
    ))
}
