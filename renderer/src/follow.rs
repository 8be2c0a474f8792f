//! Brings everything that edits and time have made stale up to date.

use crate::bands::seconds;
use crate::event::check;
use crate::sphere_cache::{Scope, follow_spheres};
use crate::{FrameClocks, Listener, Method, Plan, RenderError, Renderer, Stale, paper_tables};
use core::ops::ControlFlow;
use glam::Vec3;
use render_cpu::{Hierarchy, Looks, Update, World};
use scene::Bounds;
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

    /// Updates the plan: strategies may have changed, and things that move go behind floors and come from there.
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

    /// The hierarchy at the present time.
    pub(crate) fn follow_hierarchy(&mut self) -> Arc<Hierarchy> {
        if self.stale.has(Stale::HIERARCHY | Stale::LIGHTS) && self.scene.fit_lights() {
            self.mark(Stale::LIGHTS | Stale::MAPS);
        }
        let scene = &self.scene;
        let mut done = Update::Kept;
        match self.hierarchy.as_mut().and_then(Arc::get_mut) {
            Some(kept) => {
                if self.stale.has(Stale::HIERARCHY) {
                    done = kept.update(scene);
                } else {
                    if self.stale.has(Stale::LIGHTS) {
                        kept.update_lights(scene);
                    }
                    if self.stale.has(Stale::SURFACES) {
                        kept.update_surfaces(scene);
                    }
                }
            }
            None => {
                self.hierarchy = Some(Arc::new(Hierarchy::new(scene)));
                done = Update::Built;
            }
        }
        self.upkeep.hierarchy_builds += u64::from(done == Update::Built);
        self.upkeep.hierarchy_refits += u64::from(done == Update::Refitted);
        if done != Update::Kept {
            [&mut self.kept, &mut self.reduced].into_iter().for_each(|kept| kept.maps.clear());
        }
        if done != Update::Kept || self.stale.has(Stale::POINTS) {
            [&mut self.kept, &mut self.reduced].into_iter().for_each(|kept| kept.points.clear());
        }
        self.stale = self.stale.without(Stale::HIERARCHY | Stale::SURFACES | Stale::POINTS);
        Arc::clone(self.hierarchy.get_or_insert_with(|| Arc::new(Hierarchy::new(scene))))
    }

    /// Updates spheres, silhouettes and hierarchy to the present time.
    pub(crate) fn follow(&mut self, clocks: &mut FrameClocks) -> Result<Arc<Hierarchy>, RenderError> {
        let hierarchy = seconds(&mut clocks.hierarchy, || self.follow_hierarchy());
        check(&self.cancel)?;
        let (scene, plan, revisions) = (&self.scene, &self.plan, self.rows.revisions());
        if self.stale.has(Stale::SPHERES | Stale::LIGHTS) {
            seconds(&mut clocks.spheres, || {
                self.sets.place(scene, revisions);
                self.sets.pose(scene, Some((&self.animation, self.time)), &mut self.set)?;
                self.upkeep.sphere_updates += u64::from(self.spheres.update(&self.set));
                Ok::<(), RenderError>(())
            })?;
        }
        check(&self.cancel)?;
        // A change of lights or size may make simplified forms worth their time, or no longer.
        let looks = match self.settings.keep_points || !self.animation.is_still() || self.points.is_some() {
            true => Looks::MANY,
            false => crate::looks::of_picture(scene),
        };
        if self.stale.has(Stale::SILHOUETTES) || looks != self.silhouettes.looks() {
            self.custom.update(scene, plan)?;
            let (kept, cancel) = (&mut self.silhouettes, &self.cancel);
            let [made, refitted] =
                seconds(&mut clocks.silhouettes, || plan.follow_silhouettes(scene, (revisions, looks), kept, cancel));
            self.upkeep.silhouette_builds += made as u64;
            self.upkeep.silhouette_refits += refitted as u64;
        }
        check(&self.cancel)?;
        self.stale = Stale::NOTHING;
        Ok(hierarchy)
    }
}
