use crate::flip::{PIXELS_PER_DEGREE, flip};
use crate::{Picture, SizesDiffer, luminance, srgb_bytes};

/// Per-pixel visual difference between two pictures as an observer sees them on a screen.
///
/// FLIP (P. Andersson et al., *FLIP: A Difference Evaluator for Alternating Images*, Proc. ACM Comput. Graph. Interact.
/// Tech. 3(2), 2020), low dynamic range: both pictures times `2^exposure`, clamped and coded in eight-bit sRGB, seen at
/// 67 pixels a degree.
pub struct FlipMap {
    values: Vec<f32>,
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
        let [test, reference] = [test, reference].map(|p| (srgb_bytes(p, exposure), p.width()));
        Ok(Self { values: flip(&reference.0, &test.0, reference.1, PIXELS_PER_DEGREE) })
    }

    /// Mean over the pixels: 0 no difference, 1 the largest one.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.values.iter().map(|v| f64::from(*v)).sum::<f64>() / self.values.len().max(1) as f64
    }

    /// RGB bytes in the "magma" colours: black no difference, bright yellow the largest one.
    #[must_use]
    pub fn rgb_bytes(&self) -> Vec<u8> {
        self.values.iter().flat_map(|v| magma(*v)).collect()
    }
}

/// Every fifth of the 256 colours of the map "magma" (S. van der Walt and N. Smith, CC0). Linear interpolation meets the
/// others to one unit of a byte.
const MAGMA: [u32; 52] = [
    0x00_0004, 0x02_020b, 0x05_0416, 0x09_0720, 0x0e_0b2b, 0x14_0e36, 0x1a_1042, 0x21_114e, 0x29_115a, 0x31_1165,
    0x39_0f6e, 0x42_0f75, 0x4a_1079, 0x52_137c, 0x5a_167e, 0x62_1980, 0x6a_1c81, 0x72_1f81, 0x79_2282, 0x81_2581,
    0x89_2881, 0x91_2b81, 0x99_2d80, 0xa1_307e, 0xaa_337d, 0xb2_357b, 0xba_3878, 0xc2_3b75, 0xca_3e72, 0xd2_426f,
    0xd9_466b, 0xe0_4c67, 0xe7_5263, 0xec_5860, 0xf1_605d, 0xf4_695c, 0xf7_725c, 0xf9_7b5d, 0xfb_8560, 0xfc_8e64,
    0xfd_9869, 0xfe_a16e, 0xfe_aa74, 0xfe_b47b, 0xfe_bd82, 0xfe_c68a, 0xfe_cf92, 0xfe_d89a, 0xfd_e2a3, 0xfd_ebac,
    0xfc_f4b6, 0xfc_fdbf,
];

/// RGB of a value in [0, 1] in the "magma" colours.
fn magma(value: f32) -> [u8; 3] {
    let at = value.clamp(0.0, 1.0) * (MAGMA.len() - 1) as f32;
    let low = (at as usize).min(MAGMA.len() - 2);
    let [_, from @ ..] = MAGMA[low].to_be_bytes().map(f32::from);
    let [_, to @ ..] = MAGMA[low + 1].to_be_bytes().map(f32::from);
    [0, 1, 2].map(|k| (from[k] + (to[k] - from[k]) * (at - low as f32) + 0.5) as u8)
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
    fn magma_ends_and_middle() {
        // Colours 0, 128 and 255 of the map.
        assert_eq!(magma(0.0), [0, 0, 4]);
        let middle = magma(128.0 / 255.0);
        assert!(middle.iter().zip([183, 55, 121]).all(|(a, b)| a.abs_diff(b) <= 1), "{middle:?}");
        assert_eq!(magma(1.0), [252, 253, 191]);
        assert_eq!(magma(f32::INFINITY), magma(1.0));
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
