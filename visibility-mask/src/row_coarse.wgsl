// One row of a coarse mask: 64 samples as bits, in eight planes of eight: bit c of plane k is sample 8c + k.

// Planes 0…3 and 4…7, a byte each.
struct Row { a: vec2u }

fn row_none() -> Row { return Row(vec2u(0u)); }

// Samples from `start` up to `end`.
fn row_span(start: u32, end: u32) -> Row { return Row(planes_from(start) & ~planes_from(end)); }

// Samples k and above.
fn planes_from(k: u32) -> vec2u {
    let bit = k >> 3u;
    // In a plane before the sample's own one, the first sample is a bit later.
    let before = vec2u(min(k & 7u, 4u), max(k & 7u, 4u) - 4u);
    // A shift by 32 is not defined; two shifts by half of it are.
    let half = 4u * (4u - before);
    let late = (vec2u(0x01010101u) >> half) >> half;
    return vec2u(((0xffu << bit) & 0xffu) * 0x01010101u) & ~(late << vec2u(bit & 7u));
}

fn row_without(row: Row, blocked: Row) -> Row { return Row(row.a & ~blocked.a); }

// The row without the samples from `start` up to `end` that are in one plane.
fn row_without_line(row: Row, plane: u32, start: u32, end: u32) -> Row {
    let line = select(vec2u(0xffu, 0u), vec2u(0u, 0xffu), plane > 3u) << vec2u(8u * (plane & 3u));
    return Row(row.a & ~(row_span(start, end).a & line));
}

// The same with four planes from `first` on, 0 or 4.
fn row_without_lines(row: Row, first: u32, starts: vec4u, ends: vec4u) -> Row {
    let k = vec4u(7u, 6u, 5u, 4u) - first;
    let all = vec4u(0xffu);
    let lines = (all << ((starts + k) >> vec4u(3u))) & ~(all << ((ends + k) >> vec4u(3u))) & all;
    let word = (lines.x | lines.y << 8u) | (lines.z << 16u | lines.w << 24u);
    return Row(row.a & ~select(vec2u(word, 0u), vec2u(0u, word), first > 0u));
}

// The row without those of samples 32k … 32k + 31 whose bit is set.
fn row_without_samples(row: Row, k: u32, bits: u32) -> Row {
    var blocked = vec2u(0u);
    for (var plane = 0u; plane < 8u; plane++) {
        let four = ((((bits >> plane) & 0x01010101u) * 0x10204080u) >> 28u) << (8u * (plane & 3u) + 4u * k);
        blocked |= select(vec2u(four, 0u), vec2u(0u, four), plane > 3u);
    }
    return Row(row.a & ~blocked);
}

fn row_is_none(row: Row) -> bool { return (row.a.x | row.a.y) == 0u; }

fn row_count(row: Row) -> u32 { return countOneBits(row.a.x) + countOneBits(row.a.y); }

const ROW_WORDS = 2u;

// A word of its bits.
fn row_word(row: Row, k: u32) -> u32 { return row.a[k]; }

// The first sample, and the one after the last; of a row that has any.
fn row_bounds(row: Row) -> vec2u {
    var bounds = vec2u(row_width, 0u);
    for (var plane = 0u; plane < 8u; plane++) {
        let samples = (select(row.a.x, row.a.y, plane > 3u) >> (8u * (plane & 3u))) & 0xffu;
        if (samples != 0u) {
            bounds = vec2u(
                min(bounds.x, 8u * firstTrailingBit(samples) + plane),
                max(bounds.y, 8u * firstLeadingBit(samples) + plane + 1u)
            );
        }
    }
    return bounds;
}

// Samples 32k … 32k + 31 as bits.
fn row_samples(row: Row, k: u32) -> u32 {
    var samples = 0u;
    for (var plane = 0u; plane < 8u; plane++) {
        let word = select(row.a.x, row.a.y, plane > 3u) >> (8u * (plane & 3u) + 4u * k);
        samples |= (((word & 0xfu) * 0x00204081u) & 0x01010101u) << plane;
    }
    return samples;
}

const row_width = 64u;
// Groups of four columns.
const row_groups = 4u;

fn row_refine(finer: bool) {}

// Columns of four samples: bit n of the planes of word i is column 2n + i.
alias Counts = vec2u;

fn row_counts(row: Row) -> Counts { return row.a; }

// Numbers of the four columns of a group.
fn row_columns(group: u32) -> vec4u { return vec4u(0u, 2u, 4u, 6u) + (8u * (group & 1u) + (group >> 1u)); }

// Samples in each of the four columns.
fn counts_of(counts: Counts, group: u32) -> vec4f {
    let word = select(counts.x, counts.y, group > 1u) >> (4u * (group & 1u));
    return vec4f(countOneBits((vec4u(word) >> vec4u(0u, 1u, 2u, 3u)) & vec4u(0x01010101u)));
}
