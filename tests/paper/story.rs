//! Section 4: descent, level, climb. The roots come back, and the climb is seen unstable.

use crate::flown::{flights, identified};
use crate::paper_cases::PAPER;
use crate::program::folder;
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::simulation::linear::state_matrix;

#[test]
fn the_models_flown_have_the_printed_roots() {
    for case in PAPER {
        let model = case.model();
        let a = state_matrix(&model).fixed_view::<4, 4>(4, 4).into_owned();
        let near = |root: &nalgebra::Complex<f64>| (root.re - case.root.0).hypot(root.im - case.root.1) < 1e-9;
        assert!(a.complex_eigenvalues().iter().any(near), "{}: {}", case.name, a.complex_eigenvalues());
        let (l_v, n_v) = (model.derivative(Axis::L, Variable::V), model.derivative(Axis::N, Variable::V));
        eprintln!("{}: L_v {l_v:.5} for {}, N_v {n_v:.5} for {}", case.name, case.l_v, case.n_v);
        assert!((l_v / case.l_v - 1.0).abs() < 0.06 && (n_v / case.n_v - 1.0).abs() < 0.06);
    }
}

#[test]
fn the_printed_roots_come_back_and_the_climb_is_unstable() {
    let folder = folder("paper-story");
    for case in PAPER {
        let runs = flights(&folder, &case, 1);
        let answer = identified(&runs, &["--states", "v,p,phi,r", "--outputs", "beta,p,phi,r,ay", "--doubt-instruments"]);
        let pair = &answer["modes"]["dutch_roll"];
        let number = |key: &str| pair[key].as_f64().unwrap();
        let off = [(number("real") - case.root.0) / number("std_real"), (number("imag") - case.root.1) / number("std_imag")];
        let unstable = number("probability_unstable");
        eprintln!("{}: {pair}; off by {off:.2?} standard errors", case.name);
        assert!(off.into_iter().all(|off| off.abs() < 3.0), "{}: {off:?}", case.name);
        assert!(if case.root.0 > 0.0 { unstable > 0.95 } else { unstable < 0.05 }, "{}: {unstable}", case.name);
    }
}
