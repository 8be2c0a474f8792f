//! Everything that a page shows beside the picture.

use crate::desk::{Desk, Thing};
use glam::{Vec2, Vec3};
use lighting::Light;
use pictures::luminance;
use renderer::MaskSample;
use serde::Serialize;
use session::gloss::{self, Gloss};
use session::{LightItem, LightPart, ObjectItem, Probe, lamp};

/// Lights that are listed, at most.
const LIGHTS: usize = 24;
/// Lights whose masks are sent.
const MASKS: usize = 4;

/// The scene, what is selected and the newest picture.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Report {
    picture: Shown,
    lights: Vec<Lamp>,
    /// The number of the selected light.
    light: Option<usize>,
    object: Option<Chosen>,
    handles: Option<Grips>,
    /// The ends of the lines of a box around the selected object.
    edges: Vec<[Vec2; 2]>,
    objects: usize,
    tolerance: f32,
    strategy: Option<&'static str>,
    projection: &'static str,
    exposure: f32,
    metered: f32,
    /// Numbers of steps that can be taken back, and made again.
    steps: [usize; 2],
    time: f32,
    duration: f32,
    /// How many pixels were taken apart, and where the last one is, in parts of the picture.
    probes: u64,
    pixel: Option<Vec2>,
    lines: Vec<String>,
    /// Radius of the scene.
    extent: f32,
}

/// The newest picture.
#[derive(Clone, Debug, Serialize)]
struct Shown {
    size: [usize; 2],
    whole: [u32; 2],
    divisor: u32,
    edits: u64,
    seconds: f64,
    latency: f64,
}

#[derive(Clone, Debug, Serialize)]
struct Lamp {
    number: usize,
    kind: &'static str,
    /// Its mark on the screen.
    at: Option<Vec2>,
    /// Its middle, in the coordinates of the scene.
    center: Option<Vec3>,
    size: Option<f32>,
    radiance: f32,
    color: Vec3,
    moves: bool,
}

/// The selected object.
#[derive(Clone, Debug, Serialize)]
struct Chosen {
    name: String,
    parts: usize,
    material: &'static str,
    strategy: Option<&'static str>,
    taken: &'static str,
    exponent: Option<f32>,
    roughness: Option<f32>,
    color: Option<Vec3>,
    moves: bool,
}

/// The handles on the screen.
#[derive(Clone, Debug, Serialize)]
struct Grips {
    middle: Vec2,
    tips: [Option<Vec2>; 3],
    circle: Option<f32>,
    aim: Option<Vec2>,
}

/// A pixel taken apart.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Pixel {
    pixel: [u32; 2],
    object: String,
    material: &'static str,
    point: Vec3,
    normal: Vec3,
    distance: f32,
    radiance: Vec3,
    reference: Vec3,
    deviation: Vec3,
    lights: Vec<Part>,
}

/// The part of a light in it, as luminance.
#[derive(Clone, Debug, Serialize)]
struct Part {
    number: usize,
    kind: &'static str,
    unshadowed: f64,
    visible: f64,
    radiance: f64,
    mask: Option<Mask>,
}

/// A light as the point sees it: 0 beside the light, 1 lit, 2 blocked.
#[derive(Clone, Debug, Serialize)]
struct Mask {
    size: [usize; 2],
    /// Width and height of the window before the light, as tangents.
    sides: Vec2,
    samples: String,
}

impl Desk {
    /// The report; its lines are given once.
    pub(crate) fn report(&mut self) -> Report {
        let lines = core::mem::take(&mut self.lines);
        let (scene, picture) = (self.editor.scene(), self.editor.picture());
        let lights = scene.lights.iter().enumerate().filter(|(_, item)| !matches!(item.light, Light::Sky(_)));
        let selected = |item: &LightItem| self.selected == Some(Thing::Light(item.handle));
        let object = match self.selected {
            Some(Thing::Object(handle)) => self.editor.object(handle),
            _ => None,
        };
        let [width, height] = scene.size.map(|side| side as f32);
        Report {
            picture: Shown {
                size: picture.size,
                whole: scene.size,
                divisor: picture.divisor,
                edits: picture.edits,
                seconds: picture.seconds,
                latency: picture.latency,
            },
            lights: lights.take(LIGHTS).map(|(number, item)| self.lamp(number, item)).collect(),
            light: scene.lights.iter().position(selected),
            object: object.map(|item| self.chosen(item)),
            handles: self.grips(),
            edges: object.filter(|item| !item.is_backdrop).map(|item| self.edges(item)).unwrap_or_default(),
            objects: scene.objects.len(),
            tolerance: scene.settings.accuracy.tolerance,
            strategy: scene.settings.strategy.map(scene::Strategy::name),
            projection: scene.camera.projection.name(),
            exposure: self.display.exposure,
            metered: self.metered,
            steps: scene.steps,
            time: scene.time,
            duration: scene.duration,
            probes: self.probes,
            pixel: self
                .probed
                .as_ref()
                .map(|([x, y], _)| Vec2::new((*x as f32 + 0.5) / width, (*y as f32 + 0.5) / height)),
            lines,
            extent: scene.bounds().radius().max(1e-6),
        }
    }

    fn lamp(&self, number: usize, item: &LightItem) -> Lamp {
        let radiance = item.light.full_radiance();
        let most = radiance.max_element();
        Lamp {
            number,
            kind: item.light.name(),
            at: self.mark(&item.light),
            center: lamp::center(&item.light),
            size: lamp::size(&item.light),
            radiance: most,
            color: radiance / most.max(f32::MIN_POSITIVE),
            moves: item.is_animated,
        }
    }

    fn chosen(&self, item: &ObjectItem) -> Chosen {
        let material = self.editor.scene().materials.get(item.material).map(|item| &item.material);
        let gloss = material.and_then(gloss::of);
        Chosen {
            name: item.name.clone(),
            parts: item.parts,
            material: material.map_or("", |material| material.name()),
            strategy: item.strategy.map(scene::Strategy::name),
            taken: item.taken.name(),
            exponent: gloss.and_then(|gloss| if let Gloss::Exponent(exponent) = gloss { Some(exponent) } else { None }),
            roughness: gloss.and_then(|gloss| if let Gloss::Roughness(value) = gloss { Some(value) } else { None }),
            color: material.and_then(gloss::color),
            moves: item.is_animated,
        }
    }

    fn grips(&self) -> Option<Grips> {
        let handles = self.handles()?;
        Some(Grips { middle: handles.middle()?, tips: handles.tips(), circle: handles.circle(), aim: handles.aim() })
    }

    /// The box around an object.
    fn edges(&self, item: &ObjectItem) -> Vec<[Vec2; 2]> {
        let (projection, bounds) = (self.projection(), item.bounds);
        let corner = |i: usize| {
            let pick = |k: usize| if i >> k & 1 == 0 { bounds.min[k] } else { bounds.max[k] };
            projection.pixel(Vec3::new(pick(0), pick(1), pick(2)))
        };
        let pairs =
            (0..8_usize).flat_map(|i| [1, 2, 4].into_iter().filter(move |k| i & k == 0).map(move |k| (i, i | k)));
        pairs.filter_map(|(a, b)| Some([corner(a)?, corner(b)?])).filter(|_| !bounds.is_empty()).collect()
    }

    /// The pixel that was taken apart last.
    pub(crate) fn pixel(&self) -> Option<Pixel> {
        let (pixel, probe) = self.probed.as_ref()?;
        let scene = self.editor.scene();
        let Probe { pick, radiance, lights, reference: [reference, deviation], hemisphere: _ } = probe;
        let object = scene.object(pick.object);
        let material = scene.materials.iter().find(|item| item.handle == pick.material);
        let mut parts: Vec<(usize, &LightPart)> = lights.iter().enumerate().collect();
        parts.sort_by(|a, b| b.1.unshadowed.element_sum().total_cmp(&a.1.unshadowed.element_sum()));
        let part = |(place, (number, part)): (usize, &(usize, &LightPart))| Part {
            number: *number,
            kind: scene.light(part.light).map_or("", |item| item.light.name()),
            unshadowed: luminance(part.unshadowed),
            visible: luminance(part.visible),
            radiance: luminance(part.radiance),
            mask: part.mask.as_ref().filter(|_| place < MASKS).map(|mask| Mask {
                size: mask.size,
                sides: mask.sides,
                samples: mask.samples.iter().map(|sample| letter(*sample)).collect(),
            }),
        };
        Some(Pixel {
            pixel: *pixel,
            object: object.map_or_else(String::new, |item| item.name.clone()),
            material: material.map_or("", |item| item.material.name()),
            point: pick.receiver.position,
            normal: pick.receiver.normal,
            distance: pick.distance,
            radiance: *radiance,
            reference: *reference,
            deviation: *deviation,
            lights: parts.iter().enumerate().take(LIGHTS).map(part).collect(),
        })
    }
}

const fn letter(sample: MaskSample) -> char {
    match sample {
        MaskSample::Outside => '0',
        MaskSample::Lit => '1',
        MaskSample::Blocked => '2',
    }
}
