use glam::Vec3;

/// The most rays that are traced.
pub(super) const WITNESSES: usize = 3;

/// Directions to send rays in.
#[derive(Clone, Copy, Debug, Default)]
pub struct Witnesses {
    directions: [Vec3; WITNESSES],
    len: usize,
}

impl Witnesses {
    pub(super) fn push(&mut self, direction: Vec3) {
        self.directions[self.len] = direction;
        self.len += 1;
    }

    /// The directions, the best first.
    #[must_use]
    pub fn as_slice(&self) -> &[Vec3] {
        &self.directions[..self.len]
    }
}
