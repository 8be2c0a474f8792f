use core::ops::ControlFlow;

use glam::{Vec3, Vec4};

use super::cover::greedy_cover;
use super::descent::descend;
use super::error::BuildError;
use super::exchange::{insert, removal_costs};
use super::options::{BuildOptions, Progress};
use super::random::{Random, fibonacci};
use super::solid::Solid;
use super::surface::Surface;
use super::tree::TriangleTree;
use super::view::{View, error};

/// Directions of the descent, over half the sphere: opposite ones have the same silhouette.
const VIEWS: usize = 96;

/// Room around the mesh's silhouette in a view, in units of D: balls do not reach farther out.
const MARGIN: f32 = 0.04;

/// Builds the spheres in unit space.
pub(crate) fn build(
    surface: &Surface,
    tree: &TriangleTree,
    solid: &Solid,
    options: &BuildOptions,
    progress: &mut Progress,
) -> Result<Vec<Vec4>, BuildError> {
    let mut report = |done: f32| match progress(done) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(BuildError::Cancelled),
    };
    report(0.02)?;
    let mut spheres = greedy_cover(solid, options.count);
    report(0.05)?;
    if options.rounds == 0 {
        return Ok(spheres);
    }
    let views = views(&surface.triangles, options.count);
    report(0.15)?;
    let mut random = Random::new(options.seed);
    let places = solid.scatter(tree, 8000, &mut random);
    descend(&views, &mut spheres, 200, [0.004, 0.0006], &mut random);
    let mut best = error(&views, &spheres);
    for round in 0..options.rounds {
        let done = round as f32 / options.rounds as f32;
        report(0.25 + 0.6 * done)?;
        let mut trial = spheres.clone();
        let moved = ((0.15 - 0.11 * done) * options.count as f32).ceil() as usize;
        take_out(&views, &mut trial, moved, &mut random);
        let missing = options.count - trial.len();
        let from = random.below(places.len() / 2 + 1);
        insert(&views, &mut trial, &places[from..from + places.len() / 2], missing, &mut random);
        descend(&views, &mut trial, 120, [0.002, 0.0004], &mut random);
        let found = error(&views, &trial);
        if std::env::var_os("SETS_LOG").is_some() {
            eprintln!("round {round}: {found:.5} against {best:.5}, {} moved, {}", moved, trial.len());
        }
        if found < best {
            (spheres, best) = (trial, found);
        }
    }
    report(0.85)?;
    let mut trial = spheres.clone();
    descend(&views, &mut trial, 300, [0.001, 0.0001], &mut random);
    let found = error(&views, &trial);
    if std::env::var_os("SETS_LOG").is_some() {
        eprintln!("final: {found:.5} against {best:.5}");
    }
    if found < best {
        spheres = trial;
    }
    report(0.95)?;
    Ok(spheres)
}

fn views(triangles: &[[Vec3; 3]], count: usize) -> Vec<View> {
    use rayon::prelude::*;
    let size = match count {
        0..=160 => 192,
        161..=640 => 256,
        _ => 384,
    };
    (0..VIEWS).into_par_iter().map(|i| View::new(fibonacci(i, 2 * VIEWS), triangles, MARGIN, size)).collect()
}

/// Removes about `count` spheres that the silhouettes miss least, no two of them neighbours.
fn take_out(views: &[View], spheres: &mut Vec<Vec4>, count: usize, random: &mut Random) {
    let costs = removal_costs(views, spheres);
    // Blurred costs make the rounds differ.
    let mut order: Vec<(f32, usize)> =
        costs.iter().enumerate().map(|(i, cost)| (cost * (0.6 + 0.8 * random.unit()), i)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut gone: Vec<usize> = Vec::with_capacity(count);
    for (_, i) in order {
        if gone.len() == count || gone.len() + 1 >= spheres.len() {
            break;
        }
        let beside = |j: &usize| {
            let reach = spheres[i].w.max(spheres[*j].w);
            spheres[i].truncate().distance_squared(spheres[*j].truncate()) < reach * reach
        };
        if !gone.iter().any(beside) {
            gone.push(i);
        }
    }
    gone.sort_unstable();
    for i in gone.into_iter().rev() {
        spheres.remove(i);
    }
}
