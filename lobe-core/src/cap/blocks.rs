use super::brushed::Brushed;
use super::chord::{self, Chord, finish};
use super::microfacets::{self, Ellipse};
use super::pair::Pair;
use super::{albedo, form, lambert, slab};
use crate::lanes::{Block, Columns, Lane, Level, WIDTH, map, ones, row, rows_with, set_row};
use crate::seen::Seen;
use crate::{PackedLobe, TileLobes};
use core::f32::consts::FRAC_1_PI;
use fearless_simd::dispatch;
use glam::Vec3;

/// From so many of one kind on a block is evaluated where it lies; fewer move together with others of their kind.
const DENSE: u32 = 12;

/// Integrals that wait for others of their kind: a block of each kind, evaluated when it is full.
pub(super) struct Blocks {
    crossed: Block<2>,
    slab: Block<12>,
    whole: Block<12>,
    few: Block<15>,
    many: Block<15>,
    piece: Block<15>,
    edge: Block<15>,
    microfacets: Facets,
    microfacets_cut: Facets,
    microfacets_all: Facets,
    /// The three of microfacets with a grain.
    brushed: [Facets; 3],
}

impl Blocks {
    pub(super) const fn new() -> Self {
        Self {
            crossed: Block::new(),
            slab: Block::new(),
            whole: Block::new(),
            few: Block::new(),
            many: Block::new(),
            piece: Block::new(),
            edge: Block::new(),
            microfacets: Facets::new(),
            microfacets_cut: Facets::new(),
            microfacets_all: Facets::new(),
            brushed: [const { Facets::new() }; 3],
        }
    }

    /// Takes block `number` of a tile's lobes and the light of their receivers; their integrals go to `out`, at once or when others
    /// like them have come.
    pub(super) fn take(&mut self, level: Level, seen: &Columns<10>, lobes: &TileLobes, number: usize, out: &mut [f32]) {
        let (first, block) = (number * WIDTH, lobes.block(number));
        let mut sorted = [[0.0; WIDTH]; 2];
        map(level, &Sort, seen, block, &mut sorted);
        let [forms, values] = &sorted;
        out[first..first + WIDTH].copy_from_slice(values);
        let mut waiting = rows_with(forms, form::DONE) ^ ((1 << WIDTH) - 1);
        let whole = rows_with(forms, form::WHOLE);
        if whole.count_ones() >= DENSE {
            let of = core::array::from_fn(|j| (first + j) as u32);
            let mut chords = [[0.0; WIDTH]; 16];
            map(level, &Whole, seen, block, &mut chords);
            self.chords(level, &chords, whole, &of, out);
            waiting ^= whole;
        }
        for j in ones(waiting) {
            let (light, lobe): (Seen, PackedLobe) = (bytemuck::cast(row(seen, j)), bytemuck::cast(row(block, j)));
            if !lobe.is_microfacets() {
                self.push(level, forms[j], &light, &lobe, first + j, out);
            } else if let Some(of) = facets(lobes, number, j, &lobe) {
                self.push_facets(level, forms[j], &light.pair(&lobe), of, out);
            }
        }
    }

    fn push_facets(&mut self, level: Level, form: f32, pair: &Pair, of: [u32; 2], out: &mut [f32]) {
        if form == form::MICROFACETS {
            self.microfacets.push(level, over_chords::<false>, pair, of, out);
        } else if form == form::MICROFACETS_CUT {
            self.microfacets_cut.push(level, over_chords::<true>, pair, of, out);
        } else if form == form::MICROFACETS_ALL {
            self.microfacets_all.push(level, over_facets, pair, of, out);
        } else {
            let which = (form - form::BRUSHED - form::MICROFACETS) as usize;
            self.brushed[which].push(level, BRUSHED[which], pair, of, out);
        }
    }

    fn push(&mut self, level: Level, form: f32, light: &Seen, lobe: &PackedLobe, k: usize, out: &mut [f32]) {
        if form == form::WHOLE {
            if self.whole.push(&bytemuck::cast(light.pair(lobe)), k) {
                self.whole(level, out);
            }
        } else if form == form::SLAB {
            if self.slab.push(&bytemuck::cast(light.pair(lobe)), k) {
                self.slab(level, out);
            }
        } else if form == form::CROSSED {
            if self.crossed.push(&[light.cos_beta, light.sin_sq], k) {
                self.crossed(level, out);
            }
        } else {
            self.pieces(level, form, &light.pair(lobe), k, out);
        }
    }

    #[cold]
    #[inline(never)]
    fn pieces(&mut self, level: Level, form: f32, pair: &Pair, k: usize, out: &mut [f32]) {
        for piece in Chord::pieces(pair) {
            let row = bytemuck::cast(piece);
            if form == form::EDGE {
                if self.edge.push(&row, k) {
                    flush::<{ chord::EDGE }, true>(level, &mut self.edge, out);
                }
            } else if self.piece.push(&row, k) {
                flush::<{ chord::PIECE }, true>(level, &mut self.piece, out);
            }
        }
    }

    /// Evaluates what still waits.
    pub(super) fn finish(&mut self, level: Level, out: &mut [f32]) {
        self.whole(level, out);
        self.slab(level, out);
        self.crossed(level, out);
        flush::<{ chord::FEW }, false>(level, &mut self.few, out);
        flush::<{ chord::MANY }, false>(level, &mut self.many, out);
        flush::<{ chord::PIECE }, true>(level, &mut self.piece, out);
        flush::<{ chord::EDGE }, true>(level, &mut self.edge, out);
        self.microfacets.flush(level, over_chords::<false>, out);
        self.microfacets_cut.flush(level, over_chords::<true>, out);
        self.microfacets_all.flush(level, over_facets, out);
        self.brushed.iter_mut().zip(BRUSHED).for_each(|(brushed, sum)| brushed.flush(level, sum, out));
    }

    fn crossed(&mut self, level: Level, out: &mut [f32]) {
        if self.crossed.len > 0 {
            let mut values = [[0.0; WIDTH]];
            map(level, &Crossed, &self.crossed.columns, &[], &mut values);
            self.crossed.flush(&values[0], out);
        }
    }

    fn slab(&mut self, level: Level, out: &mut [f32]) {
        if self.slab.len > 0 {
            let mut values = [[0.0; WIDTH]];
            map(level, &Slab, &self.slab.columns, &[], &mut values);
            self.slab.flush(&values[0], out);
        }
    }

    fn whole(&mut self, level: Level, out: &mut [f32]) {
        if self.whole.len > 0 {
            let mut chords = [[0.0; WIDTH]; 16];
            map(level, &Whole, &self.whole.columns, &[], &mut chords);
            let (rows, of) = ((1 << self.whole.len) - 1, self.whole.of);
            self.whole.len = 0;
            self.chords(level, &chords, rows, &of, out);
        }
    }

    /// Chords and how many nodes they want: enough of a kind are summed, others wait.
    fn chords(&mut self, level: Level, chords: &Columns<16>, rows: u32, of: &[u32; WIDTH], out: &mut [f32]) {
        let [columns @ .., nodes] = chords;
        let few = rows & rows_with(nodes, chord::FEW as f32);
        let many = rows & rows_with(nodes, chord::MANY as f32);
        sum_or_wait::<{ chord::FEW }>(level, columns, few, of, &mut self.few, out);
        sum_or_wait::<{ chord::MANY }>(level, columns, many, of, &mut self.many, out);
    }
}

fn sum_or_wait<const N: usize>(
    level: Level,
    columns: &Columns<15>,
    rows: u32,
    of: &[u32; WIDTH],
    block: &mut Block<15>,
    out: &mut [f32],
) {
    if rows.count_ones() >= DENSE {
        let values = sum::<N, false>(level, columns);
        for j in ones(rows) {
            out[of[j] as usize] += values[j];
        }
        return;
    }
    for j in ones(rows) {
        if block.push(&row(columns, j), of[j] as usize) {
            flush::<N, false>(level, block, out);
        }
    }
}

/// The form that a lobe of a tile needs, and its value where no form is needed.
struct Sort;
impl Lane<10, 8, 2> for Sort {
    #[inline(always)]
    fn value(&self, seen: [f32; 10], lobe: [f32; 8]) -> [f32; 2] {
        let lobe: PackedLobe = bytemuck::cast(lobe);
        let [form, value] = form::of(&bytemuck::cast(seen), &lobe);
        let empty = lobe.flux == Vec3::ZERO;
        [if empty { form::DONE } else { form }, if empty { 0.0 } else { value }]
    }
}

struct Crossed;
impl Lane<2, 0, 1> for Crossed {
    #[inline(always)]
    fn value(&self, [cos_beta, sin_sq]: [f32; 2], []: [f32; 0]) -> [f32; 1] {
        [lambert::through_horizon(cos_beta, sin_sq) * FRAC_1_PI]
    }
}

struct Slab;
impl Lane<12, 0, 1> for Slab {
    #[inline(always)]
    fn value(&self, row: [f32; 12], []: [f32; 0]) -> [f32; 1] {
        [slab::slab(&bytemuck::cast::<_, Pair>(row))]
    }
}

/// Chords, and how many nodes they want.
struct Whole;
impl Whole {
    #[inline(always)]
    fn of(pair: &Pair) -> [f32; 16] {
        let chord = Chord::whole(pair);
        let nodes = if chord.is_narrow() { chord::FEW as f32 } else { chord::MANY as f32 };
        let mut all = [if chord.weight > 0.0 { nodes } else { 0.0 }; 16];
        all[..15].copy_from_slice(&bytemuck::cast::<_, [f32; 15]>(chord));
        all
    }
}
impl Lane<10, 8, 16> for Whole {
    #[inline(always)]
    fn value(&self, seen: [f32; 10], lobe: [f32; 8]) -> [f32; 16] {
        Self::of(&bytemuck::cast::<_, Seen>(seen).pair(&bytemuck::cast(lobe)))
    }
}
impl Lane<12, 0, 16> for Whole {
    #[inline(always)]
    fn value(&self, pair: [f32; 12], []: [f32; 0]) -> [f32; 16] {
        Self::of(&bytemuck::cast(pair))
    }
}

/// The chord sums of a block.
fn sum<const N: usize, const CUT: bool>(level: Level, columns: &Columns<15>) -> [f32; WIDTH] {
    let nodes = const { chord::nodes::<N>() };
    let sums = dispatch!(level, _simd => {
        let mut sums = [0.0; WIDTH];
        for (cos, sin) in nodes {
            for (j, sum) in sums.iter_mut().enumerate() {
                let chord: Chord = bytemuck::cast(row(columns, j));
                *sum += chord.node::<CUT>(cos, sin);
            }
        }
        sums
    });
    core::array::from_fn(|j| finish(columns[0][j], sums[j]))
}

fn flush<const N: usize, const CUT: bool>(level: Level, block: &mut Block<15>, out: &mut [f32]) {
    if block.len > 0 {
        let values = sum::<N, CUT>(level, &block.columns);
        block.flush(&values, out);
    }
}

/// Where the integrals of a lobe of microfacets go and of the edge that follows it, [`NOWHERE`] for one that is not there; none of a
/// lobe that waits for its edge.
fn facets(tile: &TileLobes, number: usize, j: usize, lobe: &PackedLobe) -> Option<[u32; 2]> {
    let stride = tile.blocks_of_place();
    let other = |number: usize| bytemuck::cast::<_, PackedLobe>(row(tile.block(number), j));
    let k = (number * WIDTH + j) as u32;
    if lobe.is_edge() {
        let is_paired = number >= stride && other(number - stride).is_followed_by(lobe);
        return Some([if is_paired { k - (stride * WIDTH) as u32 } else { NOWHERE }, k]);
    }
    let is_paired = number + stride < tile.blocks() && lobe.is_followed_by(&other(number + stride));
    (!is_paired).then_some([k, NOWHERE])
}

/// No place in the output.
const NOWHERE: u32 = u32::MAX;

/// Lobes of microfacets that wait, each for itself or with its edge.
struct Facets {
    pairs: Block<12>,
    edges: [u32; WIDTH],
}

impl Facets {
    const fn new() -> Self {
        Self { pairs: Block::new(), edges: [NOWHERE; WIDTH] }
    }

    #[inline(always)]
    fn push(&mut self, level: Level, sum: SumOfPairs, pair: &Pair, [base, edge]: [u32; 2], out: &mut [f32]) {
        self.edges[self.pairs.len] = edge;
        if self.pairs.push(&bytemuck::cast(*pair), base as usize) {
            self.flush(level, sum, out);
        }
    }

    /// The integrals of those that wait; none does then.
    fn flush(&mut self, level: Level, sum: SumOfPairs, out: &mut [f32]) {
        if self.pairs.len == 0 {
            return;
        }
        let sums = sum(level, &self.pairs.columns);
        for j in 0..self.pairs.len {
            for (k, sums) in [self.pairs.of[j], self.edges[j]].into_iter().zip(&sums) {
                if k != NOWHERE {
                    out[k as usize] += sums[j];
                }
            }
        }
        self.pairs.len = 0;
    }
}

/// The integrals of both parts of each pair of a block.
type SumOfPairs = fn(Level, &Columns<12>) -> Columns<2>;

/// By the chords of their ellipses.
#[inline(never)]
fn over_chords<const IS_CUT: bool>(level: Level, pairs: &Columns<12>) -> Columns<2> {
    let mut ellipses = [[0.0; WIDTH]; 12];
    map(level, &ToEllipse::<IS_CUT>, pairs, &[], &mut ellipses);
    let sums = dispatch!(level, _simd => {
        let mut sums = [[0.0; WIDTH]; 2];
        for (cos, weight) in microfacets::nodes::<IS_CUT>() {
            let [base, edge] = &mut sums;
            for (j, (base, edge)) in base.iter_mut().zip(edge).enumerate() {
                let ellipse: Ellipse = bytemuck::cast(row(&ellipses, j));
                let node = ellipse.node::<IS_CUT>(cos, weight);
                *base += node[0];
                *edge += node[1];
            }
        }
        sums
    });
    let weights: [f32; WIDTH] = core::array::from_fn(|j| bytemuck::cast::<_, Ellipse>(row(&ellipses, j)).weight());
    sums.map(|sums| core::array::from_fn(|j| finish(weights[j], sums[j])))
}

/// Over all directions: by the facets that the eye sees.
#[inline(never)]
fn over_facets(level: Level, pairs: &Columns<12>) -> Columns<2> {
    let mut facets = [[0.0; WIDTH]; 5];
    map(level, &ToFacets, pairs, &[], &mut facets);
    dispatch!(level, _simd => {
        let mut sums = [[0.0; WIDTH]; 2];
        for turn in albedo::TURNS {
            let mut ranges = [[0.0; WIDTH]; 2];
            for j in 0..WIDTH {
                set_row(&mut ranges, j, &bytemuck::cast::<_, albedo::Facets>(row(&facets, j)).cap());
            }
            for _ in 0..albedo::HALVINGS {
                for j in 0..WIDTH {
                    let half = bytemuck::cast::<_, albedo::Facets>(row(&facets, j)).halve(row(&ranges, j), turn);
                    set_row(&mut ranges, j, &half);
                }
            }
            for place in albedo::PLACES {
                let [base, edge] = &mut sums;
                for (j, (base, edge)) in base.iter_mut().zip(edge).enumerate() {
                    let node = bytemuck::cast::<_, albedo::Facets>(row(&facets, j)).node(row(&ranges, j), turn, place);
                    *base += node[0];
                    *edge += node[1];
                }
            }
        }
        sums
    })
}

/// The sums of microfacets with a grain, by their forms.
const BRUSHED: [SumOfPairs; 3] = [over_brushed::<false>, over_brushed::<true>, over_brushed_facets];

/// [`over_chords`] of microfacets with a grain.
#[inline(never)]
fn over_brushed<const IS_CUT: bool>(level: Level, pairs: &Columns<12>) -> Columns<2> {
    let mut all = [[0.0; WIDTH]; 14];
    map(level, &ToBrushed::<IS_CUT>, pairs, &[], &mut all);
    let sums = dispatch!(level, _simd => {
        let mut sums = [[0.0; WIDTH]; 2];
        for (cos, weight) in microfacets::nodes::<IS_CUT>() {
            let [base, edge] = &mut sums;
            for (j, (base, edge)) in base.iter_mut().zip(edge).enumerate() {
                let node = bytemuck::cast::<_, Brushed>(row(&all, j)).node::<IS_CUT>(cos, weight);
                *base += node[0];
                *edge += node[1];
            }
        }
        sums
    });
    let weights: [f32; WIDTH] = core::array::from_fn(|j| bytemuck::cast::<_, Brushed>(row(&all, j)).weight());
    sums.map(|sums| core::array::from_fn(|j| finish(weights[j], sums[j])))
}

/// [`over_facets`] of microfacets with a grain: fewer, and so one by one.
#[inline(never)]
fn over_brushed_facets(level: Level, pairs: &Columns<12>) -> Columns<2> {
    let all: [[f32; 2]; WIDTH] =
        core::array::from_fn(|j| super::of_brushed_everywhere(level, &bytemuck::cast(row(pairs, j))));
    [0, 1].map(|part| all.map(|both| both[part]))
}

struct ToBrushed<const IS_CUT: bool>;
impl<const IS_CUT: bool> Lane<12, 0, 14> for ToBrushed<IS_CUT> {
    #[inline(always)]
    fn value(&self, pair: [f32; 12], []: [f32; 0]) -> [f32; 14] {
        bytemuck::cast(Brushed::new::<IS_CUT>(&bytemuck::cast(pair)))
    }
}

struct ToFacets;
impl Lane<12, 0, 5> for ToFacets {
    #[inline(always)]
    fn value(&self, pair: [f32; 12], []: [f32; 0]) -> [f32; 5] {
        bytemuck::cast(albedo::Facets::new(&bytemuck::cast(pair)))
    }
}

struct ToEllipse<const IS_CUT: bool>;
impl<const IS_CUT: bool> Lane<12, 0, 12> for ToEllipse<IS_CUT> {
    #[inline(always)]
    fn value(&self, pair: [f32; 12], []: [f32; 0]) -> [f32; 12] {
        bytemuck::cast(Ellipse::new::<IS_CUT>(&bytemuck::cast(pair)))
    }
}
