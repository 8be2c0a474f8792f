/// How an object's shadow is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Strategy {
    /// Its [`Proxy`](crate::Proxy): spheres.
    Spheres,
    /// Its triangles, through depth maps around the lights.
    ShadowMap,
    /// Its triangles, by their silhouettes: exact.
    Silhouettes,
    /// Its triangles, by shadow rays: exact.
    Rays,
    /// Not at all: it casts no shadow.
    None,
    /// By the strategy of this name, which a renderer is given.
    Custom(&'static str),
}

impl Strategy {
    /// The built-in ones, in the order that messages list them in.
    pub const ALL: [Self; 5] = [Self::Spheres, Self::ShadowMap, Self::Silhouettes, Self::Rays, Self::None];

    /// Its name in scene files and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Spheres => "spheres",
            Self::ShadowMap => "shadow-map",
            Self::Silhouettes => "silhouettes",
            Self::Rays => "rays",
            Self::None => "none",
            Self::Custom(name) => name,
        }
    }

    /// The built-in strategy of that [`name`](Self::name).
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|s| s.name() == name)
    }
}
