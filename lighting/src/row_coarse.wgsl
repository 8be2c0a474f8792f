// One row of a coarse mask: 64 samples as bits. Sample k is bit k % 32 of word k / 32.

struct Row { a: vec2u }

fn row_none() -> Row { return Row(vec2u(0u)); }

// Samples from `from` up to `to`.
fn row_span(from: u32, to: u32) -> Row { return Row(words_from(from) & ~words_from(to)); }

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
