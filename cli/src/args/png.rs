use clap::{Args, ValueEnum};
use cosine_lobes::{Display, PngDepth, ToneMap};

/// Options of all commands that write pictures as PNG files.
#[derive(Args, Clone, Debug)]
pub(crate) struct PngArgs {
    /// How radiance beyond white is shown by PNG files
    #[arg(long, value_enum, default_value_t = Tone::Soft)]
    tone: Tone,

    /// Bits of a channel of PNG files; 8 are dithered
    #[arg(long, value_enum, default_value_t = Bits::Eight)]
    bits: Bits,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Tone {
    /// Cut at white, unchanged below: for comparisons
    Linear,
    /// Unchanged below 0.8 of white; highlights approach white
    Soft,
    /// Khronos PBR Neutral: the same with more contrast in the dark
    Neutral,
    /// AgX: as film, softer, colours grow pale with brightness
    Agx,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Bits {
    #[value(name = "8")]
    Eight,
    #[value(name = "16")]
    Sixteen,
}

impl PngArgs {
    /// At an exposure in stops.
    pub(crate) fn display(&self, exposure: f32) -> Display {
        let tone = match self.tone {
            Tone::Linear => ToneMap::Linear,
            Tone::Soft => ToneMap::Soft,
            Tone::Neutral => ToneMap::Neutral,
            Tone::Agx => ToneMap::Agx,
        };
        let depth = match self.bits {
            Bits::Eight => PngDepth::Eight,
            Bits::Sixteen => PngDepth::Sixteen,
        };
        Display { exposure, tone, depth }
    }
}
