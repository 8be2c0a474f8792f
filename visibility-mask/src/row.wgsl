// One row of a mask: 256 samples as bits, in eight planes: bit c of plane k is sample 8c + k. A span starts and ends in each plane
// at one of two neighbouring bits, and a line of `mask_block_line` is one plane.

// Planes 0…3 and 4…7.
struct Row { a: vec4u, b: vec4u }

const PLANES_A = vec4u(0u, 1u, 2u, 3u);
const PLANES_B = vec4u(4u, 5u, 6u, 7u);

fn row_none() -> Row { return Row(vec4u(0u), vec4u(0u)); }

// Samples from `start` up to `end`.
fn row_span(start: u32, end: u32) -> Row {
    let s = plane_from(start >> 3u);
    let e = plane_from(end >> 3u);
    return Row(planes_span(PLANES_A, start, s, end, e), planes_span(PLANES_B, start, s, end, e));
}

fn planes_span(planes: vec4u, start: u32, s: u32, end: u32, e: u32) -> vec4u {
    // In a plane before the start's own one, the first sample is a bit later.
    let starts = select(vec4u(s), vec4u(s << 1u), planes < vec4u(start & 7u));
    let ends = select(vec4u(e), vec4u(e << 1u), planes < vec4u(end & 7u));
    return starts & ~ends;
}

// Bits from `k` on, up to 32.
fn plane_from(k: u32) -> u32 {
    // A shift by 32 is not defined; two shifts by half of it are.
    return (0xffffffffu << (k >> 1u)) << (k - (k >> 1u));
}

fn row_without(row: Row, blocked: Row) -> Row { return Row(row.a & ~blocked.a, row.b & ~blocked.b); }

// The row without the samples from `start` up to `end` that are in one plane.
fn row_without_line(row: Row, plane: u32, start: u32, end: u32) -> Row {
    let line = plane_from((start + 7u - plane) >> 3u) & ~plane_from((end + 7u - plane) >> 3u);
    return Row(
        row.a & ~select(vec4u(0u), vec4u(line), PLANES_A == vec4u(plane)),
        row.b & ~select(vec4u(0u), vec4u(line), PLANES_B == vec4u(plane))
    );
}

// The same with four planes from `first` on, 0 or 4.
fn row_without_lines(row: Row, first: u32, starts: vec4u, ends: vec4u) -> Row {
    let k = 7u - (PLANES_A + first);
    let lines = planes_from((starts + k) >> vec4u(3u)) & ~planes_from((ends + k) >> vec4u(3u));
    if (first == 0u) {
        return Row(row.a & ~lines, row.b);
    }
    return Row(row.a, row.b & ~lines);
}

fn planes_from(k: vec4u) -> vec4u {
    let half = k >> vec4u(1u);
    return (vec4u(0xffffffffu) << half) << (k - half);
}

// The row without those of samples 32k … 32k + 31 whose bit is set.
fn row_without_samples(row: Row, k: u32, bits: u32) -> Row {
    let low = vec4u(bits) >> PLANES_A;
    return Row(row.a & ~(planes_gathered(low) << vec4u(4u * k)), row.b & ~(planes_gathered(low >> vec4u(4u)) << vec4u(4u * k)));
}

// Every eighth bit, next to each other.
fn planes_gathered(bits: vec4u) -> vec4u { return ((bits & vec4u(0x01010101u)) * vec4u(0x10204080u)) >> vec4u(28u); }

fn row_is_none(row: Row) -> bool { return all((row.a | row.b) == vec4u(0u)); }

fn row_count(row: Row) -> u32 {
    let counts = countOneBits(row.a) + countOneBits(row.b);
    return (counts.x + counts.y) + (counts.z + counts.w);
}

const ROW_WORDS = 8u;

// A word of its bits.
fn row_word(row: Row, k: u32) -> u32 {
    if (k < 4u) {
        return row.a[k];
    }
    return row.b[k - 4u];
}

// The first sample, and the one after the last; of a row that has any.
fn row_bounds(row: Row) -> vec2u {
    let none_a = row.a == vec4u(0u);
    let none_b = row.b == vec4u(0u);
    let first_a = select(8u * firstTrailingBit(row.a) + PLANES_A, vec4u(row_width), none_a);
    let first_b = select(8u * firstTrailingBit(row.b) + PLANES_B, vec4u(row_width), none_b);
    let end_a = select(8u * firstLeadingBit(row.a) + PLANES_A + 1u, vec4u(0u), none_a);
    let end_b = select(8u * firstLeadingBit(row.b) + PLANES_B + 1u, vec4u(0u), none_b);
    let first = min(first_a, first_b);
    let end = max(end_a, end_b);
    return vec2u(min(min(first.x, first.y), min(first.z, first.w)), max(max(end.x, end.y), max(end.z, end.w)));
}

// Samples 32k … 32k + 31 as bits.
fn row_samples(row: Row, k: u32) -> u32 {
    return plane_spread(row.a.x, k) | (plane_spread(row.a.y, k) << 1u)
        | (plane_spread(row.a.z, k) << 2u) | (plane_spread(row.a.w, k) << 3u)
        | (plane_spread(row.b.x, k) << 4u) | (plane_spread(row.b.y, k) << 5u)
        | (plane_spread(row.b.z, k) << 6u) | (plane_spread(row.b.w, k) << 7u);
}

// Four bits, one a byte.
fn plane_spread(plane: u32, k: u32) -> u32 { return (((plane >> (4u * k)) & 0xfu) * 0x00204081u) & 0x01010101u; }

// Samples in columns, half a byte for each column.
alias Counts = vec4u;

fn planes_counts(plane: u32) -> vec4u { return (vec4u(plane) >> PLANES_A) & vec4u(0x11111111u); }

// Samples in each of the four columns of a group.
fn counts_of(counts: Counts, group: u32) -> vec4f {
    let two = select(counts.xy, counts.zw, (group & 2u) != 0u);
    let word = select(two.x, two.y, (group & 1u) != 0u) >> (group & 4u);
    return vec4f((vec4u(word) >> vec4u(0u, 8u, 16u, 24u)) & vec4u(0xfu));
}
