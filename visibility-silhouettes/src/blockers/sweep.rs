//! The parts of a window between pieces of outlines, by a sweep over heights.

use super::trapezoids::{DOUBTFUL, Emits, GAUSS, Piece, Trapezoid};
use core::ops::Range;

/// A height at which the parts between pieces change.
#[derive(Clone, Copy, Debug)]
pub(super) struct Event {
    pub(super) y: f32,
    /// Two pieces that cross; one piece, twice, that begins, ends, or crosses a bound of the light; or [`Event::ALL`].
    pub(super) pieces: [u32; 2],
}

impl Event {
    const ALL: [u32; 2] = [u32::MAX; 2];

    /// All parts end, and others begin.
    pub(super) const fn of_all(y: f32) -> Self {
        Self { y, pieces: Self::ALL }
    }
}

/// A part between two neighbouring pieces.
#[derive(Clone, Copy, Debug)]
struct Gap {
    /// The height from which on it is as it is, and the number of surfaces before it, but for a constant.
    from: f32,
    number: i32,
}

/// The number of a gap whose number is to be found.
const UNKNOWN: i32 = i32::MIN;

/// Where a piece is that is not among those at the present height.
const COMES: u32 = u32::MAX;
const GONE: u32 = u32::MAX - 1;
/// Before or behind the window.
const BESIDE: u32 = u32::MAX - 2;

/// The order of pieces that cross or begin is looked at again until the sweep is this part of the window's height above: next to others rounding may decide.
const DOUBT: f32 = 1.0 / 8192.0;

/// Working memory of a [`Sweep`].
#[derive(Clone, Debug, Default)]
pub(super) struct SweepMemory {
    /// Heights from the lower end of the window to its higher one.
    pub(super) events: Vec<Event>,
    /// The pieces at the present height, from left to right, and for each piece its place among them.
    order: Vec<u32>,
    places: Vec<u32>,
    /// Left of each piece, and behind the last one.
    gaps: Vec<Gap>,
}

/// The parts of a window between pieces of outlines.
///
/// # Method
/// Pieces at one height follow each other in an order that changes only where two of them cross, and where one begins or ends. The number of surfaces grows at
/// each piece by its step, so it is a property of the gaps between them. A gap lasts until one of its sides changes, and is a trapezoid then. So the time is that of the changes,
/// and not that of all pieces at each.
pub(super) struct Sweep<'a> {
    pieces: &'a [Piece],
    emits: &'a Emits<'a>,
    /// From where to where the window is.
    window: [f32; 2],
    /// Narrower parts are left out.
    narrowest: f32,
    found: &'a mut Vec<Trapezoid>,
    /// The least number of a trapezoid.
    least: i32,
    /// The number left of all pieces.
    base: i32,
    /// The gaps that have changed: the first and the last.
    changed: Option<[usize; 2]>,
    /// The last two heights between which the light's ends were found, and these.
    lit: ([f32; 2], [f32; 2], [f32; 2]),
}

impl<'a> Sweep<'a> {
    /// Between pieces, which are sorted by their lower ends, in a window.
    pub(super) const fn new(
        pieces: &'a [Piece],
        emits: &'a Emits<'a>,
        window: [f32; 2],
        narrowest: f32,
        found: &'a mut Vec<Trapezoid>,
    ) -> Self {
        let lit = ([f32::NAN; 2], [0.0; 2], [0.0; 2]);
        Self { pieces, emits, window, narrowest, found, least: i32::MAX, base: 0, changed: None, lit }
    }

    /// Adds the trapezoids with the fewest surfaces, and those with a few more. Events are sorted by height.
    pub(super) fn run(&mut self, memory: &mut SweepMemory) {
        let [Some(start), Some(end)] = [memory.events.first(), memory.events.last()].map(|event| Some(event?.y)) else {
            return;
        };
        let doubt = DOUBT * (end - start);
        memory.order.clear();
        memory.places.clear();
        memory.places.resize(self.pieces.len(), COMES);
        memory.gaps.clear();
        memory.gaps.push(Gap { from: start, number: 0 });
        let (mut rest, mut pending, mut recent) = (0, 0, 0);
        for next in 1..memory.events.len() {
            let [from, to] = [memory.events[next - 1].y, memory.events[next].y];
            if to - from <= self.thinnest() {
                continue;
            }
            let y = from + 0.5 * (to - from);
            for k in pending..next {
                let [piece, other] = memory.events[k].pieces;
                if piece == other && memory.events[k].pieces != Event::ALL {
                    self.pass(piece, (from, y), memory);
                }
            }
            while recent < pending && memory.events[recent].y + doubt < from {
                recent += 1;
            }
            // Those that begin are put among pieces that are in order, and may cross others where they begin.
            self.sort_recent(recent..next, (from, y), memory);
            let entered = rest;
            while self.pieces.get(rest).is_some_and(|piece| piece.heights[0] <= y) {
                self.enter(rest as u32, (from, y), memory);
                rest += 1;
            }
            if rest > entered {
                self.sort_recent(pending..next, (from, y), memory);
            }
            if memory.events[pending..next].iter().any(|event| event.pieces == Event::ALL) {
                self.divide_all((from, y), memory);
            }
            self.count(from, memory);
            pending = next;
        }
        for gap in 0..memory.gaps.len() {
            self.close(gap, end, memory);
        }
    }

    fn thinnest(&self) -> f32 {
        1e-2 * self.narrowest
    }

    /// Ends a gap, and begins it again.
    #[inline(always)]
    fn close(&mut self, gap: usize, to: f32, memory: &mut SweepMemory) {
        let Gap { from, number } = memory.gaps[gap];
        memory.gaps[gap].from = to;
        if to - from > self.thinnest() && number < self.least.saturating_add(DOUBTFUL as i32) {
            self.keep(gap, (from, to), number, memory);
        }
    }

    /// Adds the trapezoid of a gap.
    fn keep(&mut self, gap: usize, (from, to): (f32, f32), number: i32, memory: &SweepMemory) {
        let height = to - from;
        let y = from + 0.5 * height;
        let pieces = self.pieces;
        let piece = |place: Option<usize>| Some(&pieces[*memory.order.get(place?)? as usize]);
        let sides = [piece(gap.checked_sub(1)), piece(Some(gap))];
        let places = [
            sides[0].map_or(f32::NEG_INFINITY, |piece| piece.at(y)),
            sides[1].map_or(f32::INFINITY, |piece| piece.at(y)),
        ];
        if places[1] - places[0] < self.narrowest {
            return;
        }
        let (light, leans) = self.light([from, to]);
        let ends = [places[0].max(light[0]), places[1].min(light[1])];
        if ends[1] - ends[0] < self.narrowest {
            return;
        }
        self.least = self.least.min(number);
        let lean = |side: usize| match sides[side] {
            Some(piece) if places[side] == ends[side] => piece.at(to) - piece.at(from),
            _ => leans[side],
        };
        self.found.push(Trapezoid { ends, leans: [lean(0), lean(1)], y, height, number });
    }

    /// From where to where the light emits halfway between two heights, and how far both ends move between these.
    fn light(&mut self, heights: [f32; 2]) -> ([f32; 2], [f32; 2]) {
        if self.lit.0 != heights {
            let [from, to] = heights;
            let [y, height] = [from + 0.5 * (to - from), to - from];
            // The mean of two places is that of a parabola, as which arcs are taken.
            let [low, high] = [-GAUSS, GAUSS].map(|up| self.emits.at(y + up * height));
            let middle = [0, 1].map(|side| 0.5 * (low[side] + high[side]));
            self.lit = (heights, middle, [0, 1].map(|side| (high[side] - low[side]) / (2.0 * GAUSS)));
        }
        (self.lit.1, self.lit.2)
    }

    /// Ends gaps, and marks that their numbers are to be found.
    fn change(&mut self, [first, last]: [usize; 2], from: f32, memory: &mut SweepMemory) {
        for gap in first..=last {
            self.close(gap, from, memory);
            memory.gaps[gap].number = UNKNOWN;
        }
        self.changed = Some(self.changed.map_or([first, last], |[low, high]| [low.min(first), high.max(last)]));
    }

    /// A piece begins at or below a height.
    fn enter(&mut self, number: u32, (from, y): (f32, f32), memory: &mut SweepMemory) {
        let piece = &self.pieces[number as usize];
        // The number left of all is that on the path less those that begin left of it.
        self.base += if y >= piece.crosses { piece.step_on_path() } else { 0 };
        if piece.heights[1] <= y {
            memory.places[number as usize] = GONE;
            return;
        }
        self.base -= piece.step_left_at(y);
        if !piece.is_inside(self.window) {
            self.base += piece.step_before(self.window);
            memory.places[number as usize] = BESIDE;
            return;
        }
        let at = piece.at(y);
        let place = memory.order.partition_point(|k| self.pieces[*k as usize].at(y) < at);
        self.change([place; 2], from, memory);
        memory.gaps.insert(place + 1, Gap { from, number: UNKNOWN });
        memory.order.insert(place, number);
        renumber(memory, place);
        self.changed = self.changed.map(|[low, high]| [low, high + 1]);
    }

    /// A piece ends, crosses a bound of the light, or has just begun.
    fn pass(&mut self, number: u32, (from, y): (f32, f32), memory: &mut SweepMemory) {
        let place = memory.places[number as usize];
        let piece = &self.pieces[number as usize];
        if place == COMES || place == GONE {
            return;
        }
        let is_over = piece.heights[1] <= y;
        if is_over {
            self.base += piece.step_left_at(y);
            memory.places[number as usize] = GONE;
        }
        if place == BESIDE {
            self.base -= if is_over { piece.step_before(self.window) } else { 0 };
            return;
        }
        let place = place as usize;
        self.change([place, place + 1], from, memory);
        if is_over {
            memory.gaps.remove(place + 1);
            memory.order.remove(place);
            renumber(memory, place);
            // Gaps behind have moved.
            self.changed = self.changed.map(|[low, high]| [low, high - 1]);
        }
    }

    /// Orders the pieces of some events: two that cross and all between them, or one among its neighbours.
    fn sort_recent(&mut self, events: Range<usize>, (from, y): (f32, f32), memory: &mut SweepMemory) {
        for k in events {
            let [a, b] = memory.events[k].pieces;
            if [a, b] == Event::ALL {
                continue;
            }
            let [a, b] = [a, b].map(|piece| memory.places[piece as usize]);
            if a >= BESIDE || b >= BESIDE {
                continue;
            }
            let [mut first, mut last] = [a.min(b) as usize, a.max(b) as usize];
            let at = |k: &u32| self.pieces[*k as usize].at(y);
            let own = at(&memory.order[first]);
            if first == last {
                while first > 0 && at(&memory.order[first - 1]) > own {
                    first -= 1;
                }
                while memory.order.get(last + 1).is_some_and(|k| at(k) < own) {
                    last += 1;
                }
            }
            if !memory.order[first..=last].is_sorted_by(|a, b| at(a) <= at(b)) {
                self.change([first, last + 1], from, memory);
                self.sort([first, last], y, memory);
            }
        }
    }

    fn sort(&self, [first, last]: [usize; 2], y: f32, memory: &mut SweepMemory) {
        let at = |k: u32| self.pieces[k as usize].at(y);
        let order = &mut memory.order[first..=last];
        for i in 1..order.len() {
            let (moved, place) = (order[i], at(order[i]));
            let mut j = i;
            while j > 0 && at(order[j - 1]) > place {
                order[j] = order[j - 1];
                j -= 1;
            }
            order[j] = moved;
        }
        for (place, k) in (first..).zip(order) {
            memory.places[*k as usize] = place as u32;
        }
    }

    /// Ends all gaps, and orders all pieces.
    fn divide_all(&mut self, (from, y): (f32, f32), memory: &mut SweepMemory) {
        for gap in 0..memory.gaps.len() {
            self.close(gap, from, memory);
        }
        let at = |k: &u32| self.pieces[*k as usize].at(y);
        if !memory.order.is_sorted_by(|a, b| at(a) <= at(b)) {
            let last = memory.order.len() - 1;
            self.change([0, last + 1], from, memory);
            self.sort([0, last], y, memory);
        }
    }

    /// Finds the numbers of gaps that have changed.
    fn count(&mut self, from: f32, memory: &mut SweepMemory) {
        let changed = self.changed.take();
        let [first, last] = match changed {
            Some(changed) if memory.gaps[0].number == self.base => changed,
            None if memory.gaps[0].number == self.base => return,
            changed => [0, changed.map_or(0, |[_, last]| last)],
        };
        let pieces = self.pieces;
        let step = |k: &u32| pieces[*k as usize].step;
        let before = first.checked_sub(1);
        let mut number = before.map_or(self.base, |gap| memory.gaps[gap].number + step(&memory.order[gap]));
        for gap in first..memory.gaps.len() {
            if memory.gaps[gap].number != number {
                self.close(gap, from, memory);
                memory.gaps[gap].number = number;
            } else if gap > last {
                return;
            }
            number += memory.order.get(gap).map_or(0, step);
        }
    }
}

/// Tells pieces from one place on where they are.
fn renumber(memory: &mut SweepMemory, first: usize) {
    for (place, k) in (first..).zip(&memory.order[first..]) {
        memory.places[*k as usize] = place as u32;
    }
}
