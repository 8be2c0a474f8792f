//! Tolerance and depth for a frame time, by measuring.

use crate::console::note;
use crate::device::{Backend, Shader};
use crate::failure::Failure;
use crate::picture::{Bands, seconds};
use crate::quality::LADDER;
use crate::strategy::{Occlusion, Plan, Work};
use cosine_lobes::lobe_core::paper::Tables;
use cosine_lobes::render_cpu::{SceneSilhouettes, World};
use cosine_lobes::scene::{Frame, ShadingPoints};
use cosine_lobes::visibility_shadowmap::ShadowMap;
use cosine_lobes::visibility_spheres::SphereBlockers;
use glam::Vec3;

/// What the picture is shaded with, but for tolerance and depth.
pub(crate) struct Budget<'a> {
    pub(crate) world: &'a World<'a>,
    pub(crate) plan: &'a Plan,
    pub(crate) spheres: Option<&'a SphereBlockers>,
    pub(crate) maps: &'a [ShadowMap],
    pub(crate) silhouettes: &'a SceneSilhouettes,
    pub(crate) tables: Option<&'a Tables>,
    /// Seconds of a frame that no setting changes, but for finding the visible points.
    pub(crate) fixed: f64,
    pub(crate) quiet: bool,
}

impl Budget<'_> {
    /// The best setting of the ladder whose frame takes at most so many milliseconds, measured on strips of the picture
    /// from the fastest setting on; the fastest where all take longer. A frame is the visible points, what is made
    /// anew for it, and shading.
    pub(crate) fn choose(
        &self,
        backend: &mut Backend,
        milliseconds: f32,
        bands: &Bands<'_>,
        frame: &Frame<'_>,
    ) -> Result<(f32, u32), Failure> {
        let mut find = 0.0;
        let (points, scale) = seconds(&mut find, || bands.strips());
        let fixed = self.fixed + find * scale;
        let mut chosen: Option<((f32, u32), f64)> = None;
        for (tolerance, depth) in LADDER {
            let frame = Frame { tolerance, depth, ..*frame };
            let maps = self.maps.to_vec();
            let occlusion = Occlusion::new(self.plan, self.world, self.spheres, maps, self.silhouettes, tolerance);
            let shading = occlusion.shade(backend, depth, self.tables, Twice { points: &points, frame: &frame })?;
            let total = 1e3 * (fixed + shading * scale);
            if total > f64::from(milliseconds) && chosen.is_some() {
                break;
            }
            chosen = Some(((tolerance, depth), total));
            if total > f64::from(milliseconds) {
                break;
            }
        }
        let (setting, total) = chosen.unwrap_or((LADDER[0], 0.0));
        if !self.quiet {
            let (percent, depth) = (100.0 * setting.0, setting.1);
            let verdict = if total > f64::from(milliseconds) { ", no setting is faster" } else { "" };
            note(format_args!(
                "lobes: --time-budget {milliseconds}: tolerance {percent} %, depth {depth}, about {total:.1} ms a frame{verdict}"
            ));
        }
        Ok(setting)
    }
}

/// Shading, the faster of two times.
struct Twice<'a> {
    points: &'a ShadingPoints,
    frame: &'a Frame<'a>,
}

impl Work for Twice<'_> {
    type Output = f64;

    fn with<S: Shader>(self, shader: &mut S) -> Result<f64, Failure> {
        let mut out = vec![Vec3::ZERO; self.points.receivers.len()];
        let mut once = || shader.shade(self.points, self.frame, &mut out).map(|stats| stats.seconds);
        Ok(once()?.min(once()?))
    }
}
