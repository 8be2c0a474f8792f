use crate::binding::{Access, Slot};
use crate::kernel::Kernel;
use crate::memory::Memory;
use crate::module::Text;
use crate::{Gpu, GpuError};
use glam::Mat4;
use sphere_sets::SphereRig;
use wgpu::BufferUsages;

/// Blocker spheres that follow bones on the GPU: a pose uploads its bones, 48 bytes a joint, and no spheres.
///
/// Gives the same spheres as [`BoundSet::pose`](sphere_sets::BoundSet::pose) to within f32's rounding. Used by
/// [`GpuShader::pose`](crate::GpuShader::pose), or alone on a caller's buffer.
///
/// The spheres keep the order that they had when the blockers were made. A pose that moves neighbours far apart only costs time;
/// blockers made in that pose restore the speed.
///
/// ```no_run
/// # fn of(gpu: &render_gpu::Gpu, shader: &mut render_gpu::GpuShader, blockers: &visibility_spheres::SphereBlockers,
/// # body: &sphere_sets::BoundSet, frames: &[Vec<glam::Mat4>]) -> Result<(), render_gpu::GpuError> {
/// use sphere_sets::{SphereRig, SphereRigPart};
/// let mut pose = render_gpu::GpuPose::new(gpu, SphereRig::new(blockers, &[SphereRigPart { first: 0, set: body }])?)?;
/// for joints in frames {
///     shader.pose(&mut pose, &[(joints, &[])])?;
///     // shader.shade(…)
/// }
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct GpuPose {
    rig: SphereRig,
    kernel: Kernel,
    words: Memory,
    bones: Memory,
    floats: Vec<f32>,
}

/// Threads of a workgroup.
const GROUP: u32 = 64;

impl GpuPose {
    /// The buffer of [`SphereBlockers`](visibility_spheres::SphereBlockers) that poses are written to.
    pub(crate) const BUFFER: &str = "spheres";

    /// Compiles the kernel and uploads the data that never changes.
    ///
    /// # Errors
    /// [`GpuError`].
    pub fn new(gpu: &Gpu, rig: SphereRig) -> Result<Self, GpuError> {
        let bindings = [(Slot::Spheres, Access::Write), (Slot::Rig, Access::Read), (Slot::Bones, Access::Read)];
        let storage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let (needed, limits) = (rig.spheres().div_ceil(GROUP).into(), gpu.device().limits());
        let allowed = limits.max_compute_workgroups_per_dimension.into();
        if needed > allowed {
            return Err(GpuError::Limits { what: "spheres that follow bones", needed, allowed });
        }
        let mut words = Memory::new("rig", storage);
        words.hold(gpu, bytemuck::cast_slice(rig.words()))?;
        Ok(Self {
            rig,
            kernel: Kernel::new(gpu, &Text::new("pose_spheres", &[&sphere_sets::wgsl::POSE], &[], &bindings))?,
            words,
            bones: Memory::new("bones", storage),
            floats: Vec::new(),
        })
    }

    /// Writes the spheres of a pose to a storage buffer that holds the blockers as
    /// [`SphereBlockers::pack`](visibility_spheres::SphereBlockers::pack) wrote them. `poses` has, for each part of the rig, its
    /// joints (from bind space to the world) and the weights of its morph targets. Submits to the queue and does not wait.
    ///
    /// The spheres are finite for all bones; a sphere that could not be gets radius 0.
    ///
    /// # Errors
    /// [`GpuError::Bind`] for fewer joints or weights than the rig needs; the buffer is then unchanged.
    pub fn submit(
        &mut self,
        gpu: &Gpu,
        poses: &[(&[Mat4], &[f32])],
        spheres: &wgpu::BufferBinding<'_>,
    ) -> Result<(), GpuError> {
        self.rig.bones(poses, &mut self.floats)?;
        if self.rig.spheres() == 0 {
            return Ok(());
        }
        self.bones.hold(gpu, bytemuck::cast_slice(&self.floats))?;
        gpu.scoped("the commands of a pose", || {
            let group = self.kernel.bind(gpu, |slot| match slot {
                Slot::Spheres => Some(spheres.clone()),
                Slot::Rig => self.words.whole(),
                Slot::Bones => self.bones.whole(),
                _ => None,
            });
            self.kernel.submit(gpu, &group, [self.rig.spheres().div_ceil(GROUP), 1]);
        })
    }
}
