//! Values of options: parsers, and the messages for wrong values.

use cosine_lobes::visibility_shadowmap::MapOptions;
use std::ops::RangeInclusive;

fn number(text: &str, range: &str, good: impl Fn(f32) -> bool) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(value) if good(value) => Ok(value),
        _ => Err(format!("expected a number {range}")),
    }
}

/// A whole number of that range.
pub(super) fn whole(range: RangeInclusive<u32>) -> impl Fn(&str) -> Result<u32, String> + Clone + Send + Sync {
    move |text| match text.parse() {
        Ok(value) if range.contains(&value) => Ok(value),
        _ => Err(format!("expected a whole number from {} to {}", range.start(), range.end())),
    }
}

pub(super) fn seed(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| format!("expected a whole number from 0 to {}", u64::MAX))
}

pub(super) fn tolerance(text: &str) -> Result<f32, String> {
    number(text, "above 0 and at most 0.1", |x| x > 0.0 && x <= 0.1)
}

pub(super) fn threshold(text: &str) -> Result<f32, String> {
    number(text, "of at least 0", |x| x >= 0.0 && x.is_finite())
}

pub(super) fn exposure(text: &str) -> Result<f32, String> {
    number(text, "from -32 to 32", |x| x.abs() <= 32.0)
}

pub(super) fn fraction(text: &str) -> Result<f32, String> {
    number(text, "above 0, at most 1", |x| x > 0.0 && x <= 1.0)
}

pub(super) fn positive(text: &str) -> Result<f32, String> {
    number(text, "above 0", |x| x > 0.0 && x.is_finite())
}

pub(super) fn crease(text: &str) -> Result<f32, String> {
    number(text, "above 0, at most 180", |x| x > 0.0 && x <= 180.0)
}

pub(super) fn time(text: &str) -> Result<f32, String> {
    number(text, "of at least 0, finite in single precision", |x| x >= 0.0 && x.is_finite())
}

pub(super) fn fps(text: &str) -> Result<f32, String> {
    number(text, "above 0 and at most 10000", |x| x > 0.0 && x <= 1e4)
}

pub(super) fn frames(text: &str) -> Result<(u32, u32), String> {
    let ends = text.split_once("..").map(|(a, b)| (a.parse::<u32>(), b.parse::<u32>()));
    match ends {
        Some((Ok(a), Ok(b))) if a < b => Ok((a, b)),
        Some((Ok(a), Ok(b))) => Err(format!("there are no frames from {a} to before {b}")),
        _ => Err("expected A..B, such as 0..24".to_owned()),
    }
}

pub(super) fn crop(text: &str) -> Result<[u32; 4], String> {
    let numbers: Vec<u32> = text.split(',').map_while(|t| t.trim().parse().ok()).collect();
    match numbers[..] {
        [x0, y0, x1, y1] if text.split(',').count() == 4 && x0 < x1 && y0 < y1 => Ok([x0, y0, x1, y1]),
        _ => Err("expected X0,Y0,X1,Y1 with X0 < X1 and Y0 < Y1, such as 0,0,320,180".to_owned()),
    }
}

pub(super) fn tiles(text: &str) -> Result<(u32, u32), String> {
    match text.split_once('/').map(|(i, n)| (i.parse(), n.parse())) {
        Some((Ok(i), Ok(n))) if 1 <= i && i <= n => Ok((i, n)),
        _ => Err("expected I/N, the I-th of N parts from 1, such as 2/8".to_owned()),
    }
}

pub(super) fn map_resolution(text: &str) -> Result<u32, String> {
    let (least, most) = (MapOptions::MIN_RESOLUTION, MapOptions::MAX_RESOLUTION);
    let good = text.parse::<u32>().ok().filter(|n| (least..=most).contains(n));
    good.ok_or_else(|| format!("a shadow map has {least} to {most} texels a side"))
}

pub(super) fn size(text: &str) -> Result<(u32, u32), String> {
    let side = |t: &str| t.parse::<u32>().ok().filter(|n| (1..=16384).contains(n));
    match text.split_once(['x', 'X', '×']).map(|(w, h)| (side(w), side(h))) {
        Some((Some(w), Some(h))) => Ok((w, h)),
        _ => Err("expected WIDTHxHEIGHT, each from 1 to 16384, such as 640x360".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_checked() {
        assert_eq!(size("640x360"), Ok((640, 360)));
        for bad in ["0x0", "640", "x", "1x", "-1x5", "16385x1", "1x1x1", "1.5x2", "999999999999x1"] {
            assert!(size(bad).is_err(), "{bad}");
        }
        for bad in ["0", "-1", "NaN", "inf", "0.11", "", "x"] {
            assert!(tolerance(bad).is_err(), "{bad}");
        }
        assert_eq!(tolerance("0.1"), Ok(0.1));
        assert_eq!(whole(1..=8)("8"), Ok(8));
        for bad in ["0", "9", "-1", "1.5", "", "x", "99999999999999999999"] {
            assert_eq!(whole(1..=8)(bad), Err("expected a whole number from 1 to 8".to_owned()), "{bad}");
        }
        for bad in ["", "1,2,3", "0,0,0,1", "0,0,1,0", "0,0,1,1,1", "0,0,-1,1", "a,0,1,1"] {
            assert!(crop(bad).is_err(), "{bad}");
        }
        assert_eq!(crop("0,8,16,24"), Ok([0, 8, 16, 24]));
        for bad in ["", "0/1", "2/1", "1", "1/0", "-1/2", "1/2/3"] {
            assert!(tiles(bad).is_err(), "{bad}");
        }
        assert_eq!(tiles("2/8"), Ok((2, 8)));
        assert!(threshold("-1e-9").is_err() && exposure("nan").is_err() && positive("0").is_err());
    }
}
