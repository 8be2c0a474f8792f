use core::f64::consts::FRAC_PI_2;

/// Range of the transformed variable: beyond it the weights are below 1e-21.
const REACH: f64 = 3.5;
/// Step `1/2^LEVELS` of the finest rule.
const LEVELS: u32 = 9;
/// Two successive rules that agree to this are taken for converged: the rule's error falls as the square of it.
const AGREEMENT: f64 = 1e-12;

/// `∫ f` over an interval of the given length by the double-exponential rule (H. Takahasi, M. Mori, 1974).
///
/// `f(left, right)` gets the distances to both ends, each with full relative precision, so that an algebraic
/// singularity at either end is integrated as precisely as a smooth function. `f` must be bounded.
pub(super) fn integrate(length: f64, mut f: impl FnMut(f64, f64) -> f64) -> f64 {
    if length.is_nan() || length <= 0.0 {
        return 0.0;
    }
    let mut node = |t: f64| {
        let q = core::f64::consts::PI * t.sinh();
        let (left, right) = (1.0 / (1.0 + (-q).exp()), 1.0 / (1.0 + q.exp()));
        f(length * left, length * right) * left * right * t.cosh()
    };
    let mut step = 0.25;
    let mut sum = node(0.0);
    for i in 1..=(REACH / step) as u32 {
        sum += node(f64::from(i) * step) + node(-f64::from(i) * step);
    }
    let mut value = sum * step;
    for _ in 3..=LEVELS {
        step *= 0.5;
        let mut t = step;
        while t <= REACH {
            sum += node(t) + node(-t);
            t += 2.0 * step;
        }
        let finer = sum * step;
        let done = (finer - value).abs() <= AGREEMENT * finer.abs();
        value = finer;
        if done {
            break;
        }
    }
    value * length * 2.0 * FRAC_PI_2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smooth_and_singular_integrands() {
        let close = |a: f64, b: f64| assert!((a - b).abs() <= 2e-14 * b.abs(), "{a} {b}");
        close(integrate(2.0, |_, _| 3.0), 6.0);
        close(integrate(1.0, |x, _| x.exp()), 1.0f64.exp() - 1.0);
        close(integrate(4.0, |x, _| x.sqrt()), 16.0 / 3.0);
        close(integrate(1.0, |x, y| (x * y).sqrt()), core::f64::consts::PI / 8.0);
        close(integrate(9.0, |_, y| (-y * y / 2.0).exp()), FRAC_PI_2.sqrt());
        assert_eq!(integrate(0.0, |_, _| 1.0), 0.0);
    }
}
