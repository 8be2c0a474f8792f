use glam::{UVec3, Vec3, Vec4};
use rayon::prelude::*;

use crate::random::Random;
use crate::surface::Surface;
use crate::tree::TriangleTree;

/// The mesh as voxels: those inside it, and those that its surface passes through (all there is of an open sheet).
pub(crate) struct Solid {
    low: Vec3,
    cell: f32,
    dims: UVec3,
    resolution: u32,
    /// Per voxel, at its centre: distance to the surface, positive inside.
    depth: Vec<f32>,
    /// A vertex of each part so small that it slips between the voxels' centres, at most one a voxel.
    isolated: Vec<Vec3>,
}

impl Solid {
    /// Voxels along the longest side that are fine enough for a set of `count` spheres.
    pub(crate) const fn resolution_for(count: usize) -> u32 {
        match count {
            0..=40 => 48,
            41..=160 => 64,
            161..=640 => 96,
            _ => 128,
        }
    }

    /// `resolution` voxels along the longest side.
    pub(crate) fn new(surface: &Surface, tree: &TriangleTree, resolution: u32) -> Self {
        let [lo, hi] = surface.unit_bounds();
        let cell = (hi - lo).max_element() / resolution as f32;
        let dims = ((hi - lo) / cell).ceil().as_uvec3().clamp(UVec3::ONE, UVec3::splat(resolution));
        let low = (lo + hi) * 0.5 - dims.as_vec3() * cell * 0.5;
        let mut depth = vec![0.0; (dims.x * dims.y * dims.z) as usize];
        depth.par_chunks_mut(dims.x as usize).enumerate().for_each(|(row, depths)| {
            let (y, z) = (row as u32 % dims.y, row as u32 / dims.y);
            let mut reach = f32::INFINITY;
            let mut last = (f32::NEG_INFINITY, false);
            for (x, depth) in depths.iter_mut().enumerate() {
                let p = low + (Vec3::new(x as f32, y as f32, z as f32) + 0.5) * cell;
                let distance = tree.distance(p, reach);
                reach = (distance + cell) * 1.0001;
                // Nothing is crossed within the sphere around the last point of a query, so the answer is the same there.
                if p.x >= last.0 {
                    last = (p.x + distance, tree.contains(p));
                }
                *depth = if last.1 { distance } else { -distance };
            }
        });
        let mut solid = Self { low, cell, dims, resolution, depth, isolated: Vec::new() };
        solid.isolated = solid.find_isolated(surface);
        solid
    }

    /// The vertices with no solid voxel around them.
    fn find_isolated(&self, surface: &Surface) -> Vec<Vec3> {
        let mut seen = std::collections::HashSet::new();
        let last = self.dims - 1;
        let alone = |p: &Vec3| {
            let at = self.voxel_of(*p);
            if !seen.insert(at) {
                return false;
            }
            let (from, to) = (at.saturating_sub(UVec3::ONE), (at + 1).min(last));
            !(from.z..=to.z).any(|z| {
                (from.y..=to.y)
                    .any(|y| (from.x..=to.x).any(|x| self.is_solid(self.depth[self.index(UVec3::new(x, y, z))])))
            })
        };
        surface.triangles.iter().flatten().copied().filter(alone).collect()
    }

    pub(crate) fn isolated(&self) -> &[Vec3] {
        &self.isolated
    }

    /// The voxel that holds `p`, or the nearest one.
    pub(crate) fn voxel_of(&self, p: Vec3) -> UVec3 {
        self.locate(p).max(Vec3::ZERO).as_uvec3().min(self.dims - 1)
    }

    /// The fraction of the solid voxels inside the mesh: 0 for a sheet, nearly 1 for a sphere.
    pub(crate) fn fullness(&self) -> f32 {
        let inside = self.depth.iter().filter(|depth| **depth > 0.0).count();
        let all = self.depth.iter().filter(|depth| self.is_solid(**depth)).count();
        inside as f32 / all.max(1) as f32
    }

    fn is_solid(&self, depth: f32) -> bool {
        depth > -0.5 * self.cell
    }

    pub(crate) const fn cell(&self) -> f32 {
        self.cell
    }

    pub(crate) const fn resolution(&self) -> u32 {
        self.resolution
    }

    pub(crate) const fn dims(&self) -> UVec3 {
        self.dims
    }

    /// Position in voxels, the first voxel's centre at ½.
    pub(crate) fn locate(&self, p: Vec3) -> Vec3 {
        (p - self.low) / self.cell
    }

    /// Whether `p` is inside the mesh: from the voxel if the surface is far from it, else from the tree.
    pub(crate) fn contains(&self, tree: &TriangleTree, p: Vec3) -> bool {
        let q = self.locate(p);
        if q.cmplt(Vec3::ZERO).any() || q.cmpge(self.dims.as_vec3()).any() {
            return false;
        }
        let depth = self.depth[self.index(q.as_uvec3())];
        // No point of a voxel is farther than √3/2 cells from its centre.
        if depth.abs() > 0.867 * self.cell { depth > 0.0 } else { tree.contains(p) }
    }

    /// Whether [`Self::depth_near`] is positive for sure.
    pub(crate) fn is_deep(&self, p: Vec3) -> bool {
        let q = self.locate(p);
        if q.cmplt(Vec3::ZERO).any() || q.cmpge(self.dims.as_vec3()).any() {
            return false;
        }
        // The eight centres around p are less than √3 cells from that of its voxel.
        self.depth[self.index(q.as_uvec3())] > 1.75 * self.cell
    }

    /// Depth of a point below the surface, negative outside: interpolated between voxels; off the grid, the edge's less the distance.
    pub(crate) fn depth_near(&self, p: Vec3) -> f32 {
        let last = (self.dims - 1).as_vec3();
        let q = (self.locate(p) - 0.5).clamp(Vec3::ZERO, last);
        let low = q.floor();
        let part = q - low;
        let (low, high) = (low.as_uvec3(), (low + 1.0).min(last).as_uvec3());
        let at = |x, y, z| self.depth[self.index(UVec3::new(x, y, z))];
        let row = |y, z| at(low.x, y, z) * (1.0 - part.x) + at(high.x, y, z) * part.x;
        let plane = |z| row(low.y, z) * (1.0 - part.y) + row(high.y, z) * part.y;
        let beyond = (self.locate(p) - 0.5 - q).abs().max_element() * self.cell;
        plane(low.z) * (1.0 - part.z) + plane(high.z) * part.z - beyond
    }

    fn index(&self, at: UVec3) -> usize {
        ((at.z * self.dims.y + at.y) * self.dims.x + at.x) as usize
    }

    /// The solid voxels: inside, or with the surface within half a cell.
    pub(crate) fn voxels(&self) -> impl Iterator<Item = (UVec3, f32)> + '_ {
        self.depth.iter().enumerate().filter(|(_, depth)| self.is_solid(**depth)).map(|(i, depth)| {
            let (i, dims) = (i as u32, self.dims);
            (UVec3::new(i % dims.x, i / dims.x % dims.y, i / dims.x / dims.y), *depth)
        })
    }

    /// Whether the sphere of a voxel next to this one contains this voxel's sphere, to a tenth of a cell.
    pub(crate) fn in_deeper_neighbour(&self, (at, depth): (UVec3, f32)) -> bool {
        let last = self.dims - 1;
        (0..6).any(|side| {
            let axis = side / 2;
            let mut beside = at;
            beside[axis] = if side % 2 == 0 { at[axis].saturating_sub(1) } else { (at[axis] + 1).min(last[axis]) };
            self.depth[self.index(beside)] > depth + 0.9 * self.cell
        })
    }

    /// Centre and signed depth of a voxel, as a sphere.
    pub(crate) fn sphere(&self, (at, depth): (UVec3, f32)) -> Vec4 {
        (self.low + (at.as_vec3() + 0.5) * self.cell).extend(depth)
    }

    /// `count` scattered spheres that touch the surface from inside: (centre, depth), depth ≥ 0.
    pub(crate) fn scatter(&self, tree: &TriangleTree, count: usize, random: &mut Random) -> Vec<Vec4> {
        let voxels: Vec<_> = self.voxels().collect();
        let places: Vec<Vec3> = (0..count)
            .map(|_| {
                let i = random.below(voxels.len() + self.isolated.len());
                let Some((at, _)) = voxels.get(i) else {
                    return self.isolated[i - voxels.len()];
                };
                let jitter = Vec3::new(random.unit(), random.unit(), random.unit());
                self.low + (at.as_vec3() + jitter) * self.cell
            })
            .collect();
        places
            .par_iter()
            .map(|&p| {
                let distance = tree.distance(p, f32::INFINITY);
                p.extend(if self.contains(tree, p) { distance } else { 0.0 })
            })
            .collect()
    }
}
