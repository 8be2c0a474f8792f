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

    #[test]
    fn pictures_are_halved_to_means() {
        let picture: Vec<Vec3> = (0..15).map(|x| Vec3::splat(x as f32)).collect();
        let small: Vec<f32> = halved(&picture, [5, 3]).iter().map(|v| v.x).collect();
        assert_eq!(small, [3.0, 5.0, 6.5, 10.5, 12.5, 14.0]);
    }
}
