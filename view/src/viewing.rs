use cosine_lobes::Display;
use cosine_lobes::renderer::LayerSet;

/// The part of a picture that is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum View {
    /// The picture.
    #[default]
    Picture,
    /// The reference, as far as it has come.
    Reference,
    /// Their difference.
    Difference,
    /// Without blockers.
    Unshadowed,
    /// The visible fraction in three classes: lit, penumbra, dark.
    Classes,
    /// One light alone, by its number.
    Light(usize),
    Normals,
    Depth,
    Objects,
    /// The pixels in which an outline was found.
    Edges,
    /// Lobe integrals evaluated for each pixel.
    Work,
    /// Lobes of visibility made for each pixel.
    Lobes,
}

impl View {
    /// Those that every scene has.
    pub(crate) const ALL: [Self; 11] = [
        Self::Picture,
        Self::Reference,
        Self::Difference,
        Self::Unshadowed,
        Self::Classes,
        Self::Normals,
        Self::Depth,
        Self::Objects,
        Self::Edges,
        Self::Work,
        Self::Lobes,
    ];

    pub(crate) fn name(self) -> String {
        let name = match self {
            Self::Picture => "picture",
            Self::Reference => "reference (Monte Carlo)",
            Self::Difference => "difference from the reference",
            Self::Unshadowed => "without shadows",
            Self::Classes => "lit, penumbra, dark",
            Self::Light(number) => return format!("light {number} alone"),
            Self::Normals => "normals",
            Self::Depth => "depth",
            Self::Objects => "objects",
            Self::Edges => "edges found",
            Self::Work => "work (lobe integrals)",
            Self::Lobes => "lobes of visibility",
        };
        name.to_owned()
    }

    /// How to read its colours.
    pub(crate) const fn legend(self) -> &'static str {
        match self {
            Self::Picture | Self::Light(_) => "",
            Self::Reference => "grows while nothing else is computed",
            Self::Difference => "red: too bright; blue: too dark; full colour at 5 % of white",
            Self::Unshadowed => "as if nothing blocked light",
            Self::Classes => "white: fully lit; orange: in a penumbra; black: no light; grey: nothing to light",
            Self::Normals => "red, green, blue: along x, y, z",
            Self::Depth => "bright: near; dark: far",
            Self::Objects => "a colour for each object",
            Self::Edges => "orange: an outline or a crease, where more rays are taken; brighter: more surfaces",
            Self::Work => "black: none; bright: many",
            Self::Lobes => "of the methods that make lobes of visibility; black: none; bright: many",
        }
    }

    /// The layers that it is made of.
    pub(crate) const fn layers(self) -> LayerSet {
        let none = LayerSet::NONE;
        match self {
            Self::Picture | Self::Reference | Self::Difference | Self::Edges => none,
            Self::Unshadowed | Self::Classes => LayerSet { unshadowed: true, ..none },
            Self::Light(_) => LayerSet { lights: true, ..none },
            Self::Normals => LayerSet { normals: true, ..none },
            Self::Depth => LayerSet { depths: true, ..none },
            Self::Objects => LayerSet { objects: true, ..none },
            Self::Work | Self::Lobes => LayerSet { counts: true, ..none },
        }
    }

    /// The one behind it in the list for this number of lights, or before it.
    pub(crate) fn beside(self, lights: usize, is_back: bool) -> Self {
        let all: Vec<Self> = Self::ALL.into_iter().chain((0..lights).map(Self::Light)).collect();
        let place = all.iter().position(|view| *view == self).unwrap_or(0);
        let step = if is_back { all.len() - 1 } else { 1 };
        all[(place + step) % all.len()]
    }

    /// Whether it shows the reference.
    pub(crate) const fn wants_reference(self) -> bool {
        matches!(self, Self::Reference | Self::Difference)
    }
}

/// How the picture is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Viewing {
    pub(crate) view: View,
    /// Its depth is that of screens.
    pub(crate) display: Display,
    /// The part of the width left of which the reference is shown.
    pub(crate) split: Option<f32>,
}

impl Viewing {
    /// Whether the reference is to be computed.
    pub(crate) fn wants_reference(&self) -> bool {
        self.view.wants_reference() || self.split.is_some()
    }
}
