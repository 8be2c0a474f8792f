//! Blocker spheres for the tests of this crate.

use scene::{BlockerSet, Proxy, Scene};

/// Blockers of the scene's proxies that are spheres; receivers on them leave them within the distance.
pub(crate) fn blockers(scene: &Scene, self_distance: f32) -> BlockerSet {
    let mut set = BlockerSet { self_distances: vec![self_distance; scene.objects.len()], ..BlockerSet::default() };
    for (i, object) in scene.objects.iter().enumerate() {
        if let Proxy::Spheres(spheres) = &object.proxy {
            set.spheres.extend(spheres);
            set.objects.resize(set.spheres.len(), i as u32);
        }
    }
    set
}
