//! A renderer out of the crates, in forty lines: a sphere over a floor, lit by a round light.
//!
//! `cargo run --release --example compose` writes compose.png. Swap the visibility: `Unshadowed` for no shadows, any
//! other `Visibility` for your own.

use cosine_lobes::brdf::Lambert;
use cosine_lobes::lighting::SphereLight;
use cosine_lobes::lobe_core::{Receiver, Sphere};
use cosine_lobes::shading::{
    Accuracy, BrdfLobes, FractionIntegrator, Integrator, Interaction, LightId, LightLobes, LightVisibility, Visibility,
};
use cosine_lobes::visibility_mask::MaskVisibility;
use cosine_lobes::visibility_spheres::SphereBlockers;
use cosine_lobes::{Output, Picture, srgb_bytes, write_png};
use glam::Vec3;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (width, height) = (640, 360);
    let material = Lambert { albedo: Vec3::new(0.8, 0.7, 0.6) };
    let sphere = Sphere { center: Vec3::new(0.0, 0.8, 0.0), radius: 0.5 };
    let light = SphereLight::new(Sphere { center: Vec3::new(2.0, 4.0, 1.0), radius: 0.6 }, Vec3::splat(60.0));
    let visibility = MaskVisibility::new(SphereBlockers::new(&[sphere], &[1], &[]));
    let accuracy = Accuracy::new(0.003);

    let mut scratch = visibility.scratch();
    let mut lobes = Vec::new();
    let mut pixels = Vec::new();
    for i in 0..width * height {
        // A view from straight above: pixels are points of the floor.
        let (x, z) = ((i % width) as f32 / 100.0 - 3.2, (i / width) as f32 / 100.0 - 1.8);
        let at = Receiver::on_surface(Vec3::new(x, 0.0, z), Vec3::Y, Vec3::Y).on_object(0);
        lobes.clear();
        material.brdf_lobes(&at, &mut lobes);
        let term = light.seen_from(&at);
        let call = Interaction { at: &at, brdf: &lobes, light: &term, threshold: 0.0 };
        let mut visit = LightVisibility::alone(&visibility, LightId(0), accuracy, &mut scratch);
        let lit = FractionIntegrator.radiance(&call, &mut visit, &mut (), &mut ());
        pixels.push(lit.radiance);
    }
    let picture = Picture::new(width, height, pixels);
    write_png(Output::create("compose.png")?, width, height, &srgb_bytes(&picture, 0.0))?;
    Ok(())
}
