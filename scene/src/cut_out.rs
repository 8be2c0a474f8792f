//! Surfaces cut along the outline of their alpha. Transparent parts are no geometry, so camera, shadows of every kind and the
//! reference see the same outline.

use crate::{Mesh, Texture, TextureMap, Wrap};
use glam::{Vec2, Vec3};
use std::collections::HashMap;

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

/// Triangles and halves that are looked at of a mesh, unless it had a quarter as many: outlines are followed by texels, else by twos, fours …
const MOST_TRIANGLES: usize = 1 << 20;

/// Alphas that are equal but for rounding count as equal to the limit.
const ROUNDING: f32 = 1e-6;

impl CutOut {
    /// Cuts a mesh, whose vertices have these alphas: one each, or none. Triangles are halved along their longest side in the image until
    /// each is inside, outside or smaller than a texel. The small ones are cut along alpha's line, as those without an image are. Halves
    /// that are wholly inside stay whole. Looks at no more than `most` triangles and halves. Returns false and leaves the mesh unchanged
    /// where an image is repeated too often for that. `bounds` are those of the image.
    ///
    /// # Panics
    /// When there are alphas, but not for each vertex.
    #[must_use]
    pub fn cut(&self, mesh: &mut Mesh, alphas: &[f32], bounds: Option<&AlphaBounds>, most: usize) -> bool {
        let most = MOST_TRIANGLES.max(4 * mesh.triangles.len()).min(most);
        let limit = self.limit / self.factor.max(f32::MIN_POSITIVE);
        let size = bounds.map_or([1.0; 2], |bounds| bounds.size);
        let mut cell = 1.0;
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
                made: HashMap::new(),
                out: Vec::new(),
            };
            mesh.triangles.iter().for_each(|triangle| cutter.triangle(*triangle, 0));
            if cutter.steps <= most {
                *mesh = Mesh { triangles: cutter.out, ..cutter.mesh };
                return true;
            }
            cell *= 2.0;
            // Cells as large as the image follow nothing of it.
            if cell > f32::max(size[0], size[1]) {
                return false;
            }
        }
    }
}

impl Mesh {
    /// Takes the parts away where an image's alpha, its fourth channel, is below a limit in (0, 1]; along the line at which it is, so that
    /// camera and shadows see the same outline. Returns false and leaves the mesh unchanged where the image is repeated too often for
    /// that.
    ///
    /// Triangles are halved until each is inside, outside or smaller than a texel: up to some 40 new triangles for each texel of
    /// the outline, a million in all.
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
    /// Vertices made between two others, by these and how.
    made: HashMap<(u32, u32, bool), u32>,
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
        let mut kept = Vec::with_capacity(4);
        for k in 0..3 {
            let (here, next) = (k, (k + 1) % 3);
            if alpha[here] >= 0.0 {
                kept.push(corners[here]);
            }
            if (alpha[here] >= 0.0) != (alpha[next] >= 0.0) {
                let t = alpha[here] / (alpha[here] - alpha[next]);
                // The same from both sides.
                let (p, q) = (corners[here], corners[next]);
                let (p, q, t) = if p < q { (p, q, t) } else { (q, p, 1.0 - t) };
                kept.push(self.between(p, q, false, t));
            }
        }
        for k in 2..kept.len() {
            let piece = [kept[0], kept[k - 1], kept[k]];
            // A line that passes by a corner leaves specks without an area.
            if self.mesh.face_cross(piece).length_squared() > f64::MIN_POSITIVE {
                self.out.push(piece);
            }
        }
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
        let (mesh, i, j) = (&mut self.mesh, a as usize, b as usize);
        let number = mesh.positions.len() as u32;
        let mix = |list: &[Vec3]| list[i].lerp(list[j], t);
        let position = mix(&mesh.positions);
        mesh.positions.push(position);
        if !mesh.normals.is_empty() {
            let normal = mix(&mesh.normals).try_normalize().unwrap_or(mesh.normals[i]);
            mesh.normals.push(normal);
        }
        if !mesh.colors.is_empty() {
            let color = mix(&mesh.colors);
            mesh.colors.push(color);
        }
        if !self.alphas.is_empty() {
            let alpha = self.alphas[i] + t * (self.alphas[j] - self.alphas[i]);
            self.alphas.push(alpha);
        }
        for set in &mut mesh.uv_sets {
            let uv = set[i].lerp(set[j], t);
            set.push(uv);
        }
        self.made.insert(key, number);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Encoding;
    use core::f64::consts::PI;

    /// A disc of alpha 1 with a soft edge in the middle of an image.
    fn disc(n: u32, radius: f32) -> TextureMap {
        let texel = |i: u32| {
            let (x, y) = ((i % n) as f32 + 0.5 - 0.5 * n as f32, (i / n) as f32 + 0.5 - 0.5 * n as f32);
            let alpha = (radius * n as f32 - x.hypot(y) + 0.5).clamp(0.0, 1.0);
            [255, 255, 255, (alpha * 255.0).round() as u8]
        };
        TextureMap::new(Texture::new("disc", [n, n], (0..n * n).map(texel).collect(), Encoding::Srgb))
    }

    fn cut_by(by: &CutOut, mesh: &mut Mesh, alphas: &[f32]) -> bool {
        let bounds = by.map.as_ref().map(|map| AlphaBounds::new(&map.texture));
        by.cut(mesh, alphas, bounds.as_ref(), MOST_TRIANGLES)
    }

    fn cut(map: TextureMap, mesh: &Mesh) -> Mesh {
        let mut mesh = mesh.clone();
        assert!(cut_by(&CutOut { map: Some(map), factor: 1.0, limit: 0.5 }, &mut mesh, &[]));
        mesh.validate().expect("a mesh");
        mesh
    }

    #[test]
    fn what_is_left_has_the_area_of_what_is_opaque() {
        let quad = Mesh::quad(Vec3::ZERO, Vec3::X, Vec3::Y);
        for (n, radius, tolerance) in [(16, 0.4, 0.02), (64, 0.3, 0.002), (256, 0.45, 2e-4), (37, 0.35, 0.005)] {
            let left = cut(disc(n, radius), &quad);
            let want = 4.0 * PI * f64::from(radius).powi(2);
            println!("{n}: area {:.5} of {want:.5}, {} triangles", left.area(), left.triangles.len());
            assert!((left.area() / want - 1.0).abs() < tolerance, "{n}: {} {want}", left.area());
            // As many as the outline has texels, and a few for the inside.
            assert!(left.triangles.len() < 48 * n as usize, "{n}: {}", left.triangles.len());
            // Nothing outside, and coordinates that go with the places.
            for (p, uv) in left.positions.iter().zip(&left.uv_sets[0]) {
                assert!((Vec2::new(p.x, -p.y) * 0.5 + 0.5 - *uv).length() < 1e-5);
            }
            let used = left.triangles.iter().flatten().map(|i| left.positions[*i as usize].length());
            assert!(used.fold(0.0, f32::max) < 2.0 * radius + 1.5 / n as f32);
        }
    }

    #[test]
    fn images_that_repeat_are_cut_as_often() {
        let quad = Mesh::quad(Vec3::ZERO, Vec3::X, Vec3::Y);
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            let mut map = disc(32, 0.4);
            map.wrap = [wrap; 2];
            map.transform = glam::Affine2::from_scale_angle_translation(Vec2::splat(3.0), 0.0, Vec2::new(-1.0, 0.0));
            let discs = if wrap == Wrap::Clamp { 1.0 } else { 9.0 };
            let want = discs * 4.0 / 9.0 * PI * 0.16;
            let area = cut(map, &quad).area();
            assert!((area / want - 1.0).abs() < 0.01, "{wrap:?}: {area} {want}");
        }
    }

    #[test]
    fn whole_and_empty_images_leave_all_and_nothing() {
        let quad = Mesh::quad(Vec3::ZERO, Vec3::X, Vec3::Y);
        let flat = |alpha| TextureMap::new(Texture::new("flat", [8, 8], vec![[0, 0, 0, alpha]; 64], Encoding::Srgb));
        let mut all = quad.clone();
        cut_by(&CutOut { map: Some(flat(255)), factor: 1.0, limit: 0.5 }, &mut all, &[]);
        assert!((all.area() - 4.0).abs() < 1e-6);
        for (map, factor) in [(Some(flat(0)), 1.0), (Some(flat(255)), 0.3), (None, 0.3)] {
            let mut none = quad.clone();
            cut_by(&CutOut { map, factor, limit: 0.5 }, &mut none, &[]);
            assert!(none.triangles.is_empty());
        }
    }

    #[test]
    fn hostile_coordinates_end() {
        let mut quad = Mesh::quad(Vec3::ZERO, Vec3::X, Vec3::Y);
        for uv in [f32::NAN, f32::INFINITY, 1e30, -1e9, 1e-30] {
            quad.uv_sets[0][2] = Vec2::new(uv, 0.3);
            let mut mesh = quad.clone();
            cut_by(&CutOut { map: Some(disc(16, 0.4)), factor: 1.0, limit: 0.5 }, &mut mesh, &[]);
            assert!(mesh.triangles.len() <= 2 * MOST_TRIANGLES, "{uv}: {}", mesh.triangles.len());
            assert!(mesh.positions.iter().all(|p| p.is_finite()));
        }
    }

    #[test]
    fn the_alpha_of_vertices_cuts_with_and_without_an_image() {
        // From 0 on the left to 1 on the right: the line of 0.3 is straight.
        let quad = Mesh::quad(Vec3::ZERO, Vec3::X, Vec3::Y);
        let alphas: Vec<f32> = quad.positions.iter().map(|p| 0.5 + 0.5 * p.x).collect();
        let mut plain = quad.clone();
        assert!(cut_by(&CutOut { map: None, factor: 1.0, limit: 0.3 }, &mut plain, &alphas));
        assert!((plain.area() - 4.0 * 0.7).abs() < 1e-5, "{}", plain.area());
        // An image of alpha 0.6 everywhere moves the line: 0.6·a = 0.3 at a half.
        let flat = Texture::new("flat", [8, 8], vec![[0, 0, 0, 153]; 64], Encoding::Srgb);
        let mut shown = quad;
        assert!(cut_by(&CutOut { map: Some(TextureMap::new(flat)), factor: 1.0, limit: 0.3 }, &mut shown, &alphas));
        assert!((shown.area() - 2.0).abs() < 0.02, "{}", shown.area());
    }

    #[test]
    fn alphas_at_the_limit_are_kept() {
        let quad = Mesh::quad(Vec3::ZERO, Vec3::X, Vec3::Y);
        let flat = |alpha| TextureMap::new(Texture::new("flat", [4, 4], vec![[0, 0, 0, alpha]; 16], Encoding::Srgb));
        for (map, factor, alpha, limit, area) in [
            (Some(flat(255)), 1.0, 1.0, 1.0, 4.0),
            (Some(flat(51)), 1.0, 1.0, 0.2, 4.0),
            (None, 0.7, 0.6, 0.42, 4.0),
            (None, 0.7, 0.6, 0.43, 0.0),
            (Some(flat(255)), 1.0, 1.0, 1.5, 0.0),
            (Some(flat(0)), 0.0, 0.0, 0.0, 4.0),
        ] {
            let mut mesh = quad.clone();
            assert!(cut_by(&CutOut { map, factor, limit }, &mut mesh, &[alpha; 4]));
            assert!((mesh.area() - area).abs() < 1e-6, "{factor} {alpha} {limit}: {}", mesh.area());
        }
    }
}
