use scene::BlockerSet;
use visibility_spheres::SphereBlockers;

/// The spheres of the frames that follow each other, under one hierarchy.
#[derive(Clone, Debug, Default)]
pub struct KeptSpheres {
    blockers: Option<SphereBlockers>,
    objects: Vec<u32>,
}

impl KeptSpheres {
    /// Takes over the spheres of the next frame. The hierarchy is refitted as long as they are the same ones.
    pub fn update(&mut self, set: &BlockerSet) {
        let old = self.blockers.take().filter(|_| self.objects == set.objects);
        self.objects.clone_from(&set.objects);
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
    }

    /// What blocks, where there is anything.
    #[must_use]
    pub fn get(&self) -> Option<&SphereBlockers> {
        self.blockers.as_ref()
    }
}
