//! Visibility from sphere sets: building, culling and splatting.
