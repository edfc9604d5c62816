//! Not written yet: this member is being built.
