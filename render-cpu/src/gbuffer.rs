use crate::World;
use core::ops::{Add, Mul, Range};
use glam::{Vec2, Vec3};
use lobe_core::Receiver;
use rayon::prelude::*;
use scene::{Camera, ShadingPoints};

/// Side of the pixel tiles in whose order points are listed.
pub const TILE: u32 = 8;

/// What the camera sees: the visible points of every pixel.
///
/// Points come tile by tile ([`TILE`]² pixels, left to right, top to bottom), so that neighbours in the list are
/// neighbours in space. A camera ray that meets nothing leaves no point.
#[derive(Clone, Debug, Default)]
pub struct GBuffer {
    /// Image width in pixels.
    pub width: u32,
    /// Image height in pixels.
    pub height: u32,
    /// Camera rays a pixel.
    pub samples: u32,
    /// The visible points.
    pub points: ShadingPoints,
    /// For each point the number of its pixel, `row·width + column`.
    pub pixels: Vec<u32>,
    /// For each point the distance from the plane of the eye, along the view direction.
    pub depths: Vec<f32>,
}

/// The points of one tile.
#[derive(Default)]
struct Tile {
    receivers: Vec<Receiver>,
    materials: Vec<u32>,
    pixels: Vec<u32>,
    depths: Vec<f32>,
}

impl GBuffer {
    /// Shoots `samples` rays (at least 1) through every pixel of a `width`×`height` image: one through its centre,
    /// several through a Hammersley set that is the same in all pixels.
    ///
    /// # Panics
    /// When the image has more than 2³² pixels.
    #[must_use]
    pub fn new(world: &World<'_>, width: u32, height: u32, samples: u32) -> Self {
        Self::rows(world, width, height, samples, 0..height)
    }

    /// The same for some rows of the image only, as a picture of its own: large images in bands need little memory.
    ///
    /// # Panics
    /// As [`window`](Self::window).
    #[must_use]
    pub fn rows(world: &World<'_>, width: u32, height: u32, samples: u32, rows: Range<u32>) -> Self {
        Self::window(world, width, height, samples, 0..width, rows)
    }

    /// The same for a window of the image only, as a picture of its own: work that is split over processes.
    ///
    /// Every point is to the bit what it is in the whole image. Points come in the tiles of the whole image, cut at the
    /// window's edges.
    ///
    /// # Panics
    /// When the window has more than 2³² pixels or is not inside the image.
    #[must_use]
    pub fn window(
        world: &World<'_>,
        width: u32,
        height: u32,
        samples: u32,
        columns: Range<u32>,
        rows: Range<u32>,
    ) -> Self {
        let inside = |r: &Range<u32>, size: u32| r.start <= r.end && r.end <= size;
        assert!(inside(&columns, width) && inside(&rows, height), "window outside the image");
        let (own_width, own_height) = (columns.end - columns.start, rows.end - rows.start);
        assert!(u64::from(own_width) * u64::from(own_height) <= 1 << 32, "too many pixels");
        let samples = samples.max(1);
        let offsets = sub_pixels(samples);
        let rays = Rays::new(&world.scene().camera, width, height);
        // Tiles of the whole image that the window touches.
        let across = columns.start / TILE..columns.end.div_ceil(TILE).max(columns.start / TILE);
        let down = rows.start / TILE..rows.end.div_ceil(TILE).max(rows.start / TILE);
        let tiles: Vec<Tile> = (0..across.len() * down.len())
            .into_par_iter()
            .with_min_len(8)
            .map(|t| {
                let left = (across.start + (t % across.len()) as u32) * TILE;
                let top = (down.start + (t / across.len()) as u32) * TILE;
                let mut tile = Tile::default();
                for y in top.max(rows.start)..(top + TILE).min(rows.end) {
                    for x in left.max(columns.start)..(left + TILE).min(columns.end) {
                        for offset in &offsets {
                            let direction = rays.direction(x as f32 + offset.x, y as f32 + offset.y);
                            let pixel = (y - rows.start) * own_width + (x - columns.start);
                            tile.shoot(world, &rays, direction, pixel);
                        }
                    }
                }
                tile
            })
            .collect();

        let count = tiles.iter().map(|t| t.pixels.len()).sum();
        let mut all = Self { width: own_width, height: own_height, samples, ..Self::default() };
        all.points.receivers.reserve_exact(count);
        all.points.materials.reserve_exact(count);
        all.pixels.reserve_exact(count);
        all.depths.reserve_exact(count);
        for tile in &tiles {
            all.points.receivers.extend_from_slice(&tile.receivers);
            all.points.materials.extend_from_slice(&tile.materials);
            all.pixels.extend_from_slice(&tile.pixels);
            all.depths.extend_from_slice(&tile.depths);
        }
        all
    }

    /// Number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.pixels.len()
    }

    /// True when the camera sees nothing.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.pixels.is_empty()
    }

    /// The picture of one value a point: the mean over each pixel's rays (a box filter), `background` where a ray met
    /// nothing.
    ///
    /// # Panics
    /// When there is not one value a point.
    #[must_use]
    pub fn resolve<T>(&self, values: &[T], background: T) -> Vec<T>
    where
        T: Copy + Default + Add<Output = T> + Mul<f32, Output = T>,
    {
        assert_eq!(values.len(), self.len(), "one value a point");
        let count = self.width as usize * self.height as usize;
        let (mut sums, mut hits) = (vec![T::default(); count], vec![0u32; count]);
        for (pixel, value) in self.pixels.iter().zip(values) {
            sums[*pixel as usize] = sums[*pixel as usize] + *value;
            hits[*pixel as usize] += 1;
        }
        let share = 1.0 / self.samples.max(1) as f32;
        let mean = |(sum, hits): (T, u32)| {
            if hits == self.samples { sum * share } else { (sum + background * ((self.samples - hits) as f32)) * share }
        };
        sums.into_iter().zip(hits).map(mean).collect()
    }
}

impl Tile {
    fn shoot(&mut self, world: &World<'_>, rays: &Rays, direction: Vec3, pixel: u32) {
        let Some(hit) = world.hit(rays.eye, direction) else { return };
        let (normal, face) = (hit.normal, hit.face_normal);
        // The view from the rounded position, not the ray's: consistent with what shading sees.
        let view = (rays.eye - hit.position).try_normalize().unwrap_or(-direction);
        self.receivers.push(Receiver { position: hit.position, normal, face, view, object: hit.object });
        self.materials.push(world.scene().objects[hit.object as usize].material as u32);
        self.pixels.push(pixel);
        self.depths.push((hit.position - rays.eye).dot(rays.forward));
    }
}

/// Where in a pixel its `n` rays pass: Hammersley points, moved so that their mean is the centre.
fn sub_pixels(n: u32) -> Vec<Vec2> {
    let radical_inverse = |i: u32| f64::from(i.reverse_bits()) / 4_294_967_296.0;
    let shift = 0.5 - (0..n).map(radical_inverse).sum::<f64>() / f64::from(n);
    let x = |i: u32| (f64::from(i) + 0.5) / f64::from(n);
    (0..n).map(|i| Vec2::new(x(i) as f32, (radical_inverse(i) + shift) as f32)).collect()
}

/// [`Camera::direction`] with everything that is constant over the picture computed once.
struct Rays {
    eye: Vec3,
    forward: Vec3,
    /// Direction through the corner (0, 0) of the image and its change a pixel to the right and down.
    corner: Vec3,
    right: Vec3,
    down: Vec3,
}

impl Rays {
    fn new(camera: &Camera, width: u32, height: u32) -> Self {
        let forward = (camera.target - camera.eye).normalize();
        let right = forward.cross(camera.up).normalize();
        let up = right.cross(forward);
        let half = (0.5 * camera.vertical_fov).tan();
        let (w, h) = (width as f32, height as f32);
        Self {
            eye: camera.eye,
            forward,
            corner: forward - right * (w / h * half) + up * half,
            right: right * (2.0 * half / h),
            down: up * (-2.0 * half / h),
        }
    }

    fn direction(&self, x: f32, y: f32) -> Vec3 {
        (self.corner + self.right * x + self.down * y).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CpuShader;
    use crate::test_scenes::{floor_and_ball, material};
    use lighting::MaskVisibility;
    use scene::{Frame, Mesh, Object, Proxy, Scene, Shade, Shape};
    use visibility_spheres::SphereBlockers;

    #[test]
    fn rays_are_the_camera_s() {
        let camera = Camera { eye: Vec3::new(1.0, 2.0, 3.0), target: Vec3::X, up: Vec3::Y, vertical_fov: 0.7 };
        let rays = Rays::new(&camera, 640, 360);
        for (x, y) in [(0.5, 0.5), (320.0, 180.0), (639.5, 0.5), (17.25, 359.5)] {
            // Both are a handful of f32 operations on numbers near 1.
            assert!((rays.direction(x, y) - camera.direction(x, y, 640, 360)).length() < 1e-6);
        }
    }

    #[test]
    fn one_sample_is_the_centre_and_many_are_balanced() {
        assert_eq!(sub_pixels(1), [Vec2::splat(0.5)]);
        for n in [2u32, 3, 4, 5, 16, 33, 64] {
            let points = sub_pixels(n);
            let mean = points.iter().sum::<Vec2>() / n as f32;
            assert!((mean - 0.5).abs().max_element() < 1e-6, "{n}: {mean}");
            assert!(points.iter().all(|p| p.min_element() > 0.0 && p.max_element() < 1.0));
        }
    }

    /// Positions lie on the surfaces to f32 rounding, normals face the viewer, pixels are in tile order.
    #[test]
    fn points_lie_on_surfaces() {
        let scene = floor_and_ball();
        let world = World::new(&scene);
        let g = GBuffer::new(&world, 50, 30, 1);
        assert!(g.len() > 500 && g.len() < 1500, "{}", g.len());
        let (mut floor, mut ball) = (0, 0);
        for r in &g.points.receivers {
            assert!(r.view.dot(r.normal) > 0.0 && r.view.dot(r.face) > 0.0);
            if r.object == 0 {
                floor += 1;
                assert!(r.position.y.abs() < 1e-7, "{}", r.position);
                assert_eq!(r.normal, Vec3::Y);
            } else {
                ball += 1;
                let d = (r.position.as_dvec3() - glam::DVec3::Y).length();
                // Rounding of three coordinates up to 2: half of 1.2e-7 each.
                assert!((d - 0.5).abs() < 1.1e-7, "{d}");
            }
        }
        assert!(floor > 100 && ball > 20, "{floor} {ball}");
        let tile = |p: u32| (p / 50 / TILE, p % 50 / TILE);
        assert!(g.pixels.is_sorted_by_key(|p| tile(*p)));
    }

    #[test]
    fn bands_make_up_the_picture() {
        let scene = floor_and_ball();
        let world = World::new(&scene);
        let whole = GBuffer::new(&world, 40, 30, 2);
        let whole = whole.resolve(&whole.depths, 0.0);
        let bands = [0..16, 16..24, 24..24, 24..30].map(|rows| {
            let g = GBuffer::rows(&world, 40, 30, 2, rows);
            g.resolve(&g.depths, 0.0)
        });
        assert_eq!(bands.concat(), whole);
    }

    /// Windows that cut tiles hold the bits of the whole image, whatever groups of points they make.
    #[test]
    fn windows_make_up_the_picture() {
        let scene = floor_and_ball();
        let world = World::new(&scene);
        let set = crate::blockers(&scene, &mut |_, _| core::ops::ControlFlow::Continue(())).unwrap();
        let blockers = SphereBlockers::new(&set.spheres, &set.objects, &set.self_distances);
        let mut shader = CpuShader::new(MaskVisibility::new(blockers.with_self_shadows(&set.self_shadows), 5));
        let frame =
            Frame { materials: &scene.materials, lights: &scene.lights, tolerance: 0.003, depth: 5, threshold: 0.0 };
        let mut shade = |g: &GBuffer| {
            let mut out = vec![Vec3::ZERO; g.len()];
            shader.shade(&g.points, &frame, &mut out).unwrap();
            g.resolve(&out, Vec3::splat(0.1))
        };
        let whole = shade(&GBuffer::new(&world, 90, 70, 2));
        for (columns, rows) in [(0..33, 0..70), (33..90, 0..21), (33..90, 21..22), (33..90, 22..70), (5..5, 3..9)] {
            let g = GBuffer::window(&world, 90, 70, 2, columns.clone(), rows.clone());
            let part = shade(&g);
            let cut = rows.flat_map(|y| columns.clone().map(move |x| y * 90 + x)).map(|i| whole[i as usize]);
            assert_eq!(part, cut.collect::<Vec<_>>());
        }
    }

    /// A grid of triangles in a plane has no cracks: every ray through it hits.
    #[test]
    fn shared_edges_have_no_cracks() {
        let n = 16u32;
        let at = |i: u32| i as f32 / n as f32 * 2.0 - 1.0;
        let positions = (0..=n).flat_map(|y| (0..=n).map(move |x| Vec3::new(at(x), at(y), 0.0))).collect();
        let quads = (0..n).flat_map(|y| (0..n).map(move |x| y * (n + 1) + x));
        let triangles = quads.flat_map(|i| [[i, i + 1, i + n + 2], [i, i + n + 2, i + n + 1]]).collect();
        let mesh = Mesh { positions, normals: Vec::new(), triangles };
        let grid = Object {
            name: "grid".into(),
            shape: Shape::Mesh(mesh),
            material: 0,
            proxy: Proxy::None,
            visible: true,
            strategy: None,
        };
        // Exactly in front: pixel centres and corners fall on edges and diagonals.
        let camera = Camera { eye: Vec3::Z * 4.0, target: Vec3::ZERO, up: Vec3::Y, vertical_fov: 0.4 };
        let scene = Scene { camera, objects: vec![grid], materials: vec![material()], ..floor_and_ball() };
        let world = World::new(&scene);
        for (size, samples) in [(255, 1), (256, 1), (128, 16)] {
            assert_eq!(GBuffer::new(&world, size, size, samples).len() as u32, size * size * samples);
        }
    }

    #[test]
    fn resolving_mixes_the_background_in() {
        let scene = floor_and_ball();
        let g = GBuffer::new(&World::new(&scene), 20, 10, 16);
        let picture = g.resolve(&vec![1.0; g.len()], 0.0);
        let total: f32 = picture.iter().sum();
        assert!((total - g.len() as f32 / 16.0).abs() < 1e-3);
        assert!(picture.contains(&0.0) && picture.contains(&1.0));
        assert!(picture.iter().any(|v| *v > 0.0 && *v < 1.0));
    }

    #[test]
    fn an_empty_world_has_no_points() {
        let scene = Scene { objects: Vec::new(), ..floor_and_ball() };
        let g = GBuffer::new(&World::new(&scene), 9, 9, 1);
        assert!(g.is_empty());
        assert_eq!(g.resolve(&[], Vec3::ONE), vec![Vec3::ONE; 81]);
    }
}
