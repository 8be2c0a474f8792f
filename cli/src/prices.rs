//! The cost of each strategy on a scene and its difference from the exact picture, measured on a small picture.

use crate::args::{Visibility, name};
use crate::console::say;
use crate::failure::Failure;
use crate::input;
use cosine_lobes::render_cpu::{GBuffer, World};
use cosine_lobes::renderer::{
    Backend, FrameBlockers, KeptSpheres, Method, Plan, RenderError, Shader, ShaderTask, seconds,
};
use cosine_lobes::scene::{Animation, BlockerSet, Frame, Scene, ShadingPoints};
use cosine_lobes::shading::Accuracy;
use cosine_lobes::visibility_shadowmap::ReceiverBounds;
use cosine_lobes::{Picture, RegionError, ShadowErrors};
use glam::Vec3;
use serde_json::{Value, json};

/// Pixels of the small picture, about.
const PIXELS: f32 = 32_768.0;
/// The tolerance of the prices: the default of pictures.
const TOLERANCE: f32 = 0.005;
/// The tolerance of the exact picture.
const EXACT: f32 = 0.001;

/// Each strategy as a whole scene may take it, and the scene's own mixture.
const CHOICES: [Visibility; 5] =
    [Visibility::Scene, Visibility::Silhouettes, Visibility::Spheres, Visibility::ShadowMap, Visibility::Rays];

/// One strategy's price, in seconds, and errors as fractions of the unshadowed radiance.
pub(crate) struct Price {
    /// Once: fitting spheres, building hierarchies of edges.
    prepare: f64,
    /// Each frame in which things move: refits and maps.
    update: f64,
    /// Shading the small picture.
    shade: f64,
    penumbra: RegionError,
}

/// The prices of a scene in a small picture, and how large that was.
pub(crate) struct Prices {
    size: [u32; 2],
    penumbra: usize,
    /// Or why a strategy does not suit the scene.
    all: Vec<(Visibility, Result<Price, Failure>)>,
}

impl Prices {
    /// Measures the scene at its first moment. Fits spheres where it has none yet, and keeps them.
    pub(crate) fn measure(mut scene: Scene, animation: &Animation) -> Result<Self, Failure> {
        let scale = (PIXELS / (scene.width as f32 * scene.height as f32)).sqrt().min(1.0);
        let small = |side: u32| ((side as f32 * scale).round() as u32).max(1);
        (scene.width, scene.height) = (small(scene.width), small(scene.height));
        let mut run = |visibility, tolerance| run(&mut scene, animation, visibility, tolerance);
        let (_, unshadowed) = run(Visibility::None, EXACT)?;
        let (_, exact) = run(Visibility::Silhouettes, EXACT)?;
        let penumbra = |of: &Picture| Ok::<_, Failure>(ShadowErrors::of(of, &exact, &unshadowed)?.penumbra);
        let mut price = |visibility| {
            let (price, picture) = run(visibility, TOLERANCE)?;
            Ok(Price { penumbra: penumbra(&picture)?, ..price })
        };
        let all = CHOICES.map(|visibility| (visibility, price(visibility))).into();
        Ok(Self { size: [scene.width, scene.height], penumbra: penumbra(&exact)?.pixels, all })
    }

    pub(crate) fn print(&self) {
        let [width, height] = self.size;
        say(format_args!(
            "prices     at {width} x {height}, tolerance {TOLERANCE}, {} threads; errors over {} points in penumbra, of unshadowed \
             radiance, from the exact picture",
            rayon::current_num_threads(),
            self.penumbra
        ));
        for (visibility, price) in &self.all {
            let name = name(visibility);
            match price {
                Ok(price) => say(format_args!(
                    "           {name:11} shading {:8.1} ms, once {:8.1} ms, each moving frame {:6.1} ms, error {:.2} % (99th \
                     percentile {:.1} %)",
                    1e3 * price.shade,
                    1e3 * price.prepare,
                    1e3 * price.update,
                    100.0 * price.penumbra.mean,
                    100.0 * price.penumbra.p99
                )),
                Err(reason) => say(format_args!("           {name:11} {}", reason.message())),
            }
        }
    }

    pub(crate) fn json(&self) -> Value {
        let price = |(visibility, price): &(Visibility, Result<Price, Failure>)| match price {
            Ok(p) => json!({
                "visibility": name(visibility),
                "shade_seconds": p.shade,
                "prepare_seconds": p.prepare,
                "update_seconds": p.update,
                "mean_error": p.penumbra.mean,
                "p99_error": p.penumbra.p99,
            }),
            Err(reason) => json!({"visibility": name(visibility), "unsuited": reason.message()}),
        };
        json!({
            "width": self.size[0],
            "height": self.size[1],
            "tolerance": TOLERANCE,
            "penumbra_points": self.penumbra,
            "strategies": self.all.iter().map(price).collect::<Vec<_>>(),
        })
    }
}

/// One strategy's price without its errors, and its radiance at each visible point in a row.
fn run(
    scene: &mut Scene,
    animation: &Animation,
    visibility: Visibility,
    tolerance: f32,
) -> Result<(Price, Picture), Failure> {
    let plan = Plan::new(visibility.strategy(), scene);
    let (mut prepare, mut update) = (0.0, 0.0);
    let spheres = seconds(&mut prepare, || input::make_spheres(scene, animation, &plan, true))?;
    let scene = &*scene;
    let mut silhouettes = seconds(&mut prepare, || plan.silhouettes(scene));
    let (mut set, mut kept) = (BlockerSet::default(), KeptSpheres::default());
    seconds(&mut update, || {
        silhouettes.refit(scene);
        spheres.pose(scene, Some((animation, 0.0)), &mut set)
    })?;
    seconds(&mut update, || kept.update(&set));
    let world = World::new(scene);
    let GBuffer { points, materials, .. } = GBuffer::new(&world, scene.width, scene.height, 1);
    let receivers = ReceiverBounds::of(points.receivers.iter().map(|r| r.position)).filter(|_| plan.wants_maps(scene));
    let maps = match receivers {
        Some(receivers) => seconds(&mut update, || plan.maps(scene, receivers, None, u64::MAX))?.0,
        None => Vec::new(),
    };
    let frame = Frame::new(&materials, &scene.lights, Accuracy::new(tolerance));
    let blockers = FrameBlockers::new(&plan, &world, kept.get(), maps, &silhouettes, frame.accuracy);
    let (shade, radiance) =
        blockers.shade(&mut Backend::Cpu, Method::Moments, None, Shot { points: &points, frame: &frame })?;
    let picture = Picture::new(radiance.len(), 1, radiance);
    Ok((Price { prepare, update, shade, penumbra: RegionError::default() }, picture))
}

/// A picture of visible points that are there.
struct Shot<'a> {
    points: &'a ShadingPoints,
    frame: &'a Frame<'a>,
}

impl ShaderTask for Shot<'_> {
    type Output = (f64, Vec<Vec3>);

    /// The quickest of three.
    async fn with<S: Shader>(self, shader: &mut S) -> Result<Self::Output, RenderError> {
        let mut radiance = vec![Vec3::ZERO; self.points.receivers.len()];
        let mut quickest = f64::INFINITY;
        for _ in 0..3 {
            quickest = quickest.min(shader.shade(self.points, self.frame, &mut radiance).map_err(Into::into)?.seconds);
        }
        Ok((quickest, radiance))
    }
}
