use crate::bands::{Bands, seconds};
use crate::event::tell;
use crate::{
    Backend, CustomStrategy, Event, FrameBlockers, KeptSky, Listener, Plan, RenderError, Settings, Shader, ShaderTask,
};
use glam::Vec3;
use paper::Tables;
use render_cpu::{SceneSilhouettes, ShadeRequest, World};
use scene::{Cancel, Frame, ShadingPoints};
use shading::Accuracy;
use visibility_shadowmap::ShadowMap;
use visibility_spheres::SphereBlockers;

/// A pair of tolerance and depth on the measured curve of least error for a given time.
const fn point(tolerance: f32, depth: u32) -> Accuracy {
    Accuracy { tolerance, depth }
}

/// Settings along that curve, from the fastest to the most accurate: a time budget chooses one of these.
pub const LADDER: [Accuracy; 5] = [point(0.1, 2), point(0.03, 3), point(0.01, 4), point(0.003, 5), point(0.001, 6)];

/// The inputs of shading, except tolerance and depth.
pub(crate) struct Budget<'a> {
    pub(crate) world: &'a World<'a>,
    pub(crate) plan: &'a Plan,
    pub(crate) spheres: Option<&'a SphereBlockers>,
    pub(crate) maps: &'a [ShadowMap],
    pub(crate) silhouettes: &'a SceneSilhouettes,
    pub(crate) custom: &'a [Box<dyn CustomStrategy>],
    pub(crate) settings: &'a Settings,
    pub(crate) tables: Option<&'a Tables>,
    pub(crate) cancel: &'a Cancel,
    /// Seconds of a frame that no setting changes, without finding the visible points.
    pub(crate) fixed: f64,
}

impl Budget<'_> {
    /// Chooses the most accurate setting of the ladder whose frame takes at most `milliseconds`; the fastest one if all take
    /// longer. Settings are timed on strips of the picture, from the fastest on. A frame's time is that of the visible points, of
    /// everything that is rebuilt for it, and of shading.
    pub(crate) async fn choose(
        &self,
        backend: &mut Backend,
        sky: &mut KeptSky,
        milliseconds: f32,
        (bands, frame): (&Bands<'_>, &Frame<'_>),
        listener: &mut Listener<'_>,
    ) -> Result<Accuracy, RenderError> {
        let mut find = 0.0;
        let (points, materials, scale) = seconds(&mut find, || bands.strips());
        let fixed = self.fixed + find * scale;
        let mut chosen: Option<(Accuracy, f64)> = None;
        for accuracy in LADDER {
            let frame = Frame { materials: &materials, accuracy, ..*frame };
            let blockers =
                FrameBlockers::new(self.plan, self.world, self.spheres, self.maps.to_vec(), self.silhouettes, accuracy)
                    .with(self.custom, self.settings)
                    .under(sky, &frame, backend, self.settings.method);
            let twice = Twice { points: &points, frame: &frame, cancel: self.cancel };
            let shading = blockers.shade_async(backend, self.settings.method, self.tables, twice).await?;
            let total = 1e3 * (fixed + shading * scale);
            if total > f64::from(milliseconds) && chosen.is_some() {
                break;
            }
            chosen = Some((accuracy, total));
            if total > f64::from(milliseconds) {
                break;
            }
        }
        let (accuracy, total) = chosen.unwrap_or((LADDER[0], 0.0));
        let is_within = total <= f64::from(milliseconds);
        tell(listener, Event::Chosen { accuracy, milliseconds: total, is_within })?;
        Ok(accuracy)
    }
}

/// Shades twice and takes the shorter time.
struct Twice<'a> {
    points: &'a ShadingPoints,
    frame: &'a Frame<'a>,
    cancel: &'a Cancel,
}

impl ShaderTask for Twice<'_> {
    type Output = f64;

    async fn with<S: Shader>(self, shader: &mut S) -> Result<f64, RenderError> {
        let mut out = vec![Vec3::ZERO; self.points.receivers.len()];
        let request = ShadeRequest { cancel: Some(self.cancel), ..ShadeRequest::default() };
        let (first, _) = shader.shade_with(self.points, self.frame, &mut out, &request).await?;
        let (second, _) = shader.shade_with(self.points, self.frame, &mut out, &request).await?;
        Ok(first.seconds.min(second.seconds))
    }
}
