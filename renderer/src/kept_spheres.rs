use scene::BlockerSet;
use visibility_spheres::SphereBlockers;

/// The spheres of successive frames, under one hierarchy.
#[derive(Clone, Debug, Default)]
pub struct KeptSpheres {
    blockers: Option<SphereBlockers>,
    set: BlockerSet,
}

impl KeptSpheres {
    /// Replaces the spheres by those of the next frame. Keeps the hierarchy if no sphere has moved; refits it if the spheres are
    /// the same ones. Returns whether anything changed.
    pub fn update(&mut self, set: &BlockerSet) -> bool {
        let is_same = (&self.set.spheres, &self.set.objects) == (&set.spheres, &set.objects)
            && (&self.set.self_distances, &self.set.self_shadows) == (&set.self_distances, &set.self_shadows);
        if is_same {
            return false;
        }
        let old = self.blockers.take().filter(|_| self.set.objects == set.objects);
        self.set.clone_from(set);
        self.blockers = (!set.spheres.is_empty()).then(|| {
            let blockers = match old {
                Some(mut blockers) => {
                    blockers.update(&set.spheres);
                    blockers
                }
                None => SphereBlockers::new(&set.spheres, &set.objects, &set.self_distances),
            };
            blockers.with_self_shadows(&set.self_shadows)
        });
        true
    }

    /// The spheres, with the numbers of their objects.
    #[must_use]
    pub const fn set(&self) -> &BlockerSet {
        &self.set
    }

    /// The blockers, if there are any.
    #[must_use]
    pub fn get(&self) -> Option<&SphereBlockers> {
        self.blockers.as_ref()
    }
}
