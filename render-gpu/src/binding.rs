//! The buffers of kernels: their names and types in WGSL, the numbers of their bindings, and how kernels use them.

/// The buffers of kernels, each with a binding of its own in group 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Slot {
    Frame,
    /// The camera of the kernel of visible points, which has no frame.
    View,
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
            Self::Frame | Self::View => 0,
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

    /// Its declaration in WGSL; `None` for buffers of blockers, which have [declarations](crate::module::OwnBuffer::declaration) of their own.
    pub(crate) fn declaration(self, access: Access) -> Option<String> {
        let (name, of) = match self {
            Self::Frame => ("frame", "Frame"),
            Self::View => ("view", "View"),
            Self::Points => ("points", "array<Receiver>"),
            Self::Materials => ("materials", "array<u32>"),
            Self::Radiance => ("radiance", "array<vec4f>"),
            Self::Queue => ("queue", "Queue"),
            Self::Indirect => ("args", "array<u32>"),
            Self::Spheres => ("spheres", "array<BlockerSphere>"),
            Self::Images => ("light_images", "array<u32>"),
            Self::Tables => ("paper_tables", "array<vec2f>"),
            Self::Nodes => ("nodes", "array<BvhNode>"),
            Self::Primitives => ("primitives", "array<Primitive>"),
            Self::Sky => ("sky_table", "array<f32>"),
            Self::Rig => ("rig", "array<u32>"),
            Self::Bones => ("bones", "array<f32>"),
            Self::Normals => ("normals", "array<f32>"),
            Self::Own(_) => return None,
        };
        let space = match access {
            Access::Uniform => "uniform",
            Access::Read => "storage, read",
            Access::Write => "storage, read_write",
        };
        Some(format!("@group(0) @binding({}) var<{space}> {name}: {of};\n", self.binding()))
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
