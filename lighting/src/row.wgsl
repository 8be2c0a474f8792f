// One row of a mask: 256 samples as bits. Sample k is bit k % 32 of word k / 32.

struct Row { a: vec4u, b: vec4u }

fn row_none() -> Row { return Row(vec4u(0u), vec4u(0u)); }

// Samples from `from` up to `to`.
fn row_span(from: u32, to: u32) -> Row {
    return Row(words_span(from, to, vec4u(0u, 32u, 64u, 96u)), words_span(from, to, vec4u(128u, 160u, 192u, 224u)));
}

fn row_without(row: Row, blocked: Row) -> Row { return Row(row.a & ~blocked.a, row.b & ~blocked.b); }

// The same pattern of 32 samples is taken of each word.
fn row_masked(row: Row, pattern: u32) -> Row { return Row(row.a & vec4u(pattern), row.b & vec4u(pattern)); }

fn row_is_none(row: Row) -> bool { return all((row.a | row.b) == vec4u(0u)); }

fn row_count(row: Row) -> u32 {
    let counts = countOneBits(row.a) + countOneBits(row.b);
    return (counts.x + counts.y) + (counts.z + counts.w);
}

fn words_span(from: u32, to: u32, first: vec4u) -> vec4u {
    return words_from(from, first) & ~words_from(to, first);
}

// Samples k and above, in words whose first samples are `first`.
fn words_from(k: u32, first: vec4u) -> vec4u {
    let shift = min(max(vec4u(k), first) - first, vec4u(32u));
    // A shift by 32 is not defined, two by half as much are.
    let half = shift >> vec4u(1u);
    return (vec4u(0xffffffffu) << half) << (shift - half);
}
