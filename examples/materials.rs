//! Every material's lobes against the material itself, unshadowed and behind an edge, as a table in Markdown:
//! `cargo run --release --example materials > docs/materials.md`; with a word, only materials whose names contain it; with `costs`,
//! only the costs.
//!
//! The material's side draws directions from light and reflectance and has no code in common with the lobes.

use core::convert::Infallible;
use cosine_lobes::brdf::{
    Brdf, HalfVector, HalfVectorLobe, Lafortune, LafortuneLobe, Lambert, Material, MetallicRoughness, ModifiedPhong,
    Neumann, residual,
};
use cosine_lobes::lighting::{Light, SphereLight};
use cosine_lobes::lobe_core::{Cone, Receiver, SeenLight, Sphere, orthonormal_basis};
use cosine_lobes::render_cpu::CpuShader;
use cosine_lobes::scene::{Frame, Shade, ShadingPoints};
use cosine_lobes::shading::{
    Accuracy, BrdfLobes, Coverage, FractionIntegrator, Integrator, Interaction, LightId, LightVisibility, Unshadowed,
    Visibility, VisibilityQuery,
};
use cosine_lobes::visibility_mask::{Blockers, Edges, Mask, MaskVisibility};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Directions drawn from the light, and as many from the material.
const DRAWN: u32 = 1 << 17;

/// Directions of the light for each view and half-angle.
const LIGHTS: u32 = 12;

const VIEWS: [f64; 5] = [0.0, 30.0, 50.0, 70.0, 80.0];
const HALF_ANGLES: [f64; 3] = [0.5, 5.0, 25.0];
const TOLERANCES: [f32; 3] = [0.01, 0.003, 0.001];

/// Hides all directions on one side of a plane through the receiver, or through the middle of the light as well.
#[derive(Clone, Copy, Debug)]
enum Edge {
    At(Vec3),
    Middle,
}

impl Edge {
    /// Normal of the plane, on the hidden side.
    fn hidden(&self, cone: &Cone) -> Vec3 {
        match self {
            Self::At(hidden) => *hidden,
            Self::Middle => cone.axis.cross(Vec3::new(0.3, 0.8, 0.5)).normalize(),
        }
    }
}

impl Blockers for Edge {
    type Scratch = ();
    fn scratch(&self) {}
    fn select(&self, _: &VisibilityQuery<'_>, (): &mut ()) -> Coverage {
        Coverage::Partial
    }
    fn edges(&self, query: &VisibilityQuery<'_>, (): &(), edges: &mut Edges) {
        edges.add_plane(self.hidden(query.cone), query.cone);
    }
    fn splat(&self, query: &VisibilityQuery<'_>, (): &mut (), mask: &mut Mask) {
        let plane = mask.square().local(self.hidden(query.cone));
        for row in 0..mask.side() {
            // Hidden where plane·(x, y, 1) > 0.
            let end = -(plane.y * mask.row_y(row) + plane.z) / plane.x;
            if plane.x > 0.0 {
                mask.block_span(row, end, f32::INFINITY);
            } else {
                mask.block_span(row, f32::NEG_INFINITY, end);
            }
        }
    }
}

/// A view, a light and an edge through the light.
struct Case {
    at: Receiver,
    cone: Cone,
    edge: Edge,
}

/// Radiance toward the eye, without and with the edge.
type Radiance = [DVec3; 2];

/// The fractions of `k·g^-i` of the generalised golden ratio: points that fill the cube evenly.
fn point(k: u32) -> [f64; 3] {
    let g = 1.220_744_084_605_759_5_f64;
    [1, 2, 3].map(|i| (0.5 + f64::from(k) * g.powi(-i)).fract())
}

fn truth(material: &Material, case: &Case) -> Radiance {
    let Case { at, cone, edge } = case;
    let (right, up) = orthonormal_basis(cone.axis);
    let (axis, right, up) = (cone.axis.as_dvec3(), right.as_dvec3(), up.as_dvec3());
    let wide = f64::from(cone.one_minus_cos);
    let of_light = 1.0 / (TAU * wide);
    let mut sum = [DVec3::ZERO; 2];
    let mut add = |v: Vec3| {
        let pdf = of_light + f64::from(material.pdf(at, v));
        let value = material.eval(at, v).as_dvec3() / (pdf * f64::from(DRAWN));
        sum[0] += value;
        if v.dot(edge.hidden(cone)) < 0.0 {
            sum[1] += value;
        }
    };
    for k in 0..DRAWN {
        let [a, b, c] = point(k);
        let (off, turn) = (wide * a, TAU * b);
        let sin = (off * (2.0 - off)).sqrt();
        add((axis * (1.0 - off) + (right * turn.cos() + up * turn.sin()) * sin).as_vec3().normalize());
        if let Some(drawn) = material.sample(at, [c, a, b].map(|x| (x as f32).min(0.999_999_9))) {
            // Directions outside the light do not count.
            if 0.5 * (drawn.direction.as_dvec3() - axis).length_squared() < wide {
                add(drawn.direction);
            }
        }
    }
    sum
}

fn by_lobes(material: &Material, case: &Case, accuracy: Accuracy) -> Radiance {
    let strategy = MaskVisibility::new(case.edge);
    let mut lobes = Vec::new();
    let mut scratch = strategy.scratch();
    material.brdf_lobes(&case.at, &mut lobes);
    let light = SeenLight::of_cone(case.cone, Vec3::ONE);
    let call = Interaction { at: &case.at, brdf: &lobes, light: &light, threshold: 0.0 };
    let mut visit = LightVisibility::alone(&strategy, LightId(0), accuracy, &mut scratch);
    let lit = FractionIntegrator.radiance(&call, &mut visit, &mut (), &mut ());
    [lit.unshadowed.as_dvec3(), lit.radiance.as_dvec3()]
}

fn polar(angle: f64, turn: f64) -> DVec3 {
    DVec3::new(angle.sin() * turn.cos(), angle.sin() * turn.sin(), angle.cos())
}

/// Lights where the material mirrors the view, and beside that as far as its highlight reaches.
fn cases(half_angle: f64, width: f64) -> Vec<Case> {
    let mut cases = Vec::new();
    for view in VIEWS.map(f64::to_radians) {
        for k in 0..LIGHTS {
            let [a, b, c] = point(1000 * k + 17);
            let aside = (half_angle + width) * if k == 0 { 0.0 } else { a };
            let (up, beside) = (aside * (TAU * b).cos(), aside * (TAU * b).sin());
            // Lights above the horizon: below it each part of a light is a case of its own.
            let tilt = (view + up).clamp(-1.5, (PI / 2.0 - half_angle).min(1.5));
            let axis = polar(tilt, PI + beside / view.sin().max(0.3));
            let through = polar(half_angle * (1.6 * c - 0.8), TAU * b);
            let hidden = polar(PI / 2.0, TAU * c);
            let (right, up) = orthonormal_basis(axis.as_vec3());
            let frame = |v: DVec3| (right * v.x as f32 + up * v.y as f32 + axis.as_vec3() * v.z as f32).normalize();
            // The plane's normal is across a direction inside the light.
            let through = frame(through);
            let hidden = frame(hidden);
            let hidden = (hidden - through * through.dot(hidden)).normalize();
            let view = polar(view, 0.0).as_vec3();
            let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, view);
            let cone = Cone {
                axis: axis.as_vec3().normalize(),
                one_minus_cos: (2.0 * (0.5 * half_angle).sin().powi(2)) as f32,
                distance: f32::INFINITY,
            };
            cases.push(Case { at, cone, edge: Edge::At(hidden) });
        }
    }
    cases
}

/// Mean, 99th percentile and largest, in per cent.
fn figures(mut errors: Vec<f64>) -> String {
    errors.sort_by(f64::total_cmp);
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    let place = (errors.len() as f64 * 0.99) as usize;
    format!("{:.2} / {:.2}", 100.0 * mean, 100.0 * errors[place.min(errors.len() - 1)])
}

/// Seconds of processor time that this process's threads have taken; of the wall where the system does not say.
fn seconds() -> f64 {
    let of_thread = |entry: std::io::Result<std::fs::DirEntry>| -> Option<f64> {
        let text = std::fs::read_to_string(entry.ok()?.path().join("schedstat")).ok()?;
        Some(1e-9 * text.split_whitespace().next()?.parse::<f64>().ok()?)
    };
    let threads = std::fs::read_dir("/proc/self/task").into_iter().flatten();
    let all = threads.filter_map(of_thread).reduce(|a, b| a + b);
    let wall =
        || std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).map_or(0.0, |wall| wall.as_secs_f64());
    all.unwrap_or_else(|| wall() * rayon::current_num_threads() as f64)
}

/// Nanoseconds of a core for each point of a floor: with nothing between it and the light, and behind an edge.
fn cost(material: &Material) -> [f64; 2] {
    const SIDE: u32 = 128;
    let at = |i: u32| {
        // In tiles of 8 × 8, as pictures list their points.
        let (tile, inside) = (i / 64, i % 64);
        let (x, z) = (tile % (SIDE / 8) * 8 + inside % 8, tile / (SIDE / 8) * 8 + inside / 8);
        let position = Vec3::new(x as f32, 0.0, z as f32) * (4.0 / SIDE as f32) - Vec3::new(2.0, 0.0, 2.0);
        let view = (Vec3::new(0.0, 2.0, 5.0) - position).normalize();
        Receiver::on_surface(position, Vec3::Y, view)
    };
    let count = SIDE * SIDE;
    let points = ShadingPoints {
        receivers: (0..count).map(at).collect(),
        materials: vec![0; count as usize],
        ..ShadingPoints::default()
    };
    let light = SphereLight::new(Sphere { center: Vec3::new(0.5, 3.0, -3.0), radius: 0.4 }, Vec3::ONE).into();
    let lights = [light];
    let frame = Frame::new(std::slice::from_ref(material), &lights, Accuracy::new(0.003));
    let mut out = vec![Vec3::ZERO; count as usize];
    let mut time = |shader: &mut dyn Shade<Material, Light, Error = Infallible>| {
        let mut once = || {
            let before = seconds();
            shader.shade(&points, &frame, &mut out).map_or(f64::NAN, |_| seconds() - before)
        };
        1e9 * (0..9).map(|_| once()).fold(f64::INFINITY, f64::min) / f64::from(count)
    };
    [time(&mut CpuShader::new(Unshadowed)), time(&mut CpuShader::new(MaskVisibility::new(Edge::Middle)))]
}

fn main() {
    let gold = Vec3::new(1.0, 0.77, 0.34);
    let metal = |roughness: f32| MetallicRoughness::new(gold, 1.0, roughness).map(Material::from);
    let plastic = |roughness: f32| MetallicRoughness::new(Vec3::splat(0.5), 0.0, roughness).map(Material::from);
    let phong =
        |exponent: f32| -> Material { ModifiedPhong { kd: Vec3::splat(0.3), ks: Vec3::splat(0.4), exponent }.into() };
    let off_specular = LafortuneLobe::diagonal(Vec3::new(-0.9, -0.9, 0.8), 30.0, Vec3::splat(0.3));
    let mut materials: Vec<(String, Material, f64)> = vec![
        ("Lambert".to_owned(), Lambert { albedo: Vec3::splat(0.8) }.into(), 1.0),
        ("modified Phong, exponent 50".to_owned(), phong(50.0), 0.3),
        ("modified Phong, 1000".to_owned(), phong(1000.0), 0.1),
        (
            "Lafortune, off-specular".to_owned(),
            Lafortune { diffuse: Vec3::splat(0.2), lobes: vec![off_specular] }.into(),
            0.4,
        ),
    ];
    for roughness in [0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0] {
        let width = 3.0 * f64::from(roughness * roughness);
        materials.extend(metal(roughness).ok().map(|m| (format!("gold, roughness {roughness}"), m, width)));
    }
    for roughness in [0.1, 0.3, 0.6] {
        let width = 3.0 * f64::from(roughness * roughness);
        materials.extend(plastic(roughness).ok().map(|m| (format!("plastic, roughness {roughness}"), m, width)));
    }
    for exponent in [20.0, 60.0, 500.0] {
        let metal = Neumann { kd: Vec3::ZERO, ks: gold, exponent };
        materials.push((format!("Neumann, exponent {exponent}"), metal.into(), 2.0 / f64::from(exponent).sqrt()));
    }
    let lobe = |roughness: f32, f0: f32| HalfVectorLobe::new(roughness, Vec3::splat(f0), Vec3::splat(0.5));
    let paint = HalfVector { diffuse: Vec3::splat(0.1), lobes: vec![lobe(0.2, 0.05), lobe(0.5, 0.3)] };
    materials.push(("two half-vector lobes".to_owned(), paint.into(), 0.5));
    let wanted = std::env::args().nth(1).unwrap_or_default();
    if wanted != "costs" {
        materials.retain(|(name, ..)| name.contains(&wanted));
        print_errors(&materials);
    }
    print_costs(&materials);
}

fn print_errors(materials: &[(String, Material, f64)]) {
    println!(
        "# Materials\n\nThe lobes of each material against the material itself: `cargo run --release --example materials`.\n\n\
         Views 0 to 80° from the normal, lights above the horizon where the material mirrors the view and beside that, as far as its \
         highlight reaches. The material's side is Monte Carlo, by {} directions; half of the smallest figures is its noise.\n\n\
         *Unshadowed*: error of the radiance, largest channel, mean / 99th percentile in per cent of itself, or of a hundredth of the \
         brightest. *Behind an edge*: a straight edge hides a part of the light; error in per cent of the unshadowed radiance, at a \
         tolerance. Where the lobes only approximate a material, no tolerance helps: their *residual* is in the table of costs.\n",
        2 * DRAWN
    );
    println!("| material | half-angle | unshadowed | edge at 1 % | at 0.3 % | at 0.1 % |\n|---|---|---|---|---|---|");
    for (name, material, width) in materials {
        for degrees in HALF_ANGLES {
            let cases = cases(degrees.to_radians(), *width);
            let wants: Vec<Radiance> = cases.par_iter().map(|case| truth(material, case)).collect();
            let brightest = wants.iter().map(|want| want[0].max_element()).fold(0.0, f64::max);
            let size = |want: &Radiance| want[0].max(DVec3::splat(0.01 * brightest));
            let errors = |tolerance: f32, part: usize| {
                let pairs = cases.par_iter().zip(&wants);
                let error = pairs.map(|(case, want)| {
                    let got = by_lobes(material, case, Accuracy::new(tolerance));
                    ((got[part] - want[part]).abs() / size(want)).max_element()
                });
                figures(error.collect())
            };
            let edges = TOLERANCES.map(|tolerance| errors(tolerance, 1));
            println!("| {name} | {degrees}° | {} | {} |", errors(0.01, 0), edges.join(" | "));
        }
    }
}

fn print_costs(materials: &[(String, Material, f64)]) {
    println!(
        "\n*Residual*: root mean square of the difference of the lobes from the material over that of the material, views up to 75°. *Cost*: \
         nanoseconds of processor time a point and light, without finding the visible points: unblocked, and behind an edge through the \
         light at a tolerance of 0.3 %.\n\n| material | lobes | residual | lit | behind an edge |\n|---|---|---|---|---|"
    );
    for (name, material, _) in materials {
        let [lit, behind] = cost(material);
        let residual = residual(material);
        let residual = if residual < 1e-3 { "none".to_owned() } else { format!("{:.1} %", 100.0 * residual) };
        println!("| {name} | {} | {residual} | {lit:.0} | {behind:.0} |", material.model().lobe_count());
    }
}
