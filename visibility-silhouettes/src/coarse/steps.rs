//! The proposed steps of a patch's corners, the cheapest first.

/// A step of a corner onto another one, and the number of steps when it was proposed. Steps are ordered by their cost, in the highest 64 bits
/// (those of non-negative numbers have the same order), then by their corners.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Step(u128);

impl Step {
    /// Bits of the number of a corner.
    pub(super) const BITS: u32 = 21;

    pub(super) fn new(cost: f64, from: u32, to: u32, steps: u32) -> Self {
        let corners = u64::from(from) << Self::BITS | u64::from(to);
        let low = corners << (64 - 2 * Self::BITS) | u64::from(steps);
        Self(u128::from(cost.to_bits()) << 64 | u128::from(low))
    }

    /// From which corner, onto which one, and the number of steps before.
    pub(super) fn parts(self) -> [u32; 3] {
        let (low, rest) = (self.0 as u64, 64 - 2 * Self::BITS);
        let of = |bits: u64, count: u32| (bits & ((1 << count) - 1)) as u32;
        [of(low >> (64 - Self::BITS), Self::BITS), of(low >> rest, Self::BITS), of(low, rest)]
    }
}

/// The proposed steps of each corner, and a tree over the corners: each place has the cheaper one of the steps in the two places below it.
pub(super) struct Steps {
    lists: Vec<Vec<Step>>,
    /// The root is at 1, the places below `k` are `2k` and `2k + 1`.
    tree: Vec<Step>,
}

impl Steps {
    /// More than any step.
    const NONE: Step = Step(u128::MAX);

    pub(super) fn new(lists: Vec<Vec<Step>>) -> Self {
        let leaves = lists.len().next_power_of_two();
        let mut tree = vec![Self::NONE; 2 * leaves];
        lists.iter().zip(&mut tree[leaves..]).for_each(|(list, place)| *place = Self::cheapest_of(list));
        for k in (1..leaves).rev() {
            tree[k] = tree[2 * k].min(tree[2 * k + 1]);
        }
        Self { lists, tree }
    }

    fn cheapest_of(list: &[Step]) -> Step {
        list.iter().fold(Self::NONE, |best, step| best.min(*step))
    }

    pub(super) fn cheapest(&self) -> Option<Step> {
        (self.tree[1] != Self::NONE).then_some(self.tree[1])
    }

    /// Changes the steps of a corner.
    pub(super) fn change(&mut self, from: u32, change: impl FnOnce(&mut Vec<Step>)) {
        let list = &mut self.lists[from as usize];
        change(list);
        let mut k = self.tree.len() / 2 + from as usize;
        let mut best = Self::cheapest_of(list);
        while self.tree[k] != best {
            self.tree[k] = best;
            if k == 1 {
                break;
            }
            k /= 2;
            best = self.tree[2 * k].min(self.tree[2 * k + 1]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_core::oracle::Random;

    /// Steps of few costs, which change at random.
    #[test]
    fn the_cheapest_step_is_the_least_of_all() {
        let mut random = Random::new(6);
        for count in [0, 1, 2, 37] {
            let mut number = |below: usize| (random.uniform() * below as f64) as u32;
            let mut propose = |from: usize| -> Vec<Step> {
                (0..number(5)).map(|at| Step::new(f64::from(number(9)), from as u32, number(count), at)).collect()
            };
            let mut lists: Vec<Vec<Step>> = (0..count).map(&mut propose).collect();
            let mut steps = Steps::new(lists.clone());
            for k in 0..200_usize {
                let least = lists.iter().flatten().min().copied();
                assert_eq!(steps.cheapest().map(Step::parts), least.map(Step::parts));
                let Some(from) = (7 * k).checked_rem(count) else { continue };
                lists[from] = propose(from);
                steps.change(from as u32, |list| list.clone_from(&lists[from]));
            }
        }
        assert_eq!(Step::new(0.5, (1 << 21) - 1, 5, (1 << 22) - 1).parts(), [(1 << 21) - 1, 5, (1 << 22) - 1]);
        assert!(
            Step::new(0.5, 9, 9, 9) < Step::new(0.75, 0, 0, 0) && Step::new(0.5, 1, 9, 9) < Step::new(0.5, 2, 0, 0)
        );
    }
}
