// Columns of rows with 64 samples for broad lobes and 256 for narrow ones; the 64 are stored in place of the first of the 256.

var<private> row_width: u32 = 64u;
// Groups of four columns.
var<private> row_groups: u32 = 4u;

// Whether masks that are drawn from here on have 256 samples a row.
fn row_refine(finer: bool) {
    row_width = select(64u, 256u, finer);
    row_groups = select(4u, 8u, finer);
}

// Samples in columns of eight: half byte n of word i is column 4n + i. For 64 samples in columns of four: half bytes 0 and 4 are
// columns 2i and 2i + 8, half bytes 2 and 6 those next to them.
fn row_counts(row: Row) -> Counts {
    let a = (planes_counts(row.a.x) + planes_counts(row.a.y)) + (planes_counts(row.a.z) + planes_counts(row.a.w));
    let b = (planes_counts(row.b.x) + planes_counts(row.b.y)) + (planes_counts(row.b.z) + planes_counts(row.b.w));
    return select(columns_of_four(a) | (columns_of_four(b) << vec4u(8u)), a + b, row_width == 256u);
}

fn columns_of_four(counts: vec4u) -> vec4u { return (counts & vec4u(0xfu)) | ((counts & vec4u(0xf0u)) << vec4u(12u)); }

// Numbers of the four columns of a group.
fn row_columns(group: u32) -> vec4u {
    return select(vec4u(0u, 1u, 8u, 9u) + 2u * group, vec4u(0u, 8u, 16u, 24u) + group, row_width == 256u);
}
