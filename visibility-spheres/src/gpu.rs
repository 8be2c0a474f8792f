//! The `spheres` strategy for a GPU.

use crate::packed::{LIST_WORDS, SPHERE_BLOCK};
use crate::{SphereBlockers, wgsl};
use lobe_core::wgsl::Piece;
use shading::gpu::{GpuBlockers, GpuBuffer, GpuContents, GpuPass, GpuRun, GpuSkyPart};

const SPHERES: &str = "spheres";
const BOUNDS: &str = "spheres_bounds";
const LISTS: &str = "spheres_lists";

/// The most spheres that are all drawn for each point before a sky.
const MOST_BEFORE_SKIES: usize = 1024;
/// Threads of the workgroups that make bounds.
const GROUP: usize = 64;

/// The same spheres, culled for each tile of points before these are classified.
impl GpuBlockers for SphereBlockers {
    fn name(&self) -> &'static str {
        "spheres"
    }

    fn coverage(&self) -> &'static Piece {
        &wgsl::SPHERES
    }

    fn splat(&self) -> &'static Piece {
        &wgsl::SPHERES_SPLAT
    }

    fn has_edges(&self) -> bool {
        true
    }

    fn sky(&self) -> Option<GpuSkyPart> {
        let is_few = self.order().len() <= MOST_BEFORE_SKIES;
        is_few.then(|| GpuSkyPart { piece: &wgsl::SPHERES_SKY, reads: vec![SPHERES] })
    }

    fn is_empty(&self) -> bool {
        self.order().is_empty()
    }

    fn buffers(&self) -> Vec<GpuBuffer<'_>> {
        let mut packed = Vec::new();
        self.pack(&mut packed);
        let blocks = packed.len().div_ceil(SPHERE_BLOCK) as u32;
        let room = |name, element, contents| GpuBuffer { name, element, contents };
        vec![
            GpuBuffer::of(SPHERES, "BlockerSphere", bytemuck::cast_slice(&packed).to_vec()),
            room(BOUNDS, "vec4f", GpuContents::Room(4 * blocks)),
            room(LISTS, "u32", GpuContents::RoomPerTile(LIST_WORDS as u32)),
        ]
    }

    fn passes(&self) -> Vec<GpuPass> {
        let groups = self.order().len().div_ceil(SPHERE_BLOCK).div_ceil(GROUP) as u32;
        vec![
            GpuPass {
                entry: "bounds",
                piece: &wgsl::BOUNDS,
                reads: vec![SPHERES],
                writes: vec![BOUNDS],
                run: GpuRun::Changed(groups),
            },
            GpuPass {
                entry: "cull",
                piece: &wgsl::CULL,
                reads: vec!["points", SPHERES, BOUNDS],
                writes: vec![LISTS],
                run: GpuRun::Tiles,
            },
        ]
    }
}
