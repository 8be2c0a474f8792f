//! The parts of a window between pieces of outlines, cell by cell.

use super::parts::{Anchor, Bounds, Cell, PartMemory};
use super::trapezoids::{DOUBTFUL, Piece, Trapezoid};
use glam::Vec2;

/// There are as many cells as pieces, but fewer where these are less than this number: lists are short then.
const FEW: f32 = 64.0;
/// Most places have more surfaces before them than may be open if they have as many more in the mean. Cells are made finer then, this many for each piece.
const DEEP: f32 = 2.0;
const FINER: f32 = 6.0;
/// Across a window, and up.
const MOST_CELLS: f32 = 512.0;
/// Parts are given up where pieces meet more rows of cells than this, or where more pairs of pieces, each with itself, meet in a cell: long ones that cross each other.
const MOST_SPANS: usize = 400_000;
const MOST_PAIRS: u64 = 4_000_000;
/// Pieces are in the list of a cell if they are as near to it, in cells.
const MARGIN: f32 = 1e-3;

/// Cells of a window, as many across as up.
#[derive(Clone, Copy, Debug)]
struct Grid {
    low: Vec2,
    /// Of one cell, and its reciprocal.
    size: Vec2,
    per: Vec2,
    count: usize,
}

impl Grid {
    /// About `count` cells in all.
    fn new(bounds: &Bounds<'_>, count: f32) -> Self {
        let across = count.sqrt().ceil().clamp(1.0, MOST_CELLS);
        let size = (bounds.high - bounds.low) / across;
        Self { low: bounds.low, size, per: size.recip(), count: across as usize }
    }

    fn x(&self, column: usize) -> f32 {
        self.low.x + self.size.x * column as f32
    }

    fn y(&self, row: usize) -> f32 {
        self.low.y + self.size.y * row as f32
    }

    /// A place in cells.
    fn place(&self, x: f32) -> f32 {
        (x - self.low.x) * self.per.x
    }

    /// The row of a height, or the nearest one.
    #[inline(always)]
    fn row(&self, y: f32, ys: &[f32]) -> usize {
        let near = self.nearest((y - self.low.y) * self.per.y);
        let near = near - usize::from(near > 0 && ys[near] > y);
        near + usize::from(near + 1 < self.count && ys[near + 1] <= y)
    }

    fn nearest(&self, place: f32) -> usize {
        (place as i32).clamp(0, self.count as i32 - 1) as usize
    }

    /// The first corner right of a place, which is also given in cells.
    #[inline(always)]
    fn corner_right_of(&self, x: f32, place: f32, xs: &[f32]) -> usize {
        let near = ((place as i32).clamp(-1, self.count as i32) + 1) as usize;
        let near = near + usize::from(xs[near] <= x);
        near - usize::from(near > 0 && xs[near - 1] > x)
    }

    /// Adds a piece to the numbers on a line, if it crosses that at a place.
    #[inline(always)]
    fn count(&self, piece: &Piece, line: usize, (x, place): (f32, f32), [xs, ys]: [&[f32]; 2], numbers: &mut [i32]) {
        if piece.is_at(ys[line]) {
            let numbers = &mut numbers[line * self.corners()..][..self.corners()];
            numbers[self.corner_right_of(x, place, xs)] += piece.step;
            numbers[0] -= piece.step_left_at(ys[line]);
        }
    }

    /// Corners on a line between rows, and one that is right of all.
    const fn corners(&self) -> usize {
        self.count + 2
    }

    fn is_inside(&self, [first, end]: [usize; 2], [from, to]: [f32; 2]) -> bool {
        self.x(first) >= from && self.x(end) <= to
    }
}

/// The cells of a row that a piece may meet.
#[derive(Clone, Copy, Debug)]
struct Span {
    piece: u32,
    cells: [u32; 2],
}

/// Working memory of [`Cells`].
#[derive(Clone, Debug, Default)]
pub(super) struct CellMemory {
    /// Where the lines between columns and rows are.
    lines: [Vec<f32>; 2],
    /// The surfaces before the corners of cells, but for a constant, line by line.
    numbers: Vec<i32>,
    /// The change of the number on the path from one line to the next.
    on_path: Vec<i32>,
    spans: Vec<Span>,
    /// Where the list of each cell begins, and all lists.
    firsts: Vec<u32>,
    lists: Vec<u32>,
    /// From where to where lines emit.
    emits: Vec<[f32; 2]>,
    parts: PartMemory,
}

impl CellMemory {
    fn list(&self, cell: usize) -> &[u32] {
        &self.lists[self.firsts[cell] as usize..self.firsts[cell + 1] as usize]
    }

    /// From where to where all of a row emits, since a light is convex.
    fn inner(&self, row: usize) -> [f32; 2] {
        let [bottom, top] = [self.emits[row], self.emits[row + 1]];
        [bottom[0].max(top[0]), bottom[1].min(top[1])]
    }
}

/// The parts of a window between pieces of outlines, of those with the fewest surfaces.
///
/// # Method
/// A window has about as many cells as pieces. Along the lines between their rows, the number of surfaces before each corner is counted. Within a cell it falls by no more than
/// the steps of its pieces that fall on the way from a corner. So all cells that cannot be open are left out after a look at their lists, and the others are [divided](Self::divide).
/// A ray through an empty cell with the fewest surfaces, and rays through parts with fewer that come up, tell from which number on all is closed.
///
/// The time is that of the pieces in each cell that they meet, and of those parts that are, or may be, open. A sweep over all heights took that of all crossings between pieces:
/// two to three times as long behind leaves or before hundreds of holes.
pub(super) struct Cells<'a> {
    grid: Grid,
    pub(super) pieces: &'a [Piece],
    pub(super) bounds: &'a Bounds<'a>,
    pub(super) found: &'a mut Vec<Trapezoid>,
    /// The least number of a trapezoid or a corner.
    pub(super) least: i32,
    /// Nothing is open from this number on.
    pub(super) closed: i32,
    /// The largest step of a piece.
    steepest: i32,
}

impl<'a> Cells<'a> {
    /// Between pieces, in a window.
    pub(super) fn new(pieces: &'a [Piece], bounds: &'a Bounds<'a>, found: &'a mut Vec<Trapezoid>) -> Self {
        let steepest = pieces.iter().map(|piece| piece.step.abs()).max().unwrap_or(0);
        let count = pieces.len() as f32;
        let grid = Grid::new(bounds, count * (count / FEW).min(1.0).powi(2));
        Self { grid, pieces, bounds, found, least: i32::MAX, closed: i32::MAX, steepest }
    }

    /// Adds the trapezoids with the fewest surfaces, and those with a few more where it is not known that these are closed. `false` if that would take too long.
    pub(super) fn run(&mut self, memory: &mut CellMemory, is_open: &mut impl FnMut(Vec2) -> bool) -> bool {
        if !self.draw(memory) {
            return false;
        }
        if self.depth(memory) > DEEP {
            self.grid = Grid::new(self.bounds, FINER * self.pieces.len() as f32);
            if !self.draw(memory) {
                return false;
            }
        }
        self.look(memory, is_open);
        for row in 0..self.grid.count {
            self.divide_row(row, memory, is_open);
        }
        true
    }

    /// Numbers from which on parts are left out.
    pub(super) fn limit(&self) -> i32 {
        self.closed.min(self.least.saturating_add(DOUBTFUL as i32))
    }

    /// Rows of a cell, none of which is higher than it may be.
    pub(super) fn rows_in_cell(&self) -> u32 {
        self.bounds.rows.div_ceil(self.grid.count as u32)
    }

    /// Counts on the lines between rows, and lists the pieces of cells. `false` if these are too many.
    fn draw(&mut self, memory: &mut CellMemory) -> bool {
        let Grid { count, .. } = self.grid;
        let [xs, ys] = &mut memory.lines;
        xs.clear();
        xs.extend((0..=count).map(|k| self.grid.x(k)).chain([f32::INFINITY]));
        ys.clear();
        ys.extend((0..=count).map(|k| self.grid.y(k)));
        memory.numbers.clear();
        memory.numbers.resize((count + 1) * self.grid.corners(), 0);
        memory.on_path.clear();
        memory.on_path.resize(count + 2, 0);
        memory.spans.clear();
        memory.firsts.clear();
        memory.firsts.resize(count * count + 1, 0);
        for (k, piece) in (0..).zip(self.pieces) {
            self.draw_piece(k, piece, memory);
            if memory.spans.len() > MOST_SPANS {
                return false;
            }
        }
        if memory.firsts.iter().map(|count| u64::from(*count) * u64::from(*count)).sum::<u64>() > MOST_PAIRS {
            return false;
        }
        self.sort(memory);
        self.sum(memory);
        true
    }

    /// Adds a piece to the numbers on lines, and lists the cells that it may meet.
    #[inline(always)]
    fn draw_piece(&self, number: u32, piece: &Piece, memory: &mut CellMemory) {
        let CellMemory { lines: [xs, ys], numbers, on_path, spans, firsts, .. } = memory;
        let grid = &self.grid;
        let [from, to] = piece.heights;
        if let Some((height, step)) = piece.on_path() {
            on_path[ys.partition_point(|y| *y < height)] += step;
        }
        if to < ys[0] || from > ys[grid.count] {
            return;
        }
        let [first, last] = [from, to].map(|y| grid.row(y, ys));
        // A level one on a line is on the way from that to the row below.
        let first = first - usize::from(first > 0 && from == ys[first]);
        let mut x = piece.at_or_end(from.max(ys[first]));
        let mut place = grid.place(x);
        // A level one is at all of its places.
        let [mut left, mut right] = piece.places.map(|x| grid.place(x));
        for row in first..=last {
            grid.count(piece, row, (x, place), [xs, ys], numbers);
            if from < to {
                x = piece.at_or_end(to.min(ys[row + 1]));
                let end = grid.place(x);
                (left, right) = if place < end { (place, end) } else { (end, place) };
                place = end;
            }
            if right >= -MARGIN && left <= grid.count as f32 + MARGIN {
                let near = [left - MARGIN, right + MARGIN].map(|place| row * grid.count + grid.nearest(place));
                firsts[near[0]..=near[1]].iter_mut().for_each(|count| *count += 1);
                spans.push(Span { piece: number, cells: near.map(|cell| cell as u32) });
            }
        }
        if last + 1 == grid.count {
            grid.count(piece, grid.count, (x, place), [xs, ys], numbers);
        }
    }

    /// Fills the lists of all cells.
    fn sort(&self, memory: &mut CellMemory) {
        let CellMemory { firsts, lists, spans, .. } = memory;
        let cells = self.grid.count * self.grid.count;
        // Where each list ends, and then where it begins.
        for k in 0..cells {
            firsts[k + 1] += firsts[k];
        }
        lists.clear();
        lists.resize(firsts[cells] as usize, 0);
        for span in spans.iter().rev() {
            let [first, last] = span.cells.map(|cell| cell as usize);
            for end in &mut firsts[first..=last] {
                *end -= 1;
                lists[*end as usize] = span.piece;
            }
        }
    }

    /// Sums what pieces add, and finds where lines emit.
    fn sum(&mut self, memory: &mut CellMemory) {
        memory.emits.clear();
        self.least = i32::MAX;
        let [xs, ys] = &memory.lines;
        let lines = memory.numbers.chunks_exact_mut(self.grid.corners()).zip(&memory.on_path);
        let mut on_path = 0;
        for ((numbers, step), y) in lines.zip(ys) {
            on_path += step;
            let [from, to] = self.bounds.emits.at(*y);
            memory.emits.push([from, to]);
            let mut number = on_path;
            for (sum, x) in numbers.iter_mut().zip(xs) {
                number += *sum;
                *sum = number;
                if *x > from && *x < to {
                    self.least = self.least.min(number);
                }
            }
        }
    }

    /// How many surfaces more than the fewest are before the corners, in the mean.
    fn depth(&self, memory: &CellMemory) -> f32 {
        let [xs, _] = &memory.lines;
        let lines = memory.numbers.chunks_exact(self.grid.corners()).zip(&memory.emits);
        let emitting =
            lines.flat_map(|(numbers, [from, to])| numbers.iter().zip(xs).filter(move |(_, x)| *x > from && *x < to));
        let (count, sum) = emitting.fold((0, 0), |(count, sum), (number, _)| (count + 1, sum + i64::from(*number)));
        if count == 0 { 0.0 } else { sum as f32 / count as f32 - self.least as f32 }
    }

    /// Finds from which number on all is closed, by a ray through an empty cell.
    fn look(&mut self, memory: &CellMemory, is_open: &mut impl FnMut(Vec2) -> bool) {
        let grid = &self.grid;
        let mut fewest: Option<(i32, Vec2)> = None;
        for row in 0..grid.count {
            let inner = memory.inner(row);
            let numbers = &memory.numbers[row * grid.corners()..][..grid.count];
            for (column, number) in numbers.iter().enumerate() {
                let is_lower = fewest.is_none_or(|(least, _)| *number < least);
                if is_lower
                    && memory.list(row * grid.count + column).is_empty()
                    && grid.is_inside([column, column + 1], inner)
                {
                    fewest = Some((*number, Vec2::new(grid.x(column), grid.y(row)) + 0.5 * grid.size));
                }
            }
        }
        if let Some((number, middle)) = fewest {
            self.closed = number + i32::from(is_open(middle));
        }
    }

    /// Adds the parts of the cells of a row that may be open.
    fn divide_row(&mut self, row: usize, memory: &mut CellMemory, is_open: &mut impl FnMut(Vec2) -> bool) {
        let grid = self.grid;
        let inner = memory.inner(row);
        let mut parts = core::mem::take(&mut memory.parts);
        let mut end = 0;
        while end < grid.count {
            let first = end;
            let list = memory.list(row * grid.count + first);
            let is_inside = grid.is_inside([first, first + 1], inner);
            end += 1;
            // Empty ones beside each other are one.
            while list.is_empty()
                && end < grid.count
                && memory.list(row * grid.count + end).is_empty()
                && grid.is_inside([end, end + 1], inner) == is_inside
            {
                end += 1;
            }
            let low = Vec2::new(grid.x(first), grid.y(row));
            let mut cell = Cell { low, high: Vec2::new(grid.x(end), grid.y(row + 1)), is_inside, anchor: None };
            let bound = if is_inside {
                cell.anchor = Some(Anchor { at: low, number: memory.numbers[row * grid.corners() + first] });
                Some(self.highest(row, [first, end], memory))
            } else {
                cell.anchor = self.on_line(row, first, &cell, memory);
                cell.anchor
            };
            if bound.is_none_or(|bound| self.may_be_open(list, bound)) {
                self.divide(&cell, list, &mut parts, is_open);
            }
        }
        memory.parts = parts;
    }

    /// The corner of a cell with the most surfaces: from there the bound is most often the highest.
    fn highest(&self, row: usize, columns: [usize; 2], memory: &CellMemory) -> Anchor {
        let corner = |line: usize, column: usize| (memory.numbers[line * self.grid.corners() + column], line, column);
        let [first, end] = columns;
        let (below, above) =
            (corner(row, first).max(corner(row, end)), corner(row + 1, first).max(corner(row + 1, end)));
        let (number, line, column) = below.max(above);
        Anchor { at: Vec2::new(self.grid.x(column), self.grid.y(line)), number }
    }

    /// A point of the light on the lower or the higher side of a cell.
    fn on_line(&self, row: usize, column: usize, cell: &Cell, memory: &CellMemory) -> Option<Anchor> {
        let grid = &self.grid;
        let list = memory.list(row * grid.count + column);
        [row, row + 1].into_iter().find_map(|line| {
            let [from, to] = memory.emits[line];
            let [from, to] = [from.max(cell.low.x), to.min(cell.high.x)];
            let at = Vec2::new(0.5 * (from + to), grid.y(line));
            let before = list
                .iter()
                .map(|k| &self.pieces[*k as usize])
                .filter(|piece| piece.is_at(at.y) && (cell.low.x..at.x).contains(&piece.at_or_end(at.y)));
            let number =
                || memory.numbers[line * grid.corners() + column] + before.map(|piece| piece.step).sum::<i32>();
            (from < to).then(|| Anchor { at, number: number() })
        })
    }

    /// Whether anything may be open in a cell with some pieces, by the number at a point.
    fn may_be_open(&self, list: &[u32], Anchor { at, number }: Anchor) -> bool {
        let limit = self.limit();
        let fewer = || list.iter().map(|k| self.pieces[*k as usize].falls_from(at)).sum::<i32>();
        number - (list.len() as i32).saturating_mul(self.steepest) < limit && number - fewer() < limit
    }
}
