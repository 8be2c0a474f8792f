//! Advice: the strategy that suits an object, and the reason.

use crate::console::counted;
use cosine_lobes::scene::{Animation, Bounds, Mesh, Object, Projection, Proxy, Scene, Shape, Strategy};
use cosine_lobes::shading::LightLobes;
use cosine_lobes::sphere_sets::SetQuality;
use glam::{DVec3, Vec3};
use std::collections::HashMap;

/// A strategy for an object, with the reason.
pub(crate) struct Advice {
    pub(crate) strategy: Strategy,
    pub(crate) reason: String,
}

/// Thinner solids need many spheres. The thickness is 2V/A over the diagonal: 0.19 for a sphere, 0.11 for
/// the Stanford bunny, 0.05 for the armadillo, 0.01 for a fence.
const THIN: f64 = 0.04;
/// Counts and sizes of a mesh.
struct MeshFacts {
    /// Fraction of the edges that only one triangle has.
    open: f64,
    /// Fraction of the edges whose two triangles wind against each other.
    twisted: f64,
    /// 2V/A, the thickness of a slab of the same volume and area.
    thickness: f64,
    diagonal: f64,
}

impl MeshFacts {
    /// Linear in the triangles.
    fn of(mesh: &Mesh) -> Self {
        // Corners that are in the same place are the same, however often a file lists them.
        let mut places: HashMap<[u32; 3], u32> = HashMap::new();
        let mut place = |i: u32| {
            let key = (mesh.positions[i as usize] + Vec3::ZERO).to_array().map(f32::to_bits);
            let next = places.len() as u32;
            *places.entry(key).or_insert(next)
        };
        let triangles: Vec<[u32; 3]> = mesh.triangles.iter().map(|t| t.map(&mut place)).collect();
        // For each edge how many triangles have it, and how many of them run along it upward less those downward.
        let mut edges: HashMap<(u32, u32), (u32, i32)> = HashMap::new();
        for t in &triangles {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                let edge = edges.entry((a.min(b), a.max(b))).or_default();
                *edge = (edge.0 + 1, edge.1 + if a < b { 1 } else { -1 });
            }
        }
        let share = |of: &dyn Fn(&(u32, i32)) -> bool| {
            edges.values().filter(|e| of(e)).count() as f64 / edges.len().max(1) as f64
        };
        let bounds = mesh.bounds();
        let middle = bounds.center().as_dvec3();
        let (mut area, mut volume) = (0.0, 0.0);
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|i| mesh.positions[i as usize].as_dvec3() - middle);
            let cross = (b - a).cross(c - a);
            area += 0.5 * cross.length();
            volume += a.dot(cross) / 6.0;
        }
        Self {
            open: share(&|e| e.0 == 1),
            twisted: share(&|e| e.0 == 2 && e.1 != 0),
            thickness: if area > 0.0 { 2.0 * volume.abs() / area } else { 0.0 },
            diagonal: f64::from((bounds.max - bounds.min).length()),
        }
    }
}

/// Whether all triangles are in one plane, to a ten-thousandth of their diagonal. ShadowCasting at the first triangle outside it.
fn is_flat(mesh: &Mesh) -> bool {
    let bounds = mesh.bounds();
    let slack = 1e-4 * f64::from((bounds.max - bounds.min).length());
    let corner = |i: u32| mesh.positions[i as usize].as_dvec3();
    let plane = mesh.triangles.iter().find_map(|t| {
        let [a, b, c] = t.map(corner);
        // Slivers have no normal to rely on.
        let cross = (b - a).cross(c - a);
        (cross.length() > slack * slack).then(|| (a, cross.normalize()))
    });
    plane.is_some_and(|(a, n)| mesh.triangles.iter().flatten().all(|i| n.dot(corner(*i) - a).abs() <= slack))
}

/// Advice for an object of a scene. `set` is the quality of its sphere set, where known: a bad one speaks
/// against spheres, a good one does not speak for them.
///
/// `taken`: the strategy that pictures take at the scene's moment. `boxes` are around all objects.
pub(crate) fn advise(
    scene: &Scene,
    animation: &Animation,
    boxes: &[Bounds],
    number: usize,
    taken: Strategy,
    set: Option<&SetQuality>,
) -> Advice {
    let object = &scene.objects[number];
    let advice = |strategy, reason: String| Advice { strategy, reason };
    let mesh = match &object.shape {
        Shape::Spheres(_) => return advice(Strategy::Spheres, "spheres are exact, and cheapest".to_owned()),
        Shape::Instances(_) => {
            return advice(Strategy::Silhouettes, "one mesh at many places, which is stored once".to_owned());
        }
        Shape::Mesh(mesh) => mesh,
    };
    if object.strategy.is_none() && taken == Strategy::None {
        let reason = "a backdrop: lights and all that is seen are in front of it";
        return advice(Strategy::None, reason.to_owned());
    }
    if is_backdrop(scene, animation, boxes, number, mesh) {
        let reason = "a backdrop: lights, camera and all that casts shadows are in front of it";
        return advice(Strategy::None, reason.to_owned());
    }
    let missed = |set: &SetQuality| {
        let percent = 100.0 * set.silhouette_error;
        format!("its spheres miss {percent:.1} % of its silhouette")
    };
    // A set that the scene names is there to be used. One that an earlier picture left behind is none: with it the advice
    // would be another after the first picture than before.
    if let (Some(set), Proxy::File { .. }) = (set, &object.proxy)
        && set.suits()
    {
        return advice(Strategy::Spheres, missed(set));
    }
    let beside = match set.filter(|set| !set.suits()) {
        Some(set) => missed(set),
        None => about_spheres(mesh),
    };
    let triangles = counted(mesh.triangles.len(), "triangle");
    advice(Strategy::Silhouettes, format!("{triangles}, exact and without a fit; {beside}"))
}

/// Whether spheres could stand for a mesh, in a few words.
fn about_spheres(mesh: &Mesh) -> String {
    if is_flat(mesh) {
        return "flat: no inside that spheres could fill".to_owned();
    }
    let facts = MeshFacts::of(mesh);
    let thin = facts.thickness / facts.diagonal.max(f64::MIN_POSITIVE);
    if facts.open > 0.02 {
        format!("open, {:.0} % of its edges have one triangle: not for spheres", 100.0 * facts.open)
    } else if facts.twisted > 0.02 {
        "its triangles wind both ways: not for spheres".to_owned()
    } else if thin < THIN {
        format!("closed but thin, {:.1} % of its diagonal: spheres would be many or bulge", 100.0 * thin)
    } else {
        format!(
            "closed and compact, {:.0} % of its diagonal thick: spheres may be faster, and --prices says how far off they are",
            100.0 * thin
        )
    }
}

/// Whether an object casts no shadow in the scene file.
fn casts_nothing(object: &Object) -> bool {
    let has_spheres = object.proxy != Proxy::None;
    match object.strategy {
        None => !has_spheres && matches!(object.shape, Shape::Spheres(_)),
        Some(Strategy::Spheres) => !has_spheres,
        Some(strategy) => strategy == Strategy::None,
    }
}

/// Whether an object is a backdrop: a floor, a wall, a cove, the inside of a room. Camera, lights and the boxes of all other
/// objects must be in front of each of its triangles, and the object must bend toward that side only. An object that casts a
/// shadow is no backdrop if anything in the scene moves.
///
/// For an object that casts nothing already, only the boxes of casting objects count: a floor that reaches behind a wall
/// need not receive the wall's shadow there.
fn is_backdrop(scene: &Scene, animation: &Animation, boxes: &[Bounds], number: usize, mesh: &Mesh) -> bool {
    let silent = casts_nothing(&scene.objects[number]);
    if animation.rig(number).is_some() || !(silent || animation.is_still()) {
        return false;
    }
    let counts = |(n, o): &(usize, &Object)| *n != number && !(silent && casts_nothing(o));
    let others = || scene.objects.iter().enumerate().filter(counts).map(|(n, _)| boxes[n]);
    let size = |bounds: &Bounds| f64::from((bounds.max - bounds.min).length());
    let own = size(&boxes[number]);
    // A part of 1e-4 of the box or of the mesh, of the smaller one, may be behind: what stands on a floor touches it.
    let slack = |other: f64| 1e-4 * own.min(other);
    let corners = |b: Bounds| {
        let may_be_behind = slack(size(&b));
        let pick = move |k: usize| {
            let high = Vec3::new((k & 1) as f32, (k >> 1 & 1) as f32, (k >> 2 & 1) as f32);
            ((b.min + (b.max - b.min) * high).as_dvec3(), -may_be_behind)
        };
        (0..8).map(pick)
    };
    // How far points must be before each triangle.
    let of_lights = scene.lights.iter().map(|light| light.bounds()).map(|sphere| {
        let radius = f64::from(sphere.radius);
        (sphere.center.as_dvec3(), radius - slack(2.0 * radius))
    });
    let mut points: Vec<(DVec3, f64)> = of_lights.collect();
    let (eye, [.., forward]) = (scene.camera.eye.as_dvec3(), scene.camera.axes());
    let are_parallel = matches!(scene.camera.projection, Projection::Orthographic { .. });
    let toward_eye = |a: DVec3| if are_parallel { -forward.as_dvec3() } else { eye - a };
    // Few large triangles look at all of the mesh; many small ones are no backdrop.
    if mesh.triangles.len() * (8 * boxes.len() + points.len() + mesh.positions.len()) > 10_000_000 {
        return false;
    }
    points.extend(mesh.positions.iter().map(|p| (p.as_dvec3(), -slack(own))));
    mesh.triangles.iter().all(|t| {
        let [a, b, c] = t.map(|i| mesh.positions[i as usize].as_dvec3());
        let Some(normal) = (b - a).cross(c - a).try_normalize() else { return true };
        let normal = if normal.dot(toward_eye(a)) < 0.0 { -normal } else { normal };
        let is_before = |(p, before): (DVec3, f64)| normal.dot(p - a) >= before;
        points.iter().copied().all(is_before) && others().flat_map(corners).all(is_before)
    })
}
