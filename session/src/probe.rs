use crate::outline::outlines;
use crate::{Hemisphere, Outline};
use core::sync::atomic::AtomicBool;
use glam::Vec3;
use ray_tracing::GBuffer;
use reference::{Geometry, Reference, ReferenceJob};
use renderer::{LayerSet, LightHandle, LightMask, Pick, RenderError, Renderer, Window};
use scene::BlockerSet;

/// Lights whose masks are drawn: an environment has hundreds.
const MASKS: usize = 16;

/// One pixel taken apart.
#[derive(Clone, Debug)]
pub struct Probe {
    /// The surface in its middle.
    pub pick: Pick,
    /// Radiance of the pixel, as a picture of one ray a pixel has it.
    pub radiance: Vec3,
    /// The part of each light, in the order of the scene.
    pub lights: Vec<LightPart>,
    /// The same by shadow rays on the true surfaces: radiance, and its standard error.
    pub reference: [Vec3; 2],
    /// The surface's reflectance over the directions toward light.
    pub hemisphere: Hemisphere,
}

/// The part of a light in a pixel.
#[derive(Clone, Debug)]
pub struct LightPart {
    /// The light.
    pub light: LightHandle,
    /// Radiance that comes of it.
    pub radiance: Vec3,
    /// The same if nothing blocked it.
    pub unshadowed: Vec3,
    /// The fraction of it that a white diffuse surface sees there.
    pub visible: Vec3,
    /// The light as the point sees it, dark where a blocker hides it; of the sixteen lights that are brightest there without blockers.
    pub mask: Option<LightMask>,
    /// The outlines of blockers in that mask.
    pub outlines: Vec<Outline>,
}

impl Probe {
    /// Takes a pixel apart; none where it shows no surface. Shades on the CPU, whatever the renderer does.
    ///
    /// # Errors
    /// Those of [`Renderer::render`].
    pub fn new(renderer: &mut Renderer, x: u32, y: u32, samples: u32) -> Result<Option<Self>, RenderError> {
        let Some(pick) = renderer.pick(x, y) else { return Ok(None) };
        let lights: Vec<LightHandle> = renderer.lights().map(|(handle, _)| handle).collect();
        let hemisphere = Hemisphere::new(&pick.receiver, renderer.reflectance(x, y));
        let (width, height) = (renderer.scene().width as usize, renderer.scene().height as usize);
        let (x, y) = (x as usize, y as usize);
        let window = Window { image: [width, height], columns: x..x + 1, rows: y..y + 1 };
        let layers = LayerSet { lights: true, ..LayerSet::NONE };
        let image = renderer.render_apart(&window, layers, 1)?;
        let whole = renderer.unshadowed(x as u32, y as u32);
        let mut parts = Vec::with_capacity(lights.len());
        for (number, light) in lights.into_iter().enumerate() {
            let visible = renderer.visible_fraction(&pick.receiver, light)?;
            let radiance = image.layers.lights.get(number).and_then(|layer| layer.first()).copied().unwrap_or_default();
            let unshadowed = whole.get(number).copied().unwrap_or_default();
            let brighter = whole.iter().filter(|other| other.element_sum() > unshadowed.element_sum()).count();
            let mask = (brighter < MASKS).then(|| renderer.light_mask(&pick.receiver, light)).transpose()?;
            let own = renderer.lights().find(|(handle, _)| *handle == light).map(|(_, light)| light);
            let drawn = own.zip(mask.as_ref()).map(|(own, mask)| outlines(renderer, &pick.receiver, own, mask));
            let outlines = drawn.unwrap_or_default();
            parts.push(LightPart { light, radiance, unshadowed, visible, mask, outlines });
        }
        let reference = reference_of(renderer, &window, samples);
        let radiance = image.radiance.first().copied().unwrap_or_default();
        Ok(Some(Self { pick, radiance, lights: parts, reference, hemisphere }))
    }
}

/// Radiance of a pixel by shadow rays, and its standard error; emission of the surface included.
fn reference_of(renderer: &mut Renderer, window: &Window, samples: u32) -> [Vec3; 2] {
    let [width, height] = window.image.map(|side| side as u32);
    let columns = window.columns.start as u32..window.columns.end as u32;
    let rows = window.rows.start as u32..window.rows.end as u32;
    renderer.with_world(|world| {
        let gbuffer = GBuffer::window(world, width, height, 1, columns, rows);
        let blockers = BlockerSet::default();
        let job = ReferenceJob { world, gbuffer: &gbuffer, blockers: &blockers, geometry: Geometry::Mesh, seed: 1 };
        let mut reference = Reference::new(job);
        reference.advance(samples, &AtomicBool::new(false), &|_| {});
        let estimate = reference.estimate();
        let first = |values: &[Vec3]| values.first().copied().unwrap_or_default();
        [first(&estimate.radiance), first(&estimate.std_error)]
    })
}
