use glam::Mat4;

/// Which object of an edited scene has some number now, and what of it has changed: what was made for it before is found again,
/// whatever its number was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Revision {
    /// The same for the same object at all times.
    pub object: u64,
    /// Another one where it has another shape or another proxy.
    pub form: u64,
    /// Another one where its points have moved.
    pub place: u64,
    /// From where it stood at first.
    pub transform: Mat4,
}

impl Revision {
    /// Those of a scene with so many objects, before any edit.
    #[must_use]
    pub fn unedited(objects: usize) -> Vec<Self> {
        let of = |object| Self { object, form: 0, place: 0, transform: Mat4::IDENTITY };
        (0..objects as u64).map(of).collect()
    }
}
