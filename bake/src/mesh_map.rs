//! Light on the coordinates of one mesh, by a renderer of the program's.

use crate::coverage::Grid;
use crate::layout::{Layout, ONCE};
use crate::light::Irradiance;
use crate::page::{MOST_BYTES, State, bytes};
use crate::target::Target;
use crate::texels::Texels;
use crate::{BakeError, BakeSettings, Listener, Stage};
use core::ops::ControlFlow;
use glam::{Vec2, Vec3};
use renderer::Renderer;
use scene::Mesh;
use scene_files::{GltfDocument, GltfPart};

/// A map of the light on one mesh, in world space, whose first set of coordinates says where it lies on the map: [0, 1]², v downward.
///
/// Texels are means as those of [`Baker`](crate::Baker): over the part of the texel that lies on the surface, without points inside of bodies
/// and without those on the other side of a wall; and both sides of a seam show the same light. The mesh need not be an object of the
/// renderer's scene.
#[derive(Clone, Debug, Default)]
pub struct MeshMap {
    /// The mesh, which is lit on the side from which its triangles go round against the clock.
    pub mesh: Mesh,
    /// Width and height in texels, each 1 to [`BakeSettings::MAX_PAGE`].
    pub size: [u32; 2],
    /// Points along a texel's side, 1 to 8.
    pub samples: u32,
    /// Rings of texels around the surface that repeat its edge, at most 256.
    pub padding: u32,
    /// Whether each light has a map of its own, too; all patches of a sky count as one light.
    pub per_light: bool,
    /// The object of the scene that the mesh is, which does not darken itself by the spheres that stand for it.
    pub object: Option<usize>,
}

/// The light of a [`MeshMap`]: irradiance in W·m⁻² per channel, row by row from the top; 0 where there is no surface near.
#[derive(Clone, Debug, Default)]
pub struct MeshLight {
    /// Of all lights.
    pub light: Vec<Vec3>,
    /// Of each light, with its name: `light0`, `light1` … and `sky`.
    pub single: Vec<(String, Vec<Vec3>)>,
    /// Whether a texel lies on the surface.
    pub covered: Vec<bool>,
    /// Texels that triangles cover more than once: their coordinates overlap, and the light there is a mean.
    pub overlaps: usize,
    /// Triangles that reach beyond the map, and are cut there.
    pub beyond: usize,
}

impl MeshMap {
    /// Bakes. The listener hears [`Stage::Light`].
    ///
    /// # Cost
    /// That of [`Renderer::shade_points`] for `samples`² points a texel on the surface; 20 bytes a texel, and 12 more for each light with
    /// [`per_light`](Self::per_light), at most 4 GB.
    ///
    /// # Errors
    /// [`BakeError::Setting`] for numbers out of their ranges, a mesh without coordinates, and a map that takes too much memory;
    /// [`BakeError::Render`] where the light cannot be computed, or the work is stopped.
    ///
    /// ```
    /// use bake::MeshMap;
    /// use core::ops::ControlFlow;
    /// use glam::{Vec2, Vec3};
    /// use renderer::{Renderer, Settings};
    /// use scene::{Animation, Mesh};
    /// let mut renderer = Renderer::new(scene::builtin(), Animation::default(), Settings::default())?;
    /// let mut mesh = Mesh::quad(Vec3::Y * 3.0, Vec3::X, Vec3::NEG_Z);
    /// mesh.uv_sets = vec![vec![Vec2::Y, Vec2::ONE, Vec2::X, Vec2::ZERO]];
    /// let map = MeshMap { mesh, size: [8, 8], samples: 1, ..MeshMap::default() };
    /// let baked = map.bake(&mut renderer, &mut |_stage, _done| ControlFlow::Continue(()))?;
    /// assert!(baked.covered.iter().all(|is_covered| *is_covered) && baked.light.iter().all(|light| light.x > 0.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn bake(&self, renderer: &mut Renderer, listener: &mut Listener<'_>) -> Result<MeshLight, BakeError> {
        let light = Irradiance::new(renderer.scene(), self.per_light);
        self.validate(1 + light.groups().len())?;
        renderer.prepare(&mut |_| ControlFlow::Continue(()))?;
        light.begin(renderer, self.mesh.positions.iter().copied())?;
        let coordinates = self.coordinates().to_vec();
        let target =
            Target { part: 0, page: 0, set: 0, coordinates, triangles: self.mesh.triangles.clone(), origins: None };
        let layout = Layout { pages: vec![self.size], targets: vec![target] };
        let part = GltfPart { object: self.object, geometry: self.mesh.clone(), ..GltfPart::default() };
        let file = GltfDocument { parts: vec![part], ..GltfDocument::default() };
        let (samples, padding) = (self.samples, self.padding);
        let (file, layout, reliefs) = (&file, &layout, Vec::new());
        let texels = Texels { file, layout, light: &light, is_radiance: false, samples, padding, reliefs };
        let page = texels.page(renderer, &mut (), 0, &mut |done| listener(Stage::Light, done))?;
        let covered = page.states.iter().map(|state| *state == State::Surface).collect();
        let mut layers = page.layers.into_iter();
        let all = layers.next().unwrap_or_default();
        let single = light.groups().iter().map(|group| group.name.clone()).zip(layers).collect();
        let (overlaps, beyond) = self.faults();
        Ok(MeshLight { light: all, single, covered, overlaps, beyond })
    }

    fn coordinates(&self) -> &[Vec2] {
        self.mesh.uv_sets.first().map_or(&[], Vec::as_slice)
    }

    fn validate(&self, values: usize) -> Result<(), BakeError> {
        let fault = |name, value: &dyn core::fmt::Display, expected| {
            Err(BakeError::Setting { name, value: value.to_string(), expected })
        };
        let [width, height] = self.size;
        let size = format!("{width} x {height}");
        if !self.size.iter().all(|side| (1..=BakeSettings::MAX_PAGE).contains(side)) {
            return fault("size", &size, "1 to 16384 texels a side");
        }
        if bytes(&[self.size], values) > MOST_BYTES {
            return fault("size", &size, "a map that takes at most 4 GB");
        }
        if !(1..=8).contains(&self.samples) {
            return fault("points along a texel", &self.samples, "1 to 8");
        }
        if self.padding > 256 {
            return fault("padding", &self.padding, "at most 256 texels");
        }
        let (given, wanted) = (self.coordinates().len(), self.mesh.positions.len());
        if given != wanted || wanted == 0 {
            return fault("number of coordinates", &given, "as many as vertices, which are some");
        }
        if !self.coordinates().iter().all(|uv| uv.is_finite()) {
            return fault("a coordinate", &"not finite", "finite numbers");
        }
        Ok(())
    }

    /// Texels that are covered more than once, and triangles that reach beyond the map.
    fn faults(&self) -> (usize, usize) {
        /// Texels that are counted at once.
        const BAND: u32 = 1 << 22;
        let [width, height] = self.size;
        let corners = |triangle: &[u32; 3]| triangle.map(|i| self.coordinates()[i as usize]);
        let is_inside = |uv: &Vec2| *uv == uv.clamp(Vec2::splat(-1e-4), Vec2::splat(1.0 + 1e-4));
        let beyond = self.mesh.triangles.iter().filter(|triangle| !corners(triangle).iter().all(is_inside)).count();
        let band = (BAND / width).clamp(1, height);
        let mut overlaps = 0;
        for start in (0..height).step_by(band as usize) {
            let rows = [start, (start + band).min(height)];
            let grid = Grid { size: self.size, rows, cells: 1 };
            let mut areas = vec![0.0; width as usize * (rows[1] - rows[0]) as usize];
            for triangle in &self.mesh.triangles {
                grid.pieces(corners(triangle), |piece| {
                    let [x, y] = piece.texel;
                    areas[(y - start) as usize * width as usize + x as usize] += piece.area;
                });
            }
            overlaps += areas.iter().filter(|area| **area > ONCE).count();
        }
        (overlaps, beyond)
    }
}
