use glam::Vec3;

/// A parameter of a material that is refused. The message is one line that names the parameter and what it may be.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum MaterialError {
    /// A coefficient is NaN, infinite, negative or above 1e12.
    Coefficient {
        /// Which parameter.
        name: &'static str,
        /// The value found.
        value: Vec3,
    },
    /// An exponent is outside [0, 1e7].
    Exponent {
        /// The value found.
        value: f32,
    },
    /// The exponent of a metal's highlight is outside [1, 1e7].
    MetalExponent {
        /// The value found.
        value: f32,
    },
    /// A fraction is NaN or outside [0, 1].
    Fraction {
        /// Which parameter.
        name: &'static str,
        /// The value found.
        value: f32,
    },
    /// A Lafortune matrix has an entry that is NaN, infinite or beyond ±1e12.
    Matrix,
    /// A Lafortune matrix is not symmetric, hence the model not reciprocal.
    Asymmetric,
    /// A table of measurements is not what its format says.
    Table {
        /// The fault.
        what: String,
    },
    /// A Lafortune lobe's peak `k·‖M‖^e` is above 1e12.
    Peak {
        /// Natural logarithm of the peak.
        ln_peak: f64,
    },
}

impl core::fmt::Display for MaterialError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Coefficient { name, value } => {
                write!(f, "{name} is {value}: every channel must lie in [0, 1e12]")
            }
            Self::Exponent { value } => write!(f, "exponent is {value}: it must lie in [0, 1e7]"),
            Self::MetalExponent { value } => write!(f, "exponent is {value}: of this model it must lie in [1, 1e7]"),
            Self::Fraction { name, value } => write!(f, "{name} is {value}: it must lie in [0, 1]"),
            Self::Matrix => f.write_str("matrix entries must be finite and within ±1e12"),
            Self::Asymmetric => f.write_str("matrix is not symmetric: the reflectance would not be reciprocal"),
            Self::Table { what } => write!(f, "table {what}"),
            Self::Peak { ln_peak } => write!(
                f,
                "lobe peaks at 1e{:.0}, scale times the matrix's norm to the exponent: at most 1e12 is allowed",
                ln_peak / core::f64::consts::LN_10
            ),
        }
    }
}

impl core::error::Error for MaterialError {}

/// The largest coefficient accepted: far above any physical one (a mirror-like lobe of exponent 1e7 peaks at 1.6e6), and
/// far below what overflows f32 in sums and products.
pub(crate) const MAX_COEFFICIENT: f32 = 1e12;

pub(crate) fn check_coefficient(name: &'static str, value: Vec3) -> Result<(), MaterialError> {
    let ok = |x: f32| (0.0..=MAX_COEFFICIENT).contains(&x);
    if ok(value.x) && ok(value.y) && ok(value.z) { Ok(()) } else { Err(MaterialError::Coefficient { name, value }) }
}

pub(crate) fn check_exponent(value: f32) -> Result<(), MaterialError> {
    if (0.0..=1e7).contains(&value) { Ok(()) } else { Err(MaterialError::Exponent { value }) }
}

/// Of a model that conserves energy from exponent 1 on.
pub(crate) fn check_metal_exponent(value: f32) -> Result<(), MaterialError> {
    if (1.0..=1e7).contains(&value) { Ok(()) } else { Err(MaterialError::MetalExponent { value }) }
}

pub(crate) fn check_fraction(name: &'static str, value: f32) -> Result<(), MaterialError> {
    if (0.0..=1.0).contains(&value) { Ok(()) } else { Err(MaterialError::Fraction { name, value }) }
}
