use core::sync::atomic::{AtomicBool, Ordering};
use glam::Vec3;
use ray_tracing::GBuffer;
use reference::{Geometry, Reference, ReferenceJob};
use renderer::{LayerSet, PixelSamples, RenderError, Renderer, Settings};
use scene::{Animation, BlockerSet, Scene};
use shading::Accuracy;
use std::sync::mpsc::{self, Receiver};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

/// Tolerances that are measured, from the fastest to the most accurate.
const TOLERANCES: [f32; 7] = [0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0005];
/// The longer side of the pictures that are measured.
const SIDE: u32 = 192;
/// Samples of their reference.
const SAMPLES: u32 = 512;
/// Times that each is shaded; the shortest counts.
const REPEAT: u32 = 3;

/// One accuracy on a scene: its time and its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TradePoint {
    /// The tolerance that was requested.
    pub tolerance: f32,
    /// Seconds of shading the whole picture, in proportion to its pixels.
    pub seconds: f64,
    /// Mean error of pixels in penumbra, as a part of their unshadowed radiance.
    pub error: f64,
}

/// Error against time of a scene's own pictures, measured on a thread of its own beside the session.
///
/// Pictures of at most 192 pixels a side are compared with a reference of 512 samples, whose noise bounds the errors from below.
/// Dropped, it ends.
#[derive(Debug)]
pub struct Trade {
    points: Arc<Mutex<Vec<TradePoint>>>,
    ended: Receiver<Result<(), RenderError>>,
    stop: Arc<AtomicBool>,
}

impl Trade {
    /// Begins to measure a scene as settings draw it, on the CPU; `told` is called on the other thread with each point.
    #[must_use]
    pub fn new(scene: Scene, animation: Animation, settings: Settings, told: impl Fn() + Send + 'static) -> Self {
        let points: Arc<Mutex<Vec<TradePoint>>> = Arc::default();
        let stop = Arc::new(AtomicBool::new(false));
        let (end, ended) = mpsc::channel();
        let (theirs, stops) = (Arc::clone(&points), Arc::clone(&stop));
        thread::spawn(move || {
            let done = measure(scene, animation, settings, &stops, &mut |point| {
                theirs.lock().unwrap_or_else(PoisonError::into_inner).push(point);
                told();
            });
            // Who no longer waits needs no end.
            let _ = end.send(done);
            told();
        });
        Self { points, ended, stop }
    }

    /// The points so far, from the fastest.
    #[must_use]
    pub fn points(&self) -> Vec<TradePoint> {
        self.points.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// How it ended, once.
    ///
    /// # Errors
    /// Those of pictures.
    pub fn end(&self) -> Option<Result<(), RenderError>> {
        self.ended.try_recv().ok()
    }
}

impl Drop for Trade {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

fn measure(
    mut scene: Scene,
    animation: Animation,
    settings: Settings,
    stop: &AtomicBool,
    found: &mut dyn FnMut(TradePoint),
) -> Result<(), RenderError> {
    let whole = f64::from(scene.width) * f64::from(scene.height);
    let scale = (SIDE as f32 / scene.width.max(scene.height) as f32).min(1.0);
    (scene.width, scene.height) = small(&scene, scale);
    let more = whole / (f64::from(scene.width) * f64::from(scene.height));
    let settings = Settings {
        device: renderer::Device::Cpu,
        layers: LayerSet::NONE,
        samples: PixelSamples::Uniform(1),
        repeat: REPEAT,
        time_budget: None,
        ..settings
    };
    let mut renderer = Renderer::new(scene, animation, settings)?;
    let truth = truth(&mut renderer, stop);
    for tolerance in TOLERANCES {
        if stop.load(Ordering::Relaxed) {
            break;
        }
        renderer.set_accuracy(Accuracy::new(tolerance))?;
        let image = renderer.render()?;
        let seconds = image.stats.shading.iter().map(|stats| stats.seconds).fold(f64::INFINITY, f64::min);
        found(TradePoint { tolerance, seconds: more * seconds, error: error_of(&image.radiance, &truth) });
    }
    Ok(())
}

fn small(scene: &Scene, scale: f32) -> (u32, u32) {
    let side = |side: u32| ((side as f32 * scale).round() as u32).max(1);
    (side(scene.width), side(scene.height))
}

/// The picture by shadow rays on the true surfaces, with blockers and without.
fn truth(renderer: &mut Renderer, stop: &AtomicBool) -> [Vec<Vec3>; 2] {
    let (width, height, background) = {
        let scene = renderer.scene();
        (scene.width, scene.height, scene.background)
    };
    renderer.with_world(|world| {
        let gbuffer = GBuffer::new(world, width, height, 1);
        let blockers = BlockerSet::default();
        let job = ReferenceJob { world, gbuffer: &gbuffer, blockers: &blockers, geometry: Geometry::Mesh, seed: 7 };
        let mut reference = Reference::new(job);
        reference.advance(SAMPLES, stop, &|_| {});
        let estimate = reference.estimate();
        [estimate.radiance, estimate.unshadowed].map(|mut radiance| {
            gbuffer.add_emission(&mut radiance);
            gbuffer.picture(&radiance, background)
        })
    })
}

/// `mean |A − B|/U` over the pixels in penumbra, those with `B/U` between 1 % and 99 %: the picture A, the reference B, the same without
/// blockers U, each summed over its channels. 0 where there is no penumbra.
fn error_of(picture: &[Vec3], [reference, unshadowed]: &[Vec<Vec3>; 2]) -> f64 {
    let sum = |v: &Vec3| f64::from(v.element_sum());
    let pixels = picture.iter().zip(reference).zip(unshadowed).map(|((a, b), u)| (sum(a), sum(b), sum(u)));
    let penumbra = pixels.filter(|(_, b, u)| *u > 0.0 && (0.01..0.99).contains(&(b / u)));
    let (total, count) =
        penumbra.fold((0.0, 0_u32), |(total, count), (a, b, u)| (total + (a - b).abs() / u, count + 1));
    total / f64::from(count.max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finer_tolerances_have_smaller_errors() {
        let scene = Scene { width: 96, height: 54, ..scene::builtin() };
        let (tell, told) = mpsc::channel();
        let trade = Trade::new(scene, Animation::default(), Settings::default(), move || {
            let _ = tell.send(());
        });
        for _ in told {}
        trade.end().expect("an end").expect("pictures");
        let points = trade.points();
        println!("{points:?}");
        assert_eq!(points.iter().map(|point| point.tolerance).collect::<Vec<_>>(), TOLERANCES);
        assert!(points.iter().all(|point| point.seconds > 0.0 && point.error.is_finite()));
        let (first, last) = (points[0], points[points.len() - 1]);
        assert!(last.error < first.error && last.error < 0.01, "{first:?} {last:?}");
    }

    #[test]
    fn errors_by_hand() {
        let of = |values: [f32; 2]| values.map(Vec3::splat).to_vec();
        // Half of the first pixel's light is hidden, none of the second one's.
        let truth = [of([1.0, 3.0]), of([2.0, 3.0])];
        assert_eq!(error_of(&of([1.5, 2.0]), &truth), 0.25);
        assert_eq!(error_of(&of([1.0, 1.0]), &[of([0.0, 1.0]), of([0.0, 1.0])]), 0.0);
    }
}
