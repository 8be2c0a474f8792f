// Outlines before one receiver that cross samples so often that several lie in one: `Crowd`. Blockers draw again for each few rows, whole ones, and
// list the crossings of each sample. The thread of a row then counts them in SKY_FINER parts of the sample, of which each keeps the largest hidden part.

// Rows whose samples have room for the beginnings of lists.
const SKY_CROWD_ROWS = SKY_CELLS / SKY_SAMPLES;
// Crossings of these rows.
const SKY_LINKS = SKY_WORDS;

// Whether this number of crossings is that of a crowd: `Crowd::is_of`. Longer tables are not divided.
fn sky_is_crowd_of(crossings: u32) -> bool {
    return SKY_SAMPLES * SKY_FINER <= SKY_RUN && crossings * SKY_SPARSE > SKY_ROWS * SKY_SAMPLES;
}

// Puts a crossing in the list of its sample: the sample has the number of the last one, each the number of the one before.
fn sky_link(row: u32, column: u32, fraction: u32, step: i32) {
    // Rows before these wrap to numbers beyond all.
    let lane = row - sky_first_row;
    if (lane >= sky_rows || column >= SKY_SAMPLES) {
        return;
    }
    let place = atomicAdd(&sky_crossing_count, 1u);
    if (place < SKY_LINKS) {
        let before = u32(atomicExchange(&sky_counts[column * sky_rows + lane], i32(place + 1u)));
        atomicStore(&sky_words[place], fraction | (u32(step + 8) << 12u) | (before << 16u));
    }
}

// Counts the thread's row in the part, as `sky_count` does, of lists: `Crowd::open`.
fn sky_count_crowd(lane: u32, fewest: i32) {
    let row = sky_row(lane);
    if (row >= SKY_ROWS) {
        return;
    }
    let sure = sky_end(row, sky_horizon.local) * f32(SKY_FINER) - SKY_SURE;
    let first = sky_column();
    let fewest_here = vec4i(fewest >> SKY_CUTS);
    let one = vec4i(SKY_HALF);
    for (var c = 0u; c < SKY_COLUMNS; c++) {
        let cell = (first + c) * sky_rows + lane;
        // Of each quarter the crossings, their steps, those of them down, and what the steps hide of it; where surfaces begin first and end last.
        var cuts = vec4i(0);
        var steps = vec4i(0);
        var falls = vec4i(0);
        var hidden = vec4i(0);
        var begun = one;
        var ended = one;
        var link = u32(atomicLoad(&sky_counts[cell]));
        while (link != 0u) {
            let crossing = atomicLoad(&sky_words[link - 1u]);
            link = crossing >> 16u;
            let fraction = i32(crossing & 4095u) * i32(SKY_FINER);
            let step = i32((crossing >> 12u) & 15u) - 8;
            let part = min(fraction / SKY_HALF, i32(SKY_FINER) - 1);
            let within = fraction - part * SKY_HALF;
            let here = vec4i(part) == vec4i(0, 1, 2, 3);
            cuts += select(vec4i(0), vec4i(1), here);
            steps += select(vec4i(0), vec4i(step), here);
            hidden += select(vec4i(0), vec4i(step * (SKY_HALF - within)), here);
            if (step > 0) {
                begun = select(begun, min(begun, vec4i(within)), here);
            } else {
                falls += select(vec4i(0), vec4i(step), here);
                ended = select(ended, min(ended, vec4i(SKY_HALF - within)), here);
            }
        }
        // The numbers of surfaces at the ends of the quarters, and before those that begin there.
        let left = vec4i(0, steps.x, steps.x + steps.y, steps.x + steps.y + steps.z) + sky_number;
        let right = left + steps;
        sky_number = right.w;
        hidden += left * SKY_HALF;
        let ends = select(vec4i(0), begun, left * SKY_HALF <= fewest_here)
            + select(vec4i(0), ended, right * SKY_HALF <= fewest_here);
        let between = select(vec4i(0), begun + ended - one, (left + falls) * SKY_HALF <= fewest_here);
        let seen = max(fewest_here + 2 * one - hidden, 2 * max(ends, between));
        let parts = clamp(seen, vec4i(0), 2 * one);
        atomicStore(&sky_counts[cell], parts.x + parts.y + parts.z + parts.w);
        sky_note_quarters(sure, SKY_FINER * (first + c), (hidden << vec4u(SKY_CUTS)) + cuts, left * SKY_HALF);
    }
    sky_end_row(row);
}

// Notes the counts of the quarters of a sample, and the numbers of surfaces at their left ends.
fn sky_note_quarters(sure: f32, first: u32, counts: vec4i, left: vec4i) {
    // No loop: some drivers count the rounds of all loops of a kernel.
    sky_note(f32(first) <= sure, first, counts.x, left.x << SKY_CUTS);
    sky_note(f32(first + 1u) <= sure, first + 1u, counts.y, left.y << SKY_CUTS);
    sky_note(f32(first + 2u) <= sure, first + 2u, counts.z, left.z << SKY_CUTS);
    sky_note(f32(first + 3u) <= sure, first + 3u, counts.w, left.w << SKY_CUTS);
}
