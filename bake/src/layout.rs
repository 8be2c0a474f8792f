//! Where surfaces lie on the pages of maps: by coordinates of the file, or by coordinates that are made.

use crate::coverage::Grid;
use crate::pieces;
use crate::scattered::{Charts, Sheet, Unfolded, is_scattered};
use crate::target::Target;
use crate::{BakeError, BakeSettings};
use core::ops::ControlFlow;
use glam::Vec2;
use renderer::RenderError;
use scene_files::{GltfDocument, GltfPart};
use std::path::Path;
use uvunwrap::{Atlas, Density, MeshInput, Options, Packing};

/// The set of coordinates that light maps take: the second.
const SECOND: usize = 1;

/// Up to this number of triangles and of separate pieces charts are packed by their shapes, which takes minutes for more.
const SHAPED: usize = 20_000;
const FEW: usize = 2000;

/// From this number of separate pieces on a line says that coordinates take long.
const MANY: usize = 50_000;

/// How far beyond a page coordinates may lie, for rounding.
const BEYOND: f32 = 1e-4;

/// How many times a texel may be covered, for rounding.
pub(crate) const ONCE: f64 = 1.01;

/// The surfaces on their pages.
#[derive(Clone, Debug, Default)]
pub(crate) struct Layout {
    /// Width and height of each page.
    pub(crate) pages: Vec<[u32; 2]>,
    /// The surfaces.
    pub(crate) targets: Vec<Target>,
}

/// Hears how far the making of coordinates is, in [0, 1], and may stop it.
pub(crate) type Heard<'a> = dyn Fn(f32) -> ControlFlow<()> + Sync + 'a;

/// Lays out parts of a document.
///
/// Those with a second set of coordinates keep it, unless new ones are requested: they share a page as long as they do not overlap. All
/// others share pages of coordinates that are made.
pub(crate) fn layout(
    (path, file): (&Path, &GltfDocument),
    parts: &[usize],
    settings: &BakeSettings,
    heard: &Heard<'_>,
) -> Result<Layout, BakeError> {
    let (own, bare): (Vec<usize>, Vec<usize>) = parts.iter().partition(|part| has_own(file, **part, settings));
    let fault = |message: String| BakeError::File { path: path.to_owned(), message };
    let mut all = Layout::default();
    let mut pages = OwnPages::new(settings.page);
    for part in own {
        let page = pages.place(&file.parts[part]).map_err(fault)?;
        let mesh = &file.parts[part].geometry;
        let (coordinates, triangles) = (mesh.uv_sets[SECOND].clone(), mesh.triangles.clone());
        all.targets.push(Target { part, page, set: SECOND, coordinates, triangles, origins: None });
    }
    all.pages = vec![[settings.page; 2]; pages.pages.len()];
    let (scattered, bare): (Vec<usize>, Vec<usize>) =
        bare.into_iter().partition(|part| is_scattered(&file.parts[*part].geometry));
    if !scattered.is_empty() {
        add_scattered(&mut all, file, &scattered, settings, heard).map_err(|fault_or_stop| match fault_or_stop {
            Some(message) => fault(message),
            None => RenderError::Cancelled.into(),
        })?;
    }
    if !bare.is_empty() {
        let atlas = unwrap(path, file, &bare, settings, heard)?;
        add_atlas(&mut all, file, &bare, &atlas).map_err(fault)?;
    }
    all.targets.sort_by_key(|target| target.part);
    Ok(all)
}

/// A line about coordinates that take long to make, if they do.
pub(crate) fn about_pieces(file: &GltfDocument, parts: &[usize], settings: &BakeSettings) -> Option<String> {
    let bare = parts.iter().filter(|part| !has_own(file, **part, settings)).map(|part| &file.parts[*part].geometry);
    // Those of few triangles each lie in rows.
    let pieces: usize = bare.filter(|mesh| !is_scattered(mesh)).map(pieces::count).sum();
    (pieces >= MANY).then(|| {
        format!(
            "coordinates for {pieces} separate pieces are to be made: this takes minutes; colours of vertices need none"
        )
    })
}

/// Whether a part's own coordinates are used.
fn has_own(file: &GltfDocument, part: usize, settings: &BakeSettings) -> bool {
    !settings.unwrap && file.parts[part].geometry.uv_sets.len() > SECOND
}

/// Pages of surfaces with coordinates of their own.
struct OwnPages {
    grid: Grid,
    /// How many times each texel is covered, page by page.
    pages: Vec<Vec<f32>>,
}

impl OwnPages {
    const fn new(side: u32) -> Self {
        Self { grid: Grid { size: [side; 2], rows: [0, side], cells: 1 }, pages: Vec::new() }
    }

    /// The first page on which a surface overlaps no other; a new one if there is none.
    fn place(&mut self, part: &GltfPart) -> Result<usize, String> {
        let texels = self.texels(part)?;
        let fits = |page: &Vec<f32>| texels.iter().all(|(at, area)| f64::from(page[*at]) + area <= ONCE);
        let place = self.pages.iter().position(fits).unwrap_or(self.pages.len());
        if place == self.pages.len() {
            let count = self.grid.size[0] as usize * self.grid.size[1] as usize;
            self.pages.push(vec![0.0; count]);
        }
        texels.into_iter().for_each(|(at, area)| self.pages[place][at] += area as f32);
        Ok(place)
    }

    /// The texels that a surface covers, each once, with the areas that are covered.
    fn texels(&self, part: &GltfPart) -> Result<Vec<(usize, f64)>, String> {
        let (name, mesh) = (&part.name, &part.geometry);
        let uvs = &mesh.uv_sets[SECOND];
        let inside = |uv: &Vec2| uv.cmpge(Vec2::splat(-BEYOND)).all() && uv.cmple(Vec2::splat(1.0 + BEYOND)).all();
        if let Some(far) = uvs.iter().position(|uv| !inside(uv)) {
            let [u, v] = uvs[far].to_array();
            return Err(format!(
                "mesh \"{name}\": its second coordinates leave the page at ({u}, {v}); new ones can be made (unwrap)"
            ));
        }
        let mut found = Vec::new();
        for triangle in &mesh.triangles {
            self.grid.pieces(triangle.map(|i| uvs[i as usize]), |piece| {
                let [x, y] = piece.texel.map(|k| k as usize);
                found.push((y * self.grid.size[0] as usize + x, piece.area));
            });
        }
        found.sort_by_key(|(at, _)| *at);
        let mut texels: Vec<(usize, f64)> = Vec::new();
        for (at, area) in found {
            match texels.last_mut() {
                Some((last, sum)) if *last == at => *sum += area,
                _ => texels.push((at, area)),
            }
        }
        let twice = texels.iter().filter(|(_, area)| *area > ONCE).count();
        if twice > 0 {
            return Err(format!(
                "mesh \"{name}\": its second coordinates overlap or are mirrored onto each other in {twice} texels; new ones can be made (unwrap)"
            ));
        }
        Ok(texels)
    }
}

/// Adds surfaces of many small pieces: on one page, or with a density on as many as it takes, each surface on one of them. The fault is none
/// where the work was stopped.
fn add_scattered(
    all: &mut Layout,
    file: &GltfDocument,
    parts: &[usize],
    settings: &BakeSettings,
    heard: &Heard<'_>,
) -> Result<(), Option<String>> {
    let mut charts = Vec::new();
    for (done, part) in parts.iter().enumerate() {
        charts.push(Charts::new(&file.parts[*part].geometry));
        let done = 0.5 * (done + 1) as f32 / parts.len() as f32;
        if heard(done).is_break() {
            return Err(None);
        }
    }
    let page = (settings.page, settings.padding);
    let goes_on = |done: f32| heard(0.5 + 0.5 * done).is_continue();
    let sheet =
        |range: core::ops::Range<usize>| Sheet::new(&charts[range], settings.density.map(f64::from), page, &goes_on);
    let mut start = 0;
    while start < parts.len() {
        // As many surfaces as fit: all of them at first, then one after the other.
        let mut end = parts.len();
        let mut made = sheet(start..end);
        if made.is_none() {
            end = start;
            while let Some(more) = (end < parts.len()).then(|| sheet(start..end + 1)).flatten() {
                (made, end) = (Some(more), end + 1);
                if settings.density.is_none() {
                    break;
                }
            }
        }
        if heard(1.0).is_break() {
            return Err(None);
        }
        let Some(made) = made else {
            let (name, side) = (&file.parts[parts[start]].name, settings.page);
            return Err(Some(format!(
                "mesh \"{name}\": its charts do not fit one page of {side}: a larger page, a lower density or less padding fits, and colours of vertices need none"
            )));
        };
        for (part, unfolded) in parts[start..end].iter().zip(made.unfolded(&charts[start..end])) {
            let Unfolded { coordinates, origins, triangles } = unfolded;
            let set = file.parts[*part].geometry.uv_sets.len().max(SECOND);
            let page = all.pages.len();
            all.targets.push(Target { part: *part, page, set, coordinates, triangles, origins: Some(origins) });
        }
        all.pages.push(made.size);
        start = end;
    }
    Ok(())
}

/// Coordinates for surfaces that share none of their texels.
fn unwrap(
    path: &Path,
    file: &GltfDocument,
    parts: &[usize],
    settings: &BakeSettings,
    heard: &Heard<'_>,
) -> Result<Atlas, BakeError> {
    let lists = |part: &usize| -> (Vec<[f32; 3]>, Vec<u32>) {
        let mesh = &file.parts[*part].geometry;
        (mesh.positions.iter().map(|p| p.to_array()).collect(), mesh.triangles.iter().flatten().copied().collect())
    };
    let meshes: Vec<_> = parts.iter().map(lists).collect();
    let mut pieces = 0;
    for part in parts {
        let GltfPart { name, geometry, .. } = &file.parts[*part];
        let count = pieces::count(geometry);
        pieces += count;
        // Each is a texel at least, and has the padding to two sides for itself.
        let least = count as u64 * u64::from(1 + settings.padding).pow(2);
        if least > u64::from(settings.page).pow(2) {
            let side = settings.page;
            let message = format!(
                "mesh \"{name}\": its {count} separate pieces do not fit one page of {side}: a larger page or less padding fits, and colours of vertices need none"
            );
            return Err(BakeError::File { path: path.to_owned(), message });
        }
    }
    let faces: usize = meshes.iter().map(|(_, indices)| indices.len() / 3).sum();
    // With several pages a surface stays on one of them as a rectangle.
    let made = |density: Density, scales: &[f32]| {
        let inputs = meshes
            .iter()
            .map(|(positions, indices)| MeshInput { instance_scales: scales, ..MeshInput::new(positions, indices) });
        let packing = if faces > SHAPED || pieces > FEW { Packing::Fast } else { Packing::Shape };
        let options = Options { density, padding: settings.padding, packing, ..Options::default() };
        uvunwrap::generate_with_progress(&inputs.collect::<Vec<_>>(), &options, |progress| {
            let done = progress.done as f32 / progress.total.unwrap_or(faces).max(1) as f32;
            heard(done.min(1.0)).is_continue()
        })
    };
    let page_size = settings.page;
    let found = match settings.density {
        None => made(Density::Auto { page_size }, &[]),
        Some(texels_per_unit) => {
            let area: f64 = parts.iter().map(|part| file.parts[*part].geometry.area()).sum();
            let may_fit = area * f64::from(texels_per_unit).powi(2) <= f64::from(page_size).powi(2);
            let one = may_fit.then(|| made(Density::Fixed { texels_per_unit, page_size: None }, &[]));
            match one {
                Some(Err(error)) => Err(error),
                Some(Ok(atlas)) if atlas.width.max(atlas.height) <= page_size => Ok(atlas),
                _ => made(Density::Fixed { texels_per_unit, page_size: Some(page_size) }, &[1.0]),
            }
        }
    };
    found.map_err(|error| explain(path, file, parts, settings, &error))
}

fn explain(
    path: &Path,
    file: &GltfDocument,
    parts: &[usize],
    settings: &BakeSettings,
    error: &uvunwrap::Error,
) -> BakeError {
    let bytes = |texels: u64| texels as f64 * crate::page::TEXEL_BYTES as f64 / 1e9;
    let message = match error {
        uvunwrap::Error::Cancelled => return RenderError::Cancelled.into(),
        uvunwrap::Error::AtlasTooLarge { texels } => {
            format!("its surfaces take {texels} texels at this density, {:.1} GB: a lower density fits", bytes(*texels))
        }
        uvunwrap::Error::ChartTooLarge { width, height, page_size } => format!(
            "a surface takes {width} x {height} texels, {:.1} GB; a page has {page_size} x {page_size}: a lower density or a larger page fits",
            bytes(u64::from(*width) * u64::from(*height))
        ),
        uvunwrap::Error::NonFinitePosition { mesh, .. } => {
            format!("mesh \"{}\": a position is not finite", file.parts[parts[*mesh]].name)
        }
        error => format!("coordinates cannot be made on a page of {}: {error}", settings.page),
    };
    BakeError::File { path: path.to_owned(), message }
}

/// Adds surfaces with coordinates that were made.
fn add_atlas(all: &mut Layout, file: &GltfDocument, parts: &[usize], atlas: &Atlas) -> Result<(), String> {
    let first = all.pages.len();
    all.pages.extend((0..atlas.page_count).map(|_| [atlas.width.max(1), atlas.height.max(1)]));
    for (part, mesh) in parts.iter().zip(&atlas.meshes) {
        let GltfPart { name, geometry, .. } = &file.parts[*part];
        let mut used = mesh.vertices.iter().filter_map(|vertex| vertex.page);
        let rectangle = mesh.instances.first();
        let page = rectangle.map_or_else(|| used.next().unwrap_or(0), |rectangle| rectangle.page);
        if used.any(|other| other != page) {
            let side = atlas.width;
            return Err(format!(
                "mesh \"{name}\": its charts do not fit one page of {side}: a larger page or less padding fits"
            ));
        }
        let place = |uv: [f32; 2]| {
            let [low, high] = rectangle.map_or([[0.0; 2], [1.0; 2]], |r| [r.min, r.max]).map(Vec2::from_array);
            low + Vec2::from_array(uv) * (high - low)
        };
        all.targets.push(Target {
            part: *part,
            page: first + page as usize,
            set: geometry.uv_sets.len().max(SECOND),
            coordinates: mesh.vertices.iter().map(|vertex| place(vertex.uv)).collect(),
            triangles: mesh.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
            origins: Some(mesh.vertices.iter().map(|vertex| vertex.xref).collect()),
        });
    }
    Ok(())
}
