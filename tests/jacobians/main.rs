//! Matrices and solutions that we write by hand, against differences and closed forms.

mod linear_model;
