//! Real recordings, where they are at hand: numbers that are found from them, none of their rows.

use super::case::Case;
use super::log::Whole;
use crate::support::program::real;

/// Puts recordings beside the case; where one is absent nothing is compared, which was said.
fn at_hand(case: &mut Case, names: &[&str]) -> bool {
    for name in names {
        let Some(file) = real(name) else {
            case.skip();
            return false;
        };
        std::os::unix::fs::symlink(file.canonicalize().unwrap(), case.folder.join(name)).unwrap();
    }
    true
}

/// Instruments of the ATTAS.
pub(crate) fn checked(case: &mut Case) {
    if at_hand(case, &["attas-rud1.csv"]) {
        case.run("check attas-rud1.csv --json answer.json");
        case.json("answer.json");
    }
}

/// Derivatives and a replay of the ATTAS.
pub(crate) fn estimated(case: &mut Case) {
    if at_hand(case, &["attas-rud1.csv", "attas-ail1.csv"]) {
        case.run("identify attas-rud1.csv attas-ail1.csv --states p,r --inputs aileron,rudder,beta --json identify.json");
        case.json("identify.json");
        case.run("replay attas-rud1.csv --output-error off --json replay.json --out log.mcap --smoothed smoothed.csv");
        case.json("replay.json");
        case.log("log.mcap", Whole::None);
        case.table("smoothed.csv", false);
    }
}
