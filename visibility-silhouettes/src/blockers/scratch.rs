use super::openings::Openings;
use super::trapezoids::Trapezoids;
use crate::clip::{Chord, Front, LightSphere};
use crate::count::{Counter, Fewest};
use crate::fit::side;
use crate::lists::Lists;
use crate::near_light::NearLights;
use crate::project::{Crossing, View, project};
use crate::select::Silhouettes;
use fearless_simd::{Level, dispatch};
use glam::{Vec2, Vec3};
use lobe_core::{Capsule, Cone, Outline, Receiver, Sphere};
use shading::{Coverage, DynScratch, VisibilityQuery};
use visibility_mask::{Contour, Mask};

/// Working memory of [`SilhouetteBlockers`](crate::SilhouetteBlockers).
#[derive(Debug)]
pub struct SilhouetteScratch {
    /// Whether the current shaft comes from the caller; otherwise each receiver has its own.
    pub(super) entered: bool,
    pub(super) lists: Lists,
    /// Whether rays in the shaft may meet anything.
    pub(super) is_met: bool,
    /// One result for all receivers of the shaft on one face; searched after the first of them.
    pub(super) alike: Option<Alike>,
    /// Whether the receivers of a group are on one side of all triangles near them.
    pub(super) plane: Option<Plane>,
    /// The triangles near the lights; whether some reach into the light of the shaft, and whether its outlines are exact because of these.
    pub(super) near: NearLights,
    pub(super) is_clipped: bool,
    pub(super) is_exact: bool,
    pub(super) light: Sphere,
    /// Start of the current receiver's rays, and its cone to the light.
    pub(super) origin: Vec3,
    pub(super) cone: Cone,
    /// The normal of the receiver's facet, if it hides a part of the light.
    pub(super) facet: Option<Vec3>,
    pub(super) silhouettes: Silhouettes,
    /// Whether any of them may belong to a simplified form.
    pub(super) is_coarse: bool,
    /// Their parts outside the light, then the outlines in which a flat light or a tube cuts triangles, and where these begin.
    pub(super) outside: Silhouettes,
    pub(super) first_arc: usize,
    /// Before a tube's plane, whatever it hides.
    pub(super) before: Silhouettes,
    /// The tube that is the light, if triangles touch it.
    pub(super) body: Option<Capsule>,
    /// The arcs in which a round light cuts triangles, and whether they and `outside` are those of the current receiver.
    pub(super) arcs: Vec<Chord>,
    pub(super) is_outside_known: bool,
    /// Whether a flat light or a tube has cut them.
    pub(super) is_flat_cut: bool,
    pub(super) crossings: Vec<Crossing>,
    pub(super) counter: Counter,
    pub(super) fewest: Fewest,
    pub(super) next: Fewest,
    /// Whether a mask of the current receiver that is dark may hide an opening between its samples.
    pub(super) may_hide: bool,
    pub(super) openings: Openings,
    pub(super) trapezoids: Trapezoids,
    /// Ends of openings, and a mask for those between rows.
    pub(super) marks: Vec<[Vec2; 2]>,
    pub(super) turned: Mask,
    /// Where rays tell what is lit.
    pub(super) contour: Contour,
    pub(super) hits: DynScratch,
}

impl SilhouetteScratch {
    /// Of a strategy whose rays have this memory.
    pub(super) fn new(hits: DynScratch) -> Self {
        Self {
            entered: false,
            lists: Lists::default(),
            is_met: true,
            alike: None,
            plane: None,
            is_clipped: false,
            is_exact: false,
            // A light that no caller can mean.
            light: Sphere { center: Vec3::NAN, radius: 0.0 },
            near: NearLights::default(),
            origin: Vec3::ZERO,
            cone: Cone { axis: Vec3::Z, one_minus_cos: 0.0, distance: 0.0 },
            facet: None,
            silhouettes: Silhouettes::default(),
            is_coarse: false,
            outside: Silhouettes::default(),
            first_arc: 0,
            before: Silhouettes::default(),
            body: None,
            is_flat_cut: false,
            arcs: Vec::new(),
            is_outside_known: false,
            crossings: Vec::new(),
            counter: Counter::default(),
            fewest: Fewest::default(),
            next: Fewest::default(),
            may_hide: false,
            openings: Openings::default(),
            trapezoids: Trapezoids::default(),
            marks: Vec::new(),
            turned: Mask::default(),
            contour: Contour::default(),
            hits,
        }
    }

    /// Begins a receiver without silhouettes.
    pub(super) fn begin(&mut self, origin: Vec3, query: &VisibilityQuery<'_>) {
        self.origin = origin;
        self.cone = *query.cone;
        let near = &mut self.near;
        let touches = |body: &Capsule| near.current().is_some_and(|near| near.is_touched(body, origin));
        self.body = query.outline.and_then(Outline::body).copied().filter(touches);
        self.silhouettes.clear();
        self.is_coarse = false;
        self.is_outside_known = false;
        self.may_hide = false;
        self.is_flat_cut = false;
        self.arcs.clear();
    }

    /// The view of a mask's window.
    pub(super) fn view(&self, query: &VisibilityQuery<'_>, mask: &Mask) -> View {
        View::new(*mask.square(), mask.raster(), mask.side(), query, self.body.is_some())
    }

    /// Counts the surfaces before the samples of a mask, but for a number that all of them have. Returns the light if triangles reach into it.
    pub(super) fn cross(&mut self, query: &VisibilityQuery<'_>, view: &mut View, mask: &Mask) -> Option<LightSphere> {
        let sphere = self.project_outlines(query, view);
        let Self { crossings, counter, fewest, .. } = self;
        dispatch!(Level::new(), simd => {
            counter.count(simd, view, crossings, mask);
            counter.fewest(fewest);
        });
        sphere
    }

    /// Whether fewer surfaces may be between two samples of a view that were counted.
    pub(super) fn may_hide_fewer(&mut self, view: &View) -> bool {
        let Self { crossings, counter, fewest, .. } = self;
        crossings.iter().any(|c| c.step < 0)
            && crossings.iter().any(|c| c.step > 0)
            && dispatch!(Level::new(), simd => counter.may_hide_fewer(simd, view, crossings, fewest))
    }

    /// A mask whose rows are the columns of another one, of a depth; put it back after use.
    pub(super) fn turned_mask(&mut self, query: &VisibilityQuery<'_>, mask: &Mask, depth: u32) -> Mask {
        let mut turned = core::mem::take(&mut self.turned);
        turned.reset_to(&mask.square().turned(), depth, query.at.normal, query.outline);
        turned
    }

    /// Lists the crossings of outlines with the rows of a mask. Returns the light if triangles reach into it.
    pub(super) fn project_outlines(&mut self, query: &VisibilityQuery<'_>, view: &mut View) -> Option<LightSphere> {
        let sphere = self.cut_outlines(query, view);
        let is_cut = self.is_cut(query.outline.is_some());
        let Self { silhouettes, outside, arcs, crossings, .. } = self;
        crossings.clear();
        if is_cut {
            crossings.extend(arcs.iter().filter_map(|(a, b, step)| Crossing::of_segment(view, *a, *b, *step)));
        }
        let drawn = if is_cut { &*outside } else { &*silhouettes };
        dispatch!(Level::new(), simd => project(simd, drawn, view, crossings));
        sphere
    }

    /// Cuts outlines where triangles reach into the light, and returns it then.
    pub(super) fn cut_outlines(&mut self, query: &VisibilityQuery<'_>, view: &mut View) -> Option<LightSphere> {
        let Self { origin, silhouettes, outside, arcs, near, light, .. } = self;
        // If triangles reach into the light, surfaces count as far as its front side; else as far as its plane.
        let is_flat = query.outline.is_some();
        let end = end_of(query, *light);
        let sphere = (self.is_clipped && !is_flat).then(|| LightSphere::new(end.unwrap_or(*light), *origin));
        if let Some(sphere) = &sphere
            && !self.is_outside_known
        {
            // The same for all windows of the receiver.
            arcs.clear();
            let front = Front { axis: query.cone.axis, distance: view.far };
            let near = near.current().map(|near| if end.is_some() { &near.triangles } else { &near.cutting });
            for corners in near.into_iter().flatten() {
                sphere.clip(&front, corners.map(|p| p - *origin), || side(*corners, *origin), arcs);
            }
            sphere.outside(silhouettes, outside);
            self.is_outside_known = true;
        }
        if is_flat && self.is_cut(is_flat) {
            // The plane has cut the silhouettes too.
            view.clip = f32::INFINITY;
        }
        sphere
    }

    /// Whether the light's surface or its plane has cut outlines, whose parts `outside` are drawn.
    pub(super) fn is_cut(&self, is_flat: bool) -> bool {
        if is_flat { self.is_flat_cut } else { self.is_clipped }
    }
}

/// The part of a light that a receiver sees as a cone while others see an outline of all of it: the end of a tube.
fn end_of(query: &VisibilityQuery<'_>, light: Sphere) -> Option<Sphere> {
    let cone = query.cone;
    let radius = cone.distance * cone.sin_sq().sqrt();
    let center = query.at.position + cone.axis * cone.distance;
    (cone.one_minus_cos < 1.0 && radius < 0.99 * light.radius).then_some(Sphere { center, radius })
}

/// Receivers of a shaft on one face of an object, and their common coverage, if they have one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Alike {
    pub(super) object: u32,
    pub(super) face: Vec3,
    pub(super) coverage: Option<Coverage>,
}

/// Receivers on one face of an object, and whether they are on one side of all triangles near them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plane {
    pub(super) origins: Sphere,
    pub(super) object: u32,
    pub(super) face: Vec3,
    pub(super) is_plane: bool,
}

impl Alike {
    pub(super) fn of(self, at: &Receiver) -> Option<Coverage> {
        self.coverage.filter(|_| (self.object, self.face) == (at.object, at.face))
    }
}
