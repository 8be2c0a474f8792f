//! The `lobes` command, run as a user runs it.
#![allow(clippy::unwrap_used, reason = "in a test")]

mod bake;
mod check;
mod compare;
mod faults;
mod figures;
mod frames;
mod maps;
mod parts;
mod reference;
mod refusals;
mod render;
mod spheres;
mod support;
mod trade;

use self::support::*;
use cosine_lobes::{ExrLayer, Output, write_exr};
use glam::Vec3;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

fn picture(folder: &Path, name: &str, width: usize, values: &[f32]) -> PathBuf {
    let path = folder.join(name);
    let values: Vec<Vec3> = values.iter().map(|v| Vec3::splat(*v)).collect();
    let layers = [ExrLayer::color("beauty", &values)];
    write_exr(Output::create(&path).unwrap(), width, values.len() / width, &layers).unwrap();
    path
}
