use glam::Vec3;
use lobe_core::Sphere;

/// How many spheres are tested at once.
pub(crate) const LANES: usize = 8;

/// Eight spheres side by side: loops over the lanes become vector instructions.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Block {
    pub(crate) x: [f32; LANES],
    pub(crate) y: [f32; LANES],
    pub(crate) z: [f32; LANES],
    pub(crate) radius: [f32; LANES],
}

impl Block {
    fn set(&mut self, lane: usize, sphere: &Sphere) {
        [self.x[lane], self.y[lane], self.z[lane]] = sphere.center.to_array();
        self.radius[lane] = sphere.radius;
    }

    fn sphere(&self, lane: usize) -> Sphere {
        Sphere { center: Vec3::new(self.x[lane], self.y[lane], self.z[lane]), radius: self.radius[lane] }
    }

    /// A sphere around the first `count` spheres: about the middle of their box.
    pub(crate) fn bounds(&self, count: usize) -> Sphere {
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for lane in 0..count {
            let sphere = self.sphere(lane);
            low = low.min(sphere.center - sphere.radius);
            high = high.max(sphere.center + sphere.radius);
        }
        let center = 0.5 * low + 0.5 * high;
        if !center.is_finite() {
            return Sphere { center: Vec3::ZERO, radius: f32::INFINITY };
        }
        let reach = |lane| {
            let sphere = self.sphere(lane);
            center.distance(sphere.center) + sphere.radius
        };
        // Rounding of the distances is relative to them: the centre is exact by definition.
        Sphere { center, radius: 1.000_001 * (0..count).map(reach).fold(0.0, f32::max) }
    }
}

/// Spheres in blocks of eight, the last one filled up with empty lanes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Blocks {
    blocks: Vec<Block>,
    len: usize,
}

impl Blocks {
    pub(crate) fn push(&mut self, sphere: &Sphere) {
        let lane = self.len % LANES;
        if lane == 0 {
            self.blocks.push(Block::default());
        }
        if let Some(block) = self.blocks.last_mut() {
            block.set(lane, sphere);
        }
        self.len += 1;
    }

    pub(crate) fn set(&mut self, slot: usize, sphere: &Sphere) {
        self.blocks[slot / LANES].set(slot % LANES, sphere);
    }

    pub(crate) fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// How many lanes of a block hold a sphere.
    pub(crate) fn lanes(&self, block: usize) -> usize {
        (self.len - block * LANES).min(LANES)
    }
}

/// `1/(2τ)`, finite.
pub(crate) fn half_of(tau: f32) -> f32 {
    (0.5 / tau).min(f32::MAX)
}

/// The lanes for which `flags` is set, as bits.
pub(crate) fn bits(flags: [bool; LANES]) -> u32 {
    flags.iter().enumerate().fold(0, |bits, (lane, flag)| bits | u32::from(*flag) << lane)
}

/// Eight spheres that may hide something from the receivers of a group, as all receivers see them and as those of their own
/// object do.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Candidates {
    pub(crate) spheres: Block,
    pub(crate) object: [u32; LANES],
    /// From the sphere's centre to that of its near sphere, and that sphere's radius.
    pub(crate) offset: [[f32; LANES]; 3],
    pub(crate) own_radius: [f32; LANES],
    pub(crate) tau: [f32; LANES],
    /// `1/(2τ)`, finite.
    pub(crate) half_of_tau: [f32; LANES],
}

impl Candidates {
    pub(crate) fn set(&mut self, lane: usize, sphere: &Sphere, object: u32, near: &Sphere, tau: f32) {
        self.spheres.set(lane, sphere);
        self.object[lane] = object;
        [self.offset[0][lane], self.offset[1][lane], self.offset[2][lane]] = near.center.to_array();
        self.own_radius[lane] = near.radius;
        self.tau[lane] = tau;
        self.half_of_tau[lane] = half_of(tau);
    }
}
