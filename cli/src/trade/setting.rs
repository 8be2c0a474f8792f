//! The settings of a sweep.

use super::word;
use crate::args::{Method, TradeArgs, TradeDevice, TradeGeometry, Visibility, name};

/// The technique of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Technique {
    Lobes(Method, Visibility),
    /// Stratified shadow rays; with the culling that lobes have, or each ray alone.
    Samples {
        culled: bool,
    },
}

/// One row to be.
#[derive(Clone, Debug)]
pub(super) struct Setting {
    pub(super) technique: Technique,
    /// The method's name in the row.
    pub(super) method: String,
    pub(super) visibility: String,
    pub(super) device: TradeDevice,
    /// `cpu`, or the name of the GPU.
    pub(super) device_name: String,
    /// The swept values, where the technique has them.
    pub(super) tolerance: Option<f32>,
    pub(super) depth: Option<u32>,
    pub(super) spp: Option<u32>,
}

/// All combinations, on the CPU and the GPU of that name: tolerance and depth for moments, depth for the paper's method, whose
/// lobes know no tolerance, samples for rays.
pub(super) fn all(args: &TradeArgs, strategies: &[Visibility], gpu: &str) -> Vec<Setting> {
    let mut list = Vec::new();
    let pairs = args.device.iter().flat_map(|device| args.method.iter().map(move |method| (*device, *method)));
    for (device, method) in pairs {
        for visibility in strategies {
            let setting = |tolerance, depth| Setting {
                technique: Technique::Lobes(method, *visibility),
                method: word(method),
                visibility: name(visibility),
                device,
                device_name: if device == TradeDevice::Gpu { gpu.to_owned() } else { name(&device) },
                tolerance,
                depth: Some(depth),
                spp: None,
            };
            for &depth in &args.depth {
                match method {
                    // A GPU does not sum lobes of visibility.
                    Method::Lobes if device == TradeDevice::Gpu => {}
                    Method::Moments | Method::Lobes => {
                        list.extend(args.tolerance.iter().map(|t| setting(Some(*t), depth)))
                    }
                    Method::Paper => list.push(setting(None, depth)),
                }
            }
        }
    }
    let seen = match args.geometry {
        TradeGeometry::Spheres => Visibility::Spheres,
        TradeGeometry::Mesh => Visibility::Rays,
    };
    for (culled, method) in [(true, "samples"), (false, "samples, unculled")] {
        list.extend(args.spp.iter().map(|spp| Setting {
            technique: Technique::Samples { culled },
            method: method.to_owned(),
            visibility: name(&seen),
            device: TradeDevice::Cpu,
            device_name: name(&TradeDevice::Cpu),
            tolerance: None,
            depth: None,
            spp: Some(*spp),
        }));
    }
    list
}
