//! Decimal numbers in single precision, for files of many numbers.

/// The powers of ten that double precision has exactly.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];

/// The number that a word writes, with the bits and for the words of `str::parse`. Most words take a third of its time.
///
/// Up to 19 digits are a whole number, which is multiplied with a power of ten in double precision: two roundings, so that the product errs
/// by less than two units of its last place. It rounds to single precision as the exact number does, unless it is as near as that to the
/// middle of two single ones. `str::parse` reads the rest.
pub(crate) fn parse(word: &str) -> Option<f32> {
    quick(word.as_bytes()).or_else(|| word.parse().ok())
}

fn quick(word: &[u8]) -> Option<f32> {
    let (is_negative, digits) = match word {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, word),
    };
    let (mut whole, mut exponent, mut count, mut point) = (0_u64, 0_i32, 0, None);
    let mut place = 0;
    while let Some(byte) = digits.get(place) {
        match byte {
            b'0'..=b'9' => {
                whole = whole.wrapping_mul(10).wrapping_add(u64::from(byte - b'0'));
                count += 1;
            }
            b'.' if point.is_none() => point = Some(count),
            b'e' | b'E' => {
                exponent = power(&digits[place + 1..])?;
                break;
            }
            _ => return None,
        }
        place += 1;
    }
    // Leading zeros count, which few numbers have many of.
    if count == 0 || count > 19 {
        return None;
    }
    exponent -= count - point.unwrap_or(count);
    let power = POWERS.get(exponent.unsigned_abs() as usize)?;
    let value = if exponent < 0 { whole as f64 / power } else { whole as f64 * power };
    // The bits that single precision has no room for: half of its last place is the highest of these.
    const MIDDLE: u64 = 1 << 28;
    let is_near_middle = (value.to_bits() & (2 * MIDDLE - 1)).abs_diff(MIDDLE) <= 4;
    let is_plain = value == 0.0 || (1e-30..1e30).contains(&value);
    (is_plain && !is_near_middle).then_some(if is_negative { -value as f32 } else { value as f32 })
}

/// A power of ten, with a sign or without.
fn power(word: &[u8]) -> Option<i32> {
    let (sign, digits) = match word {
        [b'-', rest @ ..] => (-1, rest),
        [b'+', rest @ ..] => (1, rest),
        _ => (1, word),
    };
    let is_number = (1..=4).contains(&digits.len()) && digits.iter().all(u8::is_ascii_digit);
    is_number.then(|| sign * digits.iter().fold(0, |sum, digit| 10 * sum + i32::from(digit - b'0')))
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_core::Random;

    fn check(word: &str) {
        let [own, wanted] = [parse(word), word.parse().ok()].map(|x: Option<f32>| x.map(f32::to_bits));
        assert_eq!(own, wanted, "{word}");
    }

    #[test]
    fn words_are_read_as_the_standard_library_reads_them() {
        for word in [
            "",
            "-",
            "+",
            ".",
            "-.",
            "e5",
            ".e5",
            "1e",
            "1e+",
            "1e-",
            "1.2.3",
            "1,5",
            "0x10",
            "1f",
            " 1",
            "1 ",
            "--1",
            "1e5.0",
            "1_000",
            "٣",
            "NaN",
            "nan",
            "inf",
            "-inf",
            "infinity",
            "+Infinity",
            "0",
            "-0",
            "+0",
            "-0.0e9",
            "00000000000000000000",
            "0000000000000000000001",
            "1.",
            ".5",
            "-.5e1",
            "+5.e-1",
            "1E5",
            "1e38",
            "3.5e38",
            "1e39",
            "-1e39",
            "1e-45",
            "1e-46",
            "7e-46",
            "1.17549435e-38",
            "1e-400",
            "1e99999",
            "1e00001",
            "1e-00022",
            "9999999999999999999",
            "99999999999999999999",
            "16777217",
            "16777217.0000000001",
            "16777216.9999999999",
            "1.00000005960464477539",
            "0.35444599999999998",
        ] {
            check(word);
        }
    }

    /// Numbers of all lengths and sizes, those in the middle of two numbers of single precision, and those beside a middle.
    #[test]
    fn bits_are_those_of_the_standard_library() {
        let mut random = Random::new(11);
        let mut quickly = 0;
        for k in 0..200_000_u32 {
            let bits = (random.uniform() * 4_294_967_296.0) as u32;
            let single = f32::from_bits(bits);
            let scaled = (random.uniform() - 0.5) * 10_f64.powi(bits as i32 % 12);
            let middle = 0.5 * (f64::from(scaled as f32) + f64::from((scaled as f32).next_up()));
            let beside = f64::from_bits(middle.to_bits() + u64::from(k % 9));
            let word = match k % 6 {
                0 => format!("{single}"),
                1 => format!("{single:e}"),
                2 => format!("{scaled:.*}", bits as usize % 18),
                3 => format!("{middle}"),
                4 => format!("{beside}"),
                _ => {
                    format!("{}{}.{}e{}", if k.is_multiple_of(5) { "" } else { "-" }, bits / 77, bits, bits as i32 % 31)
                }
            };
            check(&word);
            quickly += u32::from(quick(word.as_bytes()).is_some());
        }
        assert!(quickly > 80_000, "{quickly}");
    }
}
