use crate::Projection;
use glam::{Vec2, Vec3};

/// Pixels within which a pointer takes hold of a handle.
const REACH: f32 = 9.0;
/// Length of the arrows, in pixels.
const ARROW: f32 = 70.0;
/// The part of an arrow that belongs to the handle in its middle.
const STEM: f32 = 0.25;
/// Where the handle of a light's direction is, in lengths of an arrow.
const AIM: f32 = 1.35;
/// The smallest circle of a size, in pixels: a smaller one would hide under the middle.
const SMALLEST: f32 = 14.0;

/// The handles of a light or an object in a picture: its middle, which is dragged in the plane of the view, arrows along the axes of the
/// world, a circle of its size, and the point that a light is aimed by.
#[derive(Clone, Copy, Debug)]
pub struct Handles {
    projection: Projection,
    center: Vec3,
    /// Length of the arrows.
    arrow: f32,
    size: Option<f32>,
    direction: Option<Vec3>,
}

/// The part of [`Handles`] that is dragged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grip {
    /// The middle: moves in the plane that faces the camera.
    Middle,
    /// An arrow: moves along x, y or z.
    Axis(usize),
    /// The circle: changes the size.
    Size,
    /// The direction of a light.
    Aim,
}

/// The result of a drag so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Dragged {
    /// Moved so far.
    Shift(Vec3),
    /// Of another size: times a factor.
    Scale(f32),
    /// Aimed in a unit direction.
    Toward(Vec3),
}

/// A drag that goes on: what it began with.
#[derive(Clone, Copy, Debug)]
pub struct Drag {
    handles: Handles,
    grip: Grip,
    from: Vec2,
}

impl Handles {
    /// The handles of a thing with its middle there.
    #[must_use]
    pub fn new(projection: Projection, center: Vec3) -> Self {
        let arrow = ARROW * projection.pixel_size(center);
        Self { projection, center, arrow, size: None, direction: None }
    }

    /// The same with a circle of this radius.
    #[must_use]
    pub fn with_size(self, radius: Option<f32>) -> Self {
        Self { size: radius, ..self }
    }

    /// The same with a handle for a light that shines in a unit direction.
    #[must_use]
    pub fn with_direction(self, direction: Option<Vec3>) -> Self {
        Self { direction, ..self }
    }

    /// The middle in the picture; none behind the eye, where nothing can be taken hold of.
    #[must_use]
    pub fn middle(&self) -> Option<Vec2> {
        self.projection.pixel(self.center)
    }

    /// The tips of the arrows; none of those that point at the eye, or whose tips are behind it.
    #[must_use]
    pub fn tips(&self) -> [Option<Vec2>; 3] {
        Vec3::AXES.map(|axis| {
            let tip = self.projection.pixel(self.center + self.arrow * axis)?;
            (tip.distance(self.middle()?) > 2.0 * REACH).then_some(tip)
        })
    }

    /// The radius of the circle, in pixels.
    #[must_use]
    pub fn circle(&self) -> Option<f32> {
        self.size.map(|radius| (radius / self.projection.pixel_size(self.center)).max(SMALLEST))
    }

    /// The place of the handle of the direction.
    #[must_use]
    pub fn aim(&self) -> Option<Vec2> {
        self.projection.pixel(self.center + AIM * self.arrow * self.direction?)
    }

    /// The handle under a pointer.
    #[must_use]
    pub fn hit(&self, pointer: Vec2) -> Option<Grip> {
        let middle = self.middle()?;
        if self.aim().is_some_and(|aim| aim.distance(pointer) <= REACH) {
            return Some(Grip::Aim);
        }
        if middle.distance(pointer) <= REACH {
            return Some(Grip::Middle);
        }
        let near = |tip: Vec2| distance_to_segment(pointer, middle + STEM * (tip - middle), tip);
        let arrows = (0..).zip(self.tips()).filter_map(|(axis, tip)| Some((axis, near(tip?))));
        if let Some((axis, distance)) = arrows.min_by(|a, b| a.1.total_cmp(&b.1))
            && distance <= REACH
        {
            return Some(Grip::Axis(axis));
        }
        let off = |radius: f32| (middle.distance(pointer) - radius).abs();
        self.circle().is_some_and(|radius| off(radius) <= 0.6 * REACH).then_some(Grip::Size)
    }

    /// Begins to drag.
    #[must_use]
    pub const fn drag(self, grip: Grip, from: Vec2) -> Drag {
        Drag { handles: self, grip, from }
    }
}

impl Drag {
    /// The part that is dragged.
    #[must_use]
    pub const fn grip(&self) -> Grip {
        self.grip
    }

    /// The result with the pointer there; none where there is none: an edge-on axis, a plane behind the eye.
    #[must_use]
    pub fn to(&self, pointer: Vec2) -> Option<Dragged> {
        let Handles { projection, center, arrow, direction, .. } = &self.handles;
        let moved = match self.grip {
            Grip::Middle => {
                let [from, to] = [self.from, pointer].map(|pixel| projection.in_view_plane(pixel, *center));
                Dragged::Shift(to? - from?)
            }
            Grip::Axis(axis) => {
                let axis = Vec3::AXES[axis];
                let [from, to] = [self.from, pointer].map(|pixel| projection.along(pixel, *center, axis));
                Dragged::Shift((to? - from?) * axis)
            }
            Grip::Size => {
                let middle = self.handles.middle()?;
                let [from, to] = [self.from, pointer].map(|pixel| pixel.distance(middle).max(1.0));
                Dragged::Scale(to / from)
            }
            Grip::Aim => {
                let radius = AIM * arrow;
                // The far side of the sphere, where the handle is there.
                let is_far = direction.is_some_and(|d| d.dot(projection.toward_eye(*center)) < 0.0);
                let near = projection.on_sphere(pointer, *center, radius) - center;
                let ray = projection.direction(pointer);
                let far = near - 2.0 * near.dot(ray) * ray;
                Dragged::Toward((if is_far { far } else { near }).normalize_or_zero())
            }
        };
        let is_usable = match moved {
            Dragged::Shift(by) => by.is_finite(),
            Dragged::Scale(by) => by.is_finite() && by > 0.0,
            Dragged::Toward(direction) => direction.is_normalized(),
        };
        is_usable.then_some(moved)
    }
}

fn distance_to_segment(p: Vec2, a: Vec2, b: Vec2) -> f32 {
    let edge = b - a;
    let t = ((p - a).dot(edge) / edge.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
    p.distance(a + t * edge)
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::Camera;

    fn handles() -> Handles {
        let camera = Camera {
            eye: Vec3::new(1.0, 2.0, 5.0),
            target: Vec3::ZERO,
            up: Vec3::Y,
            projection: scene::Projection::perspective(0.7),
        };
        let direction = Vec3::new(0.3, -1.0, 0.2).normalize();
        Handles::new(Projection::new(camera, Vec2::new(640.0, 360.0)), Vec3::new(0.3, 0.6, -0.2))
            .with_size(Some(0.4))
            .with_direction(Some(direction))
    }

    #[test]
    fn every_handle_is_found_where_it_is_drawn() {
        let handles = handles();
        let middle = handles.middle().unwrap();
        assert_eq!(handles.hit(middle), Some(Grip::Middle));
        for (axis, tip) in handles.tips().into_iter().enumerate() {
            let Some(tip) = tip else { continue };
            assert_eq!(handles.hit(tip), Some(Grip::Axis(axis)));
            assert_eq!(handles.hit(middle.lerp(tip, 0.6)), Some(Grip::Axis(axis)));
        }
        assert_eq!(handles.hit(handles.aim().unwrap()), Some(Grip::Aim));
        let beside = middle + handles.circle().unwrap() * Vec2::new(-0.6, 0.8);
        assert_eq!(handles.hit(beside), Some(Grip::Size));
        assert_eq!(handles.hit(middle + Vec2::new(-200.0, 90.0)), None);
    }

    #[test]
    fn the_middle_follows_the_pointer() {
        let handles = handles();
        let from = handles.middle().unwrap();
        let to = from + Vec2::new(37.0, -52.0);
        let Some(Dragged::Shift(by)) = handles.drag(Grip::Middle, from).to(to) else { panic!("no shift") };
        assert!(handles.projection.pixel(handles.center + by).unwrap().distance(to) < 0.05);
        assert!(by.dot(handles.projection.axes()[2]).abs() < 1e-4);
    }

    #[test]
    fn arrows_follow_the_pointer_along_their_axes() {
        let handles = handles();
        for axis in 0..3 {
            let Some(from) = handles.tips()[axis] else { continue };
            let want = handles.projection.pixel(handles.center + (handles.arrow + 0.8) * Vec3::AXES[axis]).unwrap();
            let Some(Dragged::Shift(by)) = handles.drag(Grip::Axis(axis), from).to(want) else { panic!("no shift") };
            assert!((by - 0.8 * Vec3::AXES[axis]).length() < 1e-3, "{by}");
        }
    }

    #[test]
    fn size_and_direction_follow_the_pointer() {
        let handles = handles();
        let middle = handles.middle().unwrap();
        let at = |factor: f32| middle + factor * handles.circle().unwrap() * Vec2::X;
        let Some(Dragged::Scale(by)) = handles.drag(Grip::Size, at(1.0)).to(at(1.8)) else { panic!("no scale") };
        assert!((by - 1.8).abs() < 1e-4);
        // Not moved, it stays as it is, on the near side and on the far one.
        for direction in [Vec3::new(0.3, -1.0, 0.2), Vec3::new(-0.2, -0.3, -1.0)] {
            let handles = handles.with_direction(Some(direction.normalize()));
            let from = handles.aim().unwrap();
            let Some(Dragged::Toward(toward)) = handles.drag(Grip::Aim, from).to(from) else { panic!("no direction") };
            assert!(toward.distance(direction.normalize()) < 2e-3, "{toward} {direction}");
        }
    }

    #[test]
    fn handles_behind_the_eye_are_not_found() {
        let handles = handles();
        let behind = Handles::new(handles.projection, 2.0 * handles.projection.camera().eye);
        assert_eq!((behind.middle(), behind.hit(Vec2::new(320.0, 180.0))), (None, None));
    }
}
