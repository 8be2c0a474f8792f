/// `ln B(n)` and its derivative, `B(n) = √π Γ(n/2+1)/Γ(n/2+3/2)`: the integral of `cos^(n+1)` along a meridian, which is
/// what the direction across the plane of coplanar lobes contributes to their product's integral.
///
/// Recurrence `B(n) = B(n+2)·(n+3)/(n+2)`, then the asymptotic series in `w = n/2 + 3/4` (never a difference of ln Γ).
pub(crate) fn ln_meridian(n: f64) -> (f64, f64) {
    let (mut n, mut ln, mut slope) = (n, 0.5 * core::f64::consts::PI.ln(), 0.0);
    while n < 20.0 {
        ln += (1.0 / (n + 2.0)).ln_1p();
        slope += 1.0 / (n + 3.0) - 1.0 / (n + 2.0);
        n += 2.0;
    }
    let w = 0.5 * n + 0.75;
    let x = 1.0 / (w * w);
    ln += -0.5 * w.ln() + x * (-1.0 / 64.0 + x * (5.0 / 2048.0 + x * (-61.0 / 49152.0)));
    slope += 0.5 / w * (-0.5 + x * (1.0 / 32.0 + x * (-5.0 / 512.0 + x * (61.0 / 8192.0))));
    (ln, slope)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_core::oracle;

    #[test]
    fn value_and_slope() {
        for n in [0.0, 0.3, 1.0, 5.0, 19.9, 20.1, 300.0, 1e5, 1e7] {
            let (ln, slope) = ln_meridian(n);
            assert!((ln - oracle::meridian(n).ln()).abs() < 1e-11, "{n}");
            let h = 1e-3 * (1.0 + n);
            let difference = (oracle::meridian(n + h).ln() - oracle::meridian(n).ln()) / h;
            let middle = ln_meridian(n + 0.5 * h).1;
            assert!((difference - middle).abs() < 1e-6 * slope.abs(), "{n} {difference} {middle}");
        }
    }
}
