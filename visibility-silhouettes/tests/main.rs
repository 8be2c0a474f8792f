//! Visibility of triangles.

mod coarse;
mod common;
mod flat;
mod groups;
mod metamorphic;
mod motion;
mod soups;
