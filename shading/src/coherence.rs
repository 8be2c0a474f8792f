use crate::ShadingPoints;
use core::ops::Range;
use lobe_core::compact_runs;

/// Points that follow each other in a list and are culled together, by all shaders: an 8 × 8 pixel tile of a picture.
pub const GROUP: usize = 64;

impl ShadingPoints {
    /// The groups of points that are culled together: at most [`GROUP`], none from two tiles of a picture.
    ///
    /// A tile of more points, as its pixels have several, is cut into equal parts.
    #[must_use]
    pub fn groups(&self) -> Vec<Range<usize>> {
        let count = self.receivers.len();
        let mut groups = Vec::with_capacity(count.div_ceil(GROUP).max(self.ends.len()));
        let mut first = 0;
        for end in self.ends.iter().copied().take_while(|end| *end <= count) {
            let parts = end.saturating_sub(first).div_ceil(GROUP);
            groups
                .extend((0..parts).map(|k| first + (end - first) * k / parts..first + (end - first) * (k + 1) / parts));
            first = first.max(end);
        }
        groups.extend((first..count).step_by(GROUP).map(|start| start..(start + GROUP).min(count)));
        groups
    }

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
    /// use lobe_core::Receiver;
    /// use shading::ShadingPoints;
    /// let at = |k: u32| {
    ///     let position = Vec3::X * (k * 37 % 100) as f32; // here and there
    ///     Receiver::on_surface(position, Vec3::Y, Vec3::Y)
    /// };
    /// let receivers = (0..100).map(at).collect();
    /// let mut points = ShadingPoints { receivers, materials: vec![0; 100], ..ShadingPoints::default() };
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
        self.ends.clear();
        self.squares.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use lobe_core::Receiver;

    /// Each point is in one group, in order; no group is too large, empty, or of two tiles, whatever the ends are.
    #[test]
    fn groups_keep_to_tiles() {
        let at = Receiver::on_surface(Vec3::ZERO, Vec3::Y, Vec3::Y);
        for (count, ends) in [
            (0, vec![]),
            (200, vec![]),
            (64 * 3, vec![64, 128, 192]),
            (170, vec![0, 0, 70, 70, 134, 169]),
            (100, vec![60, 700]),
            (300, vec![299, 40, 300]),
        ] {
            let points = ShadingPoints {
                receivers: vec![at; count],
                materials: vec![0; count],
                ends: ends.clone(),
                squares: Vec::new(),
            };
            let groups = points.groups();
            assert_eq!(groups.iter().cloned().flatten().collect::<Vec<_>>(), (0..count).collect::<Vec<_>>());
            assert!(groups.iter().all(|group| (1..=GROUP).contains(&group.len())));
            if ends.is_sorted() {
                assert!(groups.iter().all(|g| ends.iter().all(|end| *end <= g.start || g.end <= *end)), "{groups:?}");
            }
        }
    }
}
