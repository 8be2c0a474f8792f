use crate::{Picture, SizesDiffer, luminance, srgb_bytes};
use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageFloat, FlipImageRgb8, flip, magma_lut};

/// Per-pixel visual difference between two pictures as an observer sees them on a screen.
///
/// FLIP (P. Andersson et al., *FLIP: A Difference Evaluator for Alternating Images*, HPG 2020), low dynamic range: both
/// pictures times `2^exposure`, clamped and coded in eight-bit sRGB, seen at 67 pixels a degree.
pub struct FlipMap {
    map: FlipImageFloat,
}

impl FlipMap {
    /// Compares `test` with `reference`.
    ///
    /// # Errors
    /// When the sizes differ.
    pub fn of(test: &Picture, reference: &Picture, exposure: f32) -> Result<Self, SizesDiffer> {
        let size = |p: &Picture| (p.width(), p.height());
        if size(test) != size(reference) {
            return Err(SizesDiffer { test: size(test), reference: size(reference) });
        }
        let image =
            |p: &Picture| FlipImageRgb8::with_data(p.width() as u32, p.height() as u32, &srgb_bytes(p, exposure));
        Ok(Self { map: flip(image(reference), image(test), DEFAULT_PIXELS_PER_DEGREE) })
    }

    /// Mean over the pixels: 0 no difference, 1 the largest one.
    #[must_use]
    pub fn mean(&self) -> f64 {
        let values = self.map.to_vec();
        values.iter().map(|v| f64::from(*v)).sum::<f64>() / values.len().max(1) as f64
    }

    /// RGB bytes in the "magma" colours: black no difference, bright yellow the largest one.
    #[must_use]
    pub fn rgb_bytes(&self) -> Vec<u8> {
        self.map.apply_color_lut(&magma_lut()).to_vec()
    }
}

/// RGB bytes that show the signed difference of luminance: red where `test` is brighter, blue where it is darker, white
/// at no difference and full colour from `±scale` on.
///
/// # Errors
/// When the sizes differ.
pub fn signed_difference(test: &Picture, reference: &Picture, scale: f64) -> Result<Vec<u8>, SizesDiffer> {
    let size = |p: &Picture| (p.width(), p.height());
    if size(test) != size(reference) {
        return Err(SizesDiffer { test: size(test), reference: size(reference) });
    }
    let color = |(a, b): (&glam::Vec3, &glam::Vec3)| {
        let d = luminance(*a) - luminance(*b);
        let t = if d == 0.0 { 0.0 } else { (d / scale.abs()).clamp(-1.0, 1.0) };
        // From white to a red and a blue of about equal darkness.
        let end = if t > 0.0 { [178.0, 24.0, 43.0] } else { [33.0, 102.0, 172.0] };
        end.map(|e: f64| (255.0 + (e - 255.0) * t.abs() + 0.5) as u8)
    };
    Ok(test.pixels().iter().zip(reference.pixels()).flat_map(color).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn signs_have_their_hues() {
        let p = |v: [f32; 3]| Picture::new(3, 1, v.map(Vec3::splat).to_vec());
        let rgb = signed_difference(&p([2.0, 1.0, 0.0]), &p([1.0; 3]), 1.0).unwrap();
        assert!(rgb[0] > rgb[2], "brighter is red");
        assert_eq!(rgb[3..6], [255; 3]);
        assert!(rgb[8] > rgb[6], "darker is blue");
    }

    #[test]
    fn flip_of_equal_and_opposite() {
        let p = |v: f32| Picture::new(32, 32, vec![Vec3::splat(v); 1024]);
        assert_eq!(FlipMap::of(&p(0.5), &p(0.5), 0.0).unwrap().mean(), 0.0);
        let far = FlipMap::of(&p(0.0), &p(1.0), 0.0).unwrap();
        assert!(far.mean() > 0.9, "{}", far.mean());
        assert_eq!(far.rgb_bytes().len(), 3072);
    }
}
