use crate::ShadingPoints;
use lobe_core::compact_runs;

/// Points that follow each other in a list and are culled together, by all shaders: an 8 × 8 pixel tile of a picture.
pub const GROUP: usize = 64;

impl ShadingPoints {
    /// Reorders points that are in no order, such as the vertices of a mesh, so that neighbours in the list are
    /// neighbours in space: each aligned run of 64, 512, 4096 … of them is compact
    /// ([`compact_runs`]). Shading gives the same radiance. Masks cost several times less where many blockers are.
    ///
    /// Returns the old number of each point: point `i` of the new list was `order[i]` in the old one. An order stays good
    /// while the points move with a surface, so one is enough for an animation:
    /// [`reorder`](Self::reorder) applies it again.
    ///
    /// # Cost
    /// O(n log n), some 100 ns a point.
    ///
    /// # Panics
    /// When there are not as many materials as receivers.
    ///
    /// ```
    /// use glam::Vec3;
    /// use lobe_core::{Receiver};
    /// use scene::ShadingPoints;
    /// let at = |k: u32| {
    ///     let position = Vec3::X * (k * 37 % 100) as f32; // here and there
    ///     Receiver::on_surface(position, Vec3::Y, Vec3::Y)
    /// };
    /// let mut points = ShadingPoints { receivers: (0..100).map(at).collect(), materials: vec![0; 100] };
    /// let order = points.make_coherent();
    /// assert!(points.receivers[..64].iter().all(|at| at.position.x < 64.0));
    /// let mut colours = vec![0.0; 100]; // in the old order again
    /// for (new, old) in order.iter().enumerate() {
    ///     colours[*old as usize] = points.receivers[new].position.x;
    /// }
    /// assert_eq!(colours[1], 37.0);
    /// ```
    pub fn make_coherent(&mut self) -> Vec<u32> {
        assert_eq!(self.receivers.len(), self.materials.len(), "one material a receiver");
        let mut items: Vec<_> = self.receivers.iter().zip(0..).map(|(at, i)| (at.position, i)).collect();
        compact_runs(&mut items, GROUP);
        let order: Vec<u32> = items.into_iter().map(|item| item.1).collect();
        self.reorder(&order);
        order
    }

    /// Applies an order that [`make_coherent`](Self::make_coherent) gave to another list of the same points.
    ///
    /// # Panics
    /// When the order is of more points than there are.
    pub fn reorder(&mut self, order: &[u32]) {
        self.receivers = order.iter().map(|i| self.receivers[*i as usize]).collect();
        self.materials = order.iter().map(|i| self.materials[*i as usize]).collect();
    }
}
