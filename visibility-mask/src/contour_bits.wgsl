// Cells of a row as bits of two words.

fn bits_ones(n: u32) -> vec2u {
    return vec2u(
        select(0xffffffffu, (1u << (n & 31u)) - 1u, n < 32u),
        select(select(0xffffffffu, (1u << (n & 31u)) - 1u, n < 64u), 0u, n < 32u)
    );
}

fn bits_one(i: u32) -> vec2u { return select(vec2u(0u, 1u << (i & 31u)), vec2u(1u << (i & 31u), 0u), i < 32u); }

fn bits_has(v: vec2u, i: u32) -> bool { return ((select(v.y, v.x, i < 32u) >> (i & 31u)) & 1u) == 1u; }

// The lowest bit, 64 if there is none.
fn bits_first(v: vec2u) -> u32 { return select(32u + countTrailingZeros(v.y), countTrailingZeros(v.x), v.x != 0u); }

// The lowest bit that is not set, from `first` on.
fn bits_end(v: vec2u, first: u32) -> u32 { return bits_first(~v & ~bits_ones(first)); }

fn bits_last(v: vec2u) -> u32 { return select(31u - countLeadingZeros(v.x), 63u - countLeadingZeros(v.y), v.y != 0u); }

// Every bit moved to the next higher place, and to the next lower one.
fn bits_up(v: vec2u) -> vec2u { return vec2u(v.x << 1u, (v.y << 1u) | (v.x >> 31u)); }

fn bits_down(v: vec2u) -> vec2u { return vec2u((v.x >> 1u) | (v.y << 31u), v.y >> 1u); }

fn bits_any(v: vec2u) -> bool { return (v.x | v.y) != 0u; }
