// One row of a coarse mask: 64 samples as bits. Sample k is bit k % 32 of word k / 32.

struct Row { a: vec2u }

fn row_none() -> Row { return Row(vec2u(0u)); }

// Samples from `start` up to `end`.
fn row_span(start: u32, end: u32) -> Row { return Row(words_from(start) & ~words_from(end)); }

fn row_without(row: Row, blocked: Row) -> Row { return Row(row.a & ~blocked.a); }

// The same pattern of 32 samples is taken of each word.
fn row_masked(row: Row, pattern: u32) -> Row { return Row(row.a & vec2u(pattern)); }

fn row_is_none(row: Row) -> bool { return (row.a.x | row.a.y) == 0u; }

fn row_count(row: Row) -> u32 { return countOneBits(row.a.x) + countOneBits(row.a.y); }

// Samples k and above.
fn words_from(k: u32) -> vec2u {
    let first = vec2u(0u, 32u);
    let shift = min(max(vec2u(k), first) - first, vec2u(32u));
    // A shift by 32 is not defined, two by half as much are.
    let half = shift >> vec2u(1u);
    return (vec2u(0xffffffffu) << half) << (shift - half);
}

// Numbers of the four columns of a group: columns of four samples, the even ones of a word, then the odd ones.
fn row_columns(group: u32) -> vec4u { return 8u * (group >> 1u) + (group & 1u) + vec4u(0u, 2u, 4u, 6u); }

// Samples in each of the four.
fn row_counts(row: Row, group: u32) -> vec4f {
    let word = select(row.a.x, row.a.y, group >= 2u);
    let pairs = word - ((word >> 1u) & 0x55555555u);
    let fours = (pairs & 0x33333333u) + ((pairs >> 2u) & 0x33333333u);
    let half_bytes = fours >> (4u * (group & 1u));
    return vec4f((vec4u(half_bytes) >> vec4u(0u, 8u, 16u, 24u)) & vec4u(0xfu));
}
