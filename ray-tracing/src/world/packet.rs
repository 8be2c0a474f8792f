//! The rays of one tile of pixels, traced together.

use super::World;
use super::camera_rays::{Bundle, Rays, Row, SIDE};
use super::instance_tree::{Boxes, Walk};
use super::parallel::ParallelTriangles;
use super::primitive::SceneSphere;
use super::tree::Tree;
use super::triangle_packet::{FAR_LARGER, TrianglePacket, inside};
use fearless_simd::dispatch;
use glam::{Vec2, Vec3};
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::node::CwBvhNode;
use scene::rounding::{EDGE, WIDEST};

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

    /// For the boxes of a node's children, in the hierarchy's units around the base (`scale` a world unit): how near, infinite for those that no
    /// ray meets.
    fn child_distances(&self, node: &CwBvhNode, base: Vec3, scale: f32) -> Row {
        if self.rays.bundle == Bundle::Parallel {
            return dispatch!(self.rays.level, _simd => self.depths(&own_boxes(node, base), scale));
        }
        dispatch!(self.rays.level, _simd => self.distances(&own_boxes(node, base)))
    }

    /// The same for a place of a shared mesh, in world units.
    fn instance_distances(&self, walk: &Walk<'_>, node: &CwBvhNode) -> Row {
        if self.rays.bundle == Bundle::Parallel {
            return dispatch!(self.rays.level, _simd => self.depths(&walk.boxes(node, self.base), 1.0));
        }
        dispatch!(self.rays.level, _simd => self.distances(&walk.boxes(node, self.base)))
    }

    /// As [`distances`](Self::distances), of parallel rays: from the plane in which they start.
    #[inline(always)]
    fn depths(&self, Boxes { centers, halves }: &Boxes, scale: f32) -> Row {
        let (mut near, mut far, mut slack) = ([0.0f32; SIDE], [0.0f32; SIDE], [0.0f32; SIDE]);
        let forward = self.rays.forward.to_array();
        for ((c, h), f) in centers.iter().zip(halves).zip(forward) {
            for l in 0..SIDE {
                let (middle, half) = (f * c[l], f.abs() * h[l]);
                near[l] += middle - half;
                far[l] += middle + half;
                slack[l] += 1e-6 * (c[l].abs() + h[l]);
            }
        }
        let reach_of_planes = self.reach * scale;
        for n in &self.sides {
            let size = n.abs();
            for l in 0..SIDE {
                let reach = n.x * centers[0][l]
                    + n.y * centers[1][l]
                    + n.z * centers[2][l]
                    + (size.x * halves[0][l] + size.y * halves[1][l] + size.z * halves[2][l]);
                far[l] = if reach + reach_of_planes < -slack[l] { f32::NEG_INFINITY } else { far[l] };
            }
        }
        for l in 0..SIDE {
            near[l] = if far[l] < -slack[l] { f32::INFINITY } else { (near[l] - slack[l]).max(0.0) };
        }
        near
    }

    #[inline(always)]
    fn distances(&self, Boxes { centers, halves }: &Boxes) -> Row {
        let mut near = [0.0f32; SIDE];
        let mut slack = [0.0f32; SIDE];
        for (c, h) in centers.iter().zip(halves) {
            for l in 0..SIDE {
                let beside = (c[l].abs() - h[l]).max(0.0);
                near[l] += beside * beside;
                slack[l] += c[l].abs() + h[l];
            }
        }
        for l in 0..SIDE {
            // Far above rounding: a box too many does no harm.
            near[l] = near[l].sqrt() * 0.999_99;
            slack[l] *= -1e-6;
        }
        for n in &self.sides {
            let size = n.abs();
            for l in 0..SIDE {
                let reach = n.x * centers[0][l]
                    + n.y * centers[1][l]
                    + n.z * centers[2][l]
                    + (size.x * halves[0][l] + size.y * halves[1][l] + size.z * halves[2][l]);
                near[l] = if reach < slack[l] { f32::INFINITY } else { near[l] };
            }
        }
        near
    }

    /// Lets the rays meet eight triangles at most.
    fn meet_triangles(&mut self, numbers: &[u32], world: &World<'_>) {
        if self.rays.bundle == Bundle::Parallel {
            return dispatch!(self.rays.level, _simd => self.meet_parallel_triangles(numbers, world));
        }
        dispatch!(self.rays.level, _simd => self.meet_triangles_simd(numbers, world));
    }

    #[inline(always)]
    fn meet_triangles_simd(&mut self, numbers: &[u32], world: &World<'_>) {
        let mut t = TrianglePacket::default();
        for (l, number) in numbers.iter().enumerate().take(SIDE) {
            let c = world.triangle(*number);
            let (s, e1, e2) = (self.base - Vec3::from(c.v0), Vec3::from(c.e1), Vec3::from(c.e2));
            for k in 0..3 {
                (t.s[k][l], t.e1[k][l], t.e2[k][l]) = (s[k], e1[k], e2[k]);
            }
        }
        t.prepare(self.rays, self.first);
        if self.rays.bundle == Bundle::Sphere {
            t.rows = self.rows_between_planes(&t);
        }
        for (l, number) in numbers.iter().enumerate().take(SIDE) {
            for row in t.rows[0][l] as usize..t.rows[1][l] as usize {
                if t.giant[l] == 0.0 || !self.meet_giant(&t, l, row & 7, *number, world) {
                    self.meet_triangle(&t, l, row & 7, *number);
                }
            }
        }
        self.update_far();
    }

    /// The rows of a panorama in which triangles may be seen: none for those that lie beyond one of the planes around the rays.
    #[inline(always)]
    fn rows_between_planes(&self, t: &TrianglePacket) -> [[u32; SIDE]; 2] {
        let mut rows = [[0; SIDE], [SIDE as u32; SIDE]];
        for l in 0..SIDE {
            let at = |a: &[Row; 3]| Vec3::new(a[0][l], a[1][l], a[2][l]);
            let (s, e1, e2) = (at(&t.s), at(&t.e1), at(&t.e2));
            let slack = 1e-6 * (s.abs() + e1.abs() + e2.abs()).element_sum();
            let is_beyond = |n: &Vec3| n.dot(-s).max(n.dot(e1 - s)).max(n.dot(e2 - s)) < -slack;
            if self.sides.iter().any(is_beyond) {
                rows[1][l] = 0;
            } else if let Some(around) = &self.around
                && let Some([low, high]) = around.span([-s, e1 - s, e2 - s])
            {
                let may_meet = |row: &[f32; 2]| row[0] <= high && row[1] >= low;
                let first = around.rows.iter().position(may_meet).unwrap_or(0);
                let end = around.rows.iter().rposition(may_meet).map_or(0, |last| last + 1);
                (rows[0][l], rows[1][l]) = (first as u32, end as u32);
            }
        }
        rows
    }

    /// Lets parallel rays meet eight triangles at most.
    #[inline(always)]
    fn meet_parallel_triangles(&mut self, numbers: &[u32], world: &World<'_>) {
        let mut t = ParallelTriangles::default();
        for (l, number) in numbers.iter().enumerate().take(SIDE) {
            let c = world.triangle(*number);
            t.put(l, self.base - Vec3::from(c.v0), Vec3::from(c.e1), Vec3::from(c.e2));
        }
        t.prepare(self.rays);
        for (l, number) in numbers.iter().enumerate().take(SIDE) {
            for row in t.rows[0][l] as usize..t.rows[1][l] as usize {
                if t.is_giant[l] {
                    self.meet_parallel_giant(row & 7, *number, world);
                } else {
                    let [x, y, z] = &self.vectors;
                    let row = row & 7;
                    t.meet(l, [&x[row], &y[row], &z[row]], *number, &mut self.nearest[row], &mut self.found[row]);
                }
            }
        }
        self.update_far();
    }

    /// The same in f64, for a triangle that is large beside a pixel.
    #[cold]
    fn meet_parallel_giant(&mut self, row: usize, number: u32, world: &World<'_>) {
        let exact = world.exact(&world.triangle(number));
        let (base, direction) = (self.base.as_dvec3(), self.rays.forward.as_dvec3());
        for i in 0..SIDE {
            let start = Vec3::from_array(core::array::from_fn(|k| self.vectors[k][row][i]));
            let Some(along) = exact.meet(base + start.as_dvec3(), direction) else { continue };
            let along = along as f32;
            if along >= 0.0 && along < self.nearest[row][i] {
                (self.nearest[row][i], self.found[row][i]) = (along, number);
            }
        }
    }

    /// [`Corners::intersect`](super::primitive::Corners::intersect) for a row of rays: all that does not depend on their directions is in `t`.
    #[inline(always)]
    fn meet_triangle(&mut self, t: &TrianglePacket, l: usize, row: usize, number: u32) {
        let [x, y, z] = &self.vectors;
        let (x, y, z) = (&x[row], &y[row], &z[row]);
        let (nearest, found) = (&mut self.nearest[row], &mut self.found[row]);
        let dot = |a: &[Row; 3]| {
            let (ax, ay, az) = (a[0][l], a[1][l], a[2][l]);
            let mut out = [0.0f32; SIDE];
            for i in 0..SIDE {
                out[i] = x[i] * ax + y[i] * ay + z[i] * az;
            }
            out
        };
        let (det, u, v, height, blur) = (dot(&t.det), dot(&t.u), dot(&t.v), t.height[l], t.blur[l]);
        for i in 0..SIDE {
            let inverse = 1.0 / det[i];
            let (u, v, along) = (u[i] * inverse, v[i] * inverse, height * inverse);
            let edge = (EDGE + blur * inverse.abs()).min(WIDEST);
            // An inverse of ±∞ or NaN (ray in the plane) fails one of the comparisons.
            let hit = (u >= -edge) & (v >= -edge) & (u + v <= 1.0 + edge) & (along >= 0.0) & (along < nearest[i]);
            nearest[i] = if hit { along } else { nearest[i] };
            found[i] = if hit { number } else { found[i] };
        }
    }

    /// The same in f64, if a ray of the row meets the triangle's plane so near that the triangle is a giant there. Returns whether it does.
    #[cold]
    fn meet_giant(&mut self, t: &TrianglePacket, l: usize, row: usize, number: u32, world: &World<'_>) -> bool {
        let at = |i: usize| Vec3::from_array(core::array::from_fn(|k| self.vectors[k][row][i]));
        let det = Vec3::from_array(core::array::from_fn(|k| t.det[k][l]));
        let along = |i: usize| t.height[l] / det.dot(at(i));
        if !(0..SIDE).any(|i| t.giant[l] > FAR_LARGER * along(i).abs()) {
            return false;
        }
        let exact = world.exact(&world.triangle(number));
        let eye = self.rays.eye.as_dvec3();
        for i in 0..SIDE {
            let Some(along) = exact.meet(eye, at(i).as_dvec3()) else { continue };
            let along = along as f32;
            if along >= 0.0 && along < self.nearest[row][i] {
                (self.nearest[row][i], self.found[row][i]) = (along, number);
            }
        }
        true
    }

    /// [`SceneSphere::intersect`] for all rays that may meet it.
    fn meet_sphere(&mut self, sphere: &SceneSphere, number: u32) {
        if self.rays.bundle == Bundle::Parallel {
            return dispatch!(self.rays.level, _simd => self.meet_parallel_sphere(sphere, number));
        }
        dispatch!(self.rays.level, _simd => self.meet_sphere_simd(sphere, number));
    }

    #[inline(always)]
    fn meet_sphere_simd(&mut self, sphere: &SceneSphere, number: u32) {
        let to = sphere.sphere.center - self.base;
        let r = sphere.sphere.radius;
        let slack = 1e-6 * (to.abs().element_sum() + r);
        if self.sides.iter().any(|n| n.dot(to) < -r - slack) {
            return;
        }
        let [x, y, z] = &self.vectors;
        for row in self.rows_of(to, r) {
            let (x, y, z) = (&x[row], &y[row], &z[row]);
            let (nearest, found) = (&mut self.nearest[row], &mut self.found[row]);
            for i in 0..SIDE {
                let along = to.x * x[i] + to.y * y[i] + to.z * z[i];
                let (ax, ay, az) = (to.x - x[i] * along, to.y - y[i] * along, to.z - z[i] * along);
                let (is_met, t) = sphere_met(r, along, [ax, ay, az]);
                let hit = is_met & (t < nearest[i]);
                nearest[i] = if hit { t } else { nearest[i] };
                found[i] = if hit { number } else { found[i] };
            }
        }
        self.update_far();
    }

    #[inline(always)]
    fn meet_parallel_sphere(&mut self, sphere: &SceneSphere, number: u32) {
        let (to, d) = (sphere.sphere.center - self.base, self.rays.forward);
        let r = sphere.sphere.radius;
        let slack = 1e-6 * (to.abs().element_sum() + r);
        if self.sides.iter().any(|n| n.dot(to) + self.reach < -r - slack) {
            return;
        }
        let [x, y, z] = &self.vectors;
        for row in 0..SIDE {
            let (x, y, z) = (&x[row], &y[row], &z[row]);
            let (nearest, found) = (&mut self.nearest[row], &mut self.found[row]);
            for i in 0..SIDE {
                let (tx, ty, tz) = (to.x - x[i], to.y - y[i], to.z - z[i]);
                let along = tx * d.x + ty * d.y + tz * d.z;
                let (ax, ay, az) = (tx - d.x * along, ty - d.y * along, tz - d.z * along);
                let (is_met, t) = sphere_met(r, along, [ax, ay, az]);
                let hit = is_met & (t < nearest[i]);
                nearest[i] = if hit { t } else { nearest[i] };
                found[i] = if hit { number } else { found[i] };
            }
        }
        self.update_far();
    }

    /// The rows in which a sphere is seen.
    #[inline(always)]
    fn rows_of(&self, to: Vec3, radius: f32) -> core::ops::Range<usize> {
        if self.rays.bundle == Bundle::Sphere {
            return 0..SIDE;
        }
        let pixels = self.rays.to_row.length();
        let (w, y) = (to.dot(self.rays.forward), to.dot(self.rays.to_row) / pixels);
        let room = (w - radius) * (w + radius);
        if w <= 1.1 * radius || room <= 0.0 {
            return 0..SIDE;
        }
        // Slopes of the two planes that touch it.
        let (mid, half) = (y * w, radius * (y * y + room).max(0.0).sqrt());
        let scale = pixels / room;
        let first = self.rays.middle.y - self.first.y;
        let (low, high) = ((mid - half) * scale + first, (mid + half) * scale + first);
        let margin = self.rays.margin + 1e-5 * (low.abs() + high.abs());
        let (low, high) = inside(low - margin, high + margin);
        low as usize..high as usize
    }
}

/// Whether a ray meets a sphere, and where, from the place of its middle: along the ray, and aside.
#[inline(always)]
fn sphere_met(radius: f32, along: f32, [x, y, z]: [f32; 3]) -> (bool, f32) {
    let half_sq = radius * radius - (x * x + y * y + z * z);
    let half = half_sq.max(0.0).sqrt();
    let (enter, leave) = (along - half, along + half);
    let t = if enter >= 0.0 { enter } else { leave };
    ((half_sq >= 0.0) & (t >= 0.0), t)
}

/// The boxes of a node's children around the rays' base, in the hierarchy's units.
#[inline(always)]
fn own_boxes(node: &CwBvhNode, base: Vec3) -> Boxes {
    let step = node.e.map(|e| f32::from_bits(u32::from(e) << 23));
    let p = node.p - base;
    let bounds = [
        (&node.child_min_x, &node.child_max_x, p.x, step[0]),
        (&node.child_min_y, &node.child_max_y, p.y, step[1]),
        (&node.child_min_z, &node.child_max_z, p.z, step[2]),
    ];
    let mut boxes = Boxes { centers: [[0.0; SIDE]; 3], halves: [[0.0; SIDE]; 3] };
    for (axis, (low, high, p, step)) in bounds.into_iter().enumerate() {
        for l in 0..SIDE {
            let (low, high) = (f32::from(low[l]), f32::from(high[l]));
            boxes.centers[axis][l] = p + (low + high) * (0.5 * step);
            boxes.halves[axis][l] = (high - low) * (0.5 * step);
        }
    }
    boxes
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
