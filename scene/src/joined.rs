//! Sets that grow together, with sides.

/// Corners of triangles, or triangles, that are joined, each with a side: a forest with the parent of each.
pub(crate) struct Joined {
    parents: Vec<u32>,
    /// Whether each is turned against its parent.
    turned: Vec<bool>,
}

impl Joined {
    pub(crate) fn new(count: usize) -> Self {
        Self { parents: (0..count as u32).collect(), turned: vec![false; count] }
    }

    /// The root of a member, and whether the member is turned against it.
    pub(crate) fn root(&mut self, member: u32) -> (u32, bool) {
        let (mut at, mut turned) = (member, false);
        while self.parents[at as usize] != at {
            turned ^= self.turned[at as usize];
            at = self.parents[at as usize];
        }
        let (root, all) = (at, turned);
        let (mut at, mut turned) = (member, all);
        while self.parents[at as usize] != root && at != root {
            let next = (self.parents[at as usize], turned ^ self.turned[at as usize]);
            (self.parents[at as usize], self.turned[at as usize]) = (root, turned);
            (at, turned) = next;
        }
        (root, all)
    }

    pub(crate) fn join(&mut self, a: u32, b: u32, turned: bool) {
        let ((a, a_turned), (b, b_turned)) = (self.root(a), self.root(b));
        if a != b {
            self.parents[b as usize] = a;
            self.turned[b as usize] = a_turned ^ b_turned ^ turned;
        }
    }
}
