use crate::plan::map_sphere;
use crate::{MapReduction, Plan, RenderError};
use lobe_core::Sphere;
use scene::Scene;
use visibility_shadowmap::{ReceiverBounds, ShadowMap};

/// The shadow maps of the last picture, for the next one with the same objects.
#[derive(Debug, Default)]
pub(crate) struct KeptMaps {
    of: Option<MadeFor>,
    maps: Vec<ShadowMap>,
    coarser: Option<MapReduction>,
    /// Maps that were drawn so far.
    pub(crate) drawn: u64,
}

/// All inputs of the maps but the objects.
#[derive(Debug, PartialEq)]
struct MadeFor {
    receivers: ReceiverBounds,
    resolution: Option<u32>,
    room: u64,
    casters: Vec<bool>,
    lights: Vec<Sphere>,
}

impl KeptMaps {
    /// After objects have moved, come, gone or changed their strategy.
    pub(crate) fn clear(&mut self) {
        self.of = None;
        self.maps.clear();
    }

    /// The maps of a scene: those of lights that have not moved are kept.
    pub(crate) fn update(
        &mut self,
        plan: &Plan,
        scene: &Scene,
        receivers: ReceiverBounds,
        resolution: Option<u32>,
        room: u64,
    ) -> Result<(Vec<ShadowMap>, Option<MapReduction>), RenderError> {
        let lights: Vec<Sphere> = scene.lights.iter().map(map_sphere).collect();
        let casters = match &self.of {
            Some(of) if of.lights == lights => of.casters.clone(),
            _ => plan.casters(scene),
        };
        let now = MadeFor { receivers, resolution, room, casters, lights };
        if self.of.as_ref() == Some(&now) {
            return Ok((self.maps.clone(), self.coarser));
        }
        let old = self.of.take().filter(|of| {
            let same = (of.receivers, of.resolution, of.room, &of.casters);
            same == (receivers, resolution, room, &now.casters) && self.coarser.is_none()
        });
        let known = |light: &Sphere| {
            let place = old.as_ref()?.lights.iter().position(|other| other == light)?;
            self.maps.get(place).cloned()
        };
        let kept = now.lights.iter().filter(|light| known(light).is_some()).count();
        let (maps, coarser) = plan.maps_beside(scene, receivers, resolution, room, &known)?;
        self.drawn += (maps.len() - kept) as u64;
        (self.maps, self.coarser, self.of) = (maps.clone(), coarser, Some(now));
        Ok((maps, coarser))
    }
}
