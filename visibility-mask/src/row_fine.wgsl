// Columns of a row of 256 samples.

const row_width = 256u;
// Groups of four columns.
const row_groups = 8u;

fn row_refine(finer: bool) {}

// Samples in columns of eight: half byte n of word i is column 4n + i.
fn row_counts(row: Row) -> Counts {
    return (planes_counts(row.a.x) + planes_counts(row.a.y)) + (planes_counts(row.a.z) + planes_counts(row.a.w))
        + (planes_counts(row.b.x) + planes_counts(row.b.y)) + (planes_counts(row.b.z) + planes_counts(row.b.w));
}

// Numbers of the four columns of a group.
fn row_columns(group: u32) -> vec4u { return vec4u(0u, 8u, 16u, 24u) + group; }
