//! The part that counts allocations.

mod allocation;
