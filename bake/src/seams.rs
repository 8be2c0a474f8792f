//! The seams of charts: both sides show the same light.

use crate::page::{Page, State};
use crate::target::Target;
use glam::{DVec3, Vec2, Vec3};
use scene_files::GltfPart;
use std::collections::HashMap;

/// Points on a seam, a texel of its length.
const POINTS: f32 = 2.0;

/// How much a texel's own value counts beside a point of a seam: of texels on a surface, and of those around it.
const OWN: [f64; 2] = [0.05, 0.005];

/// Steps of the solver, and the part of the first residual at which it ends.
const STEPS: usize = 60;
const RESIDUAL: f64 = 1e-10;

/// Corners that meet with normals whose cosine is below this make an edge, over which light may change.
const SMOOTH: f32 = 0.999;

/// The difference of both sides at a point of a seam: a sum of texels.
type Row = [(u32, f32); 8];

/// Both sides' coordinates at the ends of an edge where charts meet.
struct Seam {
    one: [Vec2; 2],
    other: [Vec2; 2],
}

/// A triangle's edge: a surface, its triangle, and the corner that it begins at.
type Edge = (usize, usize, usize);

/// The seams of the surfaces of a page: edges of two triangles with common places and normals, and other coordinates. `are_alike` says
/// whether two surfaces show the same thing where they meet.
fn seams(surfaces: &[(&GltfPart, &Target)], are_alike: &dyn Fn(&GltfPart, &GltfPart) -> bool) -> Vec<Seam> {
    let corner = |(s, t, k): Edge| surfaces[s].0.geometry.triangles[t][k % 3];
    let place = |edge: Edge| {
        let position = surfaces[edge.0].0.geometry.positions[corner(edge) as usize];
        (position + 0.0).to_array().map(f32::to_bits)
    };
    let face = |(s, t, _): Edge| {
        let mesh = &surfaces[s].0.geometry;
        let [a, b, c] = mesh.triangles[t].map(|i| mesh.positions[i as usize].as_dvec3());
        (b - a).cross(c - a).normalize_or_zero().as_vec3()
    };
    let normal = |edge: Edge| {
        let of_vertex = surfaces[edge.0].0.geometry.normals.get(corner(edge) as usize).copied();
        of_vertex.unwrap_or_else(|| face(edge))
    };
    let uv = |(s, t, k): Edge| surfaces[s].1.corners(t)[k % 3];
    let next = |(s, t, k): Edge| (s, t, k + 1);
    let are_smooth = |a: Edge, b: Edge| normal(a).dot(normal(b)) >= SMOOTH;
    let mut open: HashMap<_, Vec<Edge>> = HashMap::new();
    let mut found = Vec::new();
    for (s, (part, _)) in surfaces.iter().enumerate() {
        for edge in (0..part.geometry.triangles.len()).flat_map(|t| [0, 1, 2].map(|k| (s, t, k))) {
            let end = next(edge);
            let met = |other: &&Edge| {
                (other.0 == s || are_alike(part, surfaces[other.0].0))
                    && are_smooth(edge, next(**other))
                    && are_smooth(end, **other)
            };
            let Some(&other) = open.get(&(place(end), place(edge))).and_then(|all| all.iter().rev().find(met)) else {
                open.entry((place(edge), place(end))).or_default().push(edge);
                continue;
            };
            let seam = Seam { one: [uv(edge), uv(end)], other: [uv(next(other)), uv(other)] };
            if seam.one != seam.other {
                found.push(seam);
            }
        }
    }
    found
}

/// The texels that a filter mixes at a place of a page, with their parts.
fn filter(size: [u32; 2], uv: Vec2) -> [(u32, f32); 4] {
    let at = uv * Vec2::new(size[0] as f32, size[1] as f32) - 0.5;
    let (low, part) = (at.floor(), at - at.floor());
    let index = |x: f32, y: f32| {
        let clamp = |k: f32, side: u32| (k.max(0.0) as u32).min(side - 1);
        clamp(y, size[1]) * size[0] + clamp(x, size[0])
    };
    let (x, y) = (low.x, low.y);
    [
        (index(x, y), (1.0 - part.x) * (1.0 - part.y)),
        (index(x + 1.0, y), part.x * (1.0 - part.y)),
        (index(x, y + 1.0), (1.0 - part.x) * part.y),
        (index(x + 1.0, y + 1.0), part.x * part.y),
    ]
}

/// The differences at the points of a seam.
fn rows(size: [u32; 2], seam: &Seam, rows: &mut Vec<Row>) {
    let scale = Vec2::new(size[0] as f32, size[1] as f32);
    let length = |[a, b]: [Vec2; 2]| ((b - a) * scale).length();
    let steps = (length(seam.one).max(length(seam.other)) * POINTS).ceil().clamp(1.0, 65536.0) as u32;
    for step in 0..=steps {
        let s = step as f32 / steps as f32;
        let [one, other] = [&seam.one, &seam.other].map(|ends| filter(size, ends[0].lerp(ends[1], s)));
        let mut row = [(0, 0.0); 8];
        row[..4].copy_from_slice(&one);
        row[4..].copy_from_slice(&other.map(|(texel, part)| (texel, -part)));
        rows.push(row);
    }
}

/// The least squares `Σ (R x)² + Σ λ (x − x₀)²`, over the texels at seams.
struct Fit {
    /// Differences, of places in the list of texels.
    rows: Vec<Row>,
    /// λ of each texel.
    own: Vec<f64>,
}

impl Fit {
    /// `(RᵀR + Λ) x`.
    fn times(&self, x: &[DVec3]) -> Vec<DVec3> {
        let mut out: Vec<DVec3> = x.iter().zip(&self.own).map(|(x, own)| *x * *own).collect();
        for row in &self.rows {
            let difference: DVec3 = row.iter().map(|(i, part)| x[*i as usize] * f64::from(*part)).sum();
            row.iter().for_each(|(i, part)| out[*i as usize] += difference * f64::from(*part));
        }
        out
    }

    /// The solution, by conjugate gradients from the texels' own values (M. Hestenes, E. Stiefel, 1952), each channel by itself.
    fn solve(&self, own: &[DVec3]) -> Vec<DVec3> {
        let dot = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| *a * *b).sum::<DVec3>();
        let over = |a: DVec3, b: DVec3| {
            DVec3::select(b.cmpgt(DVec3::ZERO), a / b.max(DVec3::splat(f64::MIN_POSITIVE)), DVec3::ZERO)
        };
        let mut x = own.to_vec();
        let start = self.times(&x);
        // The right side is Λ x₀.
        let mut r: Vec<DVec3> = own.iter().zip(&self.own).zip(&start).map(|((x, own), ax)| *x * *own - *ax).collect();
        let mut p = r.clone();
        let first = dot(&r, &r);
        let mut rr = first;
        for _ in 0..STEPS {
            if rr.cmple(first * RESIDUAL).all() {
                break;
            }
            let ap = self.times(&p);
            let step = over(rr, dot(&p, &ap));
            x.iter_mut().zip(&p).for_each(|(x, p)| *x += step * *p);
            r.iter_mut().zip(&ap).for_each(|(r, ap)| *r -= step * *ap);
            let next = dot(&r, &r);
            let turn = over(next, rr);
            p.iter_mut().zip(&r).for_each(|(p, r)| *p = *r + turn * *p);
            rr = next;
        }
        x
    }
}

/// Moves the texels at seams as little as it takes for both sides to show the same (M. Iwanicki, *Lighting Technology of The Last of Us*,
/// SIGGRAPH 2013): least squares of the differences at points along the seams, and of the changes. Texels that no surface covers change
/// ten times as easily. Surfaces meet in seams as well where they `are_alike`. Where the first layer `is_sum` of the others, it stays so: no
/// light of one lamp may fall below 0, where that of all may.
///
/// Cost: some 10 µs a texel at a seam.
pub(crate) fn close(
    page: &mut Page,
    surfaces: &[(&GltfPart, &Target)],
    are_alike: &dyn Fn(&GltfPart, &GltfPart) -> bool,
    is_sum: bool,
) {
    let mut differences = Vec::new();
    seams(surfaces, are_alike).iter().for_each(|seam| rows(page.size, seam, &mut differences));
    let mut texels: Vec<u32> = differences.iter().flatten().filter(|(_, part)| *part != 0.0).map(|(i, _)| *i).collect();
    texels.sort_unstable();
    texels.dedup();
    let places: HashMap<u32, u32> = texels.iter().copied().zip(0..).collect();
    for (texel, part) in differences.iter_mut().flatten() {
        *texel = if *part == 0.0 { 0 } else { places[texel] };
    }
    let own = |texel: &u32| OWN[usize::from(page.states[*texel as usize] != State::Surface)];
    let fit = Fit { own: texels.iter().map(own).collect(), rows: differences };
    for layer in &mut page.layers {
        let values: Vec<DVec3> = texels.iter().map(|texel| layer[*texel as usize].as_dvec3()).collect();
        for (texel, value) in texels.iter().zip(fit.solve(&values)) {
            layer[*texel as usize] = value.as_vec3().max(Vec3::ZERO);
        }
    }
    if is_sum && let Some((sum, lights)) = page.layers.split_first_mut() {
        for texel in &texels {
            sum[*texel as usize] = lights.iter().map(|layer| layer[*texel as usize]).sum();
        }
    }
    for texel in texels {
        let state = &mut page.states[texel as usize];
        if *state == State::Empty {
            *state = State::Around;
        }
    }
}
