// The hierarchy of bvh.rs and the primitives in it, both in its units.

// 32 bytes. The first one is no node: `low` has the units of the hierarchy a world unit, and the size of the scene in world
// units; where its count is 0 there is one from `first` on for each object, whose count is 1 if it blocks. A leaf has `count`
// primitives from `first` on; an inner node has count 0 and its children at `first` and `first + 1`.
struct BvhNode {
    low: vec3f,
    count: u32,
    high: vec3f,
    first: u32,
}

// 48 bytes. A triangle: a corner and the edges from it; `corners` is where its normals begin, or NO_CORNERS. A ball: centre and
// radius (`b.x`). `object` is its number and the flags below.
struct Primitive {
    a: vec3f,
    object: u32,
    b: vec3f,
    material: u32,
    c: vec3f,
    corners: u32,
}

@group(0) @binding(10) var<storage, read> nodes: array<BvhNode>;
@group(0) @binding(14) var<storage, read> primitives: array<Primitive>;

const ROOT = 1u;

const BALL = 0x80000000u;
const VISIBLE = 0x40000000u;
const BLOCKS = 0x20000000u;
const OBJECT = 0x1fffffffu;
const NO_CORNERS = 0xffffffffu;

// Farther than everything.
const NEVER = 3e38;

// How far outside a triangle, in barycentric units, a ray still hits.
const BVH_EDGE = 1e-6;
// The most by which rounding makes a triangle larger, in barycentric units.
const WIDEST = 0.05;

// A ray as boxes see it.
struct Slabs {
    low: vec3f,
    high: vec3f,
    inverse: vec3f,
}

fn slabs(origin: vec3f, direction: vec3f) -> Slabs {
    let size = abs(direction);
    let least = select(vec3f(1e-15), -vec3f(1e-15), direction < vec3f(0.0));
    let size_of = abs(origin);
    // What rounding may move a ray by at the far end of the scene, which is below 2²¹.
    let pad = 3e-7 * max(max(size_of.x, size_of.y), max(size_of.z, 2097152.0));
    return Slabs(origin + pad, origin - pad, 1.0 / select(direction, least, size < vec3f(1e-15)));
}

// Where a ray enters a box, or NEVER; not beyond `limit`.
fn enter(ray: Slabs, low: vec3f, high: vec3f, limit: f32) -> f32 {
    let one = (low - ray.low) * ray.inverse;
    let other = (high - ray.high) * ray.inverse;
    let first = min(one, other);
    let last = max(one, other);
    let near = max(max(first.x, first.y), max(first.z, 0.0));
    let far = min(min(last.x, last.y), min(last.z, limit));
    return select(NEVER, near, near <= far * 1.000001);
}

// Distance to a triangle, both sides, or NEVER; a ray that starts on it does not meet it (T. Möller, B. Trumbore, 1997);
// `blur` is what rounding may change of the barycentric coordinates times the determinant, over the lengths of the edges.
fn meet_triangle(t: Primitive, origin: vec3f, direction: vec3f, blur: f32) -> f32 {
    let p = cross(direction, t.c);
    let det = dot(t.b, p);
    if abs(det) < 1e-30 {
        return NEVER;
    }
    let inverse = 1.0 / det;
    let s = origin - t.a;
    let q = cross(s, t.b);
    let u = dot(s, p) * inverse;
    let v = dot(direction, q) * inverse;
    let size = blur * sqrt(dot(s, s) * max(dot(t.b, t.b), dot(t.c, t.c)));
    let edge = min(BVH_EDGE + size * abs(inverse), WIDEST);
    let along = dot(t.c, q) * inverse;
    return select(NEVER, along, u >= -edge && v >= -edge && u + v <= 1.0 + edge && along > 0.0);
}

// Distance to a ball, from inside or its surface to the far side, or NEVER.
fn meet_ball(ball: Primitive, origin: vec3f, direction: vec3f) -> f32 {
    let to = ball.a - origin;
    let along = dot(to, direction);
    // The distance of the centre from the ray first: |to|² − along² would cancel.
    let aside = to - direction * along;
    let half_sq = ball.b.x * ball.b.x - dot(aside, aside);
    let half = sqrt(max(half_sq, 0.0));
    let t = select(along + half, along - half, along > half);
    return select(NEVER, t, half_sq >= 0.0 && t > 0.0);
}
