use crate::MaterialError;
use core::f32::consts::{FRAC_PI_2, PI};
use glam::Vec3;

/// An isotropic reflectance measured at 90 × 90 × 180 pairs of directions, as the MERL database stores it (W. Matusik, H. Pfister, M. Brand,
/// L. McMillan, *A Data-Driven Reflectance Model*, 2003): by half and difference angle (S. Rusinkiewicz, 1998).
///
/// [`fit`](crate::fit()) makes lobes of it.
///
/// ```no_run
/// let measured = brdf::Merl::read(&std::fs::read("gold-metallic-paint.binary")?)?;
/// let fitted = brdf::fit(|i, o| measured.eval(i, o), 2)?;
/// println!("{:.1} % off: {:?}", 100.0 * fitted.residual, fitted.model);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Merl {
    /// All red values, all green ones, all blue ones.
    values: Vec<f32>,
}

/// Of θ_h, θ_d and φ_d.
const SIZE: [usize; 3] = [90, 90, 180];
const COUNT: usize = SIZE[0] * SIZE[1] * SIZE[2];
/// Scales of the three channels.
const SCALES: [f64; 3] = [1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0];

impl Merl {
    /// Reads the bytes of a file: three sizes as 32-bit integers, then the numbers of each channel as doubles, all little-endian. Values
    /// below zero, which mark what was not measured, are 0.
    ///
    /// # Errors
    /// [`MaterialError::Table`] for other sizes, too few bytes, and values that are NaN or above 1e12.
    pub fn read(bytes: &[u8]) -> Result<Self, MaterialError> {
        let fault = |what: String| Err(MaterialError::Table { what });
        let (header, rest) = bytes.split_at_checked(12).unwrap_or((&[], &[]));
        let sizes: Vec<i32> = header.chunks_exact(4).map(|b| i32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        if sizes.len() < 3 || sizes.iter().zip(SIZE).any(|(found, want)| *found != want as i32) {
            return fault(format!("begins with sizes {sizes:?}: expected {SIZE:?}"));
        }
        let (doubles, _) = rest.as_chunks::<8>();
        if doubles.len() < 3 * COUNT {
            return fault(format!("ends after {} of {} numbers", doubles.len(), 3 * COUNT));
        }
        let mut values = Vec::with_capacity(3 * COUNT);
        for (i, bytes) in doubles[..3 * COUNT].iter().enumerate() {
            let value = f64::from_le_bytes(*bytes) * SCALES[i / COUNT];
            if value.is_nan() || value > f64::from(crate::error::MAX_COEFFICIENT) {
                return fault(format!("number {i} is {value}: expected at most 1e12"));
            }
            values.push(value.max(0.0) as f32);
        }
        Ok(Self { values })
    }

    /// The reflectance `f_r` in sr⁻¹ for unit directions to light and eye in the frame whose third axis is the normal: the nearest value
    /// measured; 0 below the horizon.
    #[must_use]
    pub fn eval(&self, incoming: Vec3, outgoing: Vec3) -> Vec3 {
        if incoming.z <= 0.0 || outgoing.z <= 0.0 {
            return Vec3::ZERO;
        }
        let half = (incoming + outgoing).normalize_or(Vec3::Z);
        let theta_h = half.truncate().length().atan2(half.z);
        // The light's direction as seen from the half vector.
        let turned = {
            let across = half.truncate().normalize_or(glam::Vec2::X);
            let (x, y) = (incoming.x * across.x + incoming.y * across.y, incoming.y * across.x - incoming.x * across.y);
            let (s, c) = theta_h.sin_cos();
            Vec3::new(x * c - incoming.z * s, y, x * s + incoming.z * c)
        };
        let theta_d = turned.truncate().length().atan2(turned.z);
        let phi = turned.y.atan2(turned.x);
        // Light and eye may change places.
        let phi = if phi < 0.0 { phi + PI } else { phi };
        let place = |share: f32, n: usize| ((share * n as f32) as usize).min(n - 1);
        let h = place((theta_h / FRAC_PI_2).sqrt(), SIZE[0]);
        let index = place(phi / PI, SIZE[2]) + SIZE[2] * (place(theta_d / FRAC_PI_2, SIZE[1]) + SIZE[1] * h);
        Vec3::new(self.values[index], self.values[COUNT + index], self.values[2 * COUNT + index])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit_lafortune;

    /// A file of Phong's highlight over a diffuse part, by the middles of the cells.
    fn file() -> Vec<u8> {
        let mut bytes: Vec<u8> = SIZE.iter().flat_map(|n| (*n as i32).to_le_bytes()).collect();
        let mut channels = [const { Vec::new() }; 3];
        for h in 0..SIZE[0] {
            for d in 0..SIZE[1] {
                for p in 0..SIZE[2] {
                    let node = |i: usize, n: usize| (i as f32 + 0.5) / n as f32;
                    let (hs, hc) = (FRAC_PI_2 * node(h, SIZE[0]).powi(2)).sin_cos();
                    let (ds, dc) = (FRAC_PI_2 * node(d, SIZE[1])).sin_cos();
                    let (ps, pc) = (PI * node(p, SIZE[2])).sin_cos();
                    let local = Vec3::new(ds * pc, ds * ps, dc);
                    let i = Vec3::new(local.x * hc + local.z * hs, local.y, local.z * hc - local.x * hs);
                    let o = 2.0 * dc * Vec3::new(hs, 0.0, hc) - i;
                    // Not measured.
                    let value = if i.z < 0.0 || o.z < 0.0 { Vec3::NEG_ONE } else { measured(i, o) };
                    channels.iter_mut().zip(value.to_array()).for_each(|(c, v)| c.push(v));
                }
            }
        }
        for (channel, scale) in channels.iter().zip(SCALES) {
            bytes.extend(channel.iter().flat_map(|v| (f64::from(*v) / scale).to_le_bytes()));
        }
        bytes
    }

    fn measured(i: Vec3, o: Vec3) -> Vec3 {
        let mirrored = Vec3::new(-o.x, -o.y, o.z);
        Vec3::new(0.1, 0.05, 0.02) + Vec3::new(0.3, 0.6, 0.9) * i.dot(mirrored).max(0.0).powi(25)
    }

    #[test]
    fn a_table_gives_what_was_measured_and_becomes_lobes() {
        let table = Merl::read(&file()).expect("a table");
        let mut worst = 0.0_f32;
        // Of low discrepancy in four dimensions.
        let uniform = |n: u32, k: i32| (f64::from(n) * 1.167_303_978_261_418_7_f64.powi(-k)).fract() as f32;
        for n in 1..20_000 {
            let direction = |k: i32| {
                let ((s, c), b) = ((core::f32::consts::TAU * uniform(n, k)).sin_cos(), uniform(n, k + 1));
                Vec3::new(b.sqrt() * c, b.sqrt() * s, (1.0 - b).sqrt().max(0.05)).normalize()
            };
            let (i, o) = (direction(1), direction(3));
            worst = worst.max((table.eval(i, o) - measured(i, o)).abs().max_element());
            // Light and eye change places.
            let change = (table.eval(i, o) - table.eval(o, i)).abs().max_element();
            assert!(change < 0.03, "{i} {o}: {change}");
        }
        println!("largest difference {worst:.3} of a peak of 0.9");
        assert!(worst < 0.06, "{worst}");
        let fitted = fit_lafortune(|i, o| table.eval(i, o), 1).expect("finite values");
        println!("{fitted:?}");
        assert!(fitted.residual < 0.03 && (fitted.model.lobes[0].exponent() - 25.0).abs() < 2.0, "{fitted:?}");
    }

    #[test]
    fn broken_tables_are_refused_in_one_line() {
        let whole = file();
        let mut other = whole.clone();
        other[0] = 91;
        let mut infinite = whole.clone();
        infinite[12..20].copy_from_slice(&f64::INFINITY.to_le_bytes());
        for bytes in [&[][..], &whole[..11], &whole[..12], &whole[..whole.len() - 1], &other, &infinite] {
            let message = Merl::read(bytes).expect_err("broken").to_string();
            assert!(!message.contains('\n') && message.starts_with("table"), "{message}");
        }
    }
}
