//! Surfaces cut along the outline of their alpha. Transparent parts are no geometry, so camera, shadows of every kind and the
//! reference see the same outline.

mod fill;
mod outline;

use crate::{Mesh, Texture, TextureMap, Wrap};
use fill::filled;
use glam::{DVec2, Vec2, Vec3};
use outline::{HashMap, Made, Pieces};

/// A surface exists where its alpha is at least the limit: that of the image times the factor times that of the vertices.
#[derive(Clone, Debug, PartialEq)]
pub struct CutOut {
    /// Its fourth channel is alpha; 1 without.
    pub map: Option<TextureMap>,
    /// In [0, 1].
    pub factor: f32,
    /// In (0, 1].
    pub limit: f32,
}

/// The longest side of the small triangles along an outline, in texels: a single texel is a square or, where texels are blended, round.
const FINEST: f32 = 0.5;

/// Triangles and halves that are looked at of a mesh, unless it had a quarter as many: outlines are followed by halves of texels, else by whole ones, twos …
const MOST_TRIANGLES: usize = 1 << 20;

/// Outlines keep within this of alpha's line, in texels, and leave as much on one side of it as on the other.
const TOLERANCE: f64 = 0.15;

/// Steps to where texels that are not blended meet between two vertices.
const BISECTIONS: u32 = 12;

/// Alphas that are equal but for rounding count as equal to the limit.
const ROUNDING: f32 = 1e-6;

impl CutOut {
    /// Cuts a mesh, whose vertices have these alphas: one each, or none. Triangles are halved along their longest side in the image until
    /// each is inside, outside or smaller than half a texel. The small ones are cut along alpha's line, as those without an image are. Halves
    /// that are wholly inside stay whole. Of what is left of each triangle the outline is simplified by 0.15 texels, and filled with as few
    /// triangles as it needs. Looks at no more than `most` triangles and halves. Returns false and leaves the mesh unchanged
    /// where an image is repeated too often for that. `bounds` are those of the image.
    ///
    /// # Panics
    /// When there are alphas, but not for each vertex.
    #[must_use]
    pub fn cut(&self, mesh: &mut Mesh, alphas: &[f32], bounds: Option<&AlphaBounds>, most: usize) -> bool {
        let most = MOST_TRIANGLES.max(4 * mesh.triangles.len()).min(most);
        let limit = self.limit / self.factor.max(f32::MIN_POSITIVE);
        let size = bounds.map_or([1.0; 2], |bounds| bounds.size);
        let mut cell = FINEST;
        loop {
            let own = Mesh { triangles: Vec::new(), ..mesh.clone() };
            let mut cutter = Cutter {
                mesh: own,
                alphas: alphas.to_vec(),
                image: self.map.as_ref().zip(bounds),
                limit,
                cell,
                steps: 0,
                most,
                made: Made::default(),
                parents: HashMap::default(),
                out: Vec::new(),
            };
            for triangle in &mesh.triangles {
                let first = cutter.out.len();
                cutter.triangle(*triangle, 0);
                if cutter.steps <= most {
                    cutter.simplify(*triangle, first);
                }
            }
            if cutter.steps <= most {
                let cut = cutter.finished(mesh.positions.len());
                // Cells that are larger than the image's parts make others of these.
                let lost = || (cut.area() / mesh.area() - self.part(mesh, alphas)).abs();
                if cell > 1.0 && lost() > MOST_LOST {
                    return false;
                }
                *mesh = cut;
                return true;
            }
            cell *= 2.0;
            // Cells as large as the image follow nothing of it.
            if cell > f32::max(size[0], size[1]) {
                return false;
            }
        }
    }

    /// The part of a mesh's area where alpha is at least the limit, by points.
    fn part(&self, mesh: &Mesh, alphas: &[f32]) -> f64 {
        let Some(map) = &self.map else { return 1.0 };
        let Some(uvs) = mesh.uv_sets.get(map.uv_set) else { return 1.0 };
        let areas: Vec<f64> = mesh.triangles.iter().map(|t| mesh.face_cross(*t).length()).collect();
        let step = areas.iter().sum::<f64>() / f64::from(SAMPLES);
        let (mut inside, mut count, mut left) = (0_u32, 0_u32, 0.5 * step);
        for (triangle, area) in mesh.triangles.iter().zip(&areas) {
            left += area;
            while left >= step && step > 0.0 {
                left -= step;
                count += 1;
                // Points of a lattice that fills the unit square evenly, folded into the triangle.
                let [u, v] = [0.754_877_666_2, 0.569_840_291].map(|x| (f64::from(count) * x).fract() as f32);
                let [u, v] = if u + v > 1.0 { [1.0 - u, 1.0 - v] } else { [u, v] };
                let mix = |[a, b, c]: [f32; 3]| a + u * (b - a) + v * (c - a);
                let own = if alphas.is_empty() { 1.0 } else { mix(triangle.map(|i| alphas[i as usize])) };
                let [a, b, c] = triangle.map(|i| map.transform.transform_point2(uvs[i as usize]));
                let at = a + u * (b - a) + v * (c - a);
                let texel = map.texture.sample(at, [Vec2::ZERO; 2], map.wrap, map.is_pixelated)[3];
                inside += u32::from(own * self.factor * texel >= self.limit);
            }
        }
        f64::from(inside) / f64::from(count.max(1))
    }
}

/// Points by which a part of an area is known, and the part of it that may be lost or added.
const SAMPLES: u32 = 1 << 16;
const MOST_LOST: f64 = 0.02;

impl Mesh {
    /// Takes the parts away where an image's alpha, its fourth channel, is below a limit in (0, 1]; along the line at which it is, so that
    /// camera and shadows see the same outline. Returns false and leaves the mesh unchanged where the image is repeated too often for
    /// that.
    ///
    /// The outline follows alpha to 0.15 texels, and keeps its area: up to two new triangles for each texel of it, one for five or more of them
    /// where it is straight or round.
    ///
    /// ```
    /// use glam::Vec3;
    /// use scene::{Encoding, Mesh, Texture, TextureMap};
    /// // Alpha is 0 in the left half of the image.
    /// let texels = vec![[255, 255, 255, 0], [255, 255, 255, 255]];
    /// let map = TextureMap::new(Texture::new("half", [2, 1], texels, Encoding::Srgb));
    /// let mut mesh = Mesh::quad(Vec3::ZERO, Vec3::X, Vec3::Y);
    /// assert!(mesh.cut_out(&map, 0.5));
    /// assert!(mesh.area() > 1.0 && mesh.area() < 3.0);
    /// ```
    #[must_use]
    pub fn cut_out(&mut self, map: &TextureMap, limit: f32) -> bool {
        let bounds = AlphaBounds::new(&map.texture);
        let by = CutOut { map: Some(map.clone()), factor: 1.0, limit };
        by.cut(self, &[], Some(&bounds), usize::MAX)
    }
}

/// The most halvings of one triangle. They shorten its sides by 2⁴⁰, which is more than single precision resolves.
const DEEPEST: u32 = 80;

struct Cutter<'a> {
    mesh: Mesh,
    /// Of the vertices; none where all are 1.
    alphas: Vec<f32>,
    image: Option<(&'a TextureMap, &'a AlphaBounds)>,
    limit: f32,
    /// Triangles of at most this many texels a side are not halved further.
    cell: f32,
    /// Triangles looked at, and the most that may be.
    steps: usize,
    most: usize,
    made: Made,
    /// The vertices that each further one is between.
    parents: HashMap<u32, [u32; 2]>,
    out: Vec<[u32; 3]>,
}

impl Cutter<'_> {
    fn triangle(&mut self, [a, b, c]: [u32; 3], depth: u32) {
        self.steps += 1;
        if self.steps > self.most {
            return;
        }
        let own = [a, b, c].map(|i| self.own_alpha(i));
        let (least, largest) = own.into_iter().fold((1.0_f32, 0.0_f32), |(l, h), x| (l.min(x), h.max(x)));
        let uv = [a, b, c].map(|i| self.uv(i));
        let of_image = |(map, bounds): (&TextureMap, &AlphaBounds)| bounds.of(uv, map.wrap).unwrap_or((0.0, 1.0));
        let (low, high) = self.image.map_or((1.0, 1.0), of_image);
        let limit = self.limit * (1.0 - ROUNDING);
        if low * least >= limit {
            self.out.push([a, b, c]);
            return;
        }
        if high * largest < limit {
            return;
        }
        let Some((_, bounds)) = self.image else {
            self.follow([a, b, c]);
            return;
        };
        let size = Vec2::from_array(bounds.size);
        let side = |i: usize| ((uv[(i + 1) % 3] - uv[i]) * size).length_squared();
        let longest = (0..3).max_by(|i, j| side(*i).total_cmp(&side(*j))).unwrap_or(0);
        if side(longest) <= self.cell * self.cell || depth >= DEEPEST || !side(longest).is_finite() {
            self.follow([a, b, c]);
            return;
        }
        let corners = [a, b, c];
        let [p, q, r] = [0, 1, 2].map(|k| corners[(longest + k) % 3]);
        let middle = self.between(p, q, true, 0.5);
        self.triangle([p, middle, r], depth + 1);
        self.triangle([middle, q, r], depth + 1);
    }

    /// Keeps the part of a small triangle on the inner side of alpha's line.
    fn follow(&mut self, corners: [u32; 3]) {
        let alpha = corners.map(|i| self.alpha(i) - self.limit);
        // A corner or a side on alpha's line is no piece: it would bridge what is cut away on both sides of it.
        if alpha.iter().all(|alpha| *alpha <= 0.0) {
            return;
        }
        let mut kept = Vec::with_capacity(4);
        for k in 0..3 {
            let (here, next) = (k, (k + 1) % 3);
            if alpha[here] >= 0.0 {
                kept.push(corners[here]);
            }
            if (alpha[here] >= 0.0) != (alpha[next] >= 0.0) {
                // The same from both sides.
                let order = if corners[here] < corners[next] { [here, next] } else { [next, here] };
                let t = self.crossing(order.map(|k| corners[k]), order.map(|k| alpha[k]));
                kept.push(self.between(corners[order[0]], corners[order[1]], false, t));
            }
        }
        for k in 2..kept.len() {
            self.out.push([kept[0], kept[k - 1], kept[k]]);
        }
    }

    /// Where between two vertices of these alphas, less the limit, alpha's line crosses.
    fn crossing(&self, [p, q]: [u32; 2], alpha: [f32; 2]) -> f32 {
        let even = alpha[0] / (alpha[0] - alpha[1]);
        let Some((map, _)) = self.image.filter(|(map, _)| map.is_pixelated && self.cell <= 1.0) else { return even };
        // Where texels are not blended it steps.
        let [(a, own_a), (b, own_b)] = [p, q].map(|vertex| (self.uv(vertex), self.own_alpha(vertex)));
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..BISECTIONS {
            let t = 0.5 * (low + high);
            let texel = map.texture.sample(a.lerp(b, t), [Vec2::ZERO; 2], map.wrap, true)[3];
            let is_inside = (own_a + t * (own_b - own_a)) * texel >= self.limit;
            if is_inside == (alpha[0] >= 0.0) { low = t } else { high = t }
        }
        0.5 * (low + high)
    }

    /// The triangles, without vertices that were only on the way to them; the `first` ones were there before.
    fn finished(self, first: usize) -> Mesh {
        let Self { mut mesh, mut out, .. } = self;
        // A line that passes by a corner leaves specks without an area.
        out.retain(|piece| mesh.face_cross(*piece).length_squared() > f64::MIN_POSITIVE);
        let mut numbers: Vec<u32> =
            (0..mesh.positions.len() as u32).map(|i| if (i as usize) < first { i } else { u32::MAX }).collect();
        let mut kept: Vec<usize> = (0..first).collect();
        for corner in out.iter_mut().flatten() {
            let number = &mut numbers[*corner as usize];
            if *number == u32::MAX {
                *number = kept.len() as u32;
                kept.push(*corner as usize);
            }
            *corner = *number;
        }
        mesh.positions = kept.iter().map(|i| mesh.positions[*i]).collect();
        for list in [&mut mesh.normals, &mut mesh.colors] {
            if !list.is_empty() {
                *list = kept.iter().map(|i| list[*i]).collect();
            }
        }
        for set in &mut mesh.uv_sets {
            *set = kept.iter().map(|i| set[*i]).collect();
        }
        Mesh { triangles: out, ..mesh }
    }

    /// Replaces the pieces of a triangle, those from the number `first` on, by fewer of nearly the same outline.
    fn simplify(&mut self, triangle: [u32; 3], first: usize) {
        let (Some((_, bounds)), true) = (self.image, self.out.len() > first + 1) else { return };
        let size = DVec2::from_array(bounds.size.map(f64::from));
        let origin = self.uv(triangle[0]).as_dvec2();
        let place = |vertex: u32| (self.uv(vertex).as_dvec2() - origin) * size;
        let [b, c] = [place(triangle[1]), place(triangle[2])];
        let area = b.perp_dot(c);
        // A triangle that is a line in the image has no outline there.
        if !area.is_finite() || area.abs() <= 1e-6 * b.length_squared().max(c.length_squared()) {
            return;
        }
        let pieces =
            Pieces { triangle, pieces: &self.out[first..], made: &self.made, parents: &self.parents, place: &place };
        let outlines = pieces.outlines(TOLERANCE * f64::from(self.cell.max(1.0)));
        let Some((corners, triangles)) = outlines.and_then(|outlines| filled(&outlines, area.signum())) else { return };
        let weights = |p: DVec2| [p.perp_dot(c) / area, b.perp_dot(p) / area];
        let numbers: Vec<u32> = corners
            .iter()
            .map(|corner| corner.vertex.unwrap_or_else(|| self.within(triangle, weights(corner.place))))
            .collect();
        self.out.truncate(first);
        self.out.extend(triangles.into_iter().map(|triangle| triangle.map(|k| numbers[k])));
    }

    fn uv(&self, vertex: u32) -> Vec2 {
        let Some((map, _)) = self.image else { return Vec2::ZERO };
        let uv = self.mesh.uv_sets.get(map.uv_set).map_or(Vec2::ZERO, |set| set[vertex as usize]);
        map.transform.transform_point2(uv)
    }

    fn own_alpha(&self, vertex: u32) -> f32 {
        self.alphas.get(vertex as usize).copied().unwrap_or(1.0)
    }

    /// Alpha at a vertex, the mean of a cell.
    fn alpha(&self, vertex: u32) -> f32 {
        let own = self.own_alpha(vertex);
        let Some((map, bounds)) = self.image else { return own };
        let side = (self.cell - 0.5).max(0.0) / Vec2::from_array(bounds.size);
        let footprint = if self.cell > 1.0 { [Vec2::X * side.x, Vec2::Y * side.y] } else { [Vec2::ZERO; 2] };
        own * map.texture.sample(self.uv(vertex), footprint, map.wrap, map.is_pixelated)[3]
    }

    /// The vertex at the fraction `t` of the way from one to another.
    fn between(&mut self, a: u32, b: u32, is_middle: bool, t: f32) -> u32 {
        let key = (a.min(b), a.max(b), is_middle);
        if let Some(known) = self.made.get(&key) {
            return *known;
        }
        let number = self.within([a, b, b], [f64::from(t), 0.0]);
        self.made.insert(key, number);
        self.parents.insert(number, [a, b]);
        number
    }

    /// A new vertex in a triangle, by the weights of its second and third corner.
    fn within(&mut self, corners: [u32; 3], [v, w]: [f64; 2]) -> u32 {
        let corners @ [a, ..] = corners.map(|i| i as usize);
        let mesh = &mut self.mesh;
        let number = mesh.positions.len() as u32;
        let mix = |list: &[Vec3]| {
            let [a, b, c] = corners.map(|i| list[i].as_dvec3());
            (a + v * (b - a) + w * (c - a)).as_vec3()
        };
        let position = mix(&mesh.positions);
        mesh.positions.push(position);
        if !mesh.normals.is_empty() {
            let normal = mix(&mesh.normals).try_normalize().unwrap_or(mesh.normals[a]);
            mesh.normals.push(normal);
        }
        if !mesh.colors.is_empty() {
            let color = mix(&mesh.colors);
            mesh.colors.push(color);
        }
        for set in &mut mesh.uv_sets {
            let [a, b, c] = corners.map(|i| set[i].as_dvec2());
            set.push((a + v * (b - a) + w * (c - a)).as_vec2());
        }
        if !self.alphas.is_empty() {
            let [a, b, c] = corners.map(|i| f64::from(self.alphas[i]));
            self.alphas.push((a + v * (b - a) + w * (c - a)) as f32);
        }
        number
    }
}

/// Least and largest alpha of squares of texels, twice as many a side from level to level.
#[derive(Clone, Debug)]
pub struct AlphaBounds {
    size: [f32; 2],
    levels: Vec<([usize; 2], Vec<[u8; 2]>)>,
}

impl AlphaBounds {
    /// Those of an image. Cost: about three passes over its alpha.
    #[must_use]
    pub fn new(texture: &Texture) -> Self {
        let [width, height] = texture.size();
        let mut levels = vec![([width, height], texture.alphas().into_iter().map(|a| [a; 2]).collect::<Vec<_>>())];
        while let Some(([w, h], last)) = levels.last().filter(|(size, _)| size[0].max(size[1]) > 1) {
            let size = [w.div_ceil(2), h.div_ceil(2)];
            let of = |x: usize, y: usize| {
                let four = [(0, 0), (1, 0), (0, 1), (1, 1)];
                let inside = four.into_iter().map(|(i, j)| (2 * x + i, 2 * y + j)).filter(|(i, j)| i < w && j < h);
                let bounds = inside.map(|(i, j)| last[j * w + i]);
                bounds.fold([255, 0], |[low, high], [a, b]| [low.min(a), high.max(b)])
            };
            let next = (0..size[0] * size[1]).map(|k| of(k % size[0], k / size[0])).collect();
            levels.push((size, next));
        }
        Self { size: [width as f32, height as f32], levels }
    }

    /// Bounds of alpha over a triangle; `None` if the triangle crosses the image's edge.
    fn of(&self, corners: [Vec2; 3], wrap: [Wrap; 2]) -> Option<(f32, f32)> {
        let low = corners[0].min(corners[1]).min(corners[2]);
        let high = corners[0].max(corners[1]).max(corners[2]);
        // Of columns and rows those inside, and those beyond an edge.
        let mut texels = [[None; 3]; 2];
        for k in 0..2 {
            let (mut a, mut b) = (low[k], high[k]);
            match wrap[k] {
                Wrap::Clamp => (a, b) = (a.clamp(0.0, 1.0), b.clamp(0.0, 1.0)),
                Wrap::Repeat => (a, b) = (a - low[k].floor(), b - low[k].floor()),
                Wrap::Mirror => {
                    let base = 2.0 * (0.5 * low[k]).floor();
                    (a, b) = (a - base, b - base);
                    // The mirrored half.
                    if a >= 1.0 {
                        (a, b) = (2.0 - b, 2.0 - a);
                    }
                }
            }
            if !(a >= 0.0 && b <= 1.0) {
                return None;
            }
            // With the texels that are blended beside it.
            let (first, last) = ((a * self.size[k] - 1.0).floor(), (b * self.size[k] + 1.0).floor());
            let most = self.size[k] as usize - 1;
            let wraps = wrap[k] == Wrap::Repeat;
            texels[k] = [
                Some(((first.max(0.0) as usize).min(most), (last.max(0.0) as usize).min(most))),
                (wraps && first < 0.0).then_some((most, most)),
                (wraps && last > most as f32).then_some((0, 0)),
            ];
        }
        let mut all = [255, 0];
        for (x0, x1) in texels[0].into_iter().flatten() {
            for (y0, y1) in texels[1].into_iter().flatten() {
                let [low, high] = self.within([x0, x1], [y0, y1]);
                all = [all[0].min(low), all[1].max(high)];
            }
        }
        Some((f32::from(all[0]) / 255.0, f32::from(all[1]) / 255.0))
    }

    /// Bounds over columns and rows of texels.
    fn within(&self, [x0, x1]: [usize; 2], [y0, y1]: [usize; 2]) -> [u8; 2] {
        let mut level = 0;
        while (x1 >> level) - (x0 >> level) > 3 || (y1 >> level) - (y0 >> level) > 3 {
            level += 1;
        }
        let (size, bounds) = &self.levels[level];
        let mut all = [255, 0];
        for y in y0 >> level..=y1 >> level {
            for x in x0 >> level..=x1 >> level {
                let [low, high] = bounds[y * size[0] + x];
                all = [all[0].min(low), all[1].max(high)];
            }
        }
        all
    }
}
