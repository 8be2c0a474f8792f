//! Shading on the CPU and the Monte-Carlo reference.
