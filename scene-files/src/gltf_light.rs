//! The lights of a glTF file (KHR_lights_punctual).

use core::f32::consts::FRAC_PI_2;
use glam::{Mat4, Vec3};
use gltf::json::Root;
use gltf::json::extensions::scene::khr_lights_punctual::{Light as Punctual, Type};
use gltf::json::validation::Checked;
use lighting::{Light, SphereLight, SpotLight, SunLight};
use lobe_core::Sphere;
use scene::Bounds;

/// Radius of a light that has none, as a part of the radius of all that is shown: its shadows are as good as hard.
const POINT: f32 = 1e-3;

/// A light at the origin of its node.
#[derive(Clone, Copy, Debug)]
pub(crate) enum NodeLight {
    /// Intensity, and the range, which may be infinite.
    Point(Vec3, f32),
    /// Intensity along the axis, the cosines of the angles between which it falls, and the range.
    Spot(Vec3, [f32; 2], f32),
    /// Irradiance.
    Sun(Vec3),
}

/// A light, its node and the skeleton's number, where the node moves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlacedLight {
    pub(crate) light: NodeLight,
    pub(crate) world: Mat4,
    pub(crate) mover: Option<(usize, usize)>,
}

impl PlacedLight {
    /// Whether a floor at a height would hide it from all above.
    pub(crate) fn is_below(&self, height: f32) -> bool {
        match self.light {
            NodeLight::Point(..) | NodeLight::Spot(..) => self.world.w_axis.y < height,
            NodeLight::Sun(_) => self.world.z_axis.truncate().normalize_or_zero().y < -1e-3,
        }
    }
}

/// The light of a node, if it has one. Appends a note for each of its numbers that is replaced.
pub(crate) fn read_light(root: &Root, node: usize, notes: &mut Vec<String>) -> Result<Option<NodeLight>, String> {
    let Some(named) = root.nodes[node].extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref()) else {
        return Ok(None);
    };
    let index = named.light.value();
    let all = root.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
    let light =
        all.and_then(|all| all.lights.get(index)).ok_or_else(|| format!("node {node}: there is no light {index}"))?;
    let mut note = |note: String| notes.push(format!("light {index}: {note}"));
    parse(light, &mut note).map(Some).map_err(|fault| format!("light {index}: {fault}"))
}

fn parse(light: &Punctual, note: &mut impl FnMut(String)) -> Result<NodeLight, String> {
    let (color, intensity) = (Vec3::from_array(light.color), light.intensity);
    if !(color.is_finite() && color.min_element() >= 0.0) {
        return Err(format!("found color {color}: expected finite numbers that are not negative"));
    }
    if !(intensity.is_finite() && intensity >= 0.0) {
        return Err(format!("found intensity {intensity}: expected a finite number that is not negative"));
    }
    if let Some(range) = light.range
        && (range.is_nan() || range <= 0.0)
    {
        return Err(format!("found range {range}: expected a number above 0"));
    }
    // Of lights at infinity it says nothing.
    let range = light.range.unwrap_or(f32::INFINITY);
    let value = color * intensity;
    // Of finite numbers: infinite at worst.
    if value.max_element() > 1e20 {
        return Err(format!("found color {color} and intensity {intensity}: expected a product of 1e20 at most"));
    }
    match light.type_ {
        Checked::Invalid => Err("expected the type \"point\", \"spot\" or \"directional\"".to_owned()),
        Checked::Valid(Type::Point) => Ok(NodeLight::Point(value, range)),
        Checked::Valid(Type::Directional) => Ok(NodeLight::Sun(value)),
        Checked::Valid(Type::Spot) => {
            let spot = light.spot.as_ref().ok_or("a spot without its angles")?;
            let angles = cone([spot.inner_cone_angle, spot.outer_cone_angle], note)?;
            Ok(NodeLight::Spot(value, angles.map(f32::cos), range))
        }
    }
}

/// The angles of a spot. Equal ones, which some exporters write, are a cone with a hard edge.
fn cone([inner, outer]: [f32; 2], note: &mut impl FnMut(String)) -> Result<[f32; 2], String> {
    if !(inner >= 0.0 && outer > 0.0 && inner.is_finite() && outer.is_finite()) {
        return Err(format!(
            "found innerConeAngle {inner} and outerConeAngle {outer}: expected 0 ≤ inner < outer ≤ π/2"
        ));
    }
    if outer > FRAC_PI_2 + 1e-6 {
        note(format!("outerConeAngle {outer} is beyond π/2: it is taken as π/2"));
    }
    if inner > outer {
        note(format!("innerConeAngle {inner} is beyond outerConeAngle {outer}: the cone's edge is hard"));
    }
    let outer = outer.min(FRAC_PI_2);
    Ok([inner.min(outer), outer])
}

impl NodeLight {
    /// The light at the origin, shining along −z.
    pub(crate) fn at_origin(self, shown: &Bounds) -> Light {
        let sphere = Sphere { center: Vec3::ZERO, radius: POINT * shown.radius().max(f32::MIN_POSITIVE.sqrt()) };
        match self {
            Self::Point(intensity, f32::INFINITY) => SphereLight::with_intensity(sphere, intensity).into(),
            Self::Point(intensity, range) => {
                SpotLight::everywhere(SphereLight::with_intensity(sphere, intensity), range).into()
            }
            Self::Spot(intensity, cos, range) => {
                let light = SphereLight::with_intensity(sphere, intensity);
                SpotLight { light, axis: Vec3::NEG_Z, cos, range }.into()
            }
            Self::Sun(irradiance) => {
                let world = Sphere { center: shown.center(), radius: shown.radius() };
                SunLight::new(Vec3::Z, SunLight::HALF_ANGLE, irradiance, world).into()
            }
        }
    }
}
