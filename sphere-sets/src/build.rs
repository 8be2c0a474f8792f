use core::ops::ControlFlow;

use glam::{Vec3, Vec4};

use crate::bounding::bound;
use crate::cover::greedy_cover;
use crate::descent::descend;
use crate::error::BuildError;
use crate::goal::Goal;
use crate::options::{BuildOptions, Progress};
use crate::random::{Random, fibonacci, quasi_random};
use crate::solid::Solid;
use crate::surface::Surface;
use crate::swap::{insert, take_any, take_out};
use crate::tree::TriangleTree;
use crate::view::View;

/// Directions of the descent, over half the sphere: opposite ones have the same silhouette.
const VIEWS: usize = 96;

/// Places that each round chooses among.
const PLACES: usize = 4000;

/// Steps of the descent after an exchange and the length of the first. Few spheres have farther to go, and are cheap; on the
/// bunny 32 of them err by 0.0230 instead of 0.0243 in shadows with the longer steps (mean of four seeds), 16 by more.
const fn swap_descent(count: usize) -> (usize, f32) {
    match count {
        0..=23 => (120, 0.002),
        24..=48 => (120, 0.004),
        _ => (60, 0.002),
    }
}

/// Rounds after which a few spheres only fall back into the same places, so that chance takes some out; more are not
/// settled by then. With 16 spheres nearly all exchanges after the first ten end where they began.
const fn cycle(count: usize) -> u32 {
    match count {
        0..=23 => 10,
        24..=48 => 12,
        _ => u32::MAX,
    }
}

/// Exchanges that show whether more of them pay.
const WINDOW: usize = 4;

/// Points that look for an inside, and how many must find it: a sheet's own points may by rounding.
const INSIDE_POINTS: usize = 1 << 14;
const INSIDE_LEAST: usize = 8;

/// Room around the mesh's silhouette in a view, in units of D: spheres do not reach farther out.
const MARGIN: f32 = 0.04;

/// A mesh as the builder sees it, for any number of spheres.
pub(crate) struct Builder<'a> {
    surface: &'a Surface,
    tree: &'a TriangleTree,
    solid: Solid,
    /// Directions and their pixels a side; none until something descends.
    views: (Vec<View>, usize),
}

impl<'a> Builder<'a> {
    pub(crate) fn new(surface: &'a Surface, tree: &'a TriangleTree, count: usize) -> Self {
        Self { surface, tree, solid: Solid::new(surface, tree, Solid::resolution_for(count)), views: (Vec::new(), 0) }
    }

    pub(crate) const fn solid(&self) -> &Solid {
        &self.solid
    }

    /// Builds the spheres in unit space.
    pub(crate) fn build(&mut self, options: &BuildOptions, progress: &mut Progress) -> Result<Vec<Vec4>, BuildError> {
        if !options.bounding {
            return self.shadow(options, progress);
        }
        if !self.has_inside() {
            return Err(BuildError::NoInside);
        }
        let mut spheres = self.shadow(options, &mut |done| progress(0.6 * done))?;
        let mut random = Random::new(options.seed);
        bound(self.surface, &self.solid, &mut spheres, &mut random, &mut |done| progress(0.6 + 0.35 * done))?;
        Ok(spheres)
    }

    /// Whether the mesh encloses any volume, tested by points in its box.
    fn has_inside(&self) -> bool {
        let [lo, hi] = self.surface.unit_bounds();
        let inside = |i: &usize| self.tree.contains(lo + quasi_random(*i) * (hi - lo));
        (0..INSIDE_POINTS).filter(inside).nth(INSIDE_LEAST - 1).is_some()
    }

    /// The spheres with the mesh's silhouette.
    fn shadow(&mut self, options: &BuildOptions, progress: &mut Progress) -> Result<Vec<Vec4>, BuildError> {
        let mut report = |done: f32| match progress(done) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(BuildError::Cancelled),
        };
        report(0.02)?;
        if self.solid.resolution() != Solid::resolution_for(options.count) {
            self.solid = Solid::new(self.surface, self.tree, Solid::resolution_for(options.count));
        }
        let mut spheres = greedy_cover(&self.solid, options.count);
        report(0.05)?;
        if options.rounds == 0 {
            return Ok(spheres);
        }
        let size = pixels_for(options.count);
        if self.views.1 != size {
            self.views = (views(&self.surface.triangles, size), size);
        }
        report(0.15)?;
        let mut random = Random::new(options.seed);
        let places = self.solid.scatter(self.tree, 2 * PLACES, &mut random);
        let mut goal = Goal::new(&self.views.0, &self.solid, options.count);
        if options.bounding {
            // Spheres that must hold the surface start better from outlines alone.
            (goal.soft, goal.bulge) = (0.0, 0.0);
        }
        // Few rounds are requested where time matters: 200 and 300 steps with 40.
        let effort = options.rounds.min(40) as usize;
        let rates = |first, last| rates(options.count, first, last);
        descend(&goal, &mut spheres, 80 + 3 * effort, rates(0.004, 0.0006), &mut random, &mut || report(0.15))?;
        let mut search = Search::new(&goal, &places, options, spheres, random);
        for round in 0..options.rounds {
            let done = 0.2 + 0.65 * round as f32 / options.rounds as f32;
            report(done)?;
            if !search.pays() {
                break;
            }
            search.exchange(round, &mut || report(done))?;
        }
        report(0.85)?;
        let Search { best: mut spheres, error, mut random, .. } = search;
        let mut trial = spheres.clone();
        descend(&goal, &mut trial, 60 + 6 * effort, rates(0.001, 0.0001), &mut random, &mut || report(0.85))?;
        if goal.error(&trial) < error {
            spheres = trial;
        }
        report(0.95)?;
        Ok(spheres)
    }
}

/// The lengths of the first and the last step of a descent. Smaller spheres want smaller steps: with 512, steps of the size that is right for
/// 64 double the error.
fn rates(count: usize, first: f32, last: f32) -> [f32; 2] {
    let scale = (64.0 / count as f32).min(1.0);
    [first * scale, last * scale]
}

/// Rounds of exchanges: some spheres are taken out, as many put in elsewhere, and all descend.
struct Search<'a> {
    goal: &'a Goal<'a>,
    /// Places for spheres that are put in.
    places: &'a [Vec4],
    options: &'a BuildOptions,
    best: Vec<Vec4>,
    error: f32,
    /// The error after each round, beginning with that before the first.
    history: Vec<f32>,
    /// The start of the next exchanges, and its error. It may be worse than the best for a while after random removals.
    walk: (Vec<Vec4>, f32),
    random: Random,
}

impl<'a> Search<'a> {
    fn new(
        goal: &'a Goal<'a>,
        places: &'a [Vec4],
        options: &'a BuildOptions,
        spheres: Vec<Vec4>,
        random: Random,
    ) -> Self {
        let error = goal.error(&spheres);
        let walk = (spheres.clone(), error);
        Self { goal, places, options, best: spheres, error, history: vec![error], walk, random }
    }

    /// Whether another round pays. A box is soon as good as it gets: exchanges that bring little are not gone on with.
    fn pays(&self) -> bool {
        let Self { history, error, .. } = self;
        let pays = |since: usize, gain: f32| history.len() <= since + 2 || *error < (1.0 - gain) * history[since];
        pays(history.len().saturating_sub(WINDOW + 1), 0.02) || pays(0, 0.15)
    }

    /// One round.
    fn exchange(
        &mut self,
        round: u32,
        before_each: &mut dyn FnMut() -> Result<(), BuildError>,
    ) -> Result<(), BuildError> {
        let Self { goal, places, random, .. } = self;
        let (views, count) = (goal.views, self.options.count);
        let cycle = cycle(count).min(self.options.rounds);
        let left = 1.0 - (round % cycle) as f32 / cycle as f32;
        let by_chance = round > 0 && round.is_multiple_of(cycle);
        let mut trial = if by_chance { self.best.clone() } else { self.walk.0.clone() };
        if by_chance {
            take_any(&mut trial, (1.5 * (count as f32).sqrt()) as usize, random);
        } else {
            let moved = ((0.04 + 0.11 * left) * count as f32 + 2.0 * left).ceil() as usize;
            take_out(views, &mut trial, moved, random);
        }
        let missing = count - trial.len();
        let from = random.below(places.len() - PLACES.min(places.len()) + 1);
        let some = &places[from..(from + PLACES).min(places.len())];
        insert(views, &mut trial, some, missing, random);
        let (steps, rate) = swap_descent(count);
        descend(goal, &mut trial, steps, rates(count, rate, 0.0004), random, before_each)?;
        let found = goal.error(&trial);
        if found < self.error {
            self.error = found;
            self.best.clone_from(&trial);
        }
        if by_chance || found < self.walk.1 {
            self.walk = (trial, found);
        }
        self.history.push(self.error);
        Ok(())
    }
}

const fn pixels_for(count: usize) -> usize {
    match count {
        0..=160 => 192,
        161..=640 => 256,
        _ => 384,
    }
}

fn views(triangles: &[[Vec3; 3]], size: usize) -> Vec<View> {
    use rayon::prelude::*;
    let mut views: Vec<View> =
        (0..VIEWS).into_par_iter().map(|i| View::new(fibonacci(i, 2 * VIEWS), triangles, MARGIN, size)).collect();
    View::limit_weights(&mut views, 0.3);
    views
}
