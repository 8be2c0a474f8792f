use crate::camera_keys::CameraKeys;
use crate::deformer::{BoundSphere, Deformer, scaled};
use crate::mesh::MAX_COORDINATE;
use crate::placement::Placement;
use crate::skeleton::{Carrier, Skeleton};
use crate::{Camera, Object, Projection, Proxy, Scene, Shape};
use glam::{DVec3, Mat4, Vec3};
use lighting::Light;
use lobe_core::Sphere;

/// The motion of a loaded scene: key frames of a scene file, clips of glTF files.
///
/// A vertex of a moving mesh is at `p(t) = Σ_j w_j J_j(t) (p_bind + Σ_k m_k(t) Δ_k)` (glTF 2.0, §3.7.2.2 and §3.7.3.3, in
/// world space): [`Animation::rig`] gives its weights `w` and displacements `Δ`, [`Animation::pose`] the joint matrices
/// `J` and morph weights `m` of a time, [`Animation::seek`] applies them. A rigid object hangs on one joint.
///
/// Any moment may be requested, in any order: nothing is precomputed per pose. A clip and keys with `loop` start again
/// after their end; all other motion stays at its end. Readers of files fill in the [parts](crate::motion); in code
/// [`set_keys`](Self::set_keys) makes an animation:
///
/// ```
/// use glam::Vec3;
/// use scene::{Animation, KeyFrame, KeyFrames};
/// let (mut scene, mut animation) = (scene::builtin(), Animation::default());
/// let before = scene.objects[1].shape.bounds().center().x;
/// let keys = vec![KeyFrame::at(0.0), KeyFrame { translation: 4.0 * Vec3::X, ..KeyFrame::at(2.0) }];
/// animation.set_keys(1, &KeyFrames { keys, ..KeyFrames::default() }, &mut scene)?;
/// assert_eq!(animation.duration(), 2.0);
/// animation.seek(0.5, &mut scene);
/// assert!((scene.objects[1].shape.bounds().center().x - before - 1.0).abs() < 1e-5);
/// # Ok::<(), scene::SceneError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Animation {
    /// As [`Self::origin`].
    pub origin: DVec3,
    /// Seconds; `None` for those until the last key and the end of the longest clip.
    pub duration: Option<f32>,
    /// As [`Self::fps`].
    pub fps: f32,
    /// As [`Self::clips`].
    pub clips: Vec<String>,
    /// The nodes of each glTF file with a clip that moves.
    pub skeletons: Vec<Skeleton>,
    /// The motion of each object, if it moves; objects beyond the end stand still.
    pub movers: Vec<Option<Mover>>,
    /// The lights that move.
    pub lights: Vec<LightMover>,
    /// The motion of the camera, if it moves.
    pub camera: Option<CameraMover>,
}

/// The joints and weights that carry the points of a moving mesh; one entry a vertex in all of its slices.
#[derive(Clone, Copy, Debug)]
pub struct Rig<'a> {
    /// Joint numbers.
    pub joints: &'a [[u16; 4]],
    /// The weight of each of these joints: not negative, of sum 1; 0 where there are fewer than four.
    pub weights: &'a [[f32; 4]],
    /// For each morph target the displacements at weight 1, in bind space.
    pub targets: &'a [Vec<Vec3>],
}

/// Joint matrices and morph weights at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pose {
    /// From bind space to the world.
    pub joints: Vec<Mat4>,
    /// The weight of each morph target.
    pub morph: Vec<f32>,
}

/// The motion of one object.
#[derive(Clone, Debug)]
pub struct Mover {
    /// From the file's (or the shape's own) space to the world.
    pub placement: Placement,
    /// The geometry.
    pub body: Body,
    /// The spheres of an explicit proxy.
    pub proxy: Vec<BoundSphere>,
}

/// The geometry that a mover moves.
#[derive(Clone, Debug)]
pub enum Body {
    /// Spheres in own coordinates.
    Spheres(Vec<Sphere>),
    /// A mesh; without a carrier the placement is its only joint.
    Mesh(Box<Deformer>, Option<Carrier>),
}

/// Lights in a row that move as one.
#[derive(Clone, Debug)]
pub struct LightMover {
    /// The number of the first one in the scene.
    pub first: usize,
    /// In own coordinates.
    pub lights: Vec<Light>,
    /// From own coordinates to the world.
    pub placement: LightPlace,
}

/// How a light is placed.
#[derive(Clone, Debug)]
pub enum LightPlace {
    /// By key frames.
    Keys(Placement),
    /// A node of a glTF file.
    Node {
        /// The number of the skeleton in the animation.
        skeleton: usize,
        /// The number of the node in the skeleton.
        node: usize,
    },
}

/// The motion of the camera.
#[derive(Clone, Debug)]
pub enum CameraMover {
    /// By key frames.
    Keys(Box<CameraKeys>),
    /// A node of a glTF file, and the projection.
    Node {
        /// The number of the skeleton in the animation.
        skeleton: usize,
        /// The number of the node in the skeleton.
        node: usize,
        /// How it maps the scene to its picture.
        projection: Projection,
    },
}

impl Animation {
    /// Frames a second where a file does not say.
    pub const DEFAULT_FPS: f32 = 24.0;

    /// The scene's origin in the world of its file: all coordinates of the scene are relative to it. Zero but for scenes that lie
    /// far from the origin of their file, where single precision would show.
    #[must_use]
    pub const fn origin(&self) -> DVec3 {
        self.origin
    }

    /// Whether nothing moves.
    #[must_use]
    pub fn is_still(&self) -> bool {
        self.camera.is_none() && self.lights.is_empty() && self.movers.iter().all(Option::is_none)
    }

    /// Seconds: the scene file's value, else until the last key and the end of the longest clip; 0 when nothing moves.
    #[must_use]
    pub fn duration(&self) -> f32 {
        if self.is_still() {
            return 0.0;
        }
        let placements = self.movers.iter().flatten().map(|m| &m.placement);
        let of_lights = self.lights.iter().filter_map(|light| match &light.placement {
            LightPlace::Keys(placement) => Some(placement),
            LightPlace::Node { .. } => None,
        });
        let ends = placements.chain(of_lights).map(Placement::end);
        let camera = match &self.camera {
            Some(CameraMover::Keys(keys)) => keys.clock.last,
            _ => 0.0,
        };
        let longest = ends.chain(self.skeletons.iter().map(Skeleton::end)).fold(camera, f32::max);
        self.duration.unwrap_or(longest)
    }

    /// Frames a second: the scene file's value, else [`Self::DEFAULT_FPS`].
    #[must_use]
    pub const fn fps(&self) -> f32 {
        self.fps
    }

    /// The clips that the glTF files of the scene have, by name, or by number where they have none; for a scene file
    /// with the object's name and a slash before each.
    #[must_use]
    pub fn clips(&self) -> &[String] {
        &self.clips
    }

    /// The joints and weights that carry a mesh that moves; none for objects that stand still and for exact spheres.
    #[must_use]
    pub fn rig(&self, object: usize) -> Option<Rig<'_>> {
        match &self.movers.get(object)?.as_ref()?.body {
            Body::Spheres(_) => None,
            Body::Mesh(d, _) => Some(Rig { joints: &d.joints, weights: &d.weights, targets: &d.targets }),
        }
    }

    /// The joint matrices and morph weights of an object at a time in seconds; one identity for an object that stands still.
    ///
    /// Cost: one matrix for each node of the glTF file.
    #[must_use]
    pub fn pose(&self, object: usize, time: f32) -> Pose {
        let time = tamed(time);
        let mut pose = Pose::default();
        match self.movers.get(object).and_then(Option::as_ref) {
            None => pose.joints.push(Mat4::IDENTITY),
            Some(mover) => {
                let skeleton = match &mover.body {
                    Body::Mesh(_, Some(carrier)) => Some(&self.skeletons[carrier.skeleton]),
                    _ => None,
                };
                let worlds = skeleton.map_or_else(Vec::new, |s| s.worlds(time));
                mover.pose(time, skeleton, &worlds, &mut pose);
            }
        }
        pose
    }

    /// Poses a scene: positions, normals, spheres, explicit proxy spheres, lights and the camera are written in place.
    /// Topology and counts never change. The scene is the one that came with this animation; objects that were added
    /// to its end stay as they are.
    ///
    /// `time` in seconds. Times below 0 and NaN count as 0.
    ///
    /// Between two camera keys a view may be undefined (eye on target, `up` along the view). There the camera
    /// keeps its last pose.
    ///
    /// Cost: linear in the vertices that move: per vertex one matrix product for a rigid object, up to four for a
    /// skinned one, and one addition for each morph target in use.
    /// Measured on one core: for 1000 vertices 10 µs (rigid, or with up to 8 morph targets), 38 µs (skinned), 57 µs (skinned,
    /// normals from the triangles); 1 µs for each node of a file. It allocates the matrices of nodes and joints, and for
    /// normals from the triangles two vectors a vertex.
    pub fn seek(&self, time: f32, scene: &mut Scene) {
        let time = tamed(time);
        let worlds = self.worlds(time);
        self.move_objects(time, &worlds, &mut scene.objects);
        for mover in &self.lights {
            let matrix = match &mover.placement {
                LightPlace::Keys(placement) => placement.at(time),
                LightPlace::Node { skeleton, node } => worlds[*skeleton][*node],
            };
            for (light, own) in scene.lights.iter_mut().skip(mover.first).zip(&mover.lights) {
                *light = own.moved(matrix);
            }
        }
        let camera = match &self.camera {
            None => return,
            Some(CameraMover::Keys(keys)) => keys.at(time),
            &Some(CameraMover::Node { skeleton, node, projection }) => node_camera(&worlds[skeleton][node], projection),
        };
        if camera.validate().is_ok() {
            scene.camera = camera;
        }
    }

    /// World matrices of all nodes of all skeletons at a time in seconds.
    #[must_use]
    pub fn worlds(&self, time: f32) -> Vec<Vec<Mat4>> {
        self.skeletons.iter().map(|s| s.worlds(time)).collect()
    }

    /// Poses objects alone, as [`Self::seek`] does with those of a scene; `worlds` are the [world matrices](Self::worlds) of that time.
    pub fn move_objects(&self, time: f32, worlds: &[Vec<Mat4>], objects: &mut [Object]) {
        let mut pose = Pose::default();
        for (object, mover) in objects.iter_mut().zip(&self.movers) {
            let Some(mover) = mover else { continue };
            let (skeleton, worlds) = match &mover.body {
                Body::Mesh(_, Some(carrier)) => (Some(&self.skeletons[carrier.skeleton]), &*worlds[carrier.skeleton]),
                _ => (None, &[][..]),
            };
            mover.pose(time, skeleton, worlds, &mut pose);
            match (&mover.body, &mut object.shape) {
                (Body::Spheres(own), Shape::Spheres(spheres)) => place(own, &pose.joints[0], spheres),
                (Body::Mesh(deformer, _), Shape::Mesh(mesh)) if mesh.positions.len() == deformer.positions.len() => {
                    deformer.pose(&pose.joints, &pose.morph, mesh);
                }
                _ => {}
            }
            if let Proxy::Spheres(spheres) = &mut object.proxy {
                for (sphere, bound) in spheres.iter_mut().zip(&mover.proxy) {
                    *sphere = bound.at(&pose.joints);
                }
            }
        }
    }
}

impl Default for Animation {
    /// Nothing moves.
    fn default() -> Self {
        Self {
            origin: DVec3::ZERO,
            duration: None,
            fps: Self::DEFAULT_FPS,
            clips: Vec::new(),
            skeletons: Vec::new(),
            movers: Vec::new(),
            lights: Vec::new(),
            camera: None,
        }
    }
}

impl Mover {
    /// Writes joint matrices from bind space to the world, and morph weights, of a time in seconds. `skeleton` is the one of the
    /// mover's carrier, if it has one, and `worlds` are its matrices of that time.
    pub fn pose(&self, time: f32, skeleton: Option<&Skeleton>, worlds: &[Mat4], out: &mut Pose) {
        out.joints.clear();
        out.morph.clear();
        let placement = self.placement.at(time);
        match (&self.body, skeleton) {
            (Body::Mesh(_, Some(carrier)), Some(skeleton)) => {
                let usable = |m: &Mat4| m.to_cols_array().iter().all(|v| v.abs() <= MAX_COORDINATE);
                let joints = carrier.joints(worlds).map(|joint| placement * joint);
                out.joints.extend(joints.map(|m| if usable(&m) { m } else { placement }));
                if let Some(node) = carrier.morph {
                    skeleton.morph_weights(node, time, &mut out.morph);
                }
            }
            _ => out.joints.push(placement),
        }
    }
}

fn place(own: &[Sphere], matrix: &Mat4, out: &mut [Sphere]) {
    for (sphere, own) in out.iter_mut().zip(own) {
        *sphere = scaled(*own, matrix);
    }
}

/// A time that keys can be looked up at.
fn tamed(time: f32) -> f32 {
    if time.is_nan() { 0.0 } else { time.clamp(0.0, 1e9) }
}

/// The view of a glTF camera whose node has that world matrix.
#[must_use]
pub fn node_camera(world: &Mat4, projection: Projection) -> Camera {
    let eye = world.transform_point3(Vec3::ZERO);
    let forward = world.transform_vector3(Vec3::NEG_Z).normalize_or_zero();
    let up = world.transform_vector3(Vec3::Y).normalize_or_zero();
    // Far enough for the direction to survive f32.
    let target = eye + forward * eye.length().max(1.0);
    Camera { eye, target, up, projection }
}
