use crate::plan::map_sphere;
use crate::{MapReduction, Plan, RenderError};
use lobe_core::Sphere;
use scene::{Cancel, Scene};
use visibility_shadowmap::{ReceiverBounds, ShadowMap};

/// The shadow maps of the last picture, for the next one with the same objects.
#[derive(Debug, Default)]
pub(crate) struct KeptMaps {
    of: Option<MadeFor>,
    maps: Vec<ShadowMap>,
    coarser: Option<MapReduction>,
    /// Number of maps that were drawn so far.
    pub(crate) drawn: u64,
}

/// The inputs of maps beside the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MapRequest {
    pub(crate) receivers: ReceiverBounds,
    /// Texels a side, if the settings give them.
    pub(crate) resolution: Option<u32>,
    /// Bytes that the device has for the maps.
    pub(crate) room: u64,
}

/// All inputs of the maps, except the objects.
#[derive(Debug, PartialEq)]
struct MadeFor {
    request: MapRequest,
    casters: Vec<bool>,
    lights: Vec<Sphere>,
}

impl KeptMaps {
    /// Call this after objects have moved, were added or removed, or changed their strategy.
    pub(crate) fn clear(&mut self) {
        self.of = None;
        self.maps.clear();
    }

    /// The map of the light at a place in the scene, if it is there.
    pub(crate) fn of(&self, light: usize) -> Option<&ShadowMap> {
        self.maps.get(light)
    }

    /// Draws the maps of a scene; keeps those of lights that have not moved.
    pub(crate) fn update(
        &mut self,
        plan: &Plan,
        scene: &Scene,
        request: MapRequest,
        cancel: &Cancel,
    ) -> Result<(Vec<ShadowMap>, Option<MapReduction>), RenderError> {
        let lights: Vec<Sphere> = scene.lights.iter().map(map_sphere).collect();
        let casters = match &self.of {
            Some(of) if of.lights == lights => of.casters.clone(),
            _ => plan.casters(scene),
        };
        let now = MadeFor { request, casters, lights };
        if self.of.as_ref() == Some(&now) {
            return Ok((self.maps.clone(), self.coarser));
        }
        let old =
            self.of.take().filter(|of| (of.request, &of.casters) == (request, &now.casters) && self.coarser.is_none());
        let known = |light: &Sphere| {
            let place = old.as_ref()?.lights.iter().position(|other| other == light)?;
            self.maps.get(place).cloned()
        };
        let kept = now.lights.iter().filter(|light| known(light).is_some()).count();
        let known = |light: &Sphere| if cancel.is_cancelled() { Err(RenderError::Cancelled) } else { Ok(known(light)) };
        let MapRequest { receivers, resolution, room } = request;
        let (maps, coarser) = plan.maps_beside(scene, receivers, resolution, room, &known)?;
        self.drawn += (maps.len() - kept) as u64;
        (self.maps, self.coarser, self.of) = (maps.clone(), coarser, Some(now));
        Ok((maps, coarser))
    }
}
