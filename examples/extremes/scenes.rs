//! A scene of another size and at another place is the same picture.

use crate::table::Table;
use cosine_lobes::render_cpu::{CpuShader, GBuffer, SceneSilhouettes, SurfaceHits, World};
use cosine_lobes::scene::{self, Frame, Shade};
use cosine_lobes::shading::Accuracy;
use cosine_lobes::visibility_mask::MaskVisibility;
use cosine_lobes::visibility_silhouettes::SilhouetteBlockers;
use glam::Vec3;
use std::error::Error;
use std::path::Path;

const MESH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/assets/spot.obj");

fn text(size: f64, to: f64) -> String {
    let at = |x: f64, y: f64, z: f64| format!("[{:?}, {:?}, {:?}]", size * x + to, size * y, size * z - to);
    format!(
        "[image]\nwidth = 96\nheight = 54\n[camera]\neye = {}\ntarget = {}\n[[objects]]\nquad = {{ center = {}, u = [0, 0, {:?}], \
         v = [{:?}, 0, 0] }}\n[[objects]]\nmesh = \"{MESH}\"\nscale = {:?}\ntranslate = {}\n[[lights]]\nkind = \"sphere\"\n\
         center = {}\nradius = {:?}\nradiance = 30\n",
        at(1.0, 2.0, 4.0),
        at(0.0, 0.5, 0.0),
        at(0.0, 0.0, 0.0),
        10.0 * size,
        10.0 * size,
        0.7 * size,
        at(0.0, 0.55, 0.0),
        at(-2.0, 4.0, 1.0),
        0.4 * size
    )
}

fn render(folder: &Path, size: f64, to: f64) -> Result<Vec<Vec3>, Box<dyn Error>> {
    let file = folder.join("scene.toml");
    std::fs::write(&file, text(size, to))?;
    let scene = scene::load(&file)?;
    let world = World::new(&scene);
    let points = GBuffer::new(&world, scene.width, scene.height, 1);
    let silhouettes = SceneSilhouettes::new(&scene, |object| object == 1);
    let blockers = SilhouetteBlockers::new(silhouettes.meshes(), SurfaceHits::new(&world, |object| object == 1));
    let (materials, lights) = (&scene.materials, &scene.lights);
    let frame = Frame::new(materials, lights, Accuracy::new(0.003));
    let mut radiance = vec![Vec3::ZERO; points.len()];
    CpuShader::new(MaskVisibility::new(blockers)).shade(&points.points, &frame, &mut radiance)?;
    Ok(points.resolve(&radiance, Vec3::ZERO))
}

/// The largest difference of a pixel over the brightest one, as the value; it should be 0.
pub(crate) fn same(table: &mut Table) -> Result<(), Box<dyn Error>> {
    Table::head("Largest difference of a pixel, over the brightest, to the scene as it is", &["scene"]);
    let folder = tempfile::tempdir()?;
    let whole = render(folder.path(), 1.0, 0.0)?;
    let peak = whole.iter().map(|p| p.max_element()).fold(0.0, f32::max);
    for (name, size, to) in [
        ("1e-6 times as large", 1e-6, 0.0),
        ("1e-4 times as large", 1e-4, 0.0),
        ("1e6 times as large", 1e6, 0.0),
        ("moved by 1e3", 1.0, 1e3),
        ("moved by 1e5", 1.0, 1e5),
        ("moved by 1e6", 1.0, 1e6),
        ("1e-3 times as large, moved by 1e3", 1e-3, 1e3),
    ] {
        let other = render(folder.path(), size, to)?;
        let apart = whole.iter().zip(&other).map(|(a, b)| (*a - *b).abs().max_element() / peak).fold(0.0, f32::max);
        table.row(&[name.to_owned()], apart, 0.0, 1.0, 1e-3);
    }
    Ok(())
}
