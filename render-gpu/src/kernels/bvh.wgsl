// The hierarchy of bvh.rs (`nodes`) and its `primitives`, in the hierarchy's units.

// 32 bytes. A leaf has `count` primitives from `first` on; an inner node has count 0 and its children at `first` and `first + 1`.
// The first node is a header: `low.x` has the hierarchy's units per world unit, and `high` is zero. If its count is 0, one node for
// each object follows from `first` on, whose count is 0 if the object does not block, 1 if it blocks, 2 if it blocks for receivers
// whose object also has a 2.
struct BvhNode {
    low: vec3f,
    count: u32,
    high: vec3f,
    first: u32,
}

// 48 bytes. A triangle has its exact corners in `a`, `b`, `c`; `corners` is where its normals begin, or NO_CORNERS. A sphere has
// its centre in `a` and its radius in `b.x`. `object` is the object's number and the flags below.
struct Primitive {
    a: vec3f,
    object: u32,
    b: vec3f,
    material: u32,
    c: vec3f,
    corners: u32,
}

const ROOT = 1u;

// Larger than every distance.
const NEVER = 3e38;

// A ray prepared for tests against boxes.
struct Slabs {
    low: vec3f,
    high: vec3f,
    inverse: vec3f,
}

fn slabs(origin: vec3f, direction: vec3f) -> Slabs {
    let size = abs(direction);
    let least = select(vec3f(1e-15), -vec3f(1e-15), direction < vec3f(0.0));
    let size_of = abs(origin);
    // The most that rounding moves a ray at the far end of the scene, which is below 2²¹.
    let pad = 3e-7 * max(max(size_of.x, size_of.y), max(size_of.z, 2097152.0));
    return Slabs(origin + pad, origin - pad, 1.0 / select(direction, least, size < vec3f(1e-15)));
}

// The distance at which a ray enters a box, or NEVER if it misses the box or enters it beyond `limit`.
fn enter(ray: Slabs, low: vec3f, high: vec3f, limit: f32) -> f32 {
    let one = (low - ray.low) * ray.inverse;
    let other = (high - ray.high) * ray.inverse;
    let first = min(one, other);
    let last = max(one, other);
    let near = max(max(first.x, first.y), max(first.z, 0.0));
    let far = min(min(last.x, last.y), min(last.z, limit));
    return select(NEVER, near, near <= far * 1.000001);
}

// Distance to a triangle from either side, or NEVER. A ray that starts on the triangle does not meet it (T. Möller, B. Trumbore,
// 1997). `blur` bounds the rounding of the barycentric coordinates times the determinant, over the lengths of the edges.
fn meet_triangle(t: Primitive, origin: vec3f, direction: vec3f, blur: f32) -> f32 {
    let e1 = t.b - t.a;
    let e2 = t.c - t.a;
    let p = cross(direction, e2);
    let det = dot(e1, p);
    if abs(det) < 1e-30 {
        return NEVER;
    }
    let inverse = 1.0 / det;
    let s = origin - t.a;
    let q = cross(s, e1);
    let u = dot(s, p) * inverse;
    let v = dot(direction, q) * inverse;
    let lengths = vec3f(dot(s, s), dot(e1, e1), dot(e2, e2));
    let size = blur * sqrt(lengths.x * max(lengths.y, lengths.z));
    let edge = min(BVH_EDGE + size * abs(inverse), WIDEST);
    if !(u >= -edge && v >= -edge && u + v <= 1.0 + edge) {
        return NEVER;
    }
    var along = dot(e2, q) * inverse;
    let slant_sq = (lengths.y * inverse) * (lengths.z * inverse);
    if abs(along) <= CLOSE * sqrt(lengths.x * slant_sq) {
        let plane = plane_of(t, origin);
        along = -plane.w / dot(plane.xyz, direction);
    }
    return select(NEVER, along, along > 0.0);
}

// Distance to a sphere, or NEVER. From inside the sphere or its surface: the distance to the far side.
fn meet_sphere(center: vec3f, radius: f32, origin: vec3f, direction: vec3f) -> f32 {
    let to = center - origin;
    let along = dot(to, direction);
    let radius_sq = radius * radius;
    if abs(dot(to, to) - radius_sq) <= CLOSE_TO_SPHERE * radius_sq {
        // If the sphere is ahead, `off` has the sign of the nearer distance.
        let off = off_sphere(center, radius, origin);
        let half_sq = along * along - off;
        let far = along + select(sqrt(max(half_sq, 0.0)), -sqrt(max(half_sq, 0.0)), along < 0.0);
        let near = off / far;
        let first = select(max(near, far), min(near, far), min(near, far) > 0.0);
        return select(NEVER, first, half_sq >= 0.0 && first > 0.0);
    }
    // Computes the centre's distance from the ray first, since |to|² − along² would cancel.
    let aside = to - direction * along;
    let half_sq = radius_sq - dot(aside, aside);
    let half = sqrt(max(half_sq, 0.0));
    let t = select(along + half, along - half, along > half);
    return select(NEVER, t, half_sq >= 0.0 && t > 0.0);
}

// Numbers with twice the digits, three at a time: each is a sum of two floats, of which the second is at most half a last digit of
// the first (T. J. Dekker, *A Floating-Point Technique for Extending the Available Precision*, 1971).
struct Fine {
    high: vec3f,
    low: vec3f,
}

// Hides numbers from the compiler, which could otherwise replace a + b − a by b and lose the rounding that is computed here.
fn opaque(v: vec3f) -> vec3f { return bitcast<vec3f>(bitcast<vec3u>(v) ^ bitcast<vec3u>(nodes[0].high)); }

fn fine_sum(a: vec3f, b: vec3f) -> Fine {
    let sum = opaque(a + b);
    let added = opaque(sum - a);
    return Fine(sum, (a - (sum - added)) + (b - added));
}

// The sum of two fine numbers with first parts `a` and `b`; `low` is the sum of their second parts.
fn fine_add(a: vec3f, b: vec3f, low: vec3f) -> Fine {
    let sum = fine_sum(a, b);
    return fine_sum(sum.high, sum.low + low);
}

fn fine_product(a: Fine, b: Fine) -> Fine {
    // Products of halves of the digits are exact, whether or not a compiler fuses them with sums.
    let a_high = bitcast<vec3f>(bitcast<vec3u>(a.high) & vec3u(0xfffff000u));
    let b_high = bitcast<vec3f>(bitcast<vec3u>(b.high) & vec3u(0xfffff000u));
    let a_low = a.high - a_high;
    let b_low = b.high - b_high;
    let one = fine_sum(a_high * b_high, a_high * b_low);
    let both = fine_sum(one.high, a_low * b_high);
    return fine_sum(both.high, one.low + both.low + a_low * b_low + (a.high * b.low + a.low * b.high));
}

fn fine_cross(a: Fine, b: Fine) -> Fine {
    let one = fine_product(Fine(a.high.yzx, a.low.yzx), Fine(b.high.zxy, b.low.zxy));
    let other = fine_product(Fine(a.high.zxy, a.low.zxy), Fine(b.high.yzx, b.low.yzx));
    return fine_add(one.high, -other.high, one.low - other.low);
}

fn fine_dot(a: Fine, b: Fine) -> Fine {
    let product = fine_product(a, b);
    let one = fine_add(product.high.xxx, product.high.yyy, product.low.xxx + product.low.yyy);
    return fine_add(one.high, product.high.zzz, one.low + product.low.zzz);
}

// Normal of a triangle's plane, not normalised, and its dot product with the vector from the plane to a point. Computed from the
// exact corners, with an error of some 2⁻⁴⁰ of the triangle's size.
fn plane_of(t: Primitive, point: vec3f) -> vec4f {
    let normal = fine_cross(fine_sum(t.b, -t.a), fine_sum(t.c, -t.a));
    return vec4f(normal.high, fine_dot(normal, fine_sum(point, -t.a)).high.x);
}

// The squared distance of a point from a sphere's centre, minus the squared radius.
fn off_sphere(center: vec3f, radius: f32, point: vec3f) -> f32 {
    let to = fine_sum(center, -point);
    let square = fine_dot(to, to);
    let size = Fine(vec3f(radius), vec3f(0.0));
    let radius_sq = fine_product(size, size);
    return fine_add(square.high, -radius_sq.high, square.low - radius_sq.low).high.x;
}
