//! Brings everything that edits and time have made stale up to date.

use crate::bands::seconds;
use crate::event::check;
use crate::sphere_cache::{Scope, follow_spheres};
use crate::{Device, FrameClocks, Listener, Method, Plan, RenderError, Renderer, Stale, paper_tables};
use core::ops::ControlFlow;
use glam::Vec3;
use render_cpu::{Hierarchy, Looks, Update, World};
use scene::{Bounds, Object, Scene, Shape};
use std::sync::Arc;

impl Renderer {
    /// Computes spheres and tables, unless they are there. Pictures do so themselves.
    ///
    /// # Errors
    /// [`RenderError`].
    pub fn prepare(&mut self, listener: &mut Listener<'_>) -> Result<(), RenderError> {
        let cancel = self.cancel.clone();
        check(&cancel)?;
        let listener: &mut Listener<'_> = &mut |event| match cancel.is_cancelled() {
            true => ControlFlow::Break(()),
            false => listener(event),
        };
        self.follow_plan();
        if self.stale.has(Stale::SETS) {
            // Sets are fitted to objects at their initial places.
            self.rows.swap_rest(&mut self.scene);
            if self.time != 0.0 {
                self.animation.seek(0.0, &mut self.scene);
            }
            let (animation, plan, cache) = (&self.animation, &self.plan, self.settings.cache.as_deref());
            let scope = Scope { animation, plan, cache, revisions: self.rows.revisions() };
            let (sets, scene) = (&mut self.sets, &mut self.scene);
            let made = seconds(&mut self.clocks.spheres, || follow_spheres(sets, scene, &scope, listener));
            if self.time != 0.0 {
                self.animation.seek(self.time, &mut self.scene);
            }
            self.rows.swap_rest(&mut self.scene);
            self.rows.follow_proxies(&mut self.scene);
            self.upkeep.sphere_sets += made? as u64;
            self.stale = self.stale.without(Stale::SETS);
        }
        if self.settings.method == Method::Paper && self.tables.is_none() {
            let cache = self.settings.cache.as_deref();
            self.tables = Some(seconds(&mut self.clocks.tables, || paper_tables(cache, listener))?);
        }
        Ok(())
    }

    /// Lets floors block that such points of the caller's are behind.
    pub(crate) fn lights_points(&mut self, points: &[Vec3]) {
        let known = self.points;
        self.points = points.iter().fold(known, |bounds, p| Some(bounds.unwrap_or(Bounds::EMPTY).with_point(*p)));
        if self.points != known {
            self.plan_again();
        }
    }

    /// Fits lights to the scene, and updates the plan: strategies may have changed, and things that move go behind floors and come from
    /// there.
    fn follow_plan(&mut self) {
        if !self.stale.has(Stale::PLAN | Stale::HIERARCHY | Stale::LIGHTS) {
            return;
        }
        if self.scene.fit_lights() {
            self.mark(Stale::LIGHTS | Stale::MAPS);
        }
        self.plan_again();
        self.stale = self.stale.without(Stale::PLAN);
    }

    /// Makes the plan, and marks what followed another one.
    fn plan_again(&mut self) {
        let plan = Plan::with_points(self.settings.strategy, &self.scene, self.points);
        let is_new = core::mem::replace(&mut self.plan, plan) != self.plan;
        if is_new || self.stale.has(Stale::PLAN) {
            [&mut self.kept, &mut self.reduced].into_iter().for_each(|kept| kept.maps.clear());
            self.mark(Stale::SHADING | Stale::SPHERES | Stale::SILHOUETTES);
        }
    }

    /// The [exposure](crate::exposure) of the scene at the first moment of its animation, whatever the present time: the same for
    /// all frames.
    pub fn exposure(&mut self) -> f32 {
        let time = self.time;
        self.seek(0.0);
        let mut built = core::mem::take(&mut self.built);
        let hierarchy = seconds(&mut built, || self.follow_hierarchy());
        self.built = built;
        let stops = crate::exposure(&World::with_hierarchy(&self.scene, hierarchy));
        self.seek(time);
        stops
    }

    /// Runs a query against the scene at the present time.
    pub fn with_world<R>(&mut self, ask: impl FnOnce(&World<'_>) -> R) -> R {
        let hierarchy = self.follow_hierarchy();
        ask(&World::with_hierarchy(&self.scene, hierarchy))
    }

    /// The hierarchy at the present time. The plan follows what it does: things that move go behind floors and come from there.
    pub(crate) fn follow_hierarchy(&mut self) -> Arc<Hierarchy> {
        self.follow_plan();
        let done = update_hierarchy(&mut self.hierarchy, &self.scene, self.stale);
        self.has_followed(done)
    }

    /// Drops all that a change of the hierarchy makes stale. Returns the hierarchy.
    fn has_followed(&mut self, done: Update) -> Arc<Hierarchy> {
        self.upkeep.hierarchy_builds += u64::from(done == Update::Built);
        self.upkeep.hierarchy_refits += u64::from(done == Update::Refitted);
        if done != Update::Kept {
            [&mut self.kept, &mut self.reduced].into_iter().for_each(|kept| kept.maps.clear());
        }
        if done != Update::Kept || self.stale.has(Stale::POINTS) {
            [&mut self.kept, &mut self.reduced].into_iter().for_each(|kept| kept.points.clear());
        }
        self.stale = self.stale.without(Stale::HIERARCHY | Stale::SURFACES | Stale::POINTS);
        let scene = &self.scene;
        Arc::clone(self.hierarchy.get_or_insert_with(|| Arc::new(Hierarchy::new(scene))))
    }

    /// Updates spheres, silhouettes and hierarchy to the present time, after [`prepare`](Self::prepare).
    pub(crate) fn follow(&mut self, clocks: &mut FrameClocks) -> Result<Arc<Hierarchy>, RenderError> {
        // A change of lights or size may make simplified forms worth their time, or no longer.
        let looks = match self.settings.keep_points || !self.animation.is_still() || self.points.is_some() {
            true => Looks::MANY,
            false => crate::looks::of_picture(&self.scene),
        };
        let are_copied = self.backend.device() == Device::Gpu && can_copy_instances(&self.scene);
        let is_other = looks != self.silhouettes.looks() || are_copied != self.silhouettes.are_copied();
        let wants_silhouettes = is_other || self.stale.has(Stale::SILHOUETTES);
        self.silhouettes.copy_instances(are_copied);
        if wants_silhouettes {
            self.custom.update(&self.scene, &self.plan)?;
        }
        let (scene, plan, revisions, cancel) = (&self.scene, &self.plan, self.rows.revisions(), &self.cancel);
        let (hierarchy, silhouettes, stale) = (&mut self.hierarchy, &mut self.silhouettes, self.stale);
        let FrameClocks { hierarchy: hierarchy_clock, silhouettes: silhouettes_clock, .. } = clocks;
        let mut hierarchy = || seconds(hierarchy_clock, || update_hierarchy(hierarchy, scene, stale));
        let silhouettes =
            || seconds(silhouettes_clock, || plan.follow_silhouettes(scene, (revisions, looks), silhouettes, cancel));
        // Neither needs the other, and each has parts for one thread.
        let (done, [made, refitted]) = match wants_silhouettes {
            true => rayon::join(hierarchy, silhouettes),
            false => (hierarchy(), [0; 2]),
        };
        self.upkeep.silhouette_builds += made as u64;
        self.upkeep.silhouette_refits += refitted as u64;
        let hierarchy = self.has_followed(done);
        check(&self.cancel)?;
        let (scene, revisions) = (&self.scene, self.rows.revisions());
        if self.stale.has(Stale::SPHERES | Stale::LIGHTS) {
            seconds(&mut clocks.spheres, || {
                self.sets.place(scene, revisions);
                self.sets.pose(scene, Some((&self.animation, self.time)), &mut self.set)?;
                self.upkeep.sphere_updates += u64::from(self.spheres.update(&self.set));
                Ok::<(), RenderError>(())
            })?;
        }
        check(&self.cancel)?;
        self.stale = Stale::NOTHING;
        Ok(hierarchy)
    }
}

/// The most triangles of instances that a GPU gets as copies, 100 bytes each, for their silhouettes. Rays stand for more.
const MOST_COPIED: usize = 2_000_000;

/// Whether instances can be copied for a GPU.
fn can_copy_instances(scene: &Scene) -> bool {
    let count = |object: &Object| match &object.shape {
        Shape::Instances(all) => all.triangle_count(),
        Shape::Mesh(_) | Shape::Spheres(_) => 0,
    };
    scene.objects.iter().map(count).sum::<usize>() <= MOST_COPIED
}

/// Updates a hierarchy to a scene where things of it are stale.
fn update_hierarchy(hierarchy: &mut Option<Arc<Hierarchy>>, scene: &Scene, stale: Stale) -> Update {
    let Some(kept) = hierarchy.as_mut().and_then(Arc::get_mut) else {
        *hierarchy = Some(Arc::new(Hierarchy::new(scene)));
        return Update::Built;
    };
    if stale.has(Stale::HIERARCHY) {
        return kept.update(scene);
    }
    if stale.has(Stale::LIGHTS) {
        kept.update_lights(scene);
    }
    if stale.has(Stale::SURFACES) {
        kept.update_surfaces(scene);
    }
    Update::Kept
}
