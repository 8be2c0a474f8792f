//! The buffers of kernels: which there are, the numbers of their bindings, and how kernels use them.

/// The buffers of kernels, each with a binding of its own in group 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Slot {
    Frame,
    Points,
    Materials,
    Radiance,
    Queue,
    Indirect,
    Spheres,
    Images,
    Tables,
    Nodes,
    /// The table of a sky.
    Sky,
    Rig,
    Bones,
    Primitives,
    Normals,
    /// A buffer of blockers, or a page of one.
    Own(u32),
}

impl Slot {
    /// The number of the binding.
    pub(crate) const fn binding(self) -> u32 {
        match self {
            Self::Frame => 0,
            Self::Points => 1,
            Self::Materials => 2,
            Self::Radiance => 3,
            Self::Queue => 4,
            Self::Indirect => 5,
            Self::Spheres => 6,
            Self::Images => 8,
            Self::Tables => 9,
            Self::Nodes => 10,
            Self::Sky => 11,
            Self::Rig => 12,
            Self::Bones => 13,
            Self::Primitives => 14,
            Self::Normals => 15,
            Self::Own(number) => 16 + number,
        }
    }
}

/// How a kernel uses a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Access {
    Uniform,
    Read,
    Write,
}

/// A buffer of a kernel.
pub(crate) type Binding = (Slot, Access);
