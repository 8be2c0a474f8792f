//! Drags the first light of a scene at 640 × 360 for some seconds, as a pointer does that moves sixty times a second, and prints how many
//! pictures a second were seen, how long after the event each came, and in how many pixels.
//!
//! ```sh
//! cargo run --release -p cosine-lobes-session --features files --example drag -- scenes/bunny.toml
//! ```

use glam::{Mat4, Quat};
use renderer::{Renderer, Settings};
use scene::{Animation, Stopwatch};
use session::{Edit, Session};
use std::collections::BTreeMap;
use std::error::Error;
use std::time::Duration;

const SECONDS: f64 = 6.0;
const STEP: Duration = Duration::from_micros(16_667);

fn main() -> Result<(), Box<dyn Error>> {
    let watch = Stopwatch::start();
    let (mut scene, animation) = match std::env::args().nth(1) {
        Some(path) => {
            let (scene, animation, _) = scene_files::load_animated(path)?;
            (scene, animation)
        }
        None => (scene::builtin(), Animation::default()),
    };
    (scene.width, scene.height) = (640, 360);
    let renderer = Renderer::new(scene, animation, Settings::default())?;
    let opened = watch.seconds();
    let (light, first) = renderer.lights().next().map(|(handle, light)| (handle, light.clone())).ok_or("no light")?;
    let session = Session::new(renderer);
    let watch = Stopwatch::start();
    while session.picture().radiance.is_empty() {
        std::thread::sleep(Duration::from_millis(1));
    }
    let seen = watch.seconds();
    let whole = session.finished();
    println!("opened in {:.0} ms; first picture after {:.0} ms more", 1e3 * opened, 1e3 * seen);
    println!("whole picture in {:.1} ms, after {:.0} ms more", 1e3 * whole.seconds, 1e3 * watch.seconds());

    let watch = Stopwatch::start();
    let mut known = whole;
    let (mut latencies, mut divisors) = (Vec::new(), BTreeMap::<(u32, bool), usize>::new());
    let mut step = 0;
    while watch.seconds() < SECONDS {
        let turn = Mat4::from_quat(Quat::from_rotation_y(0.4 * (0.05 * f64::from(step)).sin() as f32));
        session.edit(Edit::Light(light, first.moved(turn).into()));
        step += 1;
        let next = Stopwatch::start();
        while next.seconds() < STEP.as_secs_f64() {
            std::thread::sleep(Duration::from_micros(500));
            let picture = session.picture();
            if !std::sync::Arc::ptr_eq(&picture, &known) {
                if picture.latency > 0.0 {
                    latencies.push(picture.latency);
                    *divisors.entry((picture.divisor, picture.is_sum)).or_default() += 1;
                }
                known = picture;
            }
        }
    }
    let seconds = watch.seconds();
    latencies.sort_by(f64::total_cmp);
    let at = |part: usize| latencies.get(latencies.len() * part / 100).map_or(f64::NAN, |latency| 1e3 * latency);
    println!("{:.1} pictures a second of {:.1} events", latencies.len() as f64 / seconds, f64::from(step) / seconds);
    println!("event to picture: median {:.1} ms, 95 % within {:.1} ms", at(50), at(95));
    for ((divisor, is_sum), count) in divisors {
        let sum = if is_sum { ", with what is kept of the other lights" } else { "" };
        println!("{count} pictures at 1/{divisor} of the sides{sum}");
    }
    Ok(())
}
