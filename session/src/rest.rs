use crate::Picture;
use glam::Vec3;
use lighting::Light;
use renderer::{Backend, Event, LightHandle, RenderError, Renderer};
use std::ops::ControlFlow;

/// Seconds in which the part of a light is to be there when it begins to move.
const MOST: f64 = 0.25;
/// A light whose part takes more of the picture's time is no use.
const LESS: f64 = 0.6;
/// The divisor at which the time of a part is tried.
const TRIAL: u32 = 8;

/// The picture without one light, which moves: what is seen next is this and the part of that light.
#[derive(Debug)]
pub(crate) struct Rest {
    /// The light.
    pub(crate) light: LightHandle,
    /// By how much its sides are shorter than those of the whole picture.
    pub(crate) divisor: u32,
    radiance: Vec<Vec3>,
    /// The number of changes up to which nothing but this light has changed.
    pub(crate) edits: u64,
}

impl Rest {
    /// Takes a light from a whole picture of the scene as it is. None where too little is gained: under one light, on a GPU, in a picture
    /// that is quick enough, with a light that takes most of its time, where the part itself takes long, and with shadow maps, which take
    /// most of it.
    pub(crate) fn new(
        renderer: &mut Renderer,
        light: LightHandle,
        whole: &Picture,
        budget: f64,
        clock: impl Fn() -> f64,
    ) -> Result<Option<Self>, RenderError> {
        let is_of_cpu = matches!(renderer.backend(), Backend::Cpu) && !whole.radiance.is_empty();
        let can_gain = whole.seconds > budget && whole.stats.map_bytes == 0 && renderer.lights().count() > 1;
        let own = renderer.lights().find(|(handle, _)| *handle == light).map(|(_, light)| light);
        let can_move = own.is_some_and(|own| !matches!(own, Light::Sky(_)));
        if !is_of_cpu || !can_move || !can_gain {
            return Ok(None);
        }
        let mut part = |divisor| renderer.render_light(divisor, light, &mut |_: Event<'_>| ControlFlow::Continue(()));
        // Its points are found at the first time, and another program may hold one up.
        let mut seconds = f64::INFINITY;
        for _ in 0..3 {
            let start = clock();
            drop(part(TRIAL)?);
            seconds = seconds.min(f64::from(TRIAL * TRIAL) * (clock() - start));
        }
        if seconds > MOST.min(LESS * whole.seconds) {
            return Ok(None);
        }
        let divisor = if seconds <= budget { 1 } else { 2 };
        let part = part(1)?.radiance;
        let difference: Vec<Vec3> = whole.radiance.iter().zip(part).map(|(whole, part)| *whole - part).collect();
        let radiance = if divisor == 1 { difference } else { halved(&difference, whole.size) };
        Ok(Some(Self { light, divisor, radiance, edits: whole.edits }))
    }

    /// The picture with the light as it is now.
    pub(crate) fn with(&self, part: &mut [Vec3]) {
        part.iter_mut().zip(&self.radiance).for_each(|(part, rest)| *part = (*part + *rest).max(Vec3::ZERO));
    }
}

/// The means of two by two pixels; at the right and at the bottom of fewer.
fn halved(picture: &[Vec3], [width, height]: [usize; 2]) -> Vec<Vec3> {
    let pixel = |x: usize, y: usize| {
        let (columns, rows) = (x..(x + 2).min(width), y..(y + 2).min(height));
        let count = (columns.len() * rows.len()) as f32;
        rows.flat_map(|y| columns.clone().map(move |x| y * width + x)).map(|at| picture[at]).sum::<Vec3>() / count
    };
    (0..height).step_by(2).flat_map(|y| (0..width).step_by(2).map(move |x| pixel(x, y))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::cell::Cell;
    use glam::Mat4;
    use renderer::Settings;
    use scene::Animation;

    const BUDGET: f64 = 0.03;

    /// The built-in scene under three lights, and its whole picture, which is said to take so long.
    fn stage(seconds: f64) -> (Renderer, LightHandle, Picture) {
        let mut scene = scene::builtin();
        (scene.width, scene.height) = (97, 55);
        scene.lights.push(scene.lights[0].moved(Mat4::from_rotation_y(1.0)));
        let mut renderer = Renderer::new(scene, Animation::default(), Settings::default()).expect("a scene");
        let light = renderer.lights().next().expect("a light").0;
        let renderer::Image { size, radiance, stats, .. } = renderer.render().expect("a picture");
        (renderer, light, Picture { size, radiance, stats, divisor: 1, seconds, ..Picture::default() })
    }

    /// By a clock by which each part takes so long in proportion to the whole one.
    fn rest(renderer: &mut Renderer, light: LightHandle, whole: &Picture, seconds: f64) -> Option<Rest> {
        let (now, step) = (Cell::new(0.0), seconds / f64::from(TRIAL * TRIAL));
        let clock = || now.replace(now.get() + step);
        Rest::new(renderer, light, whole, BUDGET, clock).expect("a rest")
    }

    /// With the part of the light elsewhere it is the picture there: to rounding where its sides are whole.
    #[test]
    fn a_moved_light_and_the_rest_are_the_picture() {
        let (mut renderer, light, whole) = stage(1.0);
        let off = |a: &[Vec3], b: &[Vec3]| {
            let sum = |v: Vec3| f64::from(v.abs().element_sum());
            a.iter().zip(b).map(|(a, b)| sum(*a - *b)).sum::<f64>() / b.iter().map(|b| sum(*b)).sum::<f64>()
        };
        for (seconds, divisor, most) in [(0.02, 1, 1e-5), (0.1, 2, 0.1)] {
            let rest = rest(&mut renderer, light, &whole, seconds).expect("it is worth it");
            assert_eq!(rest.divisor, divisor);
            let before = renderer.lights().next().expect("a light").1.clone();
            renderer.set_light(light, before.moved(Mat4::from_rotation_y(0.7))).expect("a light");
            let go_on = &mut |_: Event<'_>| ControlFlow::Continue(());
            let mut sum = renderer.render_light(divisor, light, go_on).expect("a part").radiance;
            rest.with(&mut sum);
            let want = renderer.render_reduced(divisor, go_on).expect("a picture").radiance;
            println!("1/{divisor}: off by {:.1e}", off(&sum, &want));
            assert!(sum.len() == want.len() && off(&sum, &want) < most, "{}", off(&sum, &want));
            renderer.set_light(light, before).expect("a light");
        }
    }

    #[test]
    fn little_gain_is_none() {
        let (mut renderer, light, whole) = stage(1.0);
        assert!(rest(&mut renderer, light, &whole, 0.26).is_none(), "too long at once");
        let (quick, half) = (Picture { seconds: BUDGET, ..whole.clone() }, Picture { seconds: 0.1, ..whole.clone() });
        assert!(rest(&mut renderer, light, &quick, 0.001).is_none(), "quick enough");
        assert!(rest(&mut renderer, light, &half, 0.07).is_none(), "most of its time");
        let others: Vec<_> = renderer.lights().map(|(handle, _)| handle).skip(1).collect();
        others.into_iter().for_each(|other| drop(renderer.remove_light(other)));
        assert!(rest(&mut renderer, light, &whole, 0.02).is_none(), "the only light");
    }

    #[test]
    fn pictures_are_halved_to_means() {
        let picture: Vec<Vec3> = (0..15).map(|x| Vec3::splat(x as f32)).collect();
        let small: Vec<f32> = halved(&picture, [5, 3]).iter().map(|v| v.x).collect();
        assert_eq!(small, [3.0, 5.0, 6.5, 10.5, 12.5, 14.0]);
    }
}
