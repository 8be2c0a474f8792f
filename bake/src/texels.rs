//! Light on the texels of pages.

use crate::BakeError;
use crate::coverage::Grid;
use crate::layout::Layout;
use crate::light::Irradiance;
use crate::look::{PartMaterial, Relief, texel_sides};
use crate::mixing::{self, Spot};
use crate::page::{Page, State, THIN};
use crate::seams;
use crate::steps::{Steps, step};
use crate::target::Face;
use core::f32::consts::FRAC_1_PI;
use core::ops::ControlFlow;
use glam::{DVec3, Mat2, Vec3};
use lobe_core::Receiver;
use renderer::{RenderError, Renderer};
use scene_files::{GltfDocument, GltfPart};

/// Points of a band of rows, about.
const BAND: u64 = 1 << 19;

/// A point of a texel.
struct Point {
    texel: u32,
    target: u32,
    triangle: u32,
    at: [f64; 2],
    area: f64,
}

/// The surfaces and the light that are baked, and the settings of texels.
pub(crate) struct Texels<'a> {
    pub(crate) file: &'a GltfDocument,
    pub(crate) layout: &'a Layout,
    pub(crate) light: &'a Irradiance,
    /// Whether the first list of a page is radiance, reflected and emitted, instead of irradiance.
    pub(crate) is_radiance: bool,
    pub(crate) samples: u32,
    pub(crate) padding: u32,
    /// The normal maps of the layout's surfaces, as far as they have any; may be left empty.
    pub(crate) reliefs: Vec<Option<Relief>>,
}

impl Texels<'_> {
    /// All pages. `heard` hears the fraction that is done.
    pub(crate) fn pages(
        &self,
        renderer: &mut Renderer,
        steps: &mut dyn Steps,
        heard: &mut dyn FnMut(f32) -> ControlFlow<()>,
    ) -> Result<Vec<Page>, BakeError> {
        let texels = |size: &[u32; 2]| f64::from(size[1]) * f64::from(size[0]);
        let all: f64 = self.layout.pages.iter().map(texels).sum();
        let mut before = 0.0;
        let mut pages = Vec::new();
        for (number, size) in self.layout.pages.iter().enumerate() {
            let own = texels(size);
            let mut page =
                self.page(renderer, steps, number, &mut |done| heard(((before + own * f64::from(done)) / all) as f32))?;
            page.fill();
            pages.push(page);
            before += own;
        }
        Ok(pages)
    }

    /// A page whose texels have values as far as `padding` from a surface. `heard` hears the fraction that is done.
    pub(crate) fn page(
        &self,
        renderer: &mut Renderer,
        steps: &mut dyn Steps,
        number: usize,
        heard: &mut dyn FnMut(f32) -> ControlFlow<()>,
    ) -> Result<Page, BakeError> {
        let size = self.layout.pages[number];
        let mut page = Page::new(size, 1 + self.light.groups().len());
        let cells = u64::from(self.samples * self.samples) * u64::from(size[0]);
        let band = (BAND / cells).clamp(1, u64::from(size[1])) as u32;
        for start in (0..size[1]).step_by(band as usize) {
            let rows = [start, (start + band).min(size[1])];
            let values = step(steps, || {
                self.band(renderer, &mut page, number, rows)?;
                Ok(page.rows(rows))
            })?;
            page.set_rows(rows, &values);
            if heard(rows[1] as f32 / size[1] as f32).is_break() {
                return Err(RenderError::Cancelled.into());
            }
        }
        page.dilate(self.padding);
        let surfaces = self.layout.targets.iter().filter(|target| target.page == number);
        // Radiance is more than the sum of its lights' irradiance.
        let is_sum = !self.is_radiance && page.layers.len() > 1;
        let surfaces: Vec<_> = surfaces.map(|target| (&self.file.parts[target.part], target)).collect();
        let scene = renderer.scene();
        let material = |part: &GltfPart| part.object.map(|object| scene.objects[object].material);
        let are_alike = |a: &GltfPart, b: &GltfPart| !self.is_radiance || material(a) == material(b);
        seams::close(&mut page, &surfaces, &are_alike, is_sum);
        Ok(page)
    }

    /// The points of a band of rows, texel by texel.
    fn points(&self, page: usize, grid: Grid) -> Vec<Point> {
        let mut points = Vec::new();
        let height = grid.size[1] as f32;
        let [first, end] = grid.rows.map(|row| row as f32 / height);
        let beyond = 1.0 / height;
        for (number, target) in self.layout.targets.iter().enumerate().filter(|(_, target)| target.page == page) {
            let part = &self.file.parts[target.part];
            for triangle in 0..target.triangles.len() {
                let corners = target.corners(triangle);
                let v = corners.map(|uv| uv.y);
                let (low, high) = (v[0].min(v[1]).min(v[2]), v[0].max(v[1]).max(v[2]));
                if low > end + beyond || high < first - beyond || Face::new(part, triangle).is_none() {
                    continue;
                }
                grid.pieces(corners, |piece| {
                    let texel = piece.texel[1] * grid.size[0] + piece.texel[0];
                    let (target, triangle) = (number as u32, triangle as u32);
                    points.push(Point { texel, target, triangle, at: piece.at, area: piece.area });
                });
            }
        }
        points.sort_by_key(|point| point.texel);
        points
    }

    fn face(&self, point: &Point) -> Face<'_> {
        let part = &self.file.parts[self.layout.targets[point.target as usize].part];
        Face::new(part, point.triangle as usize).expect("points are on triangles with an area")
    }

    /// The receiver at a point, with the normal of its map.
    fn receiver(&self, size: [u32; 2], point: &Point) -> Receiver {
        let face = self.face(point);
        let flat = face.receiver(point.at);
        let Some(Some(relief)) = self.reliefs.get(point.target as usize) else { return flat };
        Receiver { normal: relief.normal(&face, point.at, self.sides(size, point), &flat), ..flat }
    }

    /// The sides of a texel's cell, in the weights of the second and third corner of a point's triangle.
    fn sides(&self, size: [u32; 2], point: &Point) -> Mat2 {
        let corners = self.layout.targets[point.target as usize].corners(point.triangle as usize);
        texel_sides(corners, size) * (1.0 / self.samples as f32)
    }

    fn band(&self, renderer: &mut Renderer, page: &mut Page, number: usize, rows: [u32; 2]) -> Result<(), BakeError> {
        let points = self.points(number, Grid { size: page.size, rows, cells: self.samples });
        let receivers: Vec<Receiver> = points.iter().map(|point| self.receiver(page.size, point)).collect();
        let mut values = self.light.of(renderer, &receivers)?;
        let spot = |(at, point): (Receiver, &Point)| {
            let part = self.layout.targets[point.target as usize].part;
            Spot { at, weight: point.area, is_back: self.file.parts[part].is_back }
        };
        let weighted: Vec<Spot> = receivers.into_iter().zip(&points).map(spot).collect();
        let same = |a: &Point, b: &Point| a.texel == b.texel;
        let ends: Vec<usize> = points
            .chunk_by(same)
            .scan(0, |end, texel| {
                *end += texel.len();
                Some(*end)
            })
            .collect();
        let weights = mixing::weights(renderer, &weighted, &values[0], &ends);
        if self.is_radiance {
            self.reflect(renderer, page.size, &points, &mut values[0]);
        }
        let mut first = 0;
        for (weights, &end) in weights.iter().zip(&ends) {
            let texel = points[first].texel as usize;
            page.states[texel] = State::Buried;
            if let Some(weights) = weights {
                let all: f64 = weights.iter().sum();
                page.states[texel] = if all < THIN { State::Thin } else { State::Surface };
                for (layer, values) in page.layers.iter_mut().zip(&values) {
                    let each = values[first..end].iter().zip(weights);
                    let sum: DVec3 = each.map(|(value, weight)| value.as_dvec3() * *weight).sum();
                    layer[texel] = (sum / all).as_vec3();
                }
            }
            first = end;
        }
        Ok(())
    }

    /// Makes irradiance the radiance that surfaces reflect diffusely and emit.
    fn reflect(&self, renderer: &Renderer, size: [u32; 2], points: &[Point], values: &mut [Vec3]) {
        let part_materials: Vec<PartMaterial<'_>> = self
            .layout
            .targets
            .iter()
            .map(|target| PartMaterial::new(renderer.scene(), &self.file.parts[target.part]))
            .collect();
        for (point, value) in points.iter().zip(values) {
            let texel = self.sides(size, point);
            let [albedo, emission] = part_materials[point.target as usize].at(&self.face(point), point.at, texel);
            *value = albedo * *value * FRAC_1_PI + emission;
        }
    }
}
