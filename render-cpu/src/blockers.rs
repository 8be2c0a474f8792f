use core::ops::ControlFlow;
use lobe_core::Sphere;
use scene::{BlockerSet, Mesh, Object, Proxy, Scene, Shape};
use std::path::PathBuf;
use visibility_spheres::{BuildError, BuildOptions, SetFileError, SphereSet};

/// Why the blockers of a scene could not be made.
#[derive(Debug)]
#[non_exhaustive]
pub enum BlockersError {
    /// No spheres could be built for an object.
    Build {
        /// The object's name.
        object: String,
        /// The reason.
        source: BuildError,
    },
    /// A sphere-set file could not be read.
    Read {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: std::io::Error,
    },
    /// A sphere-set file is wrong.
    Set {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: SetFileError,
    },
}

impl core::fmt::Display for BlockersError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Build { object, source } => write!(f, "blocker spheres of object \"{object}\": {source}"),
            Self::Read { path, source } => write!(f, "{}: cannot read: {source}", path.display()),
            Self::Set { path, source } => write!(f, "{}: {source}", path.display()),
        }
    }
}

impl core::error::Error for BlockersError {}

/// Hears of an object's name and how much of its spheres is done, in [0, 1], and may stop the work.
pub type BlockersProgress<'a> = dyn FnMut(&str, f32) -> ControlFlow<()> + 'a;

/// Where an object's blocker spheres come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SphereSource {
    /// It has none: it blocks nothing, or another strategy has it.
    Nothing,
    /// Its [`Proxy`]: built, read or copied.
    Proxy,
    /// The exact balls that it is; nothing when it is a mesh.
    Shape,
}

/// Makes the blocker spheres of all objects from their proxies: builds, reads or copies them.
///
/// An object's self-shadow distance τ is its sphere set's; explicit spheres are measured against a visible mesh for it.
/// A ball that coincides with a light blocks nothing: it is how a light is made visible.
/// Exact balls stand for themselves: their τ is a thousandth of their mean radius, no more than keeps rounding from
/// blackening a skin.
///
/// # Errors
/// [`BlockersError`]; a build that `progress` breaks off is [`BuildError::Cancelled`].
pub fn blockers(scene: &Scene, progress: &mut BlockersProgress<'_>) -> Result<BlockerSet, BlockersError> {
    blockers_from(scene, |_| SphereSource::Proxy, progress)
}

/// The same with the source of each object by its number: a part of a [`Mixture`](lighting::Mixture) whose other
/// strategies have the rest.
///
/// # Errors
/// As [`blockers`].
pub fn blockers_from(
    scene: &Scene,
    source: impl Fn(usize) -> SphereSource,
    progress: &mut BlockersProgress<'_>,
) -> Result<BlockerSet, BlockersError> {
    let mut all = BlockerSet { self_distances: vec![0.0; scene.objects.len()], ..BlockerSet::default() };
    for (number, object) in scene.objects.iter().enumerate() {
        let (spheres, self_distance) = match (source(number), &object.shape) {
            (SphereSource::Nothing, _) | (SphereSource::Shape, Shape::Mesh(_)) => continue,
            (SphereSource::Shape, Shape::Spheres(balls)) => (balls.clone(), ball_self_distance(balls)),
            (SphereSource::Proxy, _) => proxy(object, progress)?,
        };
        let spheres = spheres.into_iter().filter(|s| !scene.lights.iter().any(|l| is_lamp(s, l.ball)));
        all.spheres.extend(spheres);
        all.objects.resize(all.spheres.len(), number as u32);
        all.self_distances[number] = self_distance;
    }
    Ok(all)
}

/// The spheres of an object's proxy and their τ.
fn proxy(object: &Object, progress: &mut BlockersProgress<'_>) -> Result<(Vec<Sphere>, f32), BlockersError> {
    let failed = |source| BlockersError::Build { object: object.name.clone(), source };
    Ok(match (&object.proxy, &object.shape) {
        (Proxy::None, _) => (Vec::new(), 0.0),
        (Proxy::Count(_), Shape::Spheres(balls)) => (balls.clone(), ball_self_distance(balls)),
        (Proxy::Count(count), Shape::Mesh(Mesh { positions, triangles, .. })) => {
            let mut report = |done| progress(&object.name, done);
            let options = BuildOptions::new(*count);
            let set = SphereSet::build_with_progress(positions, triangles, &options, &mut report);
            let set = set.map_err(failed)?;
            (set.spheres, set.self_distance)
        }
        (Proxy::File(path), _) => {
            let text = std::fs::read_to_string(path);
            let text = text.map_err(|source| BlockersError::Read { path: path.clone(), source })?;
            let set = SphereSet::from_json(&text);
            let set = set.map_err(|source| BlockersError::Set { path: path.clone(), source })?;
            (set.spheres, set.self_distance)
        }
        (Proxy::Spheres(spheres), Shape::Mesh(Mesh { positions, triangles, .. })) if object.visible => {
            // Spheres that stand for a flat or empty mesh: nothing to measure, and no inside to shadow.
            let measured = SphereSet::self_distance_of(positions, triangles, spheres);
            (spheres.clone(), measured.unwrap_or(0.0))
        }
        (Proxy::Spheres(spheres), _) => (spheres.clone(), ball_self_distance(spheres)),
    })
}

/// Whether a ball's surface is a light's, to a thousandth of its radius: a ball that makes the light visible does not hide it.
fn is_lamp(ball: &Sphere, light: Sphere) -> bool {
    let slack = 1e-3 * light.radius;
    (ball.radius - light.radius).abs() <= slack && (ball.center - light.center).length() <= slack
}

fn ball_self_distance(balls: &[Sphere]) -> f32 {
    let total: f32 = balls.iter().map(|b| b.radius).sum();
    let far = balls.iter().map(|b| b.center.abs().max_element() + b.radius).fold(0.0, f32::max);
    (1e-3 * total / balls.len().max(1) as f32).max(1e-6 * far)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::floor_and_ball;
    use glam::Vec3;

    fn make(scene: &Scene) -> Result<BlockerSet, BlockersError> {
        blockers(scene, &mut |_, _| ControlFlow::Continue(()))
    }

    #[test]
    fn a_lamp_does_not_hide_its_light() {
        let mut scene = floor_and_ball();
        let blocking = make(&scene).unwrap().spheres.len();
        scene.objects.push(scene::Object::spheres("lamp", vec![scene.lights[0].ball], 0));
        assert_eq!(make(&scene).unwrap().spheres.len(), blocking);
        scene.objects.push(scene::Object::spheres("shell", vec![Sphere { radius: 2.0, ..scene.lights[0].ball }], 0));
        let set = make(&scene).unwrap();
        assert_eq!((set.spheres.len(), set.objects.last()), (blocking + 1, Some(&3)));
    }

    #[test]
    fn every_kind_of_proxy() {
        let mut scene = floor_and_ball();
        let set = make(&scene).unwrap();
        assert_eq!((set.spheres.len(), set.objects.as_slice(), set.self_distances.len()), (1, [1].as_slice(), 2));
        assert!(set.self_distances[1] > 0.0 && set.self_distances[1] < 1e-3);

        // A closed mesh: a tetrahedron.
        let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        scene.objects[0].shape = Shape::Mesh(Mesh { positions, normals: Vec::new(), triangles });
        scene.objects[0].proxy = Proxy::Count(4);
        let built = make(&scene).unwrap();
        assert_eq!(built.objects, [0, 0, 0, 0, 1]);
        assert!(built.self_distances[0] > 0.0);

        let folder = std::env::temp_dir().join(format!("lobes-blockers-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("set.json");
        scene.objects[0].proxy = Proxy::File(path.clone());
        assert!(matches!(make(&scene), Err(BlockersError::Read { .. })));
        std::fs::write(&path, "{}").unwrap();
        assert!(matches!(make(&scene), Err(BlockersError::Set { .. })));
        std::fs::remove_dir_all(&folder).unwrap();

        scene.objects[0].proxy = Proxy::Count(0);
        assert!(make(&scene).unwrap_err().to_string().contains("floor"));
    }
}
