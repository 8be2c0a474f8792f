//! Spheres that follow bones on the GPU, against `BoundSet::pose`.

use crate::call::trial;
use brdf::Material;
use glam::{Mat3, Mat4, Quat, Vec3};
use libtest_mimic::Trial;
use lighting::SphereLight;
use lobe_core::{Receiver, SelfShadow, Sphere};
use render_gpu::{Gpu, GpuError, GpuPose, GpuShader, Occlusion};
use scene::{Frame, Shade, ShadingPoints};
use shading::Accuracy;
use sphere_sets::{BoundSet, BuildOptions, Carriers, SphereRig, SphereRigPart, SphereSet};
use visibility_spheres::{BlockerSphere, SphereBlockers};
use wgpu::util::DeviceExt;

pub(crate) fn trials(gpu: Option<&Gpu>) -> Vec<Trial> {
    vec![
        trial("pose_follows_bones_and_morphs", gpu, follows_bones_and_morphs),
        trial("pose_is_finite_whatever_the_bones", gpu, finite_whatever_the_bones),
        trial("pose_refuses_too_few_bones", gpu, too_few_bones),
        trial("pose_moves_shadows", gpu, moves_shadows),
    ]
}

/// A closed tube along x from −2 to 2 on three joints; one morph target makes it swell, another bends it.
fn tube() -> BoundSet {
    let (rings, sides) = (33_u32, 16_u32);
    let mut positions: Vec<Vec3> = (0..rings * sides)
        .map(|i| {
            let turn = (i % sides) as f32 / sides as f32 * core::f32::consts::TAU;
            Vec3::new((i / sides) as f32 / (rings - 1) as f32 * 4.0 - 2.0, 0.3 * turn.cos(), 0.3 * turn.sin())
        })
        .collect();
    let ends = [rings * sides, rings * sides + 1];
    positions.extend([Vec3::new(-2.0, 0.0, 0.0), Vec3::new(2.0, 0.0, 0.0)]);
    let mut triangles = Vec::new();
    for i in 0..sides {
        let next = (i + 1) % sides;
        for low in (0..rings - 1).map(|ring| ring * sides) {
            triangles.push([low + i, low + next, low + sides + i]);
            triangles.push([low + next, low + sides + next, low + sides + i]);
        }
        triangles.push([ends[0], next, i]);
        triangles.push([ends[1], (rings - 1) * sides + i, (rings - 1) * sides + next]);
    }
    let options = BuildOptions { rounds: 1, ..BuildOptions::new(40) };
    let mut set = SphereSet::build(&positions, &triangles, &options).expect("it fits");
    for (i, own) in set.self_shadows.iter_mut().enumerate() {
        *own = SelfShadow { offset: Vec3::new(0.3, -0.4, 0.02 * i as f32), radius: 0.9, distance: 0.1 }.sound();
    }
    let share = |p: &Vec3| [(0.5 - p.x).clamp(0.0, 1.0), (p.x - 0.5).clamp(0.0, 1.0)];
    let weights: Vec<[f32; 4]> = positions
        .iter()
        .map(|p| {
            let [first, last] = share(p);
            [first, 1.0 - first - last, last, 0.0]
        })
        .collect();
    let swell = positions.iter().map(|p| Vec3::new(0.0, p.y, p.z)).collect();
    let bend = positions.iter().map(|p| Vec3::Y * (0.1 * p.x * p.x)).collect();
    let carriers = Carriers {
        joints: &vec![[0, 1, 2, 0]; positions.len()],
        weights: &weights,
        targets: &[swell, bend],
        rest_joints: &[Mat4::IDENTITY; 3],
        rest_morph: &[0.0; 2],
    };
    set.bind(&positions, &triangles, &carriers).expect("it fits")
}

/// Fixed spheres, a tube, one more sphere, the tube once more; sphere i belongs to object i.
struct Crowd {
    set: BoundSet,
    blockers: SphereBlockers,
    own: Vec<SelfShadow>,
    firsts: [usize; 2],
}

impl Crowd {
    fn new() -> Self {
        let set = tube();
        let sphere = |x: f32| Sphere { center: Vec3::new(x, 3.0, -x), radius: 0.25 };
        let rest = &set.rest().spheres;
        let spheres = [&[sphere(0.0), sphere(1.0)], rest.as_slice(), &[sphere(2.0)], rest].concat();
        // As in the sets, whatever radii and distances.
        let still = [SelfShadow::whole(0.0)];
        let fitted = &set.rest().self_shadows;
        let mut own = [&still, &still, fitted.as_slice(), &still, fitted].concat();
        for (i, own) in own.iter_mut().enumerate() {
            *own = SelfShadow { radius: own.radius / (1.0 + i as f32), distance: 0.01 * i as f32, ..*own };
        }
        let objects: Vec<u32> = (0..spheres.len() as u32).collect();
        let blockers = SphereBlockers::new(&spheres, &objects, &[]).with_self_shadows(&own);
        let firsts = [2, 3 + rest.len()];
        Self { set, blockers, own, firsts }
    }

    fn pose(&self, gpu: &Gpu) -> GpuPose {
        let parts = self.firsts.map(|first| SphereRigPart { first, set: &self.set });
        GpuPose::new(gpu, SphereRig::new(&self.blockers, &parts).expect("it fits")).expect("it fits")
    }

    /// The blockers as in the buffer.
    fn packed(&self) -> Vec<BlockerSphere> {
        let mut packed = Vec::new();
        self.blockers.pack(&mut packed);
        packed
    }
}

/// The blockers of a pose, read back from the GPU.
fn posed(
    gpu: &Gpu,
    pose: &mut GpuPose,
    packed: &[BlockerSphere],
    poses: &[(&[Mat4], &[f32])],
) -> Result<Vec<BlockerSphere>, GpuError> {
    let buffer = gpu.device().create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: None,
        contents: bytemuck::cast_slice(packed),
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
    });
    pose.submit(gpu, poses, &buffer.as_entire_buffer_binding())?;
    let read = gpu.device().create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: buffer.size(),
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_buffer_to_buffer(&buffer, 0, &read, 0, buffer.size());
    gpu.queue().submit([encoder.finish()]);
    read.slice(..).map_async(wgpu::MapMode::Read, |result| result.expect("mapped"));
    gpu.device().poll(wgpu::PollType::wait_indefinitely()).expect("done");
    let view = read.slice(..).get_mapped_range().expect("mapped");
    Ok(bytemuck::cast_slice(&view).to_vec())
}

/// Uniform in [−1, 1).
struct Random(u32);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as f32 / 8_388_608.0 - 1.0
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }

    /// Rotated, moved, sheared, sometimes mirrored; flat in the third kind.
    fn joint(&mut self, kind: usize) -> Mat4 {
        let turn = Quat::from_axis_angle((self.vector() + Vec3::splat(1e-3)).normalize(), 3.0 * self.next());
        let scale = match kind % 4 {
            0 => Vec3::ONE,
            1 => Vec3::ONE + 0.5 * self.vector(),
            2 => Vec3::new(1.0, 0.0, 1.0),
            _ => 100.0 * self.vector(),
        };
        let shear = Mat3::from_cols(Vec3::X, Vec3::new(0.3 * self.next(), 1.0, 0.0), Vec3::Z);
        Mat4::from_translation(5.0 * self.vector())
            * Mat4::from_quat(turn)
            * Mat4::from_mat3(shear * Mat3::from_diagonal(scale))
    }
}

fn follows_bones_and_morphs(gpu: &Gpu) {
    let crowd = Crowd::new();
    let (mut pose, packed) = (crowd.pose(gpu), crowd.packed());
    let mut random = Random(1);
    let mut worst = [0.0_f32; 2];
    for kind in 0..16 {
        let bodies: [([Mat4; 3], [f32; 2]); 2] = core::array::from_fn(|_| {
            (core::array::from_fn(|_| random.joint(kind)), [random.next(), if kind < 2 { 0.0 } else { random.next() }])
        });
        let poses = bodies.each_ref().map(|(joints, morph)| (joints.as_slice(), morph.as_slice()));
        let got = posed(gpu, &mut pose, &packed, &poses).expect("it fits");
        let mut want = crowd.blockers.spheres().to_vec();
        let mut turned = crowd.own.clone();
        let mut size = vec![0.0; want.len()];
        for (first, (joints, morph)) in crowd.firsts.iter().zip(poses) {
            let (mut spheres, mut own) = (Vec::new(), Vec::new());
            crowd.set.pose(joints, morph, &mut spheres, &mut own).expect("it fits");
            turned[*first..first + spheres.len()].copy_from_slice(&own);
            want[*first..first + spheres.len()].copy_from_slice(&spheres);
            let largest = |joint: &Mat4| joint.to_cols_array().iter().fold(0.0_f32, |most, x| most.max(x.abs()));
            size[*first..first + spheres.len()].fill(joints.iter().map(largest).fold(0.0, f32::max));
        }
        for (got, before) in got.iter().zip(&packed) {
            let index = got.object as usize;
            let (want, size, own) = (want[index], size[index], crowd.own[index]);
            if size == 0.0 {
                assert_eq!(got, before, "still");
                continue;
            }
            // Four joints of four products each, points up to 2.5 from the origin.
            let far = (Vec3::from(got.center) - want.center).length() / (2.5 * size);
            // Rounding of a volume is relative to the product of the matrix's columns, not to the volume.
            let volume = (got.radius.powi(3) - want.radius.powi(3)).abs() / (size * 0.6).powi(3);
            worst = [worst[0].max(far), worst[1].max(volume)];
            assert!(far < 1e-6 && volume < 1e-6, "{kind} {index}: {got:?} for {want:?}, {far:e} {volume:e}");
            let thick = got.radius - want.radius;
            assert!(kind % 4 > 1 || thick.abs() <= 3e-6 * want.radius, "{kind} {index}: {got:?} for {want:?}");
            let offset = turned[index].offset * got.radius;
            let aside = Vec3::from(got.own_offset).distance(offset);
            assert!(kind % 4 > 1 || aside <= 3e-5 * got.radius, "{kind} {index}: {got:?}, but {offset}");
            assert!(Vec3::from(got.own_offset).length() <= (1.0 - own.radius) * got.radius * 1.000_01);
            assert!((got.own_radius - own.radius * got.radius).abs() <= 1e-6 * got.radius);
            assert!((got.own_distance - own.distance * got.radius).abs() <= 1e-6 * got.radius);
        }
    }
    println!("worst of centre and volume: {worst:?}");
}

fn finite_whatever_the_bones(gpu: &Gpu) {
    let crowd = Crowd::new();
    let (mut pose, packed) = (crowd.pose(gpu), crowd.packed());
    for bad in [f32::NAN, f32::INFINITY, 3e38, 1e-42, 0.0] {
        let joints = [Mat4::from_diagonal(Vec3::splat(bad).extend(1.0)); 3];
        let poses: [(&[Mat4], &[f32]); 2] = [(&joints, &[0.0; 2]), (&[Mat4::IDENTITY; 3], &[f32::MAX, f32::MIN])];
        for sphere in posed(gpu, &mut pose, &packed, &poses).expect("it fits") {
            let values = [sphere.radius, sphere.own_radius, sphere.own_distance];
            assert!(
                values.iter().chain(&sphere.center).chain(&sphere.own_offset).all(|x| x.is_finite()),
                "{bad}: {sphere:?}"
            );
            assert!(sphere.radius >= 0.0);
        }
    }
}

fn too_few_bones(gpu: &Gpu) {
    let crowd = Crowd::new();
    let (mut pose, packed) = (crowd.pose(gpu), crowd.packed());
    let whole: (&[Mat4], &[f32]) = (&[Mat4::IDENTITY; 3], &[0.0; 2]);
    for poses in [vec![], vec![whole], vec![whole, (&whole.0[..2], whole.1)], vec![(whole.0, &whole.1[..1]), whole]] {
        let error = posed(gpu, &mut pose, &packed, &poses).expect_err("refused");
        assert!(matches!(error, GpuError::Bind(_)) && !error.to_string().contains('\n'), "{error}");
    }
    posed(gpu, &mut pose, &packed, &[whole; 2]).expect("it fits");
}

/// The picture is the same whether spheres are posed on the GPU or on the CPU, one pose after another.
fn moves_shadows(gpu: &Gpu) {
    let crowd = Crowd::new();
    let floor = |i: usize| {
        let (x, z) = ((i % 32) as f32 * 0.2 - 3.1, (i / 32) as f32 * 0.2 - 3.1);
        let normal = Vec3::Y;
        Receiver::on_surface(Vec3::new(x, -1.0, z), normal, normal)
    };
    let points = ShadingPoints {
        receivers: (0..1024).map(floor).collect(),
        materials: vec![0; 1024],
        ..ShadingPoints::default()
    };
    let materials = [Material::lambert(Vec3::ONE)];
    let lights = [SphereLight::new(Sphere { center: Vec3::new(1.0, 6.0, 0.5), radius: 0.5 }, Vec3::ONE)];
    let frame = Frame::new(&materials, &lights, Accuracy::new(0.003));
    let shade = |shader: &mut GpuShader| {
        let mut out = vec![Vec3::ZERO; 1024];
        shader.shade(&points, &frame, &mut out).expect("it fits");
        out
    };
    let mut shader = GpuShader::new(gpu, Occlusion::of(&[&crowd.blockers])).expect("it fits");
    let mut pose = crowd.pose(gpu);
    let still = shade(&mut shader);
    let mut random = Random(5);
    for _ in 0..3 {
        let joints: [[Mat4; 3]; 2] = core::array::from_fn(|_| {
            let joint = |random: &mut Random| random.joint(0) * Mat4::from_scale(Vec3::splat(0.8));
            core::array::from_fn(|_| joint(&mut random))
        });
        shader
            .pose(&mut pose, &joints.each_ref().map(|joints| (joints.as_slice(), [0.5, 0.5].as_slice())))
            .expect("it fits");
        let got = shade(&mut shader);

        let mut spheres = crowd.blockers.spheres().to_vec();
        let mut own = crowd.own.clone();
        for (first, joints) in crowd.firsts.iter().zip(&joints) {
            let (mut posed, mut turned) = (Vec::new(), Vec::new());
            crowd.set.pose(joints, &[0.5, 0.5], &mut posed, &mut turned).expect("it fits");
            spheres[*first..first + posed.len()].copy_from_slice(&posed);
            for (own, turned) in own[*first..].iter_mut().zip(turned) {
                own.offset = turned.offset;
            }
        }
        let mut blockers = crowd.blockers.clone().with_self_shadows(&own);
        blockers.update(&spheres);
        let want = shade(&mut GpuShader::new(gpu, Occlusion::of(&[&blockers])).expect("it fits"));
        let apart = |a: &[Vec3], b: &[Vec3]| {
            a.iter().zip(b).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max)
                / a.iter().map(|v| v.max_element()).fold(0.0, f32::max)
        };
        println!("posed: {:.1e} apart, {:.1e} from the rest pose", apart(&want, &got), apart(&want, &still));
        // A sphere moved by a rounding changes samples at its rim.
        assert!(apart(&want, &got) < 1e-3 && apart(&want, &still) > 0.1);
    }
    // `occlude` restores the rest pose.
    shader.occlude(Occlusion::of(&[&crowd.blockers])).expect("it fits");
    assert_eq!(shade(&mut shader), still);
}
