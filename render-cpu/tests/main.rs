//! Shading on the CPU.

mod conformance;
mod exact;
mod many_lights;
mod openings;
mod order;
mod rays;
mod sky;
mod textures;
mod tiles;
mod windows;
