use core::fmt::Write as _;

/// A text in WGSL, the numbers that it takes from Rust, and the other pieces that it needs.
///
/// A number stands once, in Rust: the module's text has `const NAME = …;` for it. A piece names what its functions call, so the list of a
/// module's pieces says what the module is for.
///
/// ```
/// use lobe_core::wgsl::{self, Piece, join};
///
/// const STEEPNESS: f32 = 12.0;
/// static WINDOW: Piece = Piece::new("fn window(x: f32) -> f32 { return exp_f32(-STEEPNESS * x); }")
///     .numbers(lobe_core::wgsl_numbers![STEEPNESS = STEEPNESS])
///     .needs(&[&wgsl::SPECIAL]);
///
/// let text = join(&[&WINDOW, &wgsl::LOBE]);
/// assert!(text.contains("const STEEPNESS = 12.0f;"));
/// // Lobes need the special functions too: they are there once.
/// assert_eq!(text.matches("fn exp_f32").count(), 1);
/// ```
#[derive(Debug)]
pub struct Piece {
    text: &'static str,
    numbers: fn() -> String,
    needs: &'static [&'static Self],
}

/// The same one: a text may stand in several.
impl PartialEq for Piece {
    fn eq(&self, other: &Self) -> bool {
        core::ptr::eq(self, other)
    }
}

impl Eq for Piece {}

impl Piece {
    /// One of this text.
    #[must_use]
    pub const fn new(text: &'static str) -> Self {
        Self { text, numbers: String::new, needs: &[] }
    }

    /// With constants: [`wgsl_numbers!`](crate::wgsl_numbers) makes such a function.
    #[must_use]
    pub const fn numbers(self, numbers: fn() -> String) -> Self {
        Self { numbers, ..self }
    }

    /// With what its functions call. Pieces do not need each other in a circle.
    #[must_use]
    pub const fn needs(self, needs: &'static [&'static Self]) -> Self {
        Self { needs, ..self }
    }

    /// Its own text, after its constants.
    #[must_use]
    pub fn text(&self) -> String {
        (self.numbers)() + self.text
    }

    fn find(&'static self, found: &mut Vec<&'static Self>) {
        if !found.contains(&self) {
            self.needs.iter().for_each(|piece| piece.find(found));
            found.push(self);
        }
    }
}

/// The text of a module: the pieces and all that they need, each once, after what it needs.
#[must_use]
pub fn join(pieces: &[&'static Piece]) -> String {
    let mut found = Vec::new();
    pieces.iter().for_each(|piece| piece.find(&mut found));
    found.iter().map(|piece| piece.text() + "\n").collect()
}

/// A number, or several, as WGSL writes them.
pub trait Number {
    /// Adds the expression to a text.
    fn write(&self, out: &mut String);
}

/// Infinite ones become the largest number, and what is none becomes 0: WGSL has neither.
impl Number for f32 {
    fn write(&self, out: &mut String) {
        let finite = if self.is_nan() { 0.0 } else { self.clamp(Self::MIN, Self::MAX) };
        if finite.abs() == Self::MAX {
            // The shortest digits of the largest number are above it: browsers refuse them.
            out.push_str(if finite < 0.0 { "-3.40282346e38f" } else { "3.40282346e38f" });
            return;
        }
        let _ = write!(out, "{finite:?}f");
    }
}

impl Number for u32 {
    fn write(&self, out: &mut String) {
        let _ = write!(out, "{self}u");
    }
}

/// A `u32`: larger ones are its largest.
impl Number for usize {
    fn write(&self, out: &mut String) {
        u32::try_from(*self).unwrap_or(u32::MAX).write(out);
    }
}

/// Adds `name(…, …)`.
fn write_call(name: &str, numbers: &[impl Number], out: &mut String) {
    out.push_str(name);
    out.push('(');
    for (k, number) in numbers.iter().enumerate() {
        out.push_str(if k > 0 { ", " } else { "" });
        number.write(out);
    }
    out.push(')');
}

/// A `vec2f`.
impl Number for (f32, f32) {
    fn write(&self, out: &mut String) {
        write_call("vec2f", &[self.0, self.1], out);
    }
}

/// A `vec3f`.
impl Number for glam::Vec3 {
    fn write(&self, out: &mut String) {
        write_call("vec3f", &self.to_array(), out);
    }
}

/// An array, which is not empty.
impl<T: Number> Number for [T] {
    fn write(&self, out: &mut String) {
        write_call("array", self, out);
    }
}

/// An array, which is not empty.
impl<T: Number, const N: usize> Number for [T; N] {
    fn write(&self, out: &mut String) {
        self.as_slice().write(out);
    }
}

/// An array, which is not empty.
impl<T: Number> Number for Vec<T> {
    fn write(&self, out: &mut String) {
        self.as_slice().write(out);
    }
}

/// The line `const NAME = …;`.
#[must_use]
pub fn constant(name: &str, number: &impl Number) -> String {
    let mut line = format!("const {name} = ");
    number.write(&mut line);
    line + ";\n"
}

/// Constants of WGSL by their values in Rust: a function for [`Piece::numbers`](crate::wgsl::Piece::numbers).
///
/// ```
/// let numbers: fn() -> String = lobe_core::wgsl_numbers![FEW = 6_u32, HALF_ROOT = core::f32::consts::FRAC_1_SQRT_2];
/// assert_eq!(numbers(), "const FEW = 6u;\nconst HALF_ROOT = 0.70710677f;\n");
/// ```
#[macro_export]
macro_rules! wgsl_numbers {
    ($($name:ident = $number:expr),+ $(,)?) => {
        || [$($crate::wgsl::constant(stringify!($name), &$number)),+].concat()
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_back_to_the_bit() {
        assert_eq!(constant("X", &f32::INFINITY), "const X = 3.40282346e38f;\n");
        let mut random = crate::Random::new(5);
        for _ in 0..10_000 {
            let number = f32::from_bits(random.bits() as u32);
            let text = constant("X", &number);
            let read = text.trim_start_matches("const X = ").trim_end_matches("f;\n").parse::<f32>().expect("a number");
            let want = if number.is_nan() { 0.0 } else { number.clamp(f32::MIN, f32::MAX) };
            assert_eq!(read.to_bits(), want.to_bits(), "{text}");
        }
        assert_eq!(
            constant("A", &[(0.5, -1.0), (2.0, 1e9)]),
            "const A = array(vec2f(0.5f, -1.0f), vec2f(2.0f, 1000000000.0f));\n"
        );
        assert_eq!(constant("V", &glam::Vec3::new(0.5, -1.0, 2.0)), "const V = vec3f(0.5f, -1.0f, 2.0f);\n");
        assert_eq!(constant("N", &usize::MAX), "const N = 4294967295u;\n");
    }

    #[test]
    fn each_piece_is_there_once_and_after_its_needs() {
        static A: Piece = Piece::new("a");
        static B: Piece = Piece::new("b").needs(&[&A]);
        static C: Piece = Piece::new("c").needs(&[&A, &B]);
        // By place, not by text: the same text may be another piece's.
        static ALSO_A: Piece = Piece::new("a").numbers(wgsl_numbers![N = 1_u32]);
        assert_eq!(join(&[&C, &B]), "a\nb\nc\n");
        assert_eq!(join(&[&ALSO_A, &A]), "const N = 1u;\na\na\n");
    }
}
