use crate::block::{Blocks, LANES};
use crate::cone_test::ConeTest;
use crate::shaft_test::ShaftTest;
use crate::sphere_tree::SphereTree;
use crate::splat::BlockedCone;
use fearless_simd::{Level, Simd, dispatch};
use lighting::{Blockers, Edges, Mask};
use lobe_core::{Coverage, SelfShadow, Shaft, Sphere, VisibilityQuery};

/// Spheres that block light, as the `spheres` strategy sees them: wrap it in
/// [`MaskVisibility`](lighting::MaskVisibility).
///
/// # Self-shadowing
/// A sphere set stands for a mesh that lies partly inside, partly outside of it, so a receiver on the mesh is often
/// inside a sphere of its own object. The rule: *a sphere of the receiver's own object blocks a direction only if the
/// ray leaves it farther than τ from the receiver*. The blocked directions are again a cone about the sphere's centre,
/// with `d` the distance of the centre and `k = d² − r²`: the tangent cone if `k > 0` and `τ² ≤ k`, else
/// `cos β = (τ² + k)/(2τd)`, and it is continuous as the receiver moves through the sphere's surface. τ is one length for
/// an object or, better, one for each sphere, together with a smaller radius for the object's own receivers
/// ([`with_self_shadows`](Self::with_self_shadows)): both are fitted to the mesh when a set is built. Spheres of other
/// objects are whole and have τ = 0: what contains the receiver hides everything from it.
///
/// # Order
/// A sphere blocks where it is in front of the light. For a sphere that does not meet the light this is the same for
/// all directions (the one with the smaller power `d² − r²` is in front); where blocker and light intersect it is
/// decided direction by direction.
#[derive(Clone, Debug, Default)]
pub struct SphereBlockers {
    spheres: Vec<Sphere>,
    objects: Vec<u32>,
    self_distances: Vec<f32>,
    /// For each sphere, or empty.
    self_shadows: Vec<SelfShadow>,
    tree: SphereTree,
}

impl SphereBlockers {
    /// Blockers of several objects: `objects[i]` is the object of `spheres[i]`, `self_distances[object]` its τ (0 where
    /// missing). Spheres of radius zero or less, or with anything infinite or NaN, block nothing.
    ///
    /// Orders the spheres for a hierarchy: O(n log n).
    ///
    /// # Panics
    /// When `spheres` and `objects` differ in length.
    #[must_use]
    pub fn new(spheres: &[Sphere], objects: &[u32], self_distances: &[f32]) -> Self {
        assert_eq!(spheres.len(), objects.len(), "each sphere belongs to an object");
        Self {
            spheres: spheres.to_vec(),
            objects: objects.to_vec(),
            self_distances: self_distances.to_vec(),
            self_shadows: Vec::new(),
            tree: SphereTree::new(spheres),
        }
    }

    /// How receivers of its own object see each sphere, instead of the object's τ; nothing changes for none.
    ///
    /// # Panics
    /// When it is not one for each sphere, or none.
    #[must_use]
    pub fn with_self_shadows(mut self, self_shadows: &[SelfShadow]) -> Self {
        assert!(self_shadows.is_empty() || self_shadows.len() == self.spheres.len(), "one for each sphere");
        // A radius above 1 would reach out of what the hierarchy bounds.
        let sound = |s: &SelfShadow| SelfShadow {
            radius: if s.radius >= 0.0 { s.radius.min(1.0) } else { 1.0 },
            distance: s.distance.max(0.0),
        };
        self.self_shadows = self_shadows.iter().map(sound).collect();
        self
    }

    /// Moves the spheres, and makes them larger or smaller, for another pose; their objects stay. What follows is as if
    /// made by [`new`](Self::new), bit for bit.
    ///
    /// The hierarchy is refitted, O(n), or made anew where that pays: when its nodes have grown by half in area since
    /// it was made, or other spheres block than before. `true` says that it was made anew. Working memory made
    /// before keeps its meaning only after the next [`enter`](Blockers::enter).
    ///
    /// # Panics
    /// When there are more or fewer spheres than before.
    pub fn update(&mut self, spheres: &[Sphere]) -> bool {
        self.spheres.copy_from_slice(spheres);
        self.tree.update(spheres)
    }

    /// The spheres, as given.
    #[must_use]
    pub fn spheres(&self) -> &[Sphere] {
        &self.spheres
    }

    /// The object of each.
    pub(crate) fn objects(&self) -> &[u32] {
        &self.objects
    }

    /// Those that can block, neighbours near each other.
    pub(crate) fn order(&self) -> &[u32] {
        self.tree.order()
    }

    /// A sphere as receivers of its own object see it, and its τ.
    pub(crate) fn own(&self, index: usize) -> (Sphere, f32) {
        let sphere = self.spheres[index];
        match self.self_shadows.get(index) {
            Some(s) => (Sphere { radius: sphere.radius * s.radius, ..sphere }, sphere.radius * s.distance),
            None => (sphere, self.self_distances.get(self.objects[index] as usize).copied().unwrap_or(0.0)),
        }
    }

    /// What [`own`](Self::own) is whatever the sphere's radius: factors of the radius for radius and τ, and what τ has
    /// besides.
    pub(crate) fn own_law(&self, index: usize) -> [f32; 3] {
        match self.self_shadows.get(index) {
            Some(s) => [s.radius, s.distance, 0.0],
            None => [1.0, 0.0, self.own(index).1],
        }
    }

    /// Brings the candidates in the order of their numbers, so that a mask does not depend on the hierarchy.
    fn list(&self, scratch: &mut SphereScratch) {
        scratch.candidates.sort_unstable();
        scratch.blocks.clear();
        scratch.candidates.iter().for_each(|i| scratch.blocks.push(&self.spheres[*i as usize]));
    }
}

/// Working memory of [`SphereBlockers`].
#[derive(Clone, Debug, Default)]
pub struct SphereScratch {
    /// Spheres in the current shaft, ascending, and the same again to be tested eight at once.
    candidates: Vec<u32>,
    blocks: Blocks,
    /// One sphere hides the whole light from the whole shaft.
    dark: bool,
    stack: Vec<(u32, u32)>,
    /// What meets the current receiver's light cone.
    hits: Vec<BlockedCone>,
}

#[cfg(test)]
impl SphereScratch {
    pub(crate) fn candidates(&self) -> &[u32] {
        &self.candidates
    }

    pub(crate) fn is_dark(&self) -> bool {
        self.dark
    }

    pub(crate) fn hits(&self) -> &[BlockedCone] {
        &self.hits
    }

    /// How many candidates meet a shaft: one by one.
    pub(crate) fn meets(&self, test: &ShaftTest) -> u32 {
        let blocks = self.blocks.blocks().iter().enumerate();
        blocks.map(|(i, b)| (test.meets(b) & ((1 << self.blocks.lanes(i)) - 1)).count_ones()).sum()
    }
}

#[cfg(test)]
impl SphereBlockers {
    /// `select` without any culling: the same exact question to every sphere.
    pub(crate) fn select_flat(&self, query: &VisibilityQuery<'_>) -> (Coverage, Vec<BlockedCone>) {
        let light = LightBall::new(query);
        let mut solid = self.tree.order().to_vec();
        solid.sort_unstable();
        let seen: Vec<_> = solid.iter().filter_map(|i| self.look(*i as usize, query, &light)).collect();
        if seen.iter().any(|s| s.1 == Coverage::Dark) {
            return (Coverage::Dark, Vec::new());
        }
        let coverage = if seen.is_empty() { Coverage::Lit } else { Coverage::Partial };
        (coverage, seen.into_iter().map(|s| s.0).collect())
    }
}

impl Blockers for SphereBlockers {
    type Scratch = SphereScratch;

    fn scratch(&self) -> SphereScratch {
        let mut scratch = SphereScratch { candidates: self.tree.order().to_vec(), ..SphereScratch::default() };
        self.list(&mut scratch);
        scratch
    }

    fn enter(&self, shaft: &Shaft, scratch: &mut SphereScratch) -> Coverage {
        let test = ShaftTest::new(shaft);
        scratch.candidates.clear();
        self.tree.find(&test, &mut scratch.stack, &mut scratch.candidates);
        self.list(scratch);
        scratch.dark = scratch.candidates.iter().any(|i| {
            // Whose receivers they are is not known: what the smaller sphere hides, the whole one hides too.
            let (sphere, tau) = self.own(*i as usize);
            test.darkens(&sphere, tau)
        });
        if scratch.candidates.is_empty() { Coverage::Lit } else { Coverage::Partial }
    }

    fn select(&self, query: &VisibilityQuery<'_>, scratch: &mut SphereScratch) -> Coverage {
        scratch.hits.clear();
        if scratch.dark {
            return Coverage::Dark;
        }
        dispatch!(Level::new(), simd => self.select_all(simd, query, scratch))
    }

    /// The spheres' rims.
    fn edges(&self, query: &VisibilityQuery<'_>, scratch: &SphereScratch, edges: &mut Edges) {
        let tan = query.cone.tan();
        for blocked in &scratch.hits {
            blocked.add_edge(query.cone.axis, tan, edges);
        }
    }

    fn splat(&self, _: &VisibilityQuery<'_>, scratch: &mut SphereScratch, mask: &mut Mask) {
        dispatch!(Level::new(), simd => splat_all(simd, &scratch.hits, mask));
    }
}

/// Splats until nothing is lit any more.
#[inline(always)]
pub(crate) fn splat_all<S: Simd>(simd: S, hits: &[BlockedCone], mask: &mut Mask) {
    for (number, blocked) in hits.iter().enumerate() {
        if number % LANES == LANES - 1 && mask.is_dark() {
            return;
        }
        match blocked.meets_light {
            None => blocked.splat(simd, mask),
            Some((center, radius)) => blocked.splat_in_front(center, radius, mask),
        }
    }
}

/// The light of a query as a ball.
struct LightBall {
    sin: f32,
    cos: f32,
    radius: f32,
    /// Power of the receiver with respect to it.
    power: f32,
}

impl LightBall {
    fn new(query: &VisibilityQuery<'_>) -> Self {
        let cone = query.cone;
        let (sin, cos) = (cone.sin_sq().sqrt(), cone.cos());
        Self { sin, cos, radius: cone.distance * sin, power: cone.distance * cone.distance * (cos * cos) }
    }
}

impl SphereBlockers {
    #[inline(always)]
    fn select_all<S: Simd>(&self, simd: S, query: &VisibilityQuery<'_>, scratch: &mut SphereScratch) -> Coverage {
        let light = LightBall::new(query);
        let test = ConeTest::new(query);
        for (number, block) in scratch.blocks.blocks().iter().enumerate() {
            let mut maybe = test.meets(simd, block) & ((1 << scratch.blocks.lanes(number)) - 1);
            while maybe != 0 {
                let index = scratch.candidates[number * LANES + maybe.trailing_zeros() as usize] as usize;
                maybe &= maybe - 1;
                match self.look(index, query, &light) {
                    Some((_, Coverage::Dark)) => return Coverage::Dark,
                    Some((blocked, Coverage::Partial)) => scratch.hits.push(blocked),
                    _ => {}
                }
            }
        }
        if scratch.hits.is_empty() { Coverage::Lit } else { Coverage::Partial }
    }

    /// What one sphere hides of a light; `None` when nothing.
    #[inline(always)]
    fn look(&self, index: usize, query: &VisibilityQuery<'_>, light: &LightBall) -> Option<(BlockedCone, Coverage)> {
        let cone = query.cone;
        let own = self.objects[index] == query.at.object;
        let (sphere, tau) = if own { self.own(index) } else { (self.spheres[index], 0.0) };
        let to = sphere.center - query.at.position;
        let mut blocked = BlockedCone::new(to, sphere.radius, tau)?;
        if cone.distance.is_finite() {
            let apart = (to - cone.axis * cone.distance).length();
            if apart >= sphere.radius + light.radius {
                if to.length_squared() - sphere.radius * sphere.radius >= light.power {
                    return None;
                }
            } else {
                blocked.meets_light = Some((cone.axis * cone.distance, light.radius));
            }
        }
        let coverage = blocked.cover(cone.axis, light.sin, light.cos);
        (coverage != Coverage::Lit).then_some((blocked, coverage))
    }
}
