use crate::blockers_error::{BlockersError, BlockersProgress};
use glam::{Mat4, Vec3};
use lobe_core::{SelfShadow, Sphere};
use scene::{Animation, BlockerSet, Doubles, Mesh, Object, Proxy, Scene, Shape};
use sphere_sets::{BoundSet, BuildOptions, Carriers, SphereSet};
use std::path::Path;

/// Where an object's blocker spheres come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SphereSource {
    /// It has none: it blocks nothing, or another strategy has it.
    Nothing,
    /// Its [`Proxy`]: built, read or copied.
    Proxy,
    /// The exact balls that it is; nothing when it is a mesh.
    Shape,
}

/// The blocker spheres of a scene's objects, made once and posed for every frame.
///
/// A sphere set is built or read for the scene as it was loaded, and follows what carries its mesh's points
/// ([`BoundSet`]): nothing is fitted per pose. Exact balls and explicit spheres are where the scene says they are.
///
/// How an object shadows itself is fitted with its sphere set, sphere by sphere, and follows the spheres' radii; explicit
/// spheres are measured against a visible mesh for one distance τ.
/// Exact balls stand for themselves: their τ is a thousandth of their mean radius, no more than keeps rounding from
/// blackening a surface. Equal balls are one, and equal meshes ([`Doubles`]). A ball that coincides with a light blocks nothing: it is how a light is made visible.
///
/// # Cost of a pose
/// One to four matrix products a sphere that follows bones, a copy of the others.
#[derive(Clone, Debug)]
pub struct SceneSpheres {
    objects: Vec<ObjectSpheres>,
}

/// Those of one object.
#[derive(Clone, Debug)]
struct ObjectSpheres {
    spheres: Spheres,
    self_distance: f32,
    /// One a sphere, fitted with a sphere set; else empty.
    self_shadows: Vec<SelfShadow>,
    /// Of a sphere set, as it was measured when it was built.
    silhouette_error: Option<f32>,
}

impl ObjectSpheres {
    const fn new(spheres: Spheres, self_distance: f32) -> Self {
        Self { spheres, self_distance, self_shadows: Vec::new(), silhouette_error: None }
    }
}

#[derive(Clone, Debug)]
enum Spheres {
    Nothing,
    /// The balls that the object is.
    Shape,
    /// The spheres that its proxy lists.
    Listed,
    /// Those of a mesh that stands still.
    Still(Vec<Sphere>),
    /// Those of a mesh that moves.
    Bound(Box<BoundSet>),
}

impl SceneSpheres {
    /// Builds, reads or takes over the spheres of those objects to which `source` gives some, by number. The scene is as
    /// it was loaded, with the animation that it came with.
    ///
    /// # Errors
    /// [`BlockersError`]; a build that `progress` breaks off is `BuildError::Cancelled`.
    pub fn new(
        scene: &Scene,
        animation: Option<&Animation>,
        source: impl Fn(usize) -> SphereSource,
        progress: &mut BlockersProgress<'_>,
    ) -> Result<Self, BlockersError> {
        let of = |(number, object): (usize, &Object)| match (source(number), &object.shape) {
            (SphereSource::Nothing, _) | (SphereSource::Shape, Shape::Mesh(_)) => {
                Ok(ObjectSpheres::new(Spheres::Nothing, 0.0))
            }
            (SphereSource::Shape, Shape::Spheres(balls)) => {
                Ok(ObjectSpheres::new(Spheres::Shape, ball_self_distance(balls)))
            }
            (SphereSource::Proxy, _) => from_proxy(number, object, animation, progress),
        };
        Ok(Self { objects: scene.objects.iter().enumerate().map(of).collect::<Result<_, _>>()? })
    }

    /// Which objects block by a sphere set, and the share of their silhouettes that it misses.
    pub fn silhouette_errors(&self) -> impl Iterator<Item = (usize, f32)> {
        self.objects.iter().enumerate().filter_map(|(object, own)| Some((object, own.silhouette_error?)))
    }

    /// Writes the spheres to `out` as they are in a scene that was posed ([`Animation::seek`]) at a time: the same
    /// animation as in [`new`](Self::new), or none when nothing moves.
    ///
    /// # Errors
    /// [`BlockersError::Bind`] for another animation than the one that the spheres were bound to.
    pub fn pose(
        &self,
        scene: &Scene,
        at: Option<(&Animation, f32)>,
        out: &mut BlockerSet,
    ) -> Result<(), BlockersError> {
        out.spheres.clear();
        out.objects.clear();
        out.self_distances.clear();
        out.self_shadows.clear();
        let (mut posed, mut turned) = (Vec::new(), Vec::new());
        let (mut balls, mut own_balls, mut meshes) = (Doubles::default(), Doubles::default(), Doubles::default());
        for (number, (object, own)) in scene.objects.iter().zip(&self.objects).enumerate() {
            let mut self_shadows = &own.self_shadows;
            let is_double = !meshes.is_first_mesh(&scene.objects, number);
            let spheres = match (&own.spheres, &object.shape, &object.proxy) {
                _ if is_double => &Vec::new(),
                (Spheres::Shape, Shape::Spheres(list), _) | (Spheres::Listed, _, Proxy::Spheres(list)) => list,
                (Spheres::Still(list), ..) => list,
                (Spheres::Bound(set), ..) => {
                    let pose = at.map(|(animation, time)| animation.pose(number, time)).unwrap_or_default();
                    let failed = |source| BlockersError::Bind { object: object.name.clone(), source };
                    set.pose(&pose.joints, &pose.morph, &mut posed, &mut turned).map_err(failed)?;
                    self_shadows = &turned;
                    &posed
                }
                _ => &Vec::new(),
            };
            // Meshes have surfaces of their own, whatever stands for them.
            own_balls.clear();
            for (i, ball) in spheres.iter().enumerate() {
                let first = match object.shape {
                    Shape::Spheres(_) => balls.is_first(object, ball),
                    Shape::Mesh(_) => own_balls.is_first(object, ball),
                };
                if !first || scene.lights.iter().any(|l| l.is_shown_by(ball)) {
                    continue;
                }
                out.spheres.push(*ball);
                let whole = || SelfShadow::whole(own.self_distance / ball.radius.max(f32::MIN_POSITIVE));
                out.self_shadows.push(self_shadows.get(i).copied().unwrap_or_else(whole));
            }
            out.objects.resize(out.spheres.len(), number as u32);
            out.self_distances.push(own.self_distance);
        }
        Ok(())
    }
}

/// The spheres of an object's proxy and their τ.
fn from_proxy(
    number: usize,
    object: &Object,
    animation: Option<&Animation>,
    progress: &mut BlockersProgress<'_>,
) -> Result<ObjectSpheres, BlockersError> {
    let name = || object.name.clone();
    let set = match (&object.proxy, &object.shape) {
        (Proxy::None, _) => return Ok(ObjectSpheres::new(Spheres::Nothing, 0.0)),
        (Proxy::Count(_), Shape::Spheres(balls)) => {
            return Ok(ObjectSpheres::new(Spheres::Shape, ball_self_distance(balls)));
        }
        (Proxy::Spheres(list), Shape::Mesh(Mesh { positions, triangles, .. })) if object.visible => {
            // Spheres that stand for a flat or empty mesh: nothing to measure, and no inside to shadow.
            let measured = SphereSet::self_distance_of(positions, triangles, list);
            return Ok(ObjectSpheres::new(Spheres::Listed, measured.unwrap_or(0.0)));
        }
        (Proxy::Spheres(list), _) => return Ok(ObjectSpheres::new(Spheres::Listed, ball_self_distance(list))),
        (Proxy::Count(count), Shape::Mesh(Mesh { positions, triangles, .. })) => {
            let mut report = |done| progress(&object.name, done);
            let options = BuildOptions::new(*count);
            let set = SphereSet::build_with_progress(positions, triangles, &options, &mut report);
            set.map_err(|source| BlockersError::Build { object: name(), source })?
        }
        (Proxy::File { path, placement }, _) => read_set(path, placement, object)?,
    };
    let (self_distance, silhouette_error) = (set.self_distance, Some(set.quality.silhouette_error));
    let self_shadows = set.self_shadows.clone();
    let made = |spheres| Ok(ObjectSpheres { spheres, self_distance, self_shadows, silhouette_error });
    let rig = animation.and_then(|a| Some((a.rig(number)?, a.pose(number, 0.0))));
    let (Some((rig, rest)), Shape::Mesh(mesh)) = (rig, &object.shape) else {
        return made(Spheres::Still(set.spheres));
    };
    let carriers = Carriers {
        joints: rig.joints,
        weights: rig.weights,
        targets: rig.targets,
        rest_joints: &rest.joints,
        rest_morph: &rest.morph,
    };
    let bound = set.bind(&mesh.positions, &mesh.triangles, &carriers);
    let bound = bound.map_err(|source| BlockersError::Bind { object: name(), source })?;
    made(Spheres::Bound(Box::new(bound)))
}

/// Reads the file of a sphere set that is given for an object as it stood before `placement`, and puts the set where the
/// object is ([`SphereSet::placed`]).
///
/// # Errors
/// [`BlockersError::Read`], [`BlockersError::Set`], and [`BlockersError::Misfit`] for a set of another mesh.
pub fn read_set(path: &Path, placement: &Mat4, object: &Object) -> Result<SphereSet, BlockersError> {
    let path = || path.to_owned();
    let text = std::fs::read_to_string(path()).map_err(|source| BlockersError::Read { path: path(), source })?;
    let set = SphereSet::from_json(&text).map_err(|source| BlockersError::Set { path: path(), source })?;
    let mut placed = set.placed(placement);
    if let Shape::Mesh(mesh) = &object.shape {
        let back = placement.inverse();
        let own: Vec<Vec3> = mesh.positions.iter().map(|p| back.transform_point3(*p)).collect();
        let fits = set.check_fits(&own, &mesh.triangles);
        fits.map_err(|source| BlockersError::Misfit { path: path(), object: object.name.clone(), source })?;
        let bounds = mesh.bounds();
        placed.mesh_bounds = [bounds.min, bounds.max];
    }
    Ok(placed)
}

fn ball_self_distance(balls: &[Sphere]) -> f32 {
    let total: f32 = balls.iter().map(|b| b.radius).sum();
    let far = balls.iter().map(|b| b.center.abs().max_element() + b.radius).fold(0.0, f32::max);
    (1e-3 * total / balls.len().max(1) as f32).max(1e-6 * far)
}
