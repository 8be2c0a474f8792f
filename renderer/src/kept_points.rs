use brdf::Material;
use core::sync::atomic::{AtomicU64, Ordering};
use pictures::Window;
use render_cpu::{GBuffer, PixelSamples};
use visibility_shadowmap::ReceiverBounds;

/// Camera rays whose points are kept from picture to picture: about 130 MB.
const KEPT_RAYS: u64 = 1 << 21;

/// Visible points of a part of a picture.
#[derive(Debug, Default)]
pub(crate) struct Found {
    pub(crate) points: GBuffer,
    /// A number that no other points have.
    #[cfg_attr(not(feature = "gpu"), expect(dead_code, reason = "a GPU knows by it which points it has"))]
    pub(crate) stamp: u64,
}

impl Found {
    pub(crate) fn new(points: GBuffer) -> Self {
        static STAMPS: AtomicU64 = AtomicU64::new(1);
        Self { points, stamp: STAMPS.fetch_add(1, Ordering::Relaxed) }
    }
}

/// Visible points of the last pictures, part by part, for the next one that sees the same; and the box around those of the whole
/// picture.
#[derive(Debug, Default)]
pub(crate) struct KeptPoints {
    samples: PixelSamples,
    parts: Vec<(Window, Found)>,
    rays: u64,
    /// The box of the whole picture, once it was needed; the inner `None` says that the camera sees nothing.
    pub(crate) bounds: Option<Option<ReceiverBounds>>,
    /// Number of parts that were found so far.
    pub(crate) found: u64,
}

fn rays(window: &Window, samples: PixelSamples) -> u64 {
    window.pixels() as u64 * u64::from(samples.usual())
}

impl KeptPoints {
    pub(crate) fn clear(&mut self) {
        self.clear_parts();
        self.bounds = None;
    }

    /// Drops the points and keeps the box.
    pub(crate) fn clear_parts(&mut self) {
        self.parts.clear();
        self.rays = 0;
    }

    pub(crate) fn take(&mut self, window: &Window, samples: PixelSamples) -> Option<Found> {
        let place = self.parts.iter().position(|(kept, _)| kept == window).filter(|_| self.samples == samples)?;
        self.rays -= rays(window, samples);
        Some(self.parts.swap_remove(place).1)
    }

    /// Keeps points, unless there are too many, in the place of those of the same pixels.
    pub(crate) fn put(&mut self, window: &Window, samples: PixelSamples, points: Found) {
        if self.samples != samples {
            self.clear_parts();
            self.samples = samples;
        }
        let more = rays(window, samples);
        if more > KEPT_RAYS {
            return;
        }
        self.parts.retain(|(kept, _)| !kept.overlaps(window));
        self.rays = self.parts.iter().map(|(kept, _)| rays(kept, samples)).sum();
        if self.rays + more <= KEPT_RAYS {
            self.rays += more;
            self.parts.push((window.clone(), points));
        }
    }

    /// Updates kept points to changed materials, of which there were `before`. Points stay valid, unless their own materials would
    /// get other numbers; those are dropped.
    pub(crate) fn set_materials(&mut self, materials: &[Material], before: usize) {
        let has_own = self.parts.iter().any(|(_, found)| found.points.materials.len() > before);
        if has_own && materials.len() != before {
            return self.clear_parts();
        }
        for (_, Found { points, .. }) in &mut self.parts {
            if has_own {
                points.materials[..before].clone_from_slice(materials);
            } else {
                points.materials = materials.to_vec();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(left: usize, right: usize) -> Window {
        Window { image: [64, 8], columns: left..right, rows: 0..8 }
    }

    #[test]
    fn no_pixel_is_kept_twice() {
        let mut kept = KeptPoints::default();
        for k in 0..4 {
            kept.put(&part(16 * k, 16 * k + 16), 1.into(), Found::default());
        }
        kept.put(&part(8, 24), 1.into(), Found::default());
        assert_eq!(kept.rays, 8 * (16 + 32));
        assert!(kept.take(&part(0, 16), 1.into()).is_none() && kept.take(&part(8, 24), 2.into()).is_none());
        assert!(kept.take(&part(8, 24), 1.into()).is_some() && kept.take(&part(8, 24), 1.into()).is_none());
        kept.put(&part(0, 64), 3.into(), Found::default());
        assert_eq!(kept.rays, 8 * 64 * 3);
        let large = Window::whole(2000, 2000);
        kept.put(&large, 3.into(), Found::default());
        assert!(kept.take(&large, 3.into()).is_none() && kept.rays == 8 * 64 * 3);
    }
}
