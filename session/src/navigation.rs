//! Cameras that follow a pointer.

use crate::Projection;
use core::f32::consts::PI;
use glam::{Quat, Vec2, Vec3};
use scene::{Bounds, Camera, Projection as Kind};

/// The view comes no nearer to the camera's `up` than this, in radians.
const POLE: f32 = 0.05;
/// The vertical field of view of a camera that becomes a perspective one.
const FIELD: f32 = 40.0 * PI / 180.0;

/// The camera turned about its target: to the left by `turn.x` and upward by `turn.y`, in radians. It keeps its distance and stops
/// before it looks straight up or down.
///
/// ```
/// use glam::Vec2;
/// let before = scene::Camera::default();
/// let after = session::orbited(before, Vec2::new(0.3, 0.1));
/// assert!((after.eye.distance(after.target) - before.eye.distance(before.target)).abs() < 1e-5);
/// ```
#[must_use]
pub fn orbited(camera: Camera, turn: Vec2) -> Camera {
    let up = camera.up.normalize_or(Vec3::Y);
    let offset = camera.eye - camera.target;
    let distance = offset.length();
    let toward = offset / distance;
    let right = up.cross(toward).normalize_or(Vec3::X);
    // The angle between the direction of the eye and `up`.
    let polar = toward.dot(up).clamp(-1.0, 1.0).acos();
    let (low, high) = (POLE.min(polar), (PI - POLE).max(polar));
    let lift = polar - (polar - turn.y).clamp(low, high);
    let toward = Quat::from_axis_angle(up, -turn.x) * (Quat::from_axis_angle(right, -lift) * toward);
    Camera { eye: camera.target + distance * toward.normalize_or(Vec3::Z), ..camera }
}

/// The camera shifted in its image plane so that what is at its target follows a pointer that moves by so many pixels of a picture.
#[must_use]
pub fn panned(camera: Camera, size: Vec2, pixels: Vec2) -> Camera {
    let projection = Projection::new(camera, size);
    let [right, up, _] = projection.axes();
    let shift = projection.pixel_size(camera.target) * (pixels.y * up - pixels.x * right);
    Camera { eye: camera.eye + shift, target: camera.target + shift, ..camera }
}

/// The camera at another distance from its target: times a factor. An orthographic camera stays where it is, and the height of its picture
/// changes by the factor.
#[must_use]
pub fn zoomed(camera: Camera, factor: f32) -> Camera {
    if let Kind::Orthographic { height } = camera.projection {
        let projection = Kind::Orthographic { height: height * factor };
        return Camera {
            projection: if projection.validate().is_ok() { projection } else { camera.projection },
            ..camera
        };
    }
    let offset = (camera.eye - camera.target) * factor;
    // Nearer the direction would be lost in rounding; farther coordinates would.
    let nearest = 1e-4 * (1.0 + camera.target.length());
    let length = offset.length();
    if !(nearest..=1e8).contains(&length) {
        return camera;
    }
    Camera { eye: camera.target + offset, ..camera }
}

/// The camera moved back or forward, and aimed, so that a box fills the picture; it keeps its direction. The picture of an orthographic
/// camera changes its height instead, and a panoramic camera sees the box as one of 90° does.
#[must_use]
pub fn framed(camera: Camera, bounds: Bounds, size: Vec2) -> Camera {
    let [right, up, forward] = Projection::new(camera, size).axes();
    let (center, half) = (bounds.center(), 0.5 * bounds.size());
    let corner = |i: u32| half * Vec3::from_array([0, 1, 2].map(|k| if i >> k & 1 == 0 { -1.0 } else { 1.0 }));
    let aspect = size.x / size.y.max(1.0);
    let tan_y = match camera.projection {
        Kind::Perspective { vertical_fov } => (0.5 * vertical_fov).tan(),
        Kind::Orthographic { height } => {
            let needed = |q: Vec3| (q.dot(right).abs() / aspect).max(q.dot(up).abs());
            let wanted = Kind::Orthographic { height: 2.1 * (0..8).map(corner).map(needed).fold(0.0, f32::max) };
            let projection = if wanted.validate().is_ok() { wanted } else { Kind::Orthographic { height } };
            // All of the box is before the eye.
            let distance = camera.eye.distance(camera.target).max(1.05 * half.length());
            return Camera { eye: center - distance * forward, target: center, projection, ..camera };
        }
        Kind::Panoramic => 1.0,
    };
    let tan_x = tan_y * aspect;
    let needed = |q: Vec3| (q.dot(right).abs() / tan_x).max(q.dot(up).abs() / tan_y) - q.dot(forward);
    let distance = (0..8).map(corner).map(needed).fold(0.0, f32::max);
    let usual = camera.eye.distance(camera.target);
    let distance = if distance > 0.0 { 1.05 * distance } else { usual };
    Camera { eye: center - distance * forward, target: center, ..camera }
}

/// The camera with another projection, by its [name](Kind::name): what is at the target keeps its size. A perspective camera that was none has a
/// vertical field of view of 40° and moves back or forward; of a panorama 90° are seen as one. An unknown name changes nothing.
#[must_use]
pub fn projected(camera: Camera, name: &str) -> Camera {
    let offset = camera.eye - camera.target;
    let height = match camera.projection {
        Kind::Perspective { vertical_fov } => 2.0 * offset.length() * (0.5 * vertical_fov).tan(),
        Kind::Orthographic { height } => height,
        Kind::Panoramic => 2.0 * offset.length(),
    };
    let changed = match name {
        _ if name == camera.projection.name() => return camera,
        "perspective" => {
            let distance = height / (2.0 * (0.5 * FIELD).tan());
            let eye = camera.target + distance * offset.normalize_or(Vec3::Z);
            Camera { eye, projection: Kind::perspective(FIELD), ..camera }
        }
        "orthographic" => Camera { projection: Kind::Orthographic { height }, ..camera },
        "panoramic" => Camera { projection: Kind::Panoramic, ..camera },
        _ => return camera,
    };
    if changed.validate().is_ok() { changed } else { camera }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_projection_keeps_the_size_at_the_target() {
        let size = |camera: Camera| Projection::new(camera, SIZE).pixel_size(camera.target);
        let before = camera();
        let flat = projected(before, "orthographic");
        assert!((size(flat) / size(before) - 1.0).abs() < 1e-5 && flat.eye == before.eye);
        let back = projected(zoomed(flat, 0.5), "perspective");
        assert!((size(back) / size(before) - 0.5).abs() < 1e-5, "{back:?}");
        assert_eq!(projected(before, "panoramic").projection, Kind::Panoramic);
        assert_eq!(projected(projected(before, "panoramic"), "orthographic").eye, before.eye);
        assert_eq!([projected(before, "perspective"), projected(before, "fisheye")], [before; 2]);
    }

    const SIZE: Vec2 = Vec2::new(640.0, 360.0);

    fn camera() -> Camera {
        Camera { eye: Vec3::new(1.0, 2.0, 5.0), target: Vec3::new(0.2, 0.5, 0.0), ..Camera::default() }
    }

    fn orthographic() -> Camera {
        Camera { projection: Kind::Orthographic { height: 3.0 }, ..camera() }
    }

    fn height(camera: Camera) -> f32 {
        let Kind::Orthographic { height } = camera.projection else { panic!("{camera:?}") };
        height
    }

    #[test]
    fn zoom_changes_the_height_of_an_orthographic_picture() {
        let before = orthographic();
        let near = zoomed(before, 0.5);
        assert_eq!((near.eye, near.target, height(near)), (before.eye, before.target, 1.5));
        let mut camera = before;
        (0..2000).for_each(|_| camera = zoomed(camera, 0.9));
        camera.validate().unwrap();
        (0..4000).for_each(|_| camera = zoomed(camera, 1.1));
        camera.validate().unwrap();
        assert_eq!(height(zoomed(before, f32::NAN)), 3.0);
    }

    #[test]
    fn an_orbit_keeps_its_distance_and_its_horizon() {
        let before = camera();
        let after = orbited(before, Vec2::new(0.4, -0.2));
        let of = |c: Camera| c.eye - c.target;
        assert!((of(after).length() - of(before).length()).abs() < 1e-5);
        assert_eq!(after.target, before.target);
        let elevation = |c: Camera| (of(c).y / of(c).length()).asin();
        assert!((elevation(after) - elevation(before) + 0.2).abs() < 1e-5);
        // The eye turns to the left as it is seen from the target, so that the scene turns to the right.
        let flat = |c: Camera| Vec2::new(of(c).x, of(c).z);
        assert!((flat(before).angle_to(flat(after)).abs() - 0.4).abs() < 1e-5);
        let [right, ..] = Projection::new(before, SIZE).axes();
        assert!((after.eye - before.eye).dot(right) < 0.0);
    }

    #[test]
    fn an_orbit_stops_before_the_poles() {
        for lift in [10.0, -10.0] {
            let after = orbited(camera(), Vec2::new(0.0, lift));
            after.validate().unwrap();
            let toward = (after.eye - after.target).normalize();
            assert!((toward.y.abs() - POLE.cos()).abs() < 1e-4, "{toward}");
            assert_eq!(toward.y > 0.0, lift > 0.0);
        }
    }

    #[test]
    fn the_target_follows_a_pan() {
        for before in [camera(), orthographic()] {
            let pixels = Vec2::new(40.0, -25.0);
            let after = Projection::new(panned(before, SIZE, pixels), SIZE);
            let moved = after.pixel(before.target).unwrap() - 0.5 * SIZE;
            assert!(moved.distance(pixels) < 0.05, "{moved}");
        }
    }

    #[test]
    fn zoom_has_ends() {
        let before = camera();
        let near = zoomed(before, 0.5);
        assert!((near.eye.distance(near.target) * 2.0 - before.eye.distance(before.target)).abs() < 1e-5);
        let mut camera = before;
        (0..2000).for_each(|_| camera = zoomed(camera, 0.9));
        camera.validate().unwrap();
        (0..4000).for_each(|_| camera = zoomed(camera, 1.1));
        camera.validate().unwrap();
    }

    #[test]
    fn a_framed_box_fills_the_picture() {
        let bounds = Bounds { min: Vec3::new(-3.0, 0.0, -1.0), max: Vec3::new(1.0, 2.0, 2.0) };
        let panoramic = Camera { projection: Kind::Panoramic, ..camera() };
        for (camera, least) in [(camera(), 0.8), (orthographic(), 0.9), (panoramic, 0.2)] {
            let after = framed(camera, bounds, SIZE);
            after.validate().unwrap();
            let projection = Projection::new(after, SIZE);
            let mut most = 0.0_f32;
            for i in 0..8 {
                let side = |k: usize| if i >> k & 1 == 0 { bounds.min[k] } else { bounds.max[k] };
                let pixel = projection.pixel(Vec3::new(side(0), side(1), side(2))).unwrap();
                let from_middle = (pixel - 0.5 * SIZE).abs() / (0.5 * SIZE);
                most = most.max(from_middle.max_element());
            }
            assert!(most > least && most <= 1.0, "{most}");
        }
        // One without an extent is looked at from as far as before.
        let point = framed(camera(), Bounds::EMPTY.with_point(Vec3::ONE), SIZE);
        assert!((point.eye.distance(point.target) - camera().eye.distance(camera().target)).abs() < 1e-5);
        assert_eq!(height(framed(orthographic(), Bounds::EMPTY.with_point(Vec3::ONE), SIZE)), 3.0);
    }
}
