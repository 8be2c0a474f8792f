// A sphere wholly in front of the plane through the receiver, on the mask: an ellipse, in its centre form, in rows and samples of
// the mask.
struct Ellipse {
    x: f32,
    y: f32,
    shear: f32,
    k0: f32,
    k2: f32,
    half_height: f32,
    // A row's mean span is shorter than that at its centre by the second derivative.
    bend: f32,
    // Samples that an edge runs along within one row before it is taken by area.
    flat: f32,
}

// `c` is the centre in the frame of the mask's square, `c.z > r`.
fn ellipse(c: vec3f, r: f32, mask: Mask) -> Ellipse {
    let raster = mask_raster(mask);
    let g = (c.z - r) * (c.z + r);
    let u = c.y * c.y + g;
    let w = c.x * c.x + u;
    let of_g = 1.0 / g;
    let of_u = 1.0 / u;
    let aspect = raster.samples / raster.rows;
    let k0 = r * r * w * of_g * of_u * (raster.samples * raster.samples);
    let k2 = w * g * of_u * of_u * (aspect * aspect);
    return Ellipse(
        (c.x * c.z * of_g - raster.left) * raster.samples,
        (c.y * c.z * of_g - raster.bottom) * raster.rows,
        c.x * c.y * of_u * aspect,
        k0,
        k2,
        r * sqrt(u) * of_g * raster.rows,
        k0 * k2 * (1.0 / 24.0),
        FLAT * f32(row_width / (SIDE * row_bands)),
    );
}

// Blocks what of the own row `j` is in it.
fn ellipse_splat(e: Ellipse, j: u32) {
    let first = floor(clamp(e.y - e.half_height, 0.0, f32(SIDE)));
    let end = floor(clamp(e.y + e.half_height + 1.0, 0.0, f32(SIDE)));
    if (f32(j) < first || f32(j) >= end) {
        return;
    }
    let t = f32(j) + (0.5 - e.y);
    let square = max(e.k0 - e.k2 * t * t, 0.0);
    let half = sqrt(square);
    let away = abs(t);
    // An end of the ellipse is in this row, or its edge runs along it.
    if (e.half_height - away < 0.5 || abs(e.shear) * half + e.k2 * away > e.flat * half) {
        ellipse_lines(e, j, 0u);
        ellipse_lines(e, j, 4u);
        return;
    }
    let mean = half - half * e.bend / (square * square);
    let middle = e.x + e.shear * t - row_phase(j);
    mask_block_samples(row_index(middle - mean), row_index(middle + mean));
}

// Four of the eight lines of the own row `j`, by the planes of their samples: from plane `first` on.
fn ellipse_lines(e: Ellipse, j: u32, first: u32) {
    let t = f32(j) + (0.5 - e.y) + mask_heights(j, first);
    let half = sqrt(max(e.k0 - e.k2 * t * t, vec4f(0.0)));
    let middle = e.x + e.shear * t;
    mask_block_lines(first, row_indices(middle - half), row_indices(middle + half));
}
