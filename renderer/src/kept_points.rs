use brdf::Material;
use core::ops::Range;
use pictures::Window;
use render_cpu::GBuffer;

/// Camera rays whose points are kept from picture to picture: about 130 MB.
const KEPT_RAYS: u64 = 1 << 21;

/// The visible points of the last picture, band by band, for the next one that sees the same.
#[derive(Debug, Default)]
pub(crate) struct KeptPoints {
    of: Option<(Window, u32)>,
    bands: Vec<(Range<u32>, GBuffer)>,
    /// Bands that were found so far.
    pub(crate) found: u64,
}

impl KeptPoints {
    pub(crate) fn clear(&mut self) {
        self.of = None;
        self.bands.clear();
    }

    pub(crate) fn take(&mut self, window: &Window, samples: u32, rows: &Range<u32>) -> Option<GBuffer> {
        self.of.as_ref().filter(|(w, s)| (w, *s) == (window, samples))?;
        let place = self.bands.iter().position(|(kept, _)| kept == rows)?;
        Some(self.bands.swap_remove(place).1)
    }

    pub(crate) fn put(&mut self, window: &Window, samples: u32, rows: Range<u32>, points: GBuffer) {
        let [width, height] = window.size().map(|side| side as u64);
        if width * height * u64::from(samples) > KEPT_RAYS {
            return;
        }
        if self.of.as_ref().is_none_or(|(w, s)| (w, *s) != (window, samples)) {
            self.bands.clear();
            self.of = Some((window.clone(), samples));
        }
        self.bands.push((rows, points));
    }

    /// Follows materials that have changed, of which there were `before`: no point is found anew, but where points with materials of
    /// their own would get other numbers.
    pub(crate) fn set_materials(&mut self, materials: &[Material], before: usize) {
        let has_own = self.bands.iter().any(|(_, points)| points.materials.len() > before);
        if has_own && materials.len() != before {
            return self.clear();
        }
        for (_, points) in &mut self.bands {
            if has_own {
                points.materials[..before].clone_from_slice(materials);
            } else {
                points.materials = materials.to_vec();
            }
        }
    }
}
