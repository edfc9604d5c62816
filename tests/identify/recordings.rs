//! Real recordings with a published answer.

use crate::support::identified::{derivative, identified};
use crate::support::program::real;

/// The author's ten derivatives are of these two recordings and a repeat of each that is not here.
#[test]
fn the_attas_has_the_authors_ten_derivatives() {
    let (Some(rudder), Some(aileron)) = (real("attas-rud1.csv"), real("attas-ail1.csv")) else { return };
    let (status, answer) = identified(&[&rudder, &aileron], &["--states", "p,r", "--inputs", "aileron,rudder,beta"]);
    assert!(status == 0 && answer["output_error"]["converged"] == true);
    let published = [
        ("L_p", -2.067),
        ("L_r", 1.029),
        ("L_aileron", -6.306),
        ("L_rudder", 1.145),
        ("L_beta", -3.844),
        ("N_p", -0.1839),
        ("N_r", -0.4856),
        ("N_aileron", -0.3912),
        ("N_rudder", -1.761),
        ("N_beta", 3.031),
    ];
    for (name, value) in published {
        let (found, std) = derivative(&answer, name);
        let off = (found - value).abs();
        eprintln!("{name} {found:.4} +- {std:.4}, published {value}: {:.2} s.e., {:.1} %", off / std, 100.0 * off / value.abs());
        assert!(off < 3.0 * std, "{name}: {found} +- {std}, published {value}");
        if ["L_p", "L_aileron", "L_beta", "N_beta", "N_rudder"].contains(&name) {
            assert!(off < 0.03 * f64::abs(value), "{name}: {found}, published {value}");
        }
    }
    assert!(answer["modes"]["reason"].as_str().unwrap().contains("`beta` is an input"));
}

#[test]
fn with_sideslip_put_right_the_attas_has_its_dutch_roll() {
    let (Some(rudder), Some(aileron)) = (real("attas-rud1.csv"), real("attas-ail1.csv")) else { return };
    let more = ["--states", "beta,p,phi,r", "--inputs", "aileron,rudder", "--set", "vane_position_m=[13.08,0,0]"];
    let (status, answer) = identified(&[&rudder, &aileron], &more);
    let pair = &answer["modes"]["dutch_roll"];
    let number = |key: &str| pair[key].as_f64().unwrap();
    let (omega, zeta) = (number("omega"), number("zeta"));
    eprintln!("{pair}");
    assert!(status == 0 && (1.77..=1.86).contains(&omega) && (0.080..=0.095).contains(&zeta), "{pair}");
}

#[test]
fn the_attas_has_its_short_period() {
    let Some(elevator) = real("attas-elv1.csv") else { return };
    let (status, answer) = identified(&[&elevator], &["--states", "alpha,q", "--inputs", "elevator"]);
    let pair = &answer["modes"]["short_period"];
    let (omega, zeta) = (pair["omega"].as_f64().unwrap(), pair["zeta"].as_f64().unwrap());
    eprintln!("{pair}");
    assert!(status == 0 && (omega / 2.53 - 1.0).abs() < 0.01 && (zeta / 0.493 - 1.0).abs() < 0.04, "{pair}");
    let published = [
        ("Z_alpha", -0.4834),
        ("Z_q", 0.1042),
        ("Z_elevator", 0.6763),
        ("M_alpha", -4.926),
        ("M_q", -2.006),
        ("M_elevator", -7.208),
    ];
    for (name, value) in published {
        let (found, std) = derivative(&answer, name);
        eprintln!("{name} {found:.4} +- {std:.4}, published {value}");
        assert!((found - value).abs() < 3.0 * std, "{name}: {found} +- {std}, published {value}");
    }
}

/// Published: Cm on alpha, qhat, elevator -1.47617, -36.3533, -1.86877 with alpha*elevator offered and not taken.
#[test]
fn the_twin_otter_has_its_published_equation() {
    let Some(file) = real("twin-otter-020213f1_018.csv") else { return };
    let more = ["--response", "Cm", "--candidates", "alpha;qhat;elevator;alpha*elevator;alpha^2;alpha*qhat"];
    let (status, answer) = identified(&[&file], &more);
    let terms = answer["regression"]["terms"].as_array().unwrap();
    assert!(status == 0 && terms.len() == 3, "{terms:?}");
    for (name, published) in [("alpha", -1.47617), ("qhat", -36.3533), ("elevator", -1.86877)] {
        let term = terms.iter().find(|term| term["name"] == name).unwrap();
        assert!((term["value"].as_f64().unwrap() / published - 1.0).abs() < 0.002, "{term}");
        assert!(term["partial_f"].as_f64().unwrap() < term["partial_f_white"].as_f64().unwrap(), "coloured residuals: {term}");
    }
    assert_eq!(answer["regression"]["steps"].as_array().unwrap().len(), 4);
}

#[test]
fn where_sideslip_is_hidden_the_roots_hold_and_the_derivatives_are_not_believed() {
    let Some(file) = real("citation-2018-dutchroll.csv") else { return };
    let (status, answer) = identified(&[&file], &[]);
    let notes = answer["notes"].to_string();
    assert!(status == 0 && notes.contains("sideslip is neither state nor input"), "{notes}");
    let root = &answer["modes"]["others"][0];
    let (omega, zeta) = (root["omega"].as_f64().unwrap(), root["zeta"].as_f64().unwrap());
    assert!((2.03..=2.10).contains(&omega) && (0.085..=0.115).contains(&zeta), "{root}");
}
