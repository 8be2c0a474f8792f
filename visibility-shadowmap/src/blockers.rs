use crate::clip::{MOST, Polygon};
use crate::face_view::{Block, FaceView, Image, Item, NEAR, TileView, Verdict};
use crate::map::ShadowMap;
use crate::polygon_union::PolygonUnion;
use fearless_simd::{Level, dispatch};
use glam::{Vec2, Vec3};
use lobe_core::{Accuracy, Coverage, LightId, Shaft, VisibilityQuery};
use visibility_mask::{Blockers, Mask, UnitSquare, facet_coverage};

/// Nodes that a group of receivers starts from, at most about this many.
const FRONTIER: usize = 48;

/// The `shadow-map` strategy: the texels of each light's [`ShadowMap`] block what is behind them. Wrap it in
/// [`MaskVisibility`](visibility_mask::MaskVisibility).
///
/// # Method (§5.3 of the paper)
/// A texel with a surface is a small quadrilateral at its depth. Its corners take the mean depth of those neighbours that
/// belong to the same surface, so that there are no gaps and planes are exact. Seen from the receiver it covers a
/// quadrilateral of the unit square; all of them are united. A texel counts only if it is in front of the light and above
/// the receiver's tangent plane, within sixteen texels of it by more than half a texel's size: there is no other depth bias.
///
/// A pyramid over each layer finds what can meet the cone from the receiver to the light. Where the depths of a node are
/// bilinear to within an eighth of a mask cell, the node is drawn as one quadrilateral. What is smaller than 0.7 of a cell is
/// not looked into for its outlines and depth steps: 4 × 4 of its texels say how much of it blocks, and it is drawn as a
/// trapezoid of that area on the side where they are, at their mean depth; as two where it shows two depths. Only where
/// the depths of one differ by what would move it by more than a quarter of a cell is it looked into, as next to the light.
///
/// An outline is where the light's centre sees it. Next to a light that touches an object, or overlaps it, other parts of
/// the light see round it, between the layers: there a sphere's penumbra errs by 0.6 %, up to 4 % where a sixth of it is
/// such an outline.
///
/// # Several lights
/// One map for each, which must have been built for its sphere. A light without a map is not shadowed.
///
/// # Cost
/// It follows the mask once the light is some 150 texels wide, five a cell; before that the texels, of which there are more
/// in a finer map. Measured under a bunny, light of 6°, masks of 32², on its floor, for maps of 512², 1024², 2048² and
/// 4096² (the light 74, 147, 294, 588 texels wide): 560, 750, 880, 970 nodes visited by a receiver in the penumbra, 190, 300,
/// 390, 450 quadrilaterals drawn, in 40, 60, 77, 88 µs. On the bunny itself (27, 54, 108, 216 texels, fewer at what is
/// near the receiver) in 21, 33, 50, 77 µs. A lit receiver beside the shadow visits 2 nodes, one on the bunny 30 to 55. See
/// `examples/measure.rs`.
#[derive(Clone, Debug, Default)]
pub struct ShadowMapBlockers {
    maps: Vec<ShadowMap>,
    /// The light of each map.
    lights: Vec<LightId>,
    casters: Vec<bool>,
    /// Objects whose receivers are left to others.
    left: Vec<bool>,
}

impl ShadowMapBlockers {
    /// The maps of a frame's first lights, in their order.
    #[must_use]
    pub fn new(maps: Vec<ShadowMap>) -> Self {
        Self::of_lights((0..).map(LightId).zip(maps))
    }

    /// The maps of some of a frame's lights.
    #[must_use]
    pub fn of_lights(maps: impl IntoIterator<Item = (LightId, ShadowMap)>) -> Self {
        let (lights, maps) = maps.into_iter().unzip();
        Self { maps, lights, casters: Vec::new(), left: Vec::new() }
    }

    /// States which objects, by their number, the maps were made of: a receiver on one of them sees no light below its
    /// own face, which a smooth shading normal would let through. No object unless stated.
    #[must_use]
    pub fn with_casters(self, casters: Vec<bool>) -> Self {
        Self { casters, ..self }
    }

    /// Leaves receivers on some objects to other blockers, by the objects' numbers: for these the maps hide nothing. No object unless
    /// stated.
    ///
    /// It is for objects that the maps [draw](ShadowMap::draws). What shadows them is mostly their own surface a few texels away,
    /// seen from the side near terminators, and half a texel above a surface is not told from the surface: on a bunny 99 % of the
    /// penumbra were within 45 % of the light by its fitted map, where floors were within 1.7 %.
    #[must_use]
    pub fn leaving(self, objects: Vec<bool>) -> Self {
        Self { left: objects, ..self }
    }

    fn leaves(&self, object: u32) -> bool {
        self.left.get(object as usize).is_some_and(|left| *left)
    }

    /// How much of the light the receiver's own facet hides.
    fn own_face(&self, query: &VisibilityQuery<'_>) -> Coverage {
        let casts = self.casters.get(query.at.object as usize).is_some_and(|casts| *casts);
        if casts { facet_coverage(query.at, query.cone) } else { Coverage::Lit }
    }

    /// The maps.
    #[must_use]
    pub fn maps(&self) -> &[ShadowMap] {
        &self.maps
    }

    /// The light of each map.
    #[must_use]
    pub fn lights(&self) -> &[LightId] {
        &self.lights
    }

    /// For each object whether maps were made of it, and whether its receivers are left to others.
    pub(crate) fn objects(&self) -> impl Iterator<Item = [bool; 2]> {
        let all = self.casters.len().max(self.left.len());
        let at = |objects: &[bool], k: usize| objects.get(k).is_some_and(|is| *is);
        (0..all).map(move |k| [at(&self.casters, k), at(&self.left, k)])
    }

    fn map_of(&self, light: LightId) -> Option<usize> {
        self.lights.iter().position(|of| *of == light)
    }

    /// The map's faces as a receiver sees them.
    fn look(map: &ShadowMap, query: &VisibilityQuery<'_>, square: &UnitSquare, cell: Vec2, out: &mut Vec<FaceView>) {
        out.clear();
        let view = |face| FaceView::new(face, &map.light, query.at.position, query.at.face, square, cell);
        out.extend(map.faces.iter().map(view));
    }
}

/// Working memory of [`ShadowMapBlockers`].
#[derive(Clone, Debug, Default)]
pub struct ShadowMapScratch {
    /// Set by `enter`: the light's map if it has one.
    entered: Option<Option<usize>>,
    /// The map of the query.
    map: Option<usize>,
    /// Nodes to start from, the first layer last.
    frontier: Vec<Item>,
    /// Of the query's own face.
    own_face: Option<Vec3>,
    views: Vec<FaceView>,
    stack: Vec<Item>,
    union: PolygonUnion,
    visited: u64,
    drawn: u64,
}

impl ShadowMapScratch {
    /// Nodes of the pyramids looked at, and quadrilaterals drawn, since this scratch was made.
    #[must_use]
    pub fn counts(&self) -> (u64, u64) {
        (self.visited, self.drawn)
    }
}

fn roots(map: &ShadowMap) -> impl Iterator<Item = Item> {
    map.faces
        .iter()
        .enumerate()
        .flat_map(|(f, face)| face.layers.iter().enumerate().map(move |(l, layer)| Item::root(f, l, layer.top())))
}

impl Blockers for ShadowMapBlockers {
    type Scratch = ShadowMapScratch;

    fn scratch(&self) -> ShadowMapScratch {
        ShadowMapScratch::default()
    }

    fn enter(&self, shaft: &Shaft, scratch: &mut ShadowMapScratch) -> Coverage {
        let index = self.map_of(shaft.id);
        scratch.entered = Some(index);
        scratch.frontier.clear();
        let Some(map) = index.map(|k| &self.maps[k]) else { return Coverage::Partial };
        let views: Vec<TileView> = map.faces.iter().map(|face| TileView::new(face, shaft)).collect();
        let layer = |item: Item| map.layer(item);
        let meets = |item: &Item| views[usize::from(item.face)].meets(*item, layer(*item));
        let mut nodes: Vec<Item> = roots(map).filter(meets).collect();
        // A node that some receiver draws as one must stay: the group must change nothing.
        let splits = |item: &Item| views[usize::from(item.face)].splits(*item, layer(*item));
        while nodes.len() < FRONTIER && nodes.iter().any(splits) {
            let mut next = Vec::with_capacity(4 * nodes.len());
            for item in nodes {
                if splits(&item) {
                    item.split(layer(item), &mut next);
                } else {
                    next.push(item);
                }
            }
            next.retain(meets);
            nodes = next;
        }
        scratch.frontier.extend(nodes);
        first_layer_last(&mut scratch.frontier);
        // A receiver's own face may still be between it and the light.
        Coverage::Partial
    }

    fn select(&self, query: &VisibilityQuery<'_>, scratch: &mut ShadowMapScratch) -> Coverage {
        scratch.map = match scratch.entered {
            Some(entered) => entered,
            None => {
                let found = self.map_of(query.light);
                scratch.frontier.clear();
                scratch.frontier.extend(found.iter().flat_map(|k| roots(&self.maps[*k])));
                first_layer_last(&mut scratch.frontier);
                found
            }
        };
        let Some(map) = scratch.map.map(|k| &self.maps[k]) else { return Coverage::Lit };
        if self.leaves(query.at.object) {
            return Coverage::Lit;
        }
        let own = self.own_face(query);
        scratch.own_face = (own == Coverage::Partial).then_some(query.at.face);
        if own != Coverage::Lit {
            return own;
        }
        if scratch.frontier.is_empty() {
            return Coverage::Lit;
        }
        let square = UnitSquare::facing(query.cone, Vec3::ZERO);
        let cell = 2.0 * square.half / (1 << Accuracy::new(query.accuracy.tolerance).depth) as f32;
        let ShadowMapScratch { frontier, views, stack, visited, .. } = scratch;
        Self::look(map, query, &square, cell, views);
        stack.clear();
        stack.extend_from_slice(frontier);
        while let Some(item) = stack.pop() {
            *visited += 1;
            let layer = map.layer(item);
            let view = &views[usize::from(item.face)];
            let Some((node, block)) = Block::around(item, layer) else { continue };
            match view.judge(item, &node, &block) {
                Verdict::No => {}
                Verdict::Split => item.split(layer, stack),
                Verdict::Blocks => return Coverage::Partial,
                Verdict::Partly(small) => match view.parts(item, layer, small) {
                    None => item.split(layer, stack),
                    Some([None, None]) => {}
                    Some(_) => return Coverage::Partial,
                },
            }
        }
        Coverage::Lit
    }

    fn splat(&self, query: &VisibilityQuery<'_>, scratch: &mut ShadowMapScratch, mask: &mut Mask) {
        dispatch!(Level::new(), _simd => self.splat_all(query, scratch, mask));
    }
}

impl ShadowMapBlockers {
    #[inline(always)]
    fn splat_all(&self, query: &VisibilityQuery<'_>, scratch: &mut ShadowMapScratch, mask: &mut Mask) {
        let Some(map) = scratch.map.map(|k| &self.maps[k]) else { return };
        let ShadowMapScratch { frontier, own_face, views, stack, union, visited, drawn, .. } = scratch;
        Self::look(map, query, mask.square(), mask.cell(), views);
        union.begin(mask);
        if let Some(face) = own_face {
            draw_below(*face, mask.square(), union);
        }
        stack.clear();
        stack.extend_from_slice(frontier);
        while let Some(item) = stack.pop() {
            *visited += 1;
            let layer = map.layer(item);
            let view = &views[usize::from(item.face)];
            let Some((node, block)) = Block::around(item, layer) else { continue };
            // The far side of an object is mostly behind its near side: what can add nothing is not looked into.
            let is_covered = || view.image.bounds(&block).is_some_and(|[low, high]| union.is_covered(low, high));
            match view.judge(item, &node, &block) {
                Verdict::No => {}
                _ if is_covered() => {}
                Verdict::Split => item.split(layer, stack),
                Verdict::Partly(small) => match view.parts(item, layer, small) {
                    None => item.split(layer, stack),
                    Some(parts) => {
                        for part in parts.into_iter().flatten() {
                            *drawn += 1;
                            draw(&view.image, part.corners, [part.q; 4], [0.0; 4], union);
                        }
                    }
                },
                Verdict::Blocks => {
                    *drawn += 1;
                    let q = layer.corners(item.level.into(), item.i.into(), item.j.into());
                    let texels = item.texels(layer);
                    let deviations = layer.edge_deviations(texels, node.deviation);
                    let [x0, x1, y0, y1] = texels.map(|x| x as f32);
                    draw(&view.image, [[x0, y0], [x1, y0], [x1, y1], [x0, y1]], q, deviations, union);
                }
            }
        }
        union.write(mask);
    }
}

fn first_layer_last(items: &mut [Item]) {
    items.sort_by_key(|item| core::cmp::Reverse(item.layer));
}

/// The part of the window below a plane through the receiver.
fn draw_below(normal: Vec3, square: &UnitSquare, union: &mut PolygonUnion) {
    let n = square.local(normal);
    let ([x0, y0], [x1, y1]) = ((square.center - square.half).to_array(), (square.center + square.half).to_array());
    let corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(|(x, y)| Vec3::new(x, y, 1.0));
    let below = Polygon::new(&corners).clip(|p: Vec3| -n.dot(p));
    let mut points = [Vec2::ZERO; MOST];
    let count = below.corners().len();
    if count >= 3 {
        points.iter_mut().zip(below.corners()).for_each(|(to, p)| *to = p.truncate());
        union.polygon(&mut points[..count], [0.0; 4]);
    }
}

/// A quadrilateral in the picture with q at its corners, and how far its neighbours' q may be from the edges.
#[inline(always)]
fn draw(image: &Image, at: [[f32; 2]; 4], q: [f32; 4], deviations: [f32; 4], union: &mut PolygonUnion) {
    let corners = image.corners(at, q);
    let near = NEAR * corners.iter().map(|p| p.abs().max_element()).fold(0.0, f32::max);
    let nearest = corners.iter().map(|p| p.z).fold(f32::INFINITY, f32::min);
    if nearest >= near {
        let mut points = corners.map(|p| p.truncate() / p.z);
        let grow = if deviations == [0.0; 4] { deviations } else { image.shifts(&points, nearest, deviations) };
        union.polygon(&mut points, grow);
    } else {
        let clipped = Polygon::new(&corners).clip(|p: Vec3| p.z - near);
        let mut points = [Vec2::ZERO; MOST];
        let count = clipped.corners().len();
        if count >= 3 {
            points.iter_mut().zip(clipped.corners()).for_each(|(to, p)| *to = p.truncate() / p.z);
            union.polygon(&mut points[..count], [0.0; 4]);
        }
    }
}
