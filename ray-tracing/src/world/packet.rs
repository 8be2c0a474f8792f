//! The rays of one tile of pixels, traced together.

mod boxes;
mod spheres;
mod triangles;

use super::World;
use super::camera_rays::{Bundle, Rays, Row, SIDE};
use super::tree::Tree;
use fearless_simd::dispatch;
use glam::{Vec2, Vec3};
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::node::CwBvhNode;

/// No primitive.
pub(crate) const NOTHING: u32 = u32::MAX;
/// Set in the number of a sphere.
pub(crate) const SPHERE: u32 = 1 << 31;

type Rows = [Row; SIDE];

/// The least cosine between the rays of a packet and their mean with which planes hold them.
const LEAST_AHEAD: f32 = 0.2;

/// The rays of a tile of a panorama, projected to a plane across their mean.
struct Around {
    mean: Vec3,
    /// Along the columns.
    down: Vec3,
    /// The least and the largest place of each row's rays along `down`.
    rows: [[f32; 2]; SIDE],
}

impl Around {
    /// The places of points along the columns, with room for rounding; none where one is too far aside to be projected.
    #[inline(always)]
    fn span(&self, points: [Vec3; 3]) -> Option<[f32; 2]> {
        let mut span = [f32::INFINITY, f32::NEG_INFINITY];
        for p in points {
            let (ahead, place) = (p.dot(self.mean), p.dot(self.down));
            if ahead * 1e3 <= p.abs().max_element() {
                return None;
            }
            let place = place / ahead;
            let room = 1e-5 * (1.0 + place.abs());
            span = [span[0].min(place - room), span[1].max(place + room)];
        }
        Some(span)
    }
}

/// A ray through each pixel of a tile, and the nearest that each has met.
pub(crate) struct RayPacket<'r> {
    pub(super) rays: &'r Rays,
    /// Where the rays start; of parallel ones the start of a ray through the middle.
    pub(super) base: Vec3,
    /// The position of the first ray in the image.
    first: Vec2,
    /// The directions of the rays; of parallel ones their starts, from the base.
    pub(super) vectors: [Rows; 3],
    /// Inner normals of four planes that hold all rays between them: all zero where there are no such planes.
    sides: [Vec3; 4],
    /// The planes' distances behind the base.
    reach: f32,
    /// Of a panorama, where there are planes.
    around: Option<Around>,
    /// Distances; negative for rays that are not wanted.
    pub(super) nearest: Rows,
    pub(super) found: [[u32; SIDE]; SIDE],
    /// Nothing farther away matters.
    far: f32,
}

impl<'r> RayPacket<'r> {
    /// The rays through the points `corner` + (column, row) + `offset` that are wanted: a bit for each column of each row.
    pub(crate) fn new(rays: &'r Rays, corner: Vec2, offset: Vec2, wanted: &[u8; SIDE]) -> Self {
        match rays.bundle {
            Bundle::Plane => dispatch!(rays.level, _simd => Self::aim(rays, corner, offset, wanted)),
            Bundle::Parallel => Self::aim_parallel(rays, corner, offset, wanted),
            Bundle::Sphere => Self::aim_around(rays, corner, offset, wanted),
        }
    }

    #[inline(always)]
    fn aim(rays: &'r Rays, corner: Vec2, offset: Vec2, wanted: &[u8; SIDE]) -> Self {
        let mut vectors = [[[0.0; SIDE]; SIDE]; 3];
        let mut nearest = [[-1.0; SIDE]; SIDE];
        for row in 0..SIDE {
            let [x, y, z] = &mut vectors;
            for (column, ((x, y), z)) in x[row].iter_mut().zip(&mut y[row]).zip(&mut z[row]).enumerate() {
                let at = corner + Vec2::new(column as f32, row as f32) + offset;
                (*x, *y, *z) = rays.toward(at.x, at.y).normalize().into();
            }
            for (column, nearest) in nearest[row].iter_mut().enumerate() {
                *nearest = if wanted[row] & 1 << column != 0 { f32::INFINITY } else { -1.0 };
            }
        }
        let first = corner + offset;
        // A tenth of a pixel around them.
        let (low, high) = (first - 0.1, first + (SIDE - 1) as f32 + 0.1);
        let toward = |x, y| rays.toward(x, y);
        let corners = [toward(low.x, low.y), toward(high.x, low.y), toward(high.x, high.y), toward(low.x, high.y)];
        let side = |i: usize| corners[i].cross(corners[(i + 1) % 4]).normalize_or_zero();
        let sides = core::array::from_fn(|i| if side(i).dot(corners[(i + 2) % 4]) < 0.0 { -side(i) } else { side(i) });
        Self {
            rays,
            base: rays.eye,
            first,
            vectors,
            sides,
            reach: 0.0,
            around: None,
            nearest,
            found: [[NOTHING; SIDE]; SIDE],
            far: f32::INFINITY,
        }
    }

    /// Rays that are still to be aimed, with a vector each.
    fn unaimed(rays: &'r Rays, first: Vec2, wanted: &[u8; SIDE], vector: impl Fn(usize, usize) -> Vec3) -> Self {
        let mut packet = Self {
            rays,
            base: rays.eye,
            first,
            vectors: [[[0.0; SIDE]; SIDE]; 3],
            sides: [Vec3::ZERO; 4],
            reach: 0.0,
            around: None,
            nearest: [[-1.0; SIDE]; SIDE],
            found: [[NOTHING; SIDE]; SIDE],
            far: f32::INFINITY,
        };
        for (row, wanted) in wanted.iter().enumerate() {
            for column in 0..SIDE {
                let v = vector(column, row);
                (0..3).for_each(|k| packet.vectors[k][row][column] = v[k]);
                if wanted & 1 << column != 0 {
                    packet.nearest[row][column] = f32::INFINITY;
                }
            }
        }
        packet
    }

    fn aim_parallel(rays: &'r Rays, corner: Vec2, offset: Vec2, wanted: &[u8; SIDE]) -> Self {
        let first = corner + offset;
        let middle = first + 0.5 * (SIDE - 1) as f32;
        let base = rays.start(middle.x, middle.y);
        let start = |column: usize, row: usize| {
            let at = first + Vec2::new(column as f32, row as f32);
            rays.start(at.x, at.y) - base
        };
        let [right, down] = [rays.to_column, rays.to_row].map(Vec3::normalize);
        // A tenth of a pixel around them.
        let reach = (0.5 * (SIDE - 1) as f32 + 0.1) / rays.to_row.length();
        Self { base, sides: [right, -right, down, -down], reach, ..Self::unaimed(rays, first, wanted, start) }
    }

    fn aim_around(rays: &'r Rays, corner: Vec2, offset: Vec2, wanted: &[u8; SIDE]) -> Self {
        let first = corner + offset;
        let longitudes: [_; SIDE] = core::array::from_fn(|column| rays.longitude(first.x + column as f32));
        let latitudes: [_; SIDE] = core::array::from_fn(|row| rays.latitude(first.y + row as f32));
        let direction = |column: usize, row: usize| rays.around(longitudes[column], latitudes[row]);
        let mut packet = Self::unaimed(rays, first, wanted, direction);
        // The planes touch the rays in a projection to a plane across their mean.
        let each = || (0..SIDE * SIDE).map(|k| direction(k % SIDE, k / SIDE));
        let mean = each().sum::<Vec3>().normalize_or_zero();
        if each().all(|d| d.dot(mean) > LEAST_AHEAD) {
            let along = direction(SIDE / 2, SIDE - 1) - direction(SIDE / 2, 0);
            let y = (along - mean * along.dot(mean)).try_normalize().unwrap_or(mean.any_orthonormal_vector());
            let x = y.cross(mean);
            let place = |d: Vec3| Vec2::new(d.dot(x), d.dot(y)) / d.dot(mean);
            let low = each().map(place).fold(Vec2::INFINITY, Vec2::min) - 1e-5;
            let high = each().map(place).fold(Vec2::NEG_INFINITY, Vec2::max) + 1e-5;
            let planes = [x - mean * low.x, mean * high.x - x, y - mean * low.y, mean * high.y - y];
            packet.sides = planes.map(Vec3::normalize_or_zero);
            let rows = core::array::from_fn(|row| {
                let each = || (0..SIDE).map(|column| place(direction(column, row)).y);
                [each().fold(f32::INFINITY, f32::min), each().fold(f32::NEG_INFINITY, f32::max)]
            });
            packet.around = Some(Around { mean, down: y, rows });
        }
        packet
    }

    /// The hit of each ray.
    pub(crate) fn found(&self) -> &[[u32; SIDE]; SIDE] {
        &self.found
    }

    #[inline(always)]
    fn update_far(&mut self) {
        let mut most = [-1.0f32; SIDE];
        for row in &self.nearest {
            for (m, t) in most.iter_mut().zip(row) {
                *m = if *t > *m { *t } else { *m };
            }
        }
        self.far = most.iter().fold(-1.0, |a: f32, b| a.max(*b));
    }
}

/// Calls `found` with the numbers of primitives in boxes that rays of the packet may meet, near ones first where that is cheap.
/// `distances` are those of a node's children; `scale` is the number of their units a world unit.
#[inline(always)]
fn walk_packet(
    bvh: &CwBvh,
    scale: f32,
    packet: &mut RayPacket<'_>,
    distances: impl Fn(&RayPacket<'_>, &CwBvhNode) -> Row,
    found: &mut impl FnMut(&mut RayPacket<'_>, u32),
) {
    // Seven siblings wait on each level; the hierarchy is never deeper than 32.
    let mut stack = [(0u32, 0.0f32); 7 * 32 + 1];
    let mut count = 1;
    while count > 0 {
        count -= 1;
        let (number, near) = stack[count];
        if near > packet.far * scale {
            continue;
        }
        let node = &bvh.nodes[number as usize];
        let near = distances(packet, node);
        let bottom = count;
        for (child, near) in near.iter().enumerate() {
            if node.is_child_empty(child) || *near > packet.far * scale || *near == f32::INFINITY {
                continue;
            }
            if node.is_leaf(child) {
                let (first, n) = node.child_primitives(child);
                for i in first..first + n {
                    found(packet, i);
                }
            } else {
                // The nearest on top.
                let mut place = count;
                while place > bottom && stack[place - 1].1 < *near {
                    stack[place] = stack[place - 1];
                    place -= 1;
                }
                stack[place] = (node.child_node_index(child), *near);
                count += 1;
            }
        }
    }
}

impl<T> Tree<T> {
    /// Calls `found` with the numbers of primitives in boxes that rays of the packet may meet.
    fn visit_packet(&self, packet: &mut RayPacket<'_>, mut found: impl FnMut(&mut RayPacket<'_>, u32)) {
        let Some(bvh) = &self.bvh else { return };
        let scale = self.scale();
        let base = packet.base * scale;
        walk_packet(bvh, scale, packet, |packet, node| packet.child_distances(node, base, scale), &mut found);
    }
}

impl World<'_> {
    /// Finds the nearest visible surface on each ray of the packet.
    pub(crate) fn trace(&self, packet: &mut RayPacket<'_>) {
        let own = &self.hierarchy.triangles.primitives[..];
        let (mut waiting, mut count) = ([0u32; SIDE], 0);
        let mut wait = |packet: &mut RayPacket<'_>, number| {
            waiting[count] = number;
            count += 1;
            if count == SIDE {
                packet.meet_triangles(&waiting, self);
                count = 0;
            }
        };
        self.hierarchy.triangles.visit_packet(packet, |packet, number| {
            if own[number as usize].visible {
                wait(packet, number);
            }
        });
        let instances = &self.hierarchy.instances;
        instances.top().visit_packet(packet, |packet, number| {
            let Some(walk) = instances.walk(number) else { return };
            let first = own.len() as u32 + walk.first;
            let distances = |packet: &RayPacket<'_>, node: &CwBvhNode| packet.instance_distances(&walk, node);
            walk_packet(walk.bvh, 1.0, packet, distances, &mut |packet, i| wait(packet, first + i));
        });
        if count > 0 {
            packet.meet_triangles(&waiting[..count], self);
        }
        let spheres = &self.hierarchy.spheres.primitives[..];
        self.hierarchy.spheres.visit_packet(packet, |packet, number| {
            let sphere = &spheres[number as usize];
            if sphere.visible {
                packet.meet_sphere(sphere, number | SPHERE);
            }
        });
    }
}
