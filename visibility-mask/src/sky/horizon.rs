use super::Pole;
use glam::Vec3;
use lobe_core::Receiver;

/// Where a receiver can see light from: the hemisphere above a plane, and the pole from which its meridians start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Horizon {
    pole: Pole,
    normal: Vec3,
    local: Vec3,
    is_facet: bool,
}

impl Horizon {
    /// Of a receiver: above its facet if that blocks light (`has_facet`), else above its shading normal.
    #[must_use]
    pub fn new(at: &Receiver, has_facet: bool) -> Self {
        let normal = if has_facet { at.face } else { at.normal };
        let pole = Pole::nearest(normal);
        Self { pole, normal, local: pole.local(normal), is_facet: has_facet && at.face != at.normal }
    }

    /// The pole nearest to the normal.
    #[must_use]
    pub const fn pole(&self) -> Pole {
        self.pole
    }

    /// The plane's unit normal.
    #[must_use]
    pub const fn normal(&self) -> Vec3 {
        self.normal
    }

    /// The same in the pole's frame.
    #[must_use]
    pub const fn local(&self) -> Vec3 {
        self.local
    }

    /// Whether it hides light that is above the horizon of the shading normal.
    #[must_use]
    pub const fn is_facet(&self) -> bool {
        self.is_facet
    }
}
