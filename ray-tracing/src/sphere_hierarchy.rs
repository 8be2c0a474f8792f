use crate::world::{Tree, build, hierarchy_scale};
use glam::{Vec3, Vec3A};
use lobe_core::Sphere;
use obvhs::Boundable;
use obvhs::aabb::Aabb;
use obvhs::ray::Ray;
use shading::Shaft;

/// A sphere with its data.
#[derive(Clone, Copy)]
struct Item<T> {
    sphere: Sphere,
    data: T,
}

impl<T> Boundable for Item<T> {
    fn aabb(&self) -> Aabb {
        let (c, r) = (Vec3A::from(self.sphere.center), Vec3A::splat(self.sphere.radius));
        Aabb::new(c - r, c + r)
    }
}

/// A hierarchy over spheres, each of which carries data of its user: for rays and for shafts.
///
/// Spheres are to be finite, with radii above 0.
///
/// ```
/// use glam::Vec3;
/// use lobe_core::Sphere;
/// use ray_tracing::SphereHierarchy;
/// let at = |x: f32| Sphere { center: Vec3::X * x, radius: 0.5 };
/// let spheres = SphereHierarchy::new(&[(at(2.0), "near"), (at(4.0), "far")]);
/// // Whatever sphere the ray enters, at its centre's distance.
/// let meet = |s: &Sphere, name: &&str, _: f32| if *name == "far" { s.center.x } else { f32::INFINITY };
/// assert!(spheres.any(Vec3::ZERO, Vec3::X, 9.0, meet));
/// assert!(!spheres.any(Vec3::ZERO, Vec3::NEG_X, 9.0, meet));
/// ```
#[derive(Debug)]
pub struct SphereHierarchy<T>(Tree<Item<T>>);

impl<T: Copy> SphereHierarchy<T> {
    /// Builds it, in `O(n log n)`.
    #[must_use]
    pub fn new(spheres: &[(Sphere, T)]) -> Self {
        let items: Vec<_> = spheres.iter().map(|(sphere, data)| Item { sphere: *sphere, data: *data }).collect();
        let bounds = items.iter().fold(Aabb::empty(), |all, b| all.union(&b.aabb()));
        let size = bounds.diagonal().length() + bounds.min.abs().max(bounds.max.abs()).max_element();
        let scale = if items.is_empty() { 1.0 } else { hierarchy_scale(size) };
        Self(Tree::new(&items, scale, |items| {
            let boxes = items.iter().map(Boundable::aabb).map(|b| Aabb::new(b.min * scale, b.max * scale));
            build(&boxes.collect::<Vec<_>>())
        }))
    }

    /// Whether a ray of unit direction meets one of the spheres nearer than `distance`. `meet` is called for a sphere whose box
    /// the ray passes. It gets the distance limit, and returns the distance at which the ray meets the sphere, or infinity.
    #[inline]
    pub fn any(&self, origin: Vec3, direction: Vec3, distance: f32, meet: impl Fn(&Sphere, &T, f32) -> f32) -> bool {
        let ray = Ray::new(origin.into(), direction.into(), 0.0, distance);
        self.0.any(ray, |item, ray| meet(&item.sphere, &item.data, ray.tmax))
    }

    /// Calls `found` for the spheres whose boxes meet the shaft.
    pub fn in_shaft(&self, shaft: &Shaft, mut found: impl FnMut(&Sphere, &T)) {
        self.0.in_shaft(shaft, &mut |_, item| {
            found(&item.sphere, &item.data);
            false
        });
    }
}
