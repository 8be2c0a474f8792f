use glam::{Vec2, Vec3, Vec4};
use tiny_skia::{Color, Paint, PathBuilder, Pixmap, Stroke, Transform};

use crate::bits::BitImage;
use crate::error::BuildError;
use crate::sphere_set::SphereSet;
use crate::surface::Surface;
use crate::view::Frame;

/// Pixels between the panels and around them.
const GAP: usize = 12;
/// Subpixels a pixel, in each direction.
const FINE: usize = 3;

const BOTH: Vec3 = Vec3::new(0.36, 0.38, 0.42);
const MESH_ONLY: Vec3 = Vec3::new(0.86, 0.22, 0.18);
const SET_ONLY: Vec3 = Vec3::new(0.16, 0.44, 0.88);

/// Draws mesh and set over each other, seen along −z, −x and −y side by side: grey where both are, red where only the
/// mesh is, blue where only the set is, and the outlines of the spheres. `size` is the side of one panel in pixels.
///
/// White background, sRGB, opaque; the caller encodes it.
///
/// # Errors
/// [`BuildError`] if the mesh could not have been built from, or [`BuildError::ExtentOutOfRange`] if the picture has no
/// or too many pixels.
pub fn preview(set: &SphereSet, positions: &[Vec3], triangles: &[[u32; 3]], size: u32) -> Result<Pixmap, BuildError> {
    let surface = Surface::new(positions, triangles)?;
    let spheres: Vec<Vec4> = set.spheres.iter().map(|sphere| surface.to_unit(*sphere)).collect();
    let side = size.clamp(16, 4096) as usize;
    let (width, height) = (3 * side + 4 * GAP, side + 2 * GAP);
    let Some(mut picture) = Pixmap::new(width as u32, height as u32) else {
        return Err(BuildError::ExtentOutOfRange);
    };
    picture.fill(Color::WHITE);
    // (right, up) on the screen.
    let panels = [(Vec3::X, Vec3::Y), (Vec3::NEG_Z, Vec3::Y), (Vec3::X, Vec3::NEG_Z)];
    let all = || spheres.iter().map(|sphere| (sphere.truncate(), sphere.w));
    for (panel, (right, up)) in panels.into_iter().enumerate() {
        let corners = surface.triangles.iter().flatten().map(|p| (*p, 0.0));
        let frame = Frame::with_axes(right, -up, corners.chain(all()), 0.01, side);
        let origin = [GAP + panel * (side + GAP), GAP];
        fill(&mut picture, origin, side, &frame, &surface.triangles, &spheres);
        outline(&mut picture, origin, &frame, &spheres);
    }
    Ok(picture)
}

fn fill(
    picture: &mut Pixmap,
    origin: [usize; 2],
    side: usize,
    frame: &Frame,
    triangles: &[[Vec3; 3]],
    spheres: &[Vec4],
) {
    let (mut mesh, mut set) = (BitImage::new(side * FINE), BitImage::new(side * FINE));
    let fine = frame.finer(FINE as f32);
    fine.draw_mesh(triangles, &mut mesh);
    fine.draw_spheres(spheres, &mut set);
    let width = picture.width() as usize;
    for y in 0..side {
        for x in 0..side {
            let mut color = Vec3::ZERO;
            for (dx, dy) in (0..FINE * FINE).map(|i| (i % FINE, i / FINE)) {
                let (px, py) = (x * FINE + dx, y * FINE + dy);
                color += match (mesh.get(px, py), set.get(px, py)) {
                    (true, true) => BOTH,
                    (true, false) => MESH_ONLY,
                    (false, true) => SET_ONLY,
                    (false, false) => Vec3::ONE,
                };
            }
            color /= (FINE * FINE) as f32;
            let [r, g, b] = color.to_array().map(|c| (c * 255.0 + 0.5) as u8);
            let at = ((origin[1] + y) * width + origin[0] + x) * 4;
            picture.data_mut()[at..at + 4].copy_from_slice(&[r, g, b, 255]);
        }
    }
}

fn outline(picture: &mut Pixmap, origin: [usize; 2], frame: &Frame, spheres: &[Vec4]) {
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    paint.set_color_rgba8(255, 255, 255, 90);
    let stroke = Stroke { width: 1.0, ..Stroke::default() };
    let offset = Vec2::new(origin[0] as f32, origin[1] as f32);
    for sphere in spheres {
        let (center, radius) = frame.disc(*sphere);
        let center = center + offset;
        if let Some(circle) = PathBuilder::from_circle(center.x, center.y, radius) {
            picture.stroke_path(&circle, &paint, &stroke, Transform::identity(), None);
        }
    }
}
