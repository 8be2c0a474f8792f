use crate::Revision;
use crate::blockers_error::{BlockersError, BlockersProgress};
use glam::{Mat4, Vec3};
use lobe_core::{SelfShadow, Sphere};
use scene::{Animation, BlockerSet, Duplicates, Mesh, Object, Proxy, Scene, Shape};
use sphere_sets::{BoundSet, BuildOptions, Carriers, SphereSet};
use std::collections::HashMap;
use std::path::Path;

/// Where an object's blocker spheres come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SphereSource {
    /// It has none: it blocks nothing, or another strategy has it.
    Nothing,
    /// Its [`Proxy`]: built, read or copied.
    Proxy,
    /// The exact spheres that it is; nothing when it is a mesh.
    Shape,
}

/// The blocker spheres of a scene's objects, made once and posed for every frame.
///
/// A sphere set is built or read for the scene as it was loaded, and follows what carries its mesh's points
/// ([`BoundSet`]): nothing is fitted per pose. Exact spheres and explicit spheres are where the scene says they are.
///
/// How an object shadows itself is fitted with its sphere set, sphere by sphere, and follows the spheres' radii; explicit
/// spheres are measured against a visible mesh for one distance τ.
/// Exact spheres stand for themselves: their τ is a thousandth of their mean radius, no more than keeps rounding from
/// blackening a surface. Equal spheres are one, and equal meshes ([`Duplicates`]). A sphere that coincides with a light blocks nothing: it is how a light is made visible.
///
/// # Cost of a pose
/// One to four matrix products a sphere that follows bones, a copy of the others.
#[derive(Clone, Debug, Default)]
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
    /// The sphere set before it was placed, of a mesh that stands still.
    own: Option<Box<SphereSet>>,
    made_for: MadeFor,
}

/// The inputs from which the spheres of an object were made.
#[derive(Clone, Copy, Debug)]
struct MadeFor {
    revision: Revision,
    source: SphereSource,
    is_visible: bool,
    /// Where the sphere set stands.
    placement: Mat4,
}

impl MadeFor {
    const NOTHING: Self = Self {
        revision: Revision { object: u64::MAX, form: 0, place: 0, transform: Mat4::IDENTITY },
        source: SphereSource::Nothing,
        is_visible: false,
        placement: Mat4::IDENTITY,
    };
}

impl ObjectSpheres {
    const fn new(spheres: Spheres, self_distance: f32) -> Self {
        let made_for = MadeFor::NOTHING;
        Self { spheres, self_distance, self_shadows: Vec::new(), silhouette_error: None, own: None, made_for }
    }

    /// Whether they are those of an object that is as it is now.
    fn is_for(&self, revision: &Revision, source: SphereSource, object: &Object) -> bool {
        let before = &self.made_for;
        let measured = matches!(self.spheres, Spheres::Listed) && before.is_visible != object.visible;
        before.revision.form == revision.form && before.source == source && !measured
    }

    /// Puts them where the object has been moved to.
    fn place(&mut self, object: &Object, revision: &Revision) {
        let placement = match object.proxy {
            Proxy::File { placement, .. } => placement,
            _ => revision.transform,
        };
        if let (Spheres::Still(spheres), Some(own), true) =
            (&mut self.spheres, &self.own, placement != self.made_for.placement)
        {
            let is_own = placement == Mat4::IDENTITY && !matches!(object.proxy, Proxy::File { .. });
            let placed = if is_own { (**own).clone() } else { own.placed(&placement) };
            (*spheres, self.self_shadows) = (placed.spheres, placed.self_shadows);
            self.self_distance = placed.self_distance;
            self.made_for.placement = placement;
        }
        if revision.transform != self.made_for.revision.transform {
            match (&self.spheres, &object.shape) {
                (Spheres::Shape, Shape::Spheres(spheres)) => self.self_distance = sphere_self_distance(spheres),
                (Spheres::Listed, _) => self.self_distance = listed_distance(object),
                _ => {}
            }
        }
        self.made_for.revision = *revision;
    }
}

/// The τ of the spheres that an object's proxy lists.
fn listed_distance(object: &Object) -> f32 {
    match (&object.proxy, &object.shape) {
        // Spheres that stand for a flat or empty mesh: nothing to measure, and no inside to shadow.
        (Proxy::Spheres(list), shape) if object.visible && shape.has_triangles() => {
            let mesh = shape.mesh().unwrap_or_default();
            SphereSet::self_distance_of(&mesh.positions, &mesh.triangles, list).unwrap_or(0.0)
        }
        (Proxy::Spheres(list), _) => sphere_self_distance(list),
        _ => 0.0,
    }
}

#[derive(Clone, Debug)]
enum Spheres {
    Nothing,
    /// The spheres that the object is.
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
        let mut all = Self::default();
        all.update(scene, animation, source, &Revision::unedited(scene.objects.len()), progress)?;
        Ok(all)
    }

    /// Follows a scene that has been edited, of whose objects there is a revision each: only spheres of objects whose form is new are
    /// built, read or measured. How many. The scene has its objects where they stood at first, before any
    /// [transform](Revision::transform); [`place`](Self::place) puts the spheres where they are.
    ///
    /// # Errors
    /// As [`new`](Self::new). Sets that are made by then are kept for the next call.
    pub fn update(
        &mut self,
        scene: &Scene,
        animation: Option<&Animation>,
        source: impl Fn(usize) -> SphereSource,
        revisions: &[Revision],
        progress: &mut BlockersProgress<'_>,
    ) -> Result<usize, BlockersError> {
        let old = core::mem::take(&mut self.objects);
        let mut old: HashMap<u64, ObjectSpheres> =
            old.into_iter().map(|own| (own.made_for.revision.object, own)).collect();
        let mut count = 0;
        for (number, (object, revision)) in scene.objects.iter().zip(revisions).enumerate() {
            let source = source(number);
            if let Some(own) = old.remove(&revision.object).filter(|own| own.is_for(revision, source, object)) {
                self.objects.push(own);
                continue;
            }
            match make(number, object, animation, source, progress) {
                Ok(mut own) => {
                    count += usize::from(!matches!(own.spheres, Spheres::Nothing));
                    let revision = Revision { transform: Mat4::IDENTITY, ..*revision };
                    own.made_for = MadeFor { revision, source, is_visible: object.visible, ..own.made_for };
                    self.objects.push(own);
                }
                Err(error) => {
                    self.objects.extend(old.into_values());
                    return Err(error);
                }
            }
        }
        Ok(count)
    }

    /// Puts the spheres where the objects of the scene have been moved to, after [`update`](Self::update).
    pub fn place(&mut self, scene: &Scene, revisions: &[Revision]) {
        for ((object, revision), own) in scene.objects.iter().zip(revisions).zip(&mut self.objects) {
            own.place(object, revision);
        }
    }

    /// Which objects block by a sphere set, and the part of their silhouettes that it misses.
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
        let (mut shapes, mut own_spheres, mut meshes) =
            (Duplicates::default(), Duplicates::default(), Duplicates::default());
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
            own_spheres.clear();
            for (i, sphere) in spheres.iter().enumerate() {
                let first = match object.shape {
                    Shape::Spheres(_) => shapes.is_first(object, sphere),
                    Shape::Mesh(_) | Shape::Instances(_) => own_spheres.is_first(object, sphere),
                };
                if !first {
                    continue;
                }
                out.spheres.push(scene.casting(sphere));
                let whole = || SelfShadow::whole(own.self_distance / sphere.radius.max(f32::MIN_POSITIVE));
                out.self_shadows.push(self_shadows.get(i).copied().unwrap_or_else(whole));
            }
            out.objects.resize(out.spheres.len(), number as u32);
            out.self_distances.push(own.self_distance);
        }
        Ok(())
    }
}

/// The spheres of an object.
fn make(
    number: usize,
    object: &Object,
    animation: Option<&Animation>,
    source: SphereSource,
    progress: &mut BlockersProgress<'_>,
) -> Result<ObjectSpheres, BlockersError> {
    match (source, &object.shape) {
        (SphereSource::Nothing, _) | (SphereSource::Shape, Shape::Mesh(_) | Shape::Instances(_)) => {
            Ok(ObjectSpheres::new(Spheres::Nothing, 0.0))
        }
        (SphereSource::Shape, Shape::Spheres(spheres)) => {
            Ok(ObjectSpheres::new(Spheres::Shape, sphere_self_distance(spheres)))
        }
        (SphereSource::Proxy, _) => from_proxy(number, object, animation, progress),
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
        (Proxy::Count(_), Shape::Spheres(spheres)) => {
            return Ok(ObjectSpheres::new(Spheres::Shape, sphere_self_distance(spheres)));
        }
        (Proxy::Spheres(_), _) => return Ok(ObjectSpheres::new(Spheres::Listed, listed_distance(object))),
        (Proxy::Count(count), shape) => {
            let mesh = shape.mesh().unwrap_or_default();
            let Mesh { positions, triangles, .. } = &*mesh;
            let mut report = |done| progress(&object.name, done);
            let options = BuildOptions::new(*count);
            let set = SphereSet::build_with_progress(positions, triangles, &options, &mut report);
            let set = set.map_err(|source| BlockersError::Build { object: name(), source })?;
            (set.clone(), set, Mat4::IDENTITY)
        }
        (Proxy::File { path, placement }, _) => {
            let (own, placed) = read_and_place(path, placement, object)?;
            (own, placed, *placement)
        }
    };
    let (own, set, placement) = set;
    let (self_distance, silhouette_error) = (set.self_distance, Some(set.quality.silhouette_error));
    let self_shadows = set.self_shadows.clone();
    let made = |spheres, own| {
        let made_for = MadeFor { placement, ..MadeFor::NOTHING };
        Ok(ObjectSpheres { spheres, self_distance, self_shadows, silhouette_error, own, made_for })
    };
    let rig = animation.and_then(|a| Some((a.rig(number)?, a.pose(number, 0.0))));
    let (Some((rig, rest)), Shape::Mesh(mesh)) = (rig, &object.shape) else {
        return made(Spheres::Still(set.spheres), Some(Box::new(own)));
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
    made(Spheres::Bound(Box::new(bound)), None)
}

/// Reads the file of a sphere set that is given for an object as it stood before `placement`, and puts the set where the
/// object is ([`SphereSet::placed`]).
///
/// # Errors
/// [`BlockersError::Read`], [`BlockersError::Set`], and [`BlockersError::Misfit`] for a set of another mesh.
pub fn read_set(path: &Path, placement: &Mat4, object: &Object) -> Result<SphereSet, BlockersError> {
    Ok(read_and_place(path, placement, object)?.1)
}

/// The set as it is in its file, and where the object is.
fn read_and_place(path: &Path, placement: &Mat4, object: &Object) -> Result<(SphereSet, SphereSet), BlockersError> {
    let path = || path.to_owned();
    let text = std::fs::read_to_string(path()).map_err(|source| BlockersError::Read { path: path(), source })?;
    let set = SphereSet::from_json(&text).map_err(|source| BlockersError::Set { path: path(), source })?;
    let mut placed = set.placed(placement);
    if let Some(mesh) = object.shape.mesh() {
        let back = placement.inverse();
        let own: Vec<Vec3> = mesh.positions.iter().map(|p| back.transform_point3(*p)).collect();
        let fits = set.check_fits(&own, &mesh.triangles);
        fits.map_err(|source| BlockersError::Misfit { path: path(), object: object.name.clone(), source })?;
        let bounds = mesh.bounds();
        placed.mesh_bounds = [bounds.min, bounds.max];
    }
    Ok((set, placed))
}

fn sphere_self_distance(spheres: &[Sphere]) -> f32 {
    let total: f32 = spheres.iter().map(|b| b.radius).sum();
    let far = spheres.iter().map(|b| b.center.abs().max_element() + b.radius).fold(0.0, f32::max);
    (1e-3 * total / spheres.len().max(1) as f32).max(1e-6 * far)
}
