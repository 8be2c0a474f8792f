use super::{Horizon, Meridians, SkyBuffer};
use glam::Vec3;
use lobe_core::Receiver;

/// Receivers that are close together, and how they see the sky.
#[derive(Clone, Copy, Debug)]
pub struct SkyTile<'a> {
    /// The receivers.
    pub receivers: &'a [Receiver],
    /// The horizon of each.
    pub horizons: &'a [Horizon],
    /// The meridians on which outlines are drawn.
    pub meridians: &'a Meridians,
}

/// Blockers before a sky: they draw their outlines into a [`SkyBuffer`], and tell whether they hide a direction.
///
/// `None` hides nothing, and a pair hides what either does.
pub trait SkyBlockers: Sync {
    /// Working memory, one a thread.
    type Scratch: Send;

    /// New working memory.
    fn scratch(&self) -> Self::Scratch;

    /// Whether the receiver's own facet hides what is below it.
    fn has_facet(&self, at: &Receiver) -> bool;

    /// Told of a tile of receivers, before they draw in any order. A chance to cull; outlines must not depend on it. Returns whether they can be
    /// drawn: `false` where they are too many, and the tile is better shaded by [`Blockers`](crate::Blockers) before parts of the sky.
    fn enter(&self, tile: &SkyTile<'_>, scratch: &mut Self::Scratch) -> bool;

    /// Draws all outlines that receiver `number` of the tile sees above its horizon. Returns whether a ray may err about them, since what is
    /// drawn is simpler than what rays meet.
    fn draw(&self, tile: &SkyTile<'_>, number: usize, buffer: &mut SkyBuffer, scratch: &mut Self::Scratch) -> bool;

    /// Whether a surface lies in a unit direction before receiver `number`, the last one that was drawn for.
    fn hides(&self, tile: &SkyTile<'_>, number: usize, direction: Vec3, scratch: &mut Self::Scratch) -> bool;
}

impl<B: SkyBlockers> SkyBlockers for Option<B> {
    type Scratch = Option<B::Scratch>;

    fn scratch(&self) -> Self::Scratch {
        self.as_ref().map(B::scratch)
    }

    fn has_facet(&self, at: &Receiver) -> bool {
        self.as_ref().is_some_and(|blockers| blockers.has_facet(at))
    }

    fn enter(&self, tile: &SkyTile<'_>, scratch: &mut Self::Scratch) -> bool {
        let (Some(blockers), Some(scratch)) = (self, scratch) else { return true };
        blockers.enter(tile, scratch)
    }

    fn draw(&self, tile: &SkyTile<'_>, number: usize, buffer: &mut SkyBuffer, scratch: &mut Self::Scratch) -> bool {
        let (Some(blockers), Some(scratch)) = (self, scratch) else { return false };
        blockers.draw(tile, number, buffer, scratch)
    }

    fn hides(&self, tile: &SkyTile<'_>, number: usize, direction: Vec3, scratch: &mut Self::Scratch) -> bool {
        let (Some(blockers), Some(scratch)) = (self, scratch) else { return false };
        blockers.hides(tile, number, direction, scratch)
    }
}

/// Blockers by reference.
impl<B: SkyBlockers> SkyBlockers for &B {
    type Scratch = B::Scratch;

    fn scratch(&self) -> Self::Scratch {
        B::scratch(self)
    }

    fn has_facet(&self, at: &Receiver) -> bool {
        B::has_facet(self, at)
    }

    fn enter(&self, tile: &SkyTile<'_>, scratch: &mut Self::Scratch) -> bool {
        B::enter(self, tile, scratch)
    }

    fn draw(&self, tile: &SkyTile<'_>, number: usize, buffer: &mut SkyBuffer, scratch: &mut Self::Scratch) -> bool {
        B::draw(self, tile, number, buffer, scratch)
    }

    fn hides(&self, tile: &SkyTile<'_>, number: usize, direction: Vec3, scratch: &mut Self::Scratch) -> bool {
        B::hides(self, tile, number, direction, scratch)
    }
}

impl<A: SkyBlockers, B: SkyBlockers> SkyBlockers for (A, B) {
    type Scratch = (A::Scratch, B::Scratch);

    fn scratch(&self) -> Self::Scratch {
        (self.0.scratch(), self.1.scratch())
    }

    fn has_facet(&self, at: &Receiver) -> bool {
        self.0.has_facet(at) || self.1.has_facet(at)
    }

    fn enter(&self, tile: &SkyTile<'_>, scratch: &mut Self::Scratch) -> bool {
        self.0.enter(tile, &mut scratch.0) && self.1.enter(tile, &mut scratch.1)
    }

    fn draw(&self, tile: &SkyTile<'_>, number: usize, buffer: &mut SkyBuffer, scratch: &mut Self::Scratch) -> bool {
        let first = self.0.draw(tile, number, buffer, &mut scratch.0);
        self.1.draw(tile, number, buffer, &mut scratch.1) || first
    }

    fn hides(&self, tile: &SkyTile<'_>, number: usize, direction: Vec3, scratch: &mut Self::Scratch) -> bool {
        self.0.hides(tile, number, direction, &mut scratch.0) || self.1.hides(tile, number, direction, &mut scratch.1)
    }
}
