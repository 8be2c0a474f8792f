use crate::clip::{MOST, Polygon};
use crate::face_view::{Block, FaceView, Image, Item, NEAR, TileView, Verdict};
use crate::map::ShadowMap;
use crate::polygon_union::PolygonUnion;
use fearless_simd::{Level, dispatch};
use glam::{Vec2, Vec3};
use shading::{Coverage, LightId, Shaft, VisibilityQuery};
use visibility_mask::{Blockers, Mask, UnitSquare, facet_coverage, mask_depth};

/// The most nodes, about, that a group of receivers starts from.
const FRONTIER: usize = 48;

/// The `shadow-map` strategy: the texels of each light's [`ShadowMap`] block the points behind them. Wrap it in
/// [`MaskVisibility`](visibility_mask::MaskVisibility).
///
/// # Method (§5.3 of the paper)
/// A texel with a surface is a small quadrilateral at its depth. The depth at each corner is the mean of those neighbours that
/// belong to the same surface, so that there are no gaps and planes are exact. Projected from the receiver, the texel covers a
/// quadrilateral of the unit square; the union of all quadrilaterals blocks. A texel counts only if it is in front of the light and
/// above the receiver's tangent plane. Within sixteen texels of the plane it must be above by more than half a texel's size: there
/// is no other depth bias.
///
/// A pyramid over each layer finds the nodes that meet the cone from the receiver to the light. A node whose depths are bilinear to
/// within an eighth of a mask cell is drawn as one quadrilateral. A node smaller than 0.7 of a cell is not searched for outlines
/// and depth steps: 4 × 4 of its texels give the fraction of it that blocks, and it is drawn as a trapezoid of that area on the
/// side of these texels, at their mean depth; as two trapezoids if it shows two depths. Only if the depths of one trapezoid differ
/// by more than a quarter of a cell on the mask, as next to the light, is the node searched after all.
///
/// The map has outlines only as the light's centre sees them. If a light touches an object or overlaps it, other parts of the light
/// see around the outline, between the layers. A sphere's penumbra then errs by 0.6 %, and by up to 4 % if a sixth of it comes from
/// such an outline.
///
/// # Several lights
/// Each light has one map, which must have been built for its sphere. A light without a map is not shadowed.
///
/// # Cost
/// Once the light is some 150 texels wide, five a cell, the cost follows the mask; before that it follows the texels, and a finer
/// map has more of them. Measured under a bunny, light of 6°, masks of 32², on its floor, for maps of 512², 1024², 2048² and 4096²
/// (the light 74, 147, 294, 588 texels wide): a receiver in penumbra visits 560, 750, 880, 970 nodes and draws 190, 300, 390, 450
/// quadrilaterals in 40, 60, 77, 88 µs. On the bunny itself (27, 54, 108, 216 texels, fewer near the receiver): 21, 33, 50, 77 µs.
/// A lit receiver beside the shadow visits 2 nodes, one on the bunny 30 to 55. See `examples/measure.rs`.
#[derive(Clone, Debug, Default)]
pub struct ShadowMapBlockers {
    maps: Vec<ShadowMap>,
    /// The light of each map.
    lights: Vec<LightId>,
    casters: Vec<bool>,
    /// Objects whose receivers are left to other blockers.
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

    /// Sets the objects, by their numbers, that the maps were built from. A receiver on one of them sees no light below its own
    /// face, which a smooth shading normal would let through. None by default.
    #[must_use]
    pub fn with_casters(self, casters: Vec<bool>) -> Self {
        Self { casters, ..self }
    }

    /// Leaves the receivers on some objects, by the objects' numbers, to other blockers: for these receivers the maps block
    /// nothing. None by default.
    ///
    /// Meant for objects that the maps [draw](ShadowMap::draws). These are shadowed mostly by their own surface a few texels away,
    /// seen edge-on near terminators, and a blocker half a texel above the surface cannot be told from the surface. On a bunny 99 %
    /// of the penumbra were within 45 % of the light with its fitted map; on floors within 1.7 %.
    #[must_use]
    pub fn leaving(self, objects: Vec<bool>) -> Self {
        Self { left: objects, ..self }
    }

    fn leaves(&self, object: u32) -> bool {
        self.left.get(object as usize).is_some_and(|left| *left)
    }

    /// Coverage of the light by the receiver's own facet.
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

    /// For each object whether maps were built from it, and whether its receivers are left to other blockers.
    pub(crate) fn objects(&self) -> impl Iterator<Item = [bool; 2]> {
        let all = self.casters.len().max(self.left.len());
        let at = |objects: &[bool], k: usize| objects.get(k).is_some_and(|is| *is);
        (0..all).map(move |k| [at(&self.casters, k), at(&self.left, k)])
    }

    fn map_of(&self, light: LightId) -> Option<usize> {
        self.lights.iter().position(|of| *of == light)
    }

    /// The views of the map's faces from a receiver.
    fn look(map: &ShadowMap, query: &VisibilityQuery<'_>, square: &UnitSquare, cell: Vec2, out: &mut Vec<FaceView>) {
        out.clear();
        let view = |face| FaceView::new(face, &map.light, query.at.position, query.at.face, square, cell);
        out.extend(map.faces.iter().map(view));
    }
}

/// Working memory of [`ShadowMapBlockers`].
#[derive(Clone, Debug, Default)]
pub struct ShadowMapScratch {
    /// The light's map, if it has one. Set by `enter`.
    entered: Option<Option<usize>>,
    /// The map of the query.
    map: Option<usize>,
    /// Nodes to start from, the first layer last.
    frontier: Vec<Item>,
    /// Normal of the query's own face, if it hides a part of the light.
    own_face: Option<Vec3>,
    views: Vec<FaceView>,
    stack: Vec<Item>,
    union: PolygonUnion,
    visited: u64,
    drawn: u64,
}

impl ShadowMapScratch {
    /// Number of visited pyramid nodes and of drawn quadrilaterals since this scratch was created.
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
        // A node that some receiver draws as one must not be split: the group must not change the result.
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
        let cell = 2.0 * square.half / (1 << mask_depth(query.accuracy)) as f32;
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
            // Skips a node that is covered already: the far side of an object is mostly behind its near side.
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

/// Draws the part of the window below a plane through the receiver.
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

/// Draws a quadrilateral of the face with q at its corners; `deviations` bound how far the neighbours' q is from its edges.
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
