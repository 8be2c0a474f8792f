// One row of a coarse mask: 64 samples as bits. Sample k is bit k % 32 of word k / 32.

struct Row { a: vec2u }

fn row_none() -> Row { return Row(vec2u(0u)); }

// Samples from `start` up to `end`.
fn row_span(start: u32, end: u32) -> Row { return Row(words_from(start) & ~words_from(end)); }

// Samples k and above.
fn words_from(k: u32) -> vec2u {
    let first = vec2u(0u, 32u);
    let shift = min(max(vec2u(k), first) - first, vec2u(32u));
    // A shift by 32 is not defined, two by half as much are.
    let half = shift >> vec2u(1u);
    return (vec2u(0xffffffffu) << half) << (shift - half);
}

fn row_without(row: Row, blocked: Row) -> Row { return Row(row.a & ~blocked.a); }

// Without those of samples `start` up to `end` that are `plane` after a multiple of eight.
fn row_without_line(row: Row, plane: u32, start: u32, end: u32) -> Row {
    return Row(row.a & ~(row_span(start, end).a & vec2u(0x01010101u << plane)));
}

// The same with four planes from `first` on, 0 or 4.
fn row_without_lines(row: Row, first: u32, starts: vec4u, ends: vec4u) -> Row {
    let a = row_without_line(row, first, starts.x, ends.x);
    let b = row_without_line(a, first + 1u, starts.y, ends.y);
    let c = row_without_line(b, first + 2u, starts.z, ends.z);
    return row_without_line(c, first + 3u, starts.w, ends.w);
}

fn row_is_none(row: Row) -> bool { return (row.a.x | row.a.y) == 0u; }

fn row_count(row: Row) -> u32 { return countOneBits(row.a.x) + countOneBits(row.a.y); }

// Samples 32k … 32k + 31 as bits.
fn row_samples(row: Row, k: u32) -> u32 { return select(row.a.x, row.a.y, k == 1u); }

// Samples in columns of four, half a byte for each column: of word i, half byte n is column 8i + n.
alias Counts = vec2u;

fn row_counts(row: Row) -> Counts {
    let pairs = row.a - ((row.a >> vec2u(1u)) & vec2u(0x55555555u));
    return (pairs & vec2u(0x33333333u)) + ((pairs >> vec2u(2u)) & vec2u(0x33333333u));
}

// Numbers of the four columns of a group.
fn row_columns(group: u32) -> vec4u { return 8u * (group >> 1u) + (group & 1u) + vec4u(0u, 2u, 4u, 6u); }

// Samples in each of the four.
fn counts_of(counts: Counts, group: u32) -> vec4f {
    let word = select(counts.x, counts.y, group >= 2u) >> (4u * (group & 1u));
    return vec4f((vec4u(word) >> vec4u(0u, 8u, 16u, 24u)) & vec4u(0xfu));
}
