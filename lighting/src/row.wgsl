// One row of a mask: 256 samples as bits. Sample k is bit k % 32 of word k / 32.

struct Row { a: vec4u, b: vec4u }

fn row_none() -> Row { return Row(vec4u(0u), vec4u(0u)); }

// Samples from `start` up to `end`.
fn row_span(start: u32, end: u32) -> Row {
    return Row(words_span(start, end, vec4u(0u, 32u, 64u, 96u)), words_span(start, end, vec4u(128u, 160u, 192u, 224u)));
}

fn row_without(row: Row, blocked: Row) -> Row { return Row(row.a & ~blocked.a, row.b & ~blocked.b); }

// The same pattern of 32 samples is taken of each word.
fn row_masked(row: Row, pattern: u32) -> Row { return Row(row.a & vec4u(pattern), row.b & vec4u(pattern)); }

fn row_is_none(row: Row) -> bool { return all((row.a | row.b) == vec4u(0u)); }

fn row_count(row: Row) -> u32 {
    let counts = countOneBits(row.a) + countOneBits(row.b);
    return (counts.x + counts.y) + (counts.z + counts.w);
}

fn words_span(start: u32, end: u32, first: vec4u) -> vec4u {
    return words_from(start, first) & ~words_from(end, first);
}

// Samples k and above, in words whose first samples are `first`.
fn words_from(k: u32, first: vec4u) -> vec4u {
    let shift = min(max(vec4u(k), first) - first, vec4u(32u));
    // A shift by 32 is not defined, two by half as much are.
    let half = shift >> vec4u(1u);
    return (vec4u(0xffffffffu) << half) << (shift - half);
}

// Numbers of the four columns of a group: columns of eight samples, whose counts are those of bytes.
fn row_columns(group: u32) -> vec4u { return 4u * group + vec4u(0u, 1u, 2u, 3u); }

// Samples in each of the four.
fn row_counts(row: Row, group: u32) -> vec4f {
    let four = select(row.a, row.b, group >= 4u);
    let two = select(four.xy, four.zw, (group & 2u) != 0u);
    let word = select(two.x, two.y, (group & 1u) != 0u);
    let pairs = word - ((word >> 1u) & 0x55555555u);
    let fours = (pairs & 0x33333333u) + ((pairs >> 2u) & 0x33333333u);
    let bytes = (fours + (fours >> 4u)) & 0x0f0f0f0fu;
    return vec4f((vec4u(bytes) >> vec4u(0u, 8u, 16u, 24u)) & vec4u(0xffu));
}
