//! `identify` in each of its ways.

use super::case::Case;
use super::flights::LINEAR;

/// All eight states of a helicopter from three runs, a fourth predicted; every output.
pub(crate) fn helicopter(case: &mut Case) {
    case.fly_four();
    case.run("identify a.csv b.csv c.csv --holdout h.csv --json answer.json --out result");
    case.json_within("answer.json", 13_000);
    case.keys("result/model.toml");
    case.drawing("result/report.html");
}

/// Chosen states and inputs: by output error, by filter error, and with the instruments in doubt.
pub(crate) fn lateral(case: &mut Case) {
    case.fly_four();
    let chosen = "--states v,p,phi,r --inputs lat_cyclic,pedal";
    case.run(&format!("identify a.csv b.csv {chosen} --holdout h.csv --json chosen.json"));
    case.json("chosen.json");
    case.run(&format!("identify a.csv b.csv {chosen} --doubt-instruments --json doubted.json"));
    case.json("doubted.json");
    case.prepare(&format!(
        "simulate --model {LINEAR} --rate 50 --noise flight --seed 9 --turbulence 1 --duration 14 --input pedal:3211:0.02:0.7 \
         --input lat_cyclic:doublet:0.01:1:8 --out gusty.csv"
    ));
    case.run(&format!("identify gusty.csv {chosen} --method filter-error --json filtered.json"));
    case.json("filtered.json");
}

/// One equation, term by term.
pub(crate) fn stepwise(case: &mut Case) {
    case.fly_four();
    case.run("identify a.csv b.csv --response ay --candidates beta;p;r;pedal;lat_cyclic;beta*r;beta*|beta| --json force.json");
    case.json("force.json");
    case.run("identify c.csv --response az --candidates alpha;q;collective;alpha^2;alpha*q;spline(alpha,0.01) --json lift.json");
    case.json("lift.json");
}

/// Equations from a band of frequencies.
pub(crate) fn frequency(case: &mut Case) {
    case.fly_four();
    case.run(
        "identify a.csv b.csv --domain frequency --band 0.1:1.2 --states v,p,phi,r --inputs lat_cyclic,pedal --json answer.json",
    );
    case.json_within("answer.json", 13_000);
}

/// Runs of two test points beside the simulation trimmed at each, on the lateral axes.
pub(crate) fn test_points(case: &mut Case) {
    for (place, name) in ["descent", "level"].into_iter().enumerate() {
        case.fly(
            &format!("replay/models/puma-flight-{name}.toml"),
            20 + place as u32,
            "pedal:3211:0.02:0.7",
            &format!("{name}1.csv"),
        );
        let inputs = "lat_cyclic:3211:0.008:0.6";
        case.fly(&format!("replay/models/puma-flight-{name}.toml"), 30 + place as u32, inputs, &format!("{name}2.csv"));
    }
    case.run(
        "identify descent1.csv level1.csv descent2.csv level2.csv --states v,p,phi,r --inputs lat_cyclic,pedal --model puma \
         --density 1.024 --json answer.json --out result",
    );
    case.json_within("answer.json", 13_000);
    case.keys("result/model-descent1.toml");
    case.keys("result/model-level1.toml");
    case.drawing("result/report.html");
}

/// Static derivatives from steady-heading sideslips of the Level-1 model.
pub(crate) fn steady_sideslips(case: &mut Case) {
    let flight = "simulate --model puma --speed 51.44 --density 1.024 --noise flight --rate 50";
    case.prepare(&format!("{flight} --input pedal:3211:0.01:0.7 --seed 1 --duration 12 --out moved1.csv"));
    case.prepare(&format!("{flight} --input lat_cyclic:3211:0.006:0.6 --seed 2 --duration 12 --out moved2.csv"));
    let mut call =
        "identify moved1.csv moved2.csv --states v,p,phi,r --inputs lat_cyclic,pedal,q,alpha --outputs beta,p,phi,r,ay \
                    --model puma --density 1.024 --json answer.json"
            .to_owned();
    for (place, sideslip) in ["-0.09", "-0.045", "0", "0.045", "0.09"].into_iter().enumerate() {
        case.prepare(&format!(
            "{flight} --sideslip={sideslip} --input pedal:step:0.00001:1 --seed {place} --duration 6 --out held{place}.csv"
        ));
        call += &format!(" --sideslips held{place}.csv");
    }
    case.run(&call);
    case.json("answer.json");
}
