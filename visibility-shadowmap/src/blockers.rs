use crate::canvas::Canvas;
use crate::clip::Polygon;
use crate::map::ShadowMap;
use crate::probe::{Image, Item, Probe, TileProbe, Verdict};
use glam::{Vec2, Vec3};
use lighting::{Blockers, Mask, UnitSquare, depth_for};
use lobe_core::{Coverage, Shaft, Sphere, VisibilityQuery};

/// Nodes that a group of receivers starts from, at most about this many.
const FRONTIER: usize = 48;

/// The `shadow-map` strategy: the texels of each light's [`ShadowMap`] block what is behind them. Wrap it in
/// [`MaskVisibility`](lighting::MaskVisibility).
///
/// # Method (§5.3 of the paper)
/// A texel with a surface is a small quadrilateral at its depth. Its corners take the mean depth of those neighbours that
/// belong to the same surface, so that there are no gaps and planes are exact. Seen from the receiver it covers a
/// quadrilateral of the unit square; all of them are united. A texel counts only if it is more than one texel size above
/// the receiver's tangent plane, and in front of the light: there is no other depth bias.
///
/// A pyramid over each layer finds what can meet the cone from the receiver to the light. Where the depths of a node are
/// bilinear to within an eighth of a mask cell, the node is drawn as one quadrilateral: cost follows the mask and the
/// shape's outline, not the map.
///
/// # Several lights
/// One map for each. [`Blockers::enter`] names the light of the queries that follow: its ball must be the one that the
/// map was built for. A light without a map is not shadowed. Without `enter` the map is found by the query's cone.
///
/// # Cost
/// Measured on a bunny, 512² map, light of 6°: see the table of `examples/measure.rs`.
#[derive(Clone, Debug, Default)]
pub struct ShadowMapBlockers {
    maps: Vec<ShadowMap>,
}

impl ShadowMapBlockers {
    /// One map for each light that casts shadows, in any order.
    #[must_use]
    pub fn new(maps: Vec<ShadowMap>) -> Self {
        Self { maps }
    }

    /// The maps.
    #[must_use]
    pub fn maps(&self) -> &[ShadowMap] {
        &self.maps
    }

    fn map_of(&self, light: &Sphere) -> Option<usize> {
        self.maps.iter().position(|map| map.light == *light)
    }

    /// The map whose light is nearest to where the query sees one, within rounding.
    fn map_seen(&self, query: &VisibilityQuery<'_>) -> Option<usize> {
        let center = query.at.position + query.cone.axis * query.cone.distance;
        let off = |map: &ShadowMap| map.light.center.distance(center);
        let best = (0..self.maps.len()).min_by(|a, b| off(&self.maps[*a]).total_cmp(&off(&self.maps[*b])))?;
        let size = query.cone.distance + center.abs().max_element();
        (off(&self.maps[best]) <= 1e-5 * size).then_some(best)
    }

    /// All nodes that block, by descent from `from`; stops at the first one if `any`.
    fn descend(map: &ShadowMap, probes: &[Probe], from: &[Item], walk: &mut Walk, any: bool) {
        walk.found.clear();
        walk.stack.clear();
        walk.stack.extend_from_slice(from);
        while let Some(item) = walk.stack.pop() {
            walk.visited += 1;
            let layer = &map.faces[usize::from(item.face)].layers[usize::from(item.layer)];
            match probes[usize::from(item.face)].judge(item, layer) {
                Verdict::No => {}
                Verdict::Split => walk.stack.extend(item.children(layer)),
                Verdict::Blocks => {
                    walk.found.push(item);
                    if any {
                        return;
                    }
                }
            }
        }
    }

    fn probes(map: &ShadowMap, query: &VisibilityQuery<'_>, square: &UnitSquare, cell: f32, out: &mut Vec<Probe>) {
        out.clear();
        let probe =
            |face| Probe::new(face, &map.light, query.at.position, query.at.normal, square, cell);
        out.extend(map.faces.iter().map(probe));
    }
}

/// Working memory of [`ShadowMapBlockers`].
#[derive(Clone, Debug, Default)]
pub struct ShadowMapScratch {
    /// Set by `enter`: the light's map if it has one.
    entered: Option<Option<usize>>,
    /// The map of the query.
    map: Option<usize>,
    /// Nodes to start from.
    frontier: Vec<Item>,
    probes: Vec<Probe>,
    /// What blocks the whole light.
    whole: Walk,
    /// What blocks a part of it.
    part: Walk,
    canvas: Canvas,
}

impl ShadowMapScratch {
    /// Nodes of the pyramids looked at, and quadrilaterals drawn, since this scratch was made.
    #[must_use]
    pub fn counts(&self) -> (u64, u64) {
        (self.whole.visited + self.part.visited, self.whole.drawn + self.part.drawn)
    }
}

#[derive(Clone, Debug, Default)]
struct Walk {
    stack: Vec<Item>,
    found: Vec<Item>,
    visited: u64,
    drawn: u64,
}

fn roots(map: &ShadowMap) -> impl Iterator<Item = Item> {
    map.faces.iter().enumerate().flat_map(|(f, face)| {
        face.layers.iter().enumerate().map(move |(l, layer)| Item::root(f, l, layer.top()))
    })
}

impl Blockers for ShadowMapBlockers {
    type Scratch = ShadowMapScratch;

    fn scratch(&self) -> ShadowMapScratch {
        ShadowMapScratch::default()
    }

    fn enter(&self, shaft: &Shaft, scratch: &mut ShadowMapScratch) {
        let index = self.map_of(&shaft.light);
        scratch.entered = Some(index);
        scratch.frontier.clear();
        let Some(map) = index.map(|k| &self.maps[k]) else { return };
        let probes: Vec<TileProbe> = map.faces.iter().map(|face| TileProbe::new(face, shaft)).collect();
        let layer = |item: Item| &map.faces[usize::from(item.face)].layers[usize::from(item.layer)];
        let meets = |item: &Item| probes[usize::from(item.face)].meets(*item, layer(*item));
        let mut nodes: Vec<Item> = roots(map).filter(meets).collect();
        // A node that could be drawn as one must stay: receivers outside of a group would draw it so.
        let splits = |item: &Item| item.level > 0 && !item.node(layer(*item)).deviation.is_finite();
        while nodes.len() < FRONTIER && nodes.iter().any(splits) {
            let mut next = Vec::with_capacity(4 * nodes.len());
            for item in nodes {
                if splits(&item) { next.extend(item.children(layer(item)).filter(meets)) } else { next.push(item) }
            }
            nodes = next;
        }
        scratch.frontier.extend(nodes);
    }

    fn select(&self, query: &VisibilityQuery<'_>, scratch: &mut ShadowMapScratch) -> Coverage {
        scratch.map = match scratch.entered {
            Some(entered) => entered,
            None => {
                let found = self.map_seen(query);
                scratch.frontier.clear();
                scratch.frontier.extend(found.iter().flat_map(|k| roots(&self.maps[*k])));
                found
            }
        };
        let Some(map) = scratch.map.map(|k| &self.maps[k]) else { return Coverage::Lit };
        if scratch.frontier.is_empty() {
            return Coverage::Lit;
        }
        let square = UnitSquare::facing(query.cone, Vec3::ZERO);
        let cell = 2.0 * square.half / (1 << depth_for(query.tolerance)) as f32;
        Self::probes(map, query, &square, cell, &mut scratch.probes);
        Self::descend(map, &scratch.probes, &scratch.frontier, &mut scratch.whole, square.half <= 0.0);
        if scratch.whole.found.is_empty() { Coverage::Lit } else { Coverage::Partial }
    }

    fn splat(&self, query: &VisibilityQuery<'_>, scratch: &mut ShadowMapScratch, mask: &mut Mask) {
        let Some(map) = scratch.map.map(|k| &self.maps[k]) else { return };
        let square = *mask.square();
        let ShadowMapScratch { frontier, probes, whole, part, canvas, .. } = scratch;
        let walk = if square.half >= square.disc {
            whole
        } else {
            Self::probes(map, query, &square, mask.cell(), probes);
            Self::descend(map, probes, frontier, part, false);
            part
        };
        canvas.begin(mask);
        let mut face = usize::MAX;
        let mut image = None;
        for item in &walk.found {
            if usize::from(item.face) != face || image.is_none() {
                face = item.face.into();
                image = Some(Image::new(&map.faces[face], &map.light, query.at.position, &square));
            }
            let Some(image) = &image else { continue };
            let layer = &map.faces[face].layers[usize::from(item.layer)];
            draw(image, image.corners(*item, layer), item.node(layer).deviation, canvas);
        }
        walk.drawn += walk.found.len() as u64;
        canvas.write(mask);
    }
}

fn draw(image: &Image, corners: [Vec3; 4], deviation: f32, canvas: &mut Canvas) {
    let near = image.near();
    let nearest = corners.iter().map(|p| p.z).fold(f32::INFINITY, f32::min);
    if nearest >= near {
        let mut points = corners.map(|p| p.truncate() / p.z);
        let grow = if deviation > 0.0 { image.shift(&points, nearest, deviation) } else { 0.0 };
        canvas.polygon(&mut points, grow);
    } else {
        let clipped = Polygon::new(&corners).clip(|p: Vec3| p.z - near);
        let mut points = [Vec2::ZERO; 5];
        let count = clipped.corners().len();
        if count >= 3 {
            points.iter_mut().zip(clipped.corners()).for_each(|(to, p)| *to = p.truncate() / p.z);
            canvas.polygon(&mut points[..count], 0.0);
        }
    }
}
