//! The Puma's published matrices go through a model file and come back, with their Dutch roll.

use crate::support::puma::published_puma;
use sideslip::dynamics::linear::{input_matrix, state_matrix};
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::flight::file::model_file::ModelFile;
use sideslip::realtime::modes::naming::eigenmodes;

const SPEEDS_KN: [u32; 8] = [0, 20, 40, 60, 80, 100, 120, 140];

#[test]
fn matrices_come_back_out_of_a_model_file() {
    for knots in SPEEDS_KN {
        let Some(published) = published_puma(knots) else { return };
        let file = ModelFile::of("puma", published.model());
        let model = ModelFile::parse(&file.to_toml()).unwrap().linear;
        let (a, b) = (state_matrix(&model), input_matrix(&model, &[]));
        let mut worst = (0.0, 0, 0);
        for row in 0..8 {
            for column in 0..8 {
                // Gravity entries: 9.80665 for the book's 9.81, and the trim out of four printed digits.
                let allowed = if matches!((row, column), (0 | 1 | 4, 3 | 6)) { 4.5e-3 } else { 1e-3 };
                let off = (a[(row, column)] - published.a[row][column]).abs();
                assert!(
                    off < allowed,
                    "{knots} kn, A({row}, {column}): {} is not {}",
                    a[(row, column)],
                    published.a[row][column]
                );
                if off > worst.0 {
                    worst = (off, row, column);
                }
            }
            for column in 0..4 {
                assert!((b[(row, column)] - published.b[row][column]).abs() < 1e-12, "{knots} kn, B({row}, {column})");
            }
        }
        eprintln!("{knots} kn: largest difference {:.1e} at A({}, {})", worst.0, worst.1, worst.2);
    }
}

#[test]
fn aerodynamic_parts_are_small_where_kinematics_are_taken_out() {
    for knots in SPEEDS_KN {
        let Some(published) = published_puma(knots) else { return };
        let model = published.model();
        for (axis, variable) in [(Axis::X, Variable::Q), (Axis::Y, Variable::P), (Axis::Y, Variable::R), (Axis::Z, Variable::Q)] {
            let value = model.derivative(axis, variable);
            assert!(value.abs() < 1.0, "{knots} kn, {}_{:?}: {value}", axis.name(), variable);
        }
    }
}

#[test]
fn the_dutch_roll_is_the_published_one() {
    // Eigenvalues of the published eight-state matrices.
    for (knots, real, imag) in
        [(40, -0.154, 0.918), (60, -0.205, 1.035), (80, -0.184, 1.054), (100, -0.107, 1.023), (120, -0.003, 0.940)]
    {
        let Some(published) = published_puma(knots) else { return };
        let mode = eigenmodes(&state_matrix(&published.model())).unwrap().dutch_roll.unwrap();
        eprintln!("{knots} kn: {:.4} +- {:.4}i", mode.re, mode.im);
        assert!((mode.re - real).abs() < 0.003 && (mode.im - imag).abs() < 0.003, "{knots} kn: {mode}");
    }
}
