//! The paper as printed.

pub(crate) mod gauss;
