use core::fmt;
use core::ops::{BitOr, BitOrAssign};

/// The kinds of results that an edit has made stale. The next picture updates these and recomputes nothing else.
#[derive(Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct Stale(u16);

impl Stale {
    /// Nothing.
    pub const NOTHING: Self = Self(0);
    /// The radiance of points.
    pub const SHADING: Self = Self(1);
    /// The visible points.
    pub const POINTS: Self = Self(1 << 1);
    /// Boxes of the hierarchy: refitted where objects have moved, built again where objects were added or removed.
    pub const HIERARCHY: Self = Self(1 << 2);
    /// Tangents of meshes, for normal maps.
    pub const SURFACES: Self = Self(1 << 3);
    /// Which spheres block, and their places.
    pub const SPHERES: Self = Self(1 << 4);
    /// Sphere sets of some objects.
    pub const SETS: Self = Self(1 << 5);
    /// Silhouettes of the meshes that were moved or added.
    pub const SILHOUETTES: Self = Self(1 << 6);
    /// Shadow maps.
    pub const MAPS: Self = Self(1 << 7);
    /// The strategy of each object.
    pub const PLAN: Self = Self(1 << 8);
    /// The paper's tables.
    pub const TABLES: Self = Self(1 << 9);
    /// The lights.
    pub const LIGHTS: Self = Self(1 << 10);
    /// The device that shades.
    pub const BACKEND: Self = Self(1 << 11);
    /// The accuracy that a time budget has chosen.
    pub const BUDGET: Self = Self(1 << 12);

    /// The consequences of a moved object.
    pub(crate) const MOVED: Self = Self::SHADING
        .with(Self::POINTS)
        .with(Self::HIERARCHY)
        .with(Self::SPHERES)
        .with(Self::SILHOUETTES)
        .with(Self::MAPS);
    /// The consequences of a change of an object's strategy.
    pub(crate) const STRATEGY: Self = Self::MOVED.with(Self::PLAN).with(Self::SETS);

    /// Every kind, by its name.
    const NAMES: [(Self, &'static str); 13] = [
        (Self::SHADING, "shading"),
        (Self::POINTS, "points"),
        (Self::HIERARCHY, "hierarchy"),
        (Self::SURFACES, "surfaces"),
        (Self::SPHERES, "spheres"),
        (Self::SETS, "sets"),
        (Self::SILHOUETTES, "silhouettes"),
        (Self::MAPS, "maps"),
        (Self::PLAN, "plan"),
        (Self::TABLES, "tables"),
        (Self::LIGHTS, "lights"),
        (Self::BACKEND, "backend"),
        (Self::BUDGET, "budget"),
    ];

    /// All kinds.
    pub(crate) const ALL: Self = Self((1 << 13) - 1);

    /// The union of both.
    #[must_use]
    pub const fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether any of these kinds is contained.
    #[must_use]
    pub const fn has(self, kinds: Self) -> bool {
        self.0 & kinds.0 != 0
    }

    /// The names of the kinds.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        Self::NAMES.into_iter().filter(move |(kind, _)| self.has(*kind)).map(|(_, name)| name)
    }

    /// All but these kinds.
    pub(crate) const fn without(self, kinds: Self) -> Self {
        Self(self.0 & !kinds.0)
    }
}

impl BitOr for Stale {
    type Output = Self;

    fn bitor(self, other: Self) -> Self {
        self.with(other)
    }
}

impl BitOrAssign for Stale {
    fn bitor_assign(&mut self, other: Self) {
        *self = *self | other;
    }
}

impl fmt::Debug for Stale {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_set().entries(self.names()).finish()
    }
}

/// How often the data that is kept between pictures was built, updated or used again.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Upkeep {
    /// Hierarchies over triangles and exact spheres that were built.
    pub hierarchy_builds: u64,
    /// Hierarchies whose boxes were refitted.
    pub hierarchy_refits: u64,
    /// Meshes whose silhouettes were prepared.
    pub silhouette_builds: u64,
    /// Meshes whose silhouettes were refitted.
    pub silhouette_refits: u64,
    /// Objects whose spheres were fitted, read or measured.
    pub sphere_sets: u64,
    /// Hierarchies over blocker spheres that were built or refitted.
    pub sphere_updates: u64,
    /// Bands of pixels whose visible points were found.
    pub point_bands: u64,
    /// Shadow maps that were drawn.
    pub maps: u64,
    /// Tables of the environment that were made.
    pub sky_tables: u64,
    /// How often the hierarchy of a GPU's rays was built or updated.
    pub ray_worlds: u64,
}
