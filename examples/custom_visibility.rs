//! A visibility strategy of one's own in one `impl`: a table of legs and a top that are exact boxes, no mesh and no
//! spheres needed to block. Used statically and behind `Box<dyn DynVisibility>`, with the same picture.
//!
//! `cargo run --release --example custom_visibility` writes custom_visibility.png.

use cosine_lobes::brdf::Material;
use cosine_lobes::lighting::SphereLight;
use cosine_lobes::lobe_core::{Cone, Sphere};
use cosine_lobes::render_cpu::{CpuShader, GBuffer, World};
use cosine_lobes::scene::{Camera, Frame, Mesh, Object, Projection, Proxy, Scene, Shade};
use cosine_lobes::shading::{Accuracy, Coverage, DynVisibility, VisibilityQuery};
use cosine_lobes::visibility_mask::{Blockers, Contour, Mask, MaskVisibility};
use cosine_lobes::{Output, Picture, srgb_bytes, write_png};
use glam::Vec3;

/// Axis-aligned boxes: centre and size.
struct Boxes(Vec<(Vec3, Vec3)>);

impl Boxes {
    /// Whether a ray from `x` enters one of the boxes nearer than the light (slabs).
    fn hide(&self, x: Vec3, v: Vec3, distance: f32) -> bool {
        self.0.iter().any(|(center, size)| {
            let (a, b) = ((*center - 0.5 * *size - x) / v, (*center + 0.5 * *size - x) / v);
            let (enter, exit) = (a.min(b).max_element(), a.max(b).min_element());
            // A receiver lies on its own box up to rounding.
            enter < exit && exit > 1e-4 && enter < distance
        })
    }
}

impl Blockers for Boxes {
    type Scratch = Contour;

    fn scratch(&self) -> Contour {
        Contour::default()
    }

    /// Something may be hidden where the sphere around a box meets the cone of light.
    fn select(&self, query: &VisibilityQuery<'_>, _: &mut Contour) -> Coverage {
        let (x, cone) = (query.at.position, query.cone);
        let meets = |(center, size): &(Vec3, Vec3)| {
            let sphere = Cone::of_sphere(x, Sphere { center: *center, radius: 0.5 * size.length() });
            let reach = sphere.cos().acos() + cone.cos().acos();
            sphere.one_minus_cos > 1.0 || sphere.axis.angle_between(cone.axis) < reach
        };
        if self.0.iter().any(meets) { Coverage::Partial } else { Coverage::Lit }
    }

    fn splat(&self, query: &VisibilityQuery<'_>, contour: &mut Contour, mask: &mut Mask) {
        contour.block(mask, |v| self.hide(query.at.position, v, query.cone.distance));
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let leg = |x: f32, z: f32| (Vec3::new(x, 0.35, z), Vec3::new(0.08, 0.7, 0.08));
    let top = (Vec3::Y * 0.73, Vec3::new(1.4, 0.06, 0.9));
    let boxes = vec![leg(-0.6, -0.35), leg(0.6, -0.35), leg(-0.6, 0.35), leg(0.6, 0.35), top];
    let mut table = Mesh::default();
    boxes.iter().for_each(|(center, size)| table.append(&Mesh::cuboid(*center, *size)));
    let floor = Mesh::quad(Vec3::ZERO, Vec3::X * 8.0, Vec3::NEG_Z * 8.0);
    let scene = Scene {
        camera: Camera {
            eye: Vec3::new(1.0, 1.9, 3.6),
            target: Vec3::Y * 0.3,
            up: Vec3::Y,
            projection: Projection::perspective(0.6),
        },
        width: 640,
        height: 400,
        materials: vec![Material::lambert(Vec3::new(0.7, 0.68, 0.64)), Material::lambert(Vec3::new(0.5, 0.27, 0.13))],
        objects: vec![Object::mesh("floor", floor, 0, Proxy::None), Object::mesh("table", table, 1, Proxy::None)],
        lights: vec![
            SphereLight::new(Sphere { center: Vec3::new(-2.0, 4.0, 1.5), radius: 0.5 }, Vec3::splat(120.0)).into(),
        ],
        ..Scene::default()
    };
    let points = GBuffer::new(&World::new(&scene), 640, 400, 4);
    let frame = Frame::new(&scene.materials, &scene.lights, Accuracy::new(0.003));
    let visibility = MaskVisibility::new(Boxes(boxes.clone()));
    let (mut radiance, mut again) = (vec![Vec3::ZERO; points.len()], vec![Vec3::ZERO; points.len()]);
    CpuShader::new(visibility).shade(&points.points, &frame, &mut radiance)?;
    let boxed: Box<dyn DynVisibility> = Box::new(MaskVisibility::new(Boxes(boxes)));
    CpuShader::new(boxed).shade(&points.points, &frame, &mut again)?;
    assert_eq!(radiance, again, "static and dynamic dispatch give the same picture");
    let picture = Picture::new(640, 400, points.resolve(&radiance, Vec3::ZERO));
    write_png(Output::create("custom_visibility.png")?, 640, 400, &srgb_bytes(&picture, 0.0))?;
    Ok(())
}
