//! Which triangles meet at an edge.

/// A side of a triangle at an edge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Side {
    /// The edge's larger place.
    to: u32,
    /// Three times the triangle's number, and that of the side there.
    pub(crate) number: u32,
    /// Whether it runs from the larger place to the smaller.
    pub(crate) is_back: bool,
}

impl Side {
    pub(crate) const fn triangle(&self) -> u32 {
        self.number / 3
    }

    /// The number of the triangle's corner at the edge's smaller place, or at its larger one, the `end`.
    pub(crate) const fn corner(&self, end: bool) -> u32 {
        self.number - self.number % 3 + (self.number % 3 + (end != self.is_back) as u32) % 3
    }
}

/// The sides of all edges, by the smaller place of each: those of place p are from `firsts[p]` to `firsts[p + 1]`, in order.
pub(crate) struct Edges {
    firsts: Vec<u32>,
    sides: Vec<Side>,
}

impl Edges {
    /// Of triangles whose corners are numbers of places.
    pub(crate) fn of(triangles: &[[u32; 3]]) -> Self {
        let edges = |t: &[u32; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
        let places = triangles.iter().flatten().max().map_or(0, |last| *last as usize + 1);
        let mut firsts = vec![0; places + 1];
        for [a, b] in triangles.iter().flat_map(edges) {
            firsts[a.min(b) as usize + 1] += 1;
        }
        for place in 0..places {
            firsts[place + 1] += firsts[place];
        }
        let (mut next, mut sides) = (firsts.clone(), vec![Side::default(); 3 * triangles.len()]);
        for (number, [a, b]) in (0..).zip(triangles.iter().flat_map(edges)) {
            let slot = &mut next[a.min(b) as usize];
            sides[*slot as usize] = Side { to: a.max(b), number, is_back: a > b };
            *slot += 1;
        }
        for at in firsts.windows(2) {
            sides[at[0] as usize..at[1] as usize].sort_unstable();
        }
        Self { firsts, sides }
    }

    /// The sides at the edge between two places, in the order of triangles.
    pub(crate) fn between(&self, a: u32, b: u32) -> &[Side] {
        let (from, to) = (a.min(b) as usize, a.max(b));
        let sides = &self.sides[self.firsts[from] as usize..self.firsts[from + 1] as usize];
        &sides[sides.partition_point(|side| side.to < to)..sides.partition_point(|side| side.to <= to)]
    }

    /// The pairs of triangles that are alone at an edge, and whether they wind against each other there. A triangle that is there twice
    /// makes no pair.
    pub(crate) fn pairs<'e>(&'e self, triangles: &'e [[u32; 3]]) -> impl Iterator<Item = (u32, u32, bool)> + 'e {
        let sorted = |side: &Side| {
            let mut places = triangles[side.triangle() as usize];
            places.sort_unstable();
            places
        };
        let all = self.firsts.windows(2).map(|at| &self.sides[at[0] as usize..at[1] as usize]);
        all.flat_map(|sides| sides.chunk_by(|a, b| a.to == b.to)).filter_map(move |edge| match edge {
            [one, other] if sorted(one) != sorted(other) => {
                Some((one.triangle(), other.triangle(), one.is_back == other.is_back))
            }
            _ => None,
        })
    }
}
