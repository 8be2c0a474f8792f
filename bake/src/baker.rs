use crate::from_scene::Plan;
use crate::glb::Document;
use crate::images::{Curve, Map};
use crate::layout::{Layout, about_pieces, layout};
use crate::light::Irradiance;
use crate::look::Relief;
use crate::materials::Light;
use crate::page::{MOST_BYTES, Page, bytes};
use crate::steps::{Steps, step};
use crate::subdivide::{Divided, Lamp, Request};
use crate::target::{is_inverted, targets};
use crate::texels::Texels;
use crate::write::Writer;
use crate::{BakeError, BakeSettings, Baked, Form, backs, from_scene, subdivide, vertices};
use core::f32::consts::FRAC_1_PI;
use core::ops::ControlFlow;
use glam::Vec3;
use renderer::{Renderer, Settings};
use scene::{Animation, Cancel, Scene, SceneError};
use scene_files::{GltfDocument, GltfPart, LoadOptions};
use std::path::{Path, PathBuf};

/// A stage of baking.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Stage {
    /// Coordinates are made.
    Coordinates,
    /// Texels or vertices are lit.
    Light,
}

/// Hears the fraction of a stage that is done, in [0, 1], and may stop the work.
pub type Listener<'a> = dyn FnMut(Stage, f32) -> ControlFlow<()> + Send + 'a;

/// The form of a loaded file: a glTF, or a scene of which a new glTF is made.
#[derive(Clone, Debug, PartialEq)]
enum Kind {
    Gltf,
    Scene(Plan),
}

/// A scene with its document: of a glTF file its own, of others a new one, with materials that are double-sided or not.
fn load(
    path: &Path,
    options: &LoadOptions,
    is_double_sided: bool,
) -> Result<(Kind, Scene, Animation, GltfDocument, Vec<String>), SceneError> {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    if ["gltf", "glb"].contains(&&*ending) {
        let (scene, animation, file, notes) = scene_files::load_document(path, options)?;
        return Ok((Kind::Gltf, scene, animation, file, notes));
    }
    let (scene, animation, mut notes) = scene_files::load_with(path, options)?;
    let is_model = ending != "toml";
    if is_model {
        notes.push(format!("{}: is lit as pictures show it", path.display()));
    }
    // A model's first object is the floor that pictures have.
    let plan = Plan::new(&scene, usize::from(is_model), is_double_sided);
    let (mut file, left_out) = from_scene::document(&scene, &plan);
    for part in &mut file.parts {
        part.moves = part.object.is_some_and(|object| animation.moves_object(object));
    }
    notes.extend(left_out);
    Ok((Kind::Scene(plan), scene, animation, file, notes))
}

/// The names of some parts, of many the first ones; `None` for no parts.
fn names<'f>(parts: impl Iterator<Item = &'f GltfPart>) -> Option<String> {
    const NAMES: usize = 3;
    let names: Vec<String> = parts.map(|part| format!("\"{}\"", part.name)).collect();
    let more = match names.len() {
        0 => return None,
        count if count > NAMES => format!(" and {} more", count - NAMES),
        _ => String::new(),
    };
    Some(names.into_iter().take(NAMES).collect::<Vec<_>>().join(", ") + &more)
}

/// A line about double-sided surfaces whose backs can be seen, if there are some.
fn about_sheets(file: &GltfDocument, sheets: &[usize]) -> Option<String> {
    let open = sheets.iter().map(|part| &file.parts[*part]).filter(|part| backs::has_border(part));
    let names = names(open)?;
    Some(format!("double-sided: both sides of {names} show the light of the front (both sides gives them their own)"))
}

/// A line about surfaces whose fronts by their normals are their backs by their triangles, if there are some.
fn about_inverted(file: &GltfDocument, parts: &[usize]) -> Option<String> {
    let names = names(parts.iter().map(|part| &file.parts[*part]).filter(|part| is_inverted(part)))?;
    Some(format!(
        "normals of {names} point against the triangles: light is baked to the side from which these go round against the clock"
    ))
}

/// A file whose light is baked.
#[derive(Debug)]
pub struct Baker {
    path: PathBuf,
    kind: Kind,
    file: GltfDocument,
    document: Document,
    /// Parts that light is baked to.
    parts: Vec<usize>,
    /// Parts that have a back of their own.
    sheets: Vec<usize>,
    settings: BakeSettings,
    renderer: Renderer,
    /// The coordinates, once they are made.
    layout: Option<Layout>,
    notes: Vec<String>,
}

impl Baker {
    /// Loads a file and checks that it suits the settings.
    ///
    /// # Errors
    /// [`BakeError`], one line: those of loading, a file without lights or surfaces, settings out of their ranges.
    pub fn open(
        path: impl AsRef<Path>,
        options: &LoadOptions,
        settings: BakeSettings,
        render: Settings,
    ) -> Result<Self, BakeError> {
        settings.validate()?;
        let path = path.as_ref().to_owned();
        let fault = |message: &str| BakeError::File { path: path.clone(), message: message.to_owned() };
        let (kind, scene, animation, mut file, mut notes) = load(&path, options, settings.both_sides)?;
        if scene.lights.is_empty() {
            return Err(fault(
                "has no light to bake (KHR_lights_punctual, or materials that emit); a scene file can light it",
            ));
        }
        let json = serde_json::from_str(&file.json).map_err(|e| fault(&e.to_string()))?;
        let (mut parts, left_out) = targets(&path, &file, &json)?;
        notes.extend(left_out);
        notes.extend(about_inverted(&file, &parts));
        let sheets: Vec<usize> =
            parts.iter().copied().filter(|part| backs::is_sheet(&json, &file.parts[*part])).collect();
        if settings.both_sides {
            parts.extend(backs::add(&mut file, &sheets).map_err(|e| fault(&e.to_string()))?);
        } else {
            notes.extend(about_sheets(&file, &sheets));
        }
        if settings.form != Form::VertexColors {
            notes.extend(about_pieces(&file, &parts, &settings));
        }
        let document = Document::new(&file).map_err(|e| fault(&e.to_string()))?;
        let renderer = Renderer::new(scene, animation, render)?;
        Ok(Self { path, kind, file, document, parts, sheets, settings, renderer, layout: None, notes })
    }

    /// A line about each thing that was left out or replaced.
    #[must_use]
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// The renderer that lights the surfaces.
    #[must_use]
    pub const fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// The glTF file that light is added to: of other files a new one.
    #[must_use]
    pub const fn document(&self) -> &GltfDocument {
        &self.file
    }

    /// Moves the animation to a time in seconds, whose light is baked from then on: nodes, skins, morph targets and lights are where they are
    /// at it. Vertices of scene files are written there; a glTF file keeps its own, and its animations. Coordinates are those of the
    /// first moment at any time.
    ///
    /// ```no_run
    /// use bake::{BakeSettings, Baker};
    /// use core::ops::ControlFlow;
    /// let options = scene_files::LoadOptions::new();
    /// let mut baker = Baker::open("walk.glb", &options, BakeSettings::default(), renderer::Settings::default())?;
    /// for frame in 0..24 {
    ///     baker.seek(frame as f32 / 24.0)?;
    ///     let baked = baker.bake(&mut |_stage, _done| ControlFlow::Continue(()))?;
    ///     std::fs::write(format!("walk.{frame:04}.glb"), baked.glb)?;
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Cost
    /// That of [`Animation::seek`]; for a scene file with the encoding of its textures.
    ///
    /// # Errors
    /// [`BakeError::File`] where the new document cannot be made.
    pub fn seek(&mut self, time: f32) -> Result<(), BakeError> {
        if time == self.renderer.time() {
            return Ok(());
        }
        self.renderer.seek(time);
        let fault = |e: serde_json::Error| BakeError::File { path: self.path.clone(), message: e.to_string() };
        match &self.kind {
            Kind::Gltf => {
                let animation = self.renderer.animation();
                let worlds = animation.worlds(time);
                self.file.parts.iter_mut().for_each(|part| part.seek(animation, time, &worlds));
            }
            Kind::Scene(plan) => {
                (self.file, _) = from_scene::document(self.renderer.scene(), plan);
                if self.settings.both_sides {
                    backs::add(&mut self.file, &self.sheets).map_err(fault)?;
                }
                self.document = Document::new(&self.file).map_err(fault)?;
            }
        }
        Ok(())
    }

    /// Sets the request that stops baking, as that of [`Renderer::set_cancel`].
    pub fn set_cancel(&mut self, cancel: Cancel) {
        self.renderer.set_cancel(cancel);
    }

    /// Bakes.
    ///
    /// # Errors
    /// [`BakeError`]: coordinates that overlap, pages that take too much memory, and a request to stop.
    pub fn bake(&mut self, listener: &mut Listener<'_>) -> Result<Baked, BakeError> {
        self.bake_with(listener, &mut ())
    }

    /// Bakes, from the steps on that were finished before.
    ///
    /// Steps are the coordinates, and some half a million points or one surface's vertices each: up to 20 MB, and 12 bytes more a texel for each
    /// light that has a map.
    ///
    /// # Errors
    /// As [`bake`](Self::bake); [`BakeError::Steps`] for steps of another bake, as far as that is seen.
    pub fn bake_with(&mut self, listener: &mut Listener<'_>, steps: &mut dyn Steps) -> Result<Baked, BakeError> {
        self.renderer.prepare(&mut |_| ControlFlow::Continue(()))?;
        match self.settings.form {
            Form::VertexColors => self.bake_vertices(listener, steps),
            Form::Lightmap | Form::Emission => self.bake_texels(listener, steps),
        }
    }

    fn part(&self, place: usize) -> &GltfPart {
        &self.file.parts[place]
    }

    fn irradiance(&mut self) -> Result<Irradiance, BakeError> {
        let per_light = self.settings.per_light && self.settings.form != Form::VertexColors;
        let light = Irradiance::new(self.renderer.scene(), per_light);
        let points = self.parts.iter().flat_map(|part| self.file.parts[*part].geometry.positions.iter().copied());
        light.begin(&mut self.renderer, points)?;
        Ok(light)
    }

    fn bake_vertices(&mut self, listener: &mut Listener<'_>, steps: &mut dyn Steps) -> Result<Baked, BakeError> {
        let light = self.irradiance()?;
        let parts: Vec<&GltfPart> = self.parts.iter().map(|part| &self.file.parts[*part]).collect();
        let mut heard = |done| listener(Stage::Light, done);
        let (lit, subdivision) = match self.settings.subdivide {
            None => {
                let lit = vertices::all(&parts, &light, &mut self.renderer, steps, &mut heard)?;
                (lit.into_iter().map(|light| Divided { mesh: None, light }).collect::<Vec<_>>(), None)
            }
            Some(error) => {
                let BakeSettings { density, most_vertices, .. } = self.settings;
                let request = Request { error, most: most_vertices as usize, density };
                let lamp = Lamp { light: &light, renderer: &mut self.renderer, steps };
                let (lit, summary) = subdivide::all(&parts, request, lamp, &mut heard)?;
                (lit, Some(summary))
            }
        };
        let most = lit.iter().flat_map(|part| &part.light).map(|v| v.max_element()).fold(0.0, f32::max);
        let scale = (most * FRAC_1_PI).max(1.0);
        let mut writer =
            Writer::new(&self.file, self.renderer.scene(), self.document.clone(), self.settings.both_sides);
        for (part, Divided { mesh, light }) in self.parts.iter().zip(&lit) {
            let part = self.part(*part);
            if let Some((vertices, triangles)) = mesh {
                writer.divided(part, vertices, triangles);
            }
            writer.colors(part, mesh.as_ref().map(|(vertices, _)| &vertices[..]), light, scale);
        }
        let vertices = lit.iter().map(|part| part.light.len() as u64).sum();
        let glb = writer.document.into_glb();
        Ok(Baked { glb, vertices, surfaces: self.parts.len(), scale, subdivision, ..Baked::default() })
    }

    /// The layout of the surfaces at the first moment, which must fit into memory.
    fn layout(&mut self, values: usize, listener: &mut Listener<'_>) -> Result<Layout, BakeError> {
        if let Some(known) = self.layout.take() {
            return Ok(known);
        }
        let time = self.renderer.time();
        self.seek(0.0)?;
        let made = self.make_layout(values, listener);
        self.seek(time)?;
        made
    }

    fn make_layout(&self, values: usize, listener: &mut Listener<'_>) -> Result<Layout, BakeError> {
        self.check_memory(&[[self.settings.page; 2]], values)?;
        let listener = std::sync::Mutex::new(listener);
        let cancel = self.renderer.cancel();
        let heard = |done| match listener.lock() {
            Ok(_) if cancel.is_cancelled() => ControlFlow::Break(()),
            Ok(mut listener) => listener(Stage::Coordinates, done),
            Err(_) => ControlFlow::Break(()),
        };
        let found = layout((&self.path, &self.file), &self.parts, &self.settings, &heard)?;
        self.check_memory(&found.pages, values)?;
        Ok(found)
    }

    fn check_memory(&self, pages: &[[u32; 2]], values: usize) -> Result<(), BakeError> {
        let bytes = bytes(pages, values);
        if bytes <= MOST_BYTES {
            return Ok(());
        }
        let (count, side) = (pages.len(), self.settings.page);
        let (pages, take) = if count == 1 { ("page", "takes") } else { ("pages", "take") };
        let lights = if values > 1 { format!(" with maps of {} single lights", values - 1) } else { String::new() };
        let message = format!(
            "{count} {pages} of {side} x {side} texels{lights} {take} {:.1} GB: at most {:.0} GB are taken",
            bytes as f64 / 1e9,
            MOST_BYTES as f64 / 1e9
        );
        Err(BakeError::File { path: self.path.clone(), message })
    }

    fn bake_texels(&mut self, listener: &mut Listener<'_>, steps: &mut dyn Steps) -> Result<Baked, BakeError> {
        let groups = Irradiance::new(self.renderer.scene(), self.settings.per_light).groups().len();
        let layout = step(steps, || self.layout(1 + groups, listener))?;
        let light = self.irradiance()?;
        let baked = self.bake_layout(&layout, &light, listener, steps);
        self.layout = Some(layout);
        baked
    }

    fn bake_layout(
        &mut self,
        layout: &Layout,
        light: &Irradiance,
        listener: &mut Listener<'_>,
        steps: &mut dyn Steps,
    ) -> Result<Baked, BakeError> {
        let scene = self.renderer.scene();
        let reliefs = layout.targets.iter().map(|target| Relief::new(scene, self.part(target.part))).collect();
        let texels = Texels {
            reliefs,
            file: &self.file,
            layout,
            light,
            is_radiance: self.settings.form == Form::Emission,
            samples: self.settings.samples,
            padding: self.settings.padding,
        };
        let pages = texels.pages(&mut self.renderer, steps, &mut |done| listener(Stage::Light, done))?;
        self.write(layout, light, pages)
    }

    fn write(&self, layout: &Layout, light: &Irradiance, pages: Vec<Page>) -> Result<Baked, BakeError> {
        let is_lightmap = self.settings.form == Form::Lightmap;
        let mut writer =
            Writer::new(&self.file, self.renderer.scene(), self.document.clone(), self.settings.both_sides);
        let mut baked = Baked { surfaces: self.parts.len(), scale: 1.0, ..Baked::default() };
        let mut textures = Vec::new();
        for (number, page) in pages.into_iter().enumerate() {
            baked.pages.push(page.size);
            baked.texels += page.states.iter().filter(|state| **state == crate::page::State::Surface).count() as u64;
            let mut layers = page.layers.into_iter();
            let map = |name: String, values: Vec<Vec3>| Map::whole(name, page.size, values);
            let all = map(format!("lightmap{number}"), layers.next().unwrap_or_default());
            let all = if is_lightmap { all.cut(&page.states) } else { all };
            let png = all.png(if is_lightmap { Curve::Linear } else { Curve::Srgb })?;
            textures.push((writer.document.add_texture(&all.name, &png), all.white));
            let singles = layers.zip(light.groups());
            let single = |name: String, values| Map { is_single: true, ..map(name, values) };
            let singles = singles.map(|(values, group)| single(format!("lightmap{number}.{}", group.name), values));
            baked.maps.extend(is_lightmap.then_some(all).into_iter().chain(singles));
        }
        for target in &layout.targets {
            let ((texture, scale), set) = (textures[target.page], target.set);
            let light = match is_lightmap {
                true => Light::Map { texture, set, scale },
                false => Light::Emission { texture, set, scale },
            };
            writer.texture(target, light);
        }
        baked.glb = writer.document.into_glb();
        Ok(baked)
    }
}
