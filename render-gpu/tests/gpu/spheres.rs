//! Sphere blockers in WGSL against the same in Rust: lists, classes, masks.

use crate::call::trial;
use glam::{Vec2, Vec3};
use libtest_mimic::Trial;
use lobe_core::oracle::Random;
use lobe_core::wgsl::{NO_OUTLINE, Piece, join};
use lobe_core::{Cone, NO_OBJECT, Receiver, SelfShadow, Sphere};
use render_gpu::wgsl::FRAME;
use render_gpu::{Gpu, GpuReceiver};
use shading::gpu::GPU_SHAPE;
use shading::{Accuracy, Coverage, LightId, Shaft, VisibilityQuery};
use visibility_mask::{Blockers, Edges, Fineness, UnitSquare, hooks, wgsl as masks};
use visibility_spheres::{BlockerSphere, LIST_WORDS, SphereBlockers, wgsl};
use wgpu::util::DeviceExt;

const TILE: usize = 64;
/// `LIST_FULL` of `packed.wgsl`.
const LIST_FULL: u32 = 1;

pub(crate) fn trials(gpu: Option<&Gpu>) -> Vec<Trial> {
    vec![
        trial("lists_of_spheres", gpu, lists),
        trial("classes_by_spheres", gpu, classes),
        trial("masks_of_distant_spheres", gpu, |gpu| spheres_on_masks(gpu, Place::Between, 81, 1e-6)),
        trial("masks_of_near_spheres", gpu, |gpu| spheres_on_masks(gpu, Place::Near, 82, 1e-4)),
        trial("masks_of_spheres_in_the_light", gpu, |gpu| spheres_on_masks(gpu, Place::Light, 83, 1e-4)),
        trial("edges_of_spheres", gpu, edges),
    ]
}

/// Runs a kernel with storage buffers of these words and a uniform as binding 0; returns the contents of `out`.
fn dispatch(gpu: &Gpu, text: &str, buffers: &[(u32, &[u32])], out: u32, groups: usize) -> Vec<u32> {
    use wgpu::BufferUsages as Usage;
    let device = gpu.device();
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(text.into()),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point: None,
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    });
    let filled = |binding: u32, words: &[u32]| {
        let usage = if binding == 0 { Usage::UNIFORM } else { Usage::STORAGE | Usage::COPY_SRC };
        let contents = bytemuck::cast_slice(words);
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
    };
    let held: Vec<_> = buffers.iter().map(|(binding, words)| (*binding, filled(*binding, words))).collect();
    let entries: Vec<_> = held
        .iter()
        .map(|(binding, buffer)| wgpu::BindGroupEntry { binding: *binding, resource: buffer.as_entire_binding() })
        .collect();
    let layout = &pipeline.get_bind_group_layout(0);
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries });
    let (_, source) = held.iter().find(|(binding, _)| *binding == out).expect("bound");
    let read = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: source.size(),
        usage: Usage::MAP_READ | Usage::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(groups as u32, 1, 1);
    }
    encoder.copy_buffer_to_buffer(source, 0, &read, 0, source.size());
    gpu.queue().submit([encoder.finish()]);
    read.slice(..).map_async(wgpu::MapMode::Read, |result| result.expect("mapped"));
    device.poll(wgpu::PollType::wait_indefinitely()).expect("done");
    let view = read.slice(..).get_mapped_range().expect("mapped");
    bytemuck::cast_slice(&view).to_vec()
}

/// The place of most spheres.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    /// Between the receivers and the light, away from both.
    Between,
    /// Around the receivers: receivers may be inside spheres, and spheres beside or behind them.
    Near,
    /// Around the light.
    Light,
    /// All of these.
    Everywhere,
}

/// Receivers, a light and spheres.
struct Setup {
    light: Sphere,
    receivers: Vec<Receiver>,
    spheres: Vec<Sphere>,
    objects: Vec<u32>,
    self_shadows: Vec<SelfShadow>,
}

impl Setup {
    /// Seen from the origin, the light lies along a random axis; tiles are small and near the origin.
    fn new(random: &mut Random, tiles: usize, count: usize, place: Place) -> Self {
        let toward = random.axis();
        let distance = random.log_uniform(2.0, 20.0);
        // Thousands of spheres that each cover a part of a wide light take a software device minutes.
        let widest = if count > 1000 && place == Place::Between { 0.2 } else { 0.9 };
        let theta = random.log_uniform(0.003, widest);
        let center = (toward * distance).as_vec3();
        let light = Sphere { center, radius: (distance * theta.sin()) as f32 };
        let mut receivers = Vec::new();
        for _ in 0..tiles {
            let middle = random.axis() * random.between(0.0, 0.3);
            let spread = random.log_uniform(0.01, 0.2);
            let tilt = random.between(0.0, 1.6);
            let normal = random.axis_at(toward, tilt).as_vec3().normalize();
            for _ in 0..TILE {
                let position = (middle + random.axis() * spread * random.uniform()).as_vec3();
                let object = [0, 1, 2, NO_OBJECT][(random.bits() % 4) as usize];
                receivers.push(Receiver::on_surface(position, normal, normal).on_object(object));
            }
        }
        let mut spheres = Vec::new();
        let mut objects = Vec::new();
        let mut self_shadows = Vec::new();
        // The same number meets the shafts, whatever the count.
        let size = 0.7 / (count as f64).cbrt().max(1.0);
        for _ in 0..count {
            let place = if place == Place::Everywhere {
                [Place::Between, Place::Near, Place::Light][(random.bits() % 3) as usize]
            } else {
                place
            };
            let radius = f64::from(light.radius);
            let (center, radius) = match place {
                Place::Near => {
                    // Spheres whose rims cross the light.
                    let r = random.log_uniform(0.3, 3.0);
                    let d = r * random.between(0.98, 1.6);
                    let rim = (r / d).min(1.0).asin() + theta * random.between(-1.0, 1.5);
                    (random.axis_at(toward, rim) * d, r)
                }
                Place::Light => {
                    let r = radius * random.log_uniform(0.1, 2.0);
                    (toward * distance + random.axis() * ((r + radius) * random.between(0.3, 1.2)), r)
                }
                _ => {
                    let along = random.between(0.25, 0.75);
                    let r = (along * radius + 0.2) * random.log_uniform(0.1, 1.0) * size + 0.01;
                    let aside = random.axis() * ((along * radius + 0.5) * random.between(0.0, 1.5));
                    (toward * (distance * along) + aside, r)
                }
            };
            spheres.push(Sphere { center: center.as_vec3(), radius: radius as f32 });
            objects.push((random.bits() % 3) as u32);
            let [radius, distance] = [random.between(0.7, 1.0) as f32, random.between(0.0, 0.5) as f32];
            let offset = (random.axis() * random.between(0.0, 0.3)).as_vec3();
            self_shadows.push(SelfShadow { offset, radius, distance }.sound());
        }
        Self { light, receivers, spheres, objects, self_shadows }
    }

    fn blockers(&self) -> SphereBlockers {
        SphereBlockers::new(&self.spheres, &self.objects, &[]).with_self_shadows(&self.self_shadows)
    }

    /// The same setup with slightly different radii.
    fn scaled(&self, spheres: f32, light: f32) -> Self {
        let scale = |sphere: &Sphere, by: f32| Sphere { radius: sphere.radius * by, ..*sphere };
        Self {
            light: scale(&self.light, light),
            spheres: self.spheres.iter().map(|sphere| scale(sphere, spheres)).collect(),
            receivers: self.receivers.clone(),
            objects: self.objects.clone(),
            self_shadows: self.self_shadows.clone(),
        }
    }

    /// The shaft from the receivers of a tile to the light.
    fn shaft(&self, tile: usize) -> Shaft {
        let receivers = &self.receivers[tile * TILE..(tile + 1) * TILE];
        let center = receivers.iter().map(|at| at.position).sum::<Vec3>() / receivers.len() as f32;
        let radius = receivers.iter().map(|at| at.position.distance(center)).fold(0.0, f32::max) * 1.000_01;
        Shaft::new(Sphere { center, radius }, self.light, LightId(0))
    }

    /// The coverage of each receiver.
    fn coverage(&self) -> Vec<Coverage> {
        let blockers = self.blockers();
        let mut scratch = blockers.scratch();
        let mut all = Vec::new();
        for (tile, receivers) in self.receivers.chunks(TILE).enumerate() {
            blockers.enter(&self.shaft(tile), &mut scratch);
            all.extend(receivers.iter().map(|at| {
                let cone = Cone::of_sphere(at.position, self.light);
                blockers.select(&VisibilityQuery::new(at, LightId(0), &cone, Accuracy::new(0.003)), &mut scratch)
            }));
        }
        all
    }
}

/// The buffers as in kernels that shade.
const UNIFORM: &str = "@group(0) @binding(0) var<uniform> frame: Frame;";
const BUFFERS: &str = "@group(0) @binding(6) var<storage, read> spheres: array<BlockerSphere>;
    @group(0) @binding(7) var<storage, read> spheres_lists: array<u32>;
    @group(0) @binding(11) var<storage, read> spheres_bounds: array<vec4f>;";

/// The words that the kernels read for a setup.
struct Words {
    frame: Vec<u32>,
    points: Vec<u32>,
    spheres: Vec<u32>,
    bounds: Vec<u32>,
    lists: Vec<u32>,
}

impl Words {
    /// The kernels compute bounds and lists.
    fn new(gpu: &Gpu, setup: &Setup) -> Self {
        let mut packed: Vec<BlockerSphere> = Vec::new();
        setup.blockers().pack(&mut packed);
        let blocks = packed.len().div_ceil(32);
        let [x, y, z] = setup.light.center.to_array().map(f32::to_bits);
        let count = setup.receivers.len() as u32;
        let light = [x, y, z, setup.light.radius.to_bits()];
        let mut frame = [light, [0; 4], [0, count, 0, 0], [0; 4]].concat();
        // The light's shape has no parameters.
        frame.resize(16 + 4 * GPU_SHAPE, 0);
        let points: Vec<_> = setup.receivers.iter().map(|at| GpuReceiver::new(at, 0)).collect();
        let points = bytemuck::cast_slice(&points).to_vec();
        let spheres: Vec<u32> = bytemuck::cast_slice(&packed).to_vec();
        let empty = vec![0; 4 * blocks];
        let buffers: [(u32, &[u32]); 2] = [(6, &spheres), (11, &empty)];
        let declared = BUFFERS.replace("read> spheres_bounds", "read_write> spheres_bounds");
        let bounds = dispatch(gpu, &(join(&[&wgsl::BOUNDS]) + &declared), &buffers, 11, blocks.div_ceil(64));
        let tiles = setup.receivers.len().div_ceil(TILE);
        let empty = vec![7; tiles * LIST_WORDS];
        let declared = BUFFERS.replace("read> spheres_lists", "read_write> spheres_lists");
        let of_points = "@group(0) @binding(1) var<storage, read> points: array<Receiver>;";
        let text = join(&[&FRAME, &wgsl::CULL]) + UNIFORM + &declared + of_points;
        let buffers: [(u32, &[u32]); 5] = [(0, &frame), (1, &points), (6, &spheres), (7, &empty), (11, &bounds)];
        let lists = dispatch(gpu, &text, &buffers, 7, tiles);
        Self { frame, points, spheres, bounds, lists }
    }

    /// Marks all lists as overflown.
    fn overflow(&mut self) {
        for list in self.lists.chunks_mut(LIST_WORDS) {
            list.fill(0);
            list[1] = LIST_FULL;
        }
    }

    /// The class of each point.
    fn classes(&self, gpu: &Gpu) -> Vec<u32> {
        const MAIN: &str = "
            @group(0) @binding(1) var<storage, read> points: array<Receiver>;
            @group(0) @binding(2) var<storage, read_write> out: array<u32>;
            @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3u) {
                if (id.x < frame.point_count) {
                    let cone = cone_of_sphere(points[id.x].position, frame.light);
                    out[id.x] = spheres_coverage(id.x / 64u, points[id.x], cone);
                }
            }";
        let text = join(&[&FRAME, &NO_OUTLINE, &wgsl::SPHERES]) + UNIFORM + BUFFERS + MAIN;
        let out = vec![9; self.points.len() / 16];
        let buffers: [(u32, &[u32]); 6] =
            [(0, &self.frame), (1, &self.points), (2, &out), (6, &self.spheres), (7, &self.lists), (11, &self.bounds)];
        dispatch(gpu, &text, &buffers, 2, out.len().div_ceil(64))
    }

    /// Rows of the masks of some points through some windows, and the sums of edges.
    fn masks(&self, gpu: &Gpu, depth: u32, coarse: bool, cases: &[(usize, UnitSquare)]) -> Vec<u32> {
        const MAIN: &str = "
            @group(0) @binding(1) var<storage, read> points: array<Receiver>;
            @group(0) @binding(2) var<storage, read> cases: array<f32>;
            @group(0) @binding(3) var<storage, read_write> out: array<u32>;
            @compute @workgroup_size(LANES) fn main(
                @builtin(workgroup_id) id: vec3u,
                @builtin(local_invocation_index) lane: u32,
            ) {
                let first = id.x * 12u;
                let right = vec3f(cases[first], cases[first + 1u], cases[first + 2u]);
                let up = vec3f(cases[first + 3u], cases[first + 4u], cases[first + 5u]);
                let point = u32(cases[first + 11u]);
                let at = points[point];
                let light = cone_of_sphere(at.position, frame.light);
                let center = vec2f(cases[first + 6u], cases[first + 7u]);
                let half = vec2f(cases[first + 8u], cases[first + 9u]);
                let square = UnitSquare(right, up, light.axis, center, half, cases[first + 10u]);
                let mask = mask_reset(square, lane, at.normal);
                spheres_splat(lane, point / 64u, at, light, mask);
                let begin = id.x * (8u * SIDE + 2u);
                if (lane < SIDE) {
                    for (var k = 0u; k < WIDTH / 32u; k++) {
                        out[begin + 8u * lane + k] = row_samples(lit, k);
                    }
                }
                let sum = total(lane, spheres_edges(lane, point / 64u, at, light, light));
                if (lane == 0u) {
                    out[begin + 8u * SIDE] = bitcast<u32>(sum.x);
                    out[begin + 8u * SIDE + 1u] = bitcast<u32>(sum.y);
                }
            }";
        let header = masks::header(depth, Fineness { coarse, ..Fineness::FINE });
        let pieces: [&'static Piece; 4] = [&FRAME, &masks::ROUND, &masks::TOTAL, &wgsl::SPHERES_SPLAT];
        let text = join(&pieces) + UNIFORM + &header + BUFFERS + MAIN;
        let squares: Vec<u32> = (cases.iter())
            .flat_map(|(point, square)| {
                let (right, up) = (square.right.to_array(), square.up.to_array());
                let UnitSquare { center, half, disc, .. } = square;
                let rest = [center.x, center.y, half.x, half.y, *disc, *point as f32];
                [right.as_slice(), &up, &rest].concat().into_iter().map(f32::to_bits)
            })
            .collect();
        let out = vec![0; cases.len() * ((8 << depth) + 2)];
        let buffers: [(u32, &[u32]); 7] = [
            (0, &self.frame),
            (1, &self.points),
            (2, &squares),
            (3, &out),
            (6, &self.spheres),
            (7, &self.lists),
            (11, &self.bounds),
        ];
        dispatch(gpu, &text, &buffers, 3, cases.len())
    }
}

fn class(coverage: Coverage) -> u32 {
    match coverage {
        Coverage::Lit => 0,
        Coverage::Partial => 1,
        Coverage::Dark => 2,
    }
}

/// Lists are ascending, short, without duplicates; contain all spheres that a receiver can meet; and are full if there are too
/// many.
fn lists(gpu: &Gpu) {
    let mut random = Random::new(80);
    let (mut listed, mut all, mut full) = (0, 0, 0);
    // Around the points, around lights that reach nearly to the receivers, and around both.
    let lights = [None, None, None, None, Some(0.0), Some(0.98), Some(0.999), Some(1.3)];
    for (count, of_distance) in [1, 33, 400, 5000, 33, 33, 33, 33].into_iter().zip(lights) {
        let mut setup = Setup::new(&mut random, 6, count, Place::Everywhere);
        if let Some(share) = of_distance {
            setup.light.radius = share * setup.light.center.length();
        }
        let words = Words::new(gpu, &setup);
        let mut packed = Vec::new();
        setup.blockers().pack(&mut packed);
        assert_eq!(packed.len(), count);
        for (tile, list) in words.lists.chunks(LIST_WORDS).enumerate() {
            let (found, flags) = (list[0] as usize, list[1]);
            assert!(found <= LIST_WORDS - 2 && flags < 4);
            if flags != 0 {
                full += 1;
                continue;
            }
            let indices = &list[2..2 + found];
            assert!(indices.windows(2).all(|pair| pair[0] < pair[1]), "{count} spheres: not ascending");
            assert!(indices.iter().all(|index| (*index as usize) < count));
            (listed, all) = (listed + found, all + count);
            // Segments from receivers to the light's surface, in double precision.
            for _ in 0..400 {
                let at = &setup.receivers[tile * TILE + (random.bits() % 64) as usize];
                let (from, light) = (at.position.as_dvec3(), setup.light.center.as_dvec3());
                let to = light + random.axis() * f64::from(setup.light.radius);
                for (index, sphere) in packed.iter().enumerate() {
                    let center = Vec3::from(sphere.center).as_dvec3();
                    let t = ((center - from).dot(to - from) / (to - from).length_squared()).clamp(0.0, 1.0);
                    if (from + (to - from) * t).distance(center) < f64::from(sphere.radius) {
                        assert!(indices.binary_search(&(index as u32)).is_ok(), "sphere {index} of {count} is missing");
                    }
                }
            }
        }
    }
    println!("{listed} of {all} spheres listed, {full} tiles full or dark");
    assert!(listed > 0 && full > 0);
}

/// Coverage with and without a list; it differs from Rust's only if a ten-thousandth of a per cent decides.
fn classes(gpu: &Gpu) {
    let mut random = Random::new(84);
    let (mut seen, mut close, mut points) = ([0; 3], 0, 0);
    for count in [1, 1, 1, 1, 3, 3, 3, 3, 33, 33, 200, 5000] {
        for place in [Place::Between, Place::Near, Place::Light, Place::Everywhere] {
            let setup = Setup::new(&mut random, 4, count, place);
            let mut words = Words::new(gpu, &setup);
            let got = words.classes(gpu);
            words.overflow();
            assert_eq!(got, words.classes(gpu), "{count} spheres {place:?}: with lists and without");
            let want = setup.coverage();
            let mut near = None;
            for (point, (got, want)) in got.iter().zip(&want).enumerate() {
                seen[class(*want) as usize] += 1;
                points += 1;
                if *got != class(*want) {
                    close += 1;
                    let near = near.get_or_insert_with(|| {
                        [(1.000_01, 1.0), (0.999_99, 1.0), (1.0, 1.000_01), (1.0, 0.999_99)]
                            .map(|(spheres, light)| setup.scaled(spheres, light).coverage())
                    });
                    let decided = near.iter().all(|other| other[point] == *want);
                    assert!(!decided, "{count} spheres {place:?}, point {point}: {got}, not {want:?}");
                }
            }
        }
    }
    println!("{seen:?} lit, partial and dark, {close} on the limit");
    assert!(seen.iter().all(|class| *class > 500), "{seen:?}");
    assert!(close * 1000 < points, "{close} of {points} differ");
}

/// A window for each partial point: the whole light, or a part of it.
fn windows(setup: &Setup, random: &mut Random) -> Vec<(usize, UnitSquare)> {
    let blockers = setup.blockers();
    let mut scratch = blockers.scratch();
    let mut all = Vec::new();
    for (point, at) in setup.receivers.iter().enumerate() {
        let cone = Cone::of_sphere(at.position, setup.light);
        let query = VisibilityQuery::new(at, LightId(0), &cone, Accuracy::new(0.003));
        if cone.one_minus_cos > 1.0 || blockers.select(&query, &mut scratch) != Coverage::Partial {
            continue;
        }
        let mut square = UnitSquare::facing(&cone, random.axis().as_vec3());
        if point % 3 == 0 {
            let mut part = || random.log_uniform(0.01, 0.7) as f32;
            square.half = square.disc * Vec2::new(part(), part());
            let mut aside = || random.between(-1.0, 1.0) as f32;
            square.center = (square.disc - square.half) * Vec2::new(aside(), aside());
        }
        all.push((point, square));
    }
    all
}

/// Bits of the masks; a fraction `share` of all may differ.
fn spheres_on_masks(gpu: &Gpu, place: Place, seed: u64, share: f64) {
    let counts = if place == Place::Near { [1; 12] } else { [1, 2, 3, 5, 1, 2, 3, 5, 33, 33, 700, 5000] };
    let mut random = Random::new(seed);
    let (mut bits, mut differing, mut masks, mut worst) = (0, 0, 0, 0);
    for (number, count) in counts.into_iter().enumerate() {
        let setup = Setup::new(&mut random, 3, count, place);
        let mut words = Words::new(gpu, &setup);
        let cases = windows(&setup, &mut random);
        if cases.is_empty() {
            continue;
        }
        let (depth, coarse) = ([3, 4, 5, 6][number % 4], number % 3 == 1);
        let got = words.masks(gpu, depth, coarse, &cases);
        if number % 2 == 0 {
            words.overflow();
            // Except for the sum of edges, which is summed in another order.
            let rows =
                |all: &[u32]| all.chunks((8 << depth) + 2).flat_map(|of| of[..8 << depth].to_vec()).collect::<Vec<_>>();
            let again = words.masks(gpu, depth, coarse, &cases);
            assert!(rows(&got) == rows(&again), "{count} spheres: with lists and without");
        }
        let side = 1 << depth;
        let blockers = setup.blockers();
        let mut scratch = blockers.scratch();
        for ((point, square), got) in cases.iter().zip(got.chunks(8 * side + 2)) {
            let at = &setup.receivers[*point];
            let cone = Cone::of_sphere(at.position, setup.light);
            let query = VisibilityQuery::new(at, LightId(0), &cone, Accuracy::new(0.003));
            blockers.select(&query, &mut scratch);
            let mut mask = hooks::mask(square, depth, coarse, at.normal);
            blockers.splat(&query, &mut scratch, &mut mask);
            let mut wrong = 0;
            for j in 0..side {
                let words = hooks::row(&mask, j).map(|word| [word as u32, (word >> 32) as u32]);
                let row = &got[8 * j..8 * j + 8];
                wrong += row.iter().zip(words.as_flattened()).map(|(a, b)| (a ^ b).count_ones()).sum::<u32>();
            }
            masks += 1;
            bits += side * if coarse { 64 } else { 256 };
            differing += wrong;
            if wrong > worst {
                worst = wrong;
                println!("{wrong} bits of depth {depth}, {count} spheres, light {:.2e}", square.disc);
            }
        }
    }
    println!("{place:?}: {differing} of {bits} bits differ in {masks} masks");
    assert!(masks > 300, "{masks} masks");
    assert!(f64::from(differing) <= share * bits as f64, "{differing} of {bits} bits differ");
}

/// The direction that a mask is turned to, from the sum of edges.
fn edges(gpu: &Gpu) {
    let mut random = Random::new(85);
    let (mut count, mut worst) = (0, 0.0_f32);
    for spheres in [1, 1, 2, 4, 33, 900] {
        let setup = Setup::new(&mut random, 3, spheres, Place::Between);
        let words = Words::new(gpu, &setup);
        let cases = windows(&setup, &mut random);
        if cases.is_empty() {
            continue;
        }
        let got = words.masks(gpu, 3, true, &cases);
        let blockers = setup.blockers();
        let mut scratch = blockers.scratch();
        for ((point, _), got) in cases.iter().zip(got.chunks(8 * 8 + 2)) {
            let at = &setup.receivers[*point];
            let cone = Cone::of_sphere(at.position, setup.light);
            let query = VisibilityQuery::new(at, LightId(0), &cone, Accuracy::new(0.003));
            blockers.select(&query, &mut scratch);
            let across = blockers.across(&query, &scratch);
            // The same sum as one edge: its length is that of the sum, and its direction half the sum's angle.
            let sum = Vec2::new(f32::from_bits(got[64]), f32::from_bits(got[65])) + Vec2::new(1e-3, 0.0);
            let half = Vec2::from_angle(0.5 * sum.to_angle());
            let (right, up) = frame(&cone);
            let turn = right * half.x + up * half.y;
            // Where edges nearly cancel, rounding decides.
            if sum.length() > 0.01 {
                count += 1;
                worst = worst.max(1.0 - turn.dot(across).abs());
            }
        }
    }
    println!("{count} turns, cosines differ by {worst:.1e}");
    assert!(count > 100 && worst < 1e-5, "{count} turns, {worst:e}");
}

/// The frame in which edges are summed, from Rust: a single edge gives its own direction.
fn frame(cone: &Cone) -> (Vec3, Vec3) {
    let across = Edges::new(cone).across();
    (across, across.cross(cone.axis))
}
