use glam::Vec3;
use lobe_core::{SelfShadow, Sphere};
use serde::{Deserialize, Serialize};

use crate::bound_file::Bones;
use crate::error::SetFileError;
use crate::quality::SetQuality;
use crate::sphere_set::SphereSet;

const FORMAT: &str = "cosine-lobes sphere set";
const VERSION: u32 = 1;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    mesh: Mesh,
    self_distance: f32,
    #[serde(default)]
    self_shadows: Vec<Vec<f32>>,
    spheres: Vec<[serde_json::Value; 4]>,
    quality: SetQuality,
    #[serde(default)]
    bones: Option<Bones>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Mesh {
    triangles: usize,
    bounds: [[f32; 3]; 2],
}

impl SphereSet {
    /// The set as JSON, one sphere `[x, y, z, r]` a line:
    /// `{"format", "version", "mesh": {"triangles", "bounds"}, "self_distance", "self_shadows", "quality", "spheres"}`,
    /// `self_shadows` one `[x, y, z, radius, distance]` for each sphere, in its radii, or left out.
    ///
    /// [`SphereSet::from_json`] gives the same set back, bit for bit.
    #[must_use]
    pub fn to_json(&self) -> String {
        self.write(None)
    }

    pub(crate) fn write(&self, bones: Option<&Bones>) -> String {
        let bones = bones.map_or_else(String::new, |bones| format!(",\n  \"bones\": {}", json(bones)));
        let row = |s: &SelfShadow| [s.offset.x, s.offset.y, s.offset.z, s.radius, s.distance];
        let own: Vec<[f32; 5]> = self.self_shadows.iter().map(row).collect();
        let own = if own.is_empty() { String::new() } else { format!("  \"self_shadows\": {},\n", json(&own)) };
        let rows: Vec<String> = self
            .spheres
            .iter()
            .map(|sphere| {
                let [x, y, z] = sphere.center.to_array();
                format!("    {}", json(&[x, y, z, sphere.radius]))
            })
            .collect();
        format!(
            "{{\n  \"format\": {},\n  \"version\": {VERSION},\n  \"mesh\": {},\n  \"self_distance\": {},\n{own}  \
             \"quality\": {},\n  \"spheres\": [\n{}\n  ]{bones}\n}}\n",
            json(FORMAT),
            json(&Mesh { triangles: self.mesh_triangles, bounds: self.mesh_bounds.map(|p| p.to_array()) }),
            json(&self.self_distance),
            json(&self.quality),
            rows.join(",\n"),
        )
    }

    /// Reads the output of [`SphereSet::to_json`], and the spheres from that of
    /// [`BoundSet::to_json`](crate::BoundSet::to_json).
    ///
    /// # Errors
    /// One line that names the fault, for anything else: text that is no JSON, missing or unknown keys, wrong types,
    /// another format or version, numbers outside single precision, negative radii or lengths, no spheres, bones that
    /// do not match the spheres.
    pub fn from_json(text: &str) -> Result<Self, SetFileError> {
        Self::read(text).map(|(set, _)| set)
    }

    pub(crate) fn read(text: &str) -> Result<(Self, Option<Bones>), SetFileError> {
        let file = file(text)?;
        let quality = file.quality;
        for (what, value) in [
            ("self_distance", file.self_distance),
            ("coverage", quality.coverage),
            ("protrusion_volume", quality.protrusion_volume),
            ("hausdorff_outside", quality.hausdorff_outside),
            ("p95_gap", quality.p95_gap),
            ("silhouette_error", quality.silhouette_error),
        ] {
            check_length(what, value)?;
        }
        let bounds = file.mesh.bounds.map(Vec3::from_array);
        if !(bounds[0].is_finite() && bounds[1].is_finite() && bounds[0].cmple(bounds[1]).all()) {
            return refuse("the mesh's bounds are not a box");
        }
        if file.spheres.is_empty() {
            return refuse("there are no spheres");
        }
        let spheres: Vec<Sphere> =
            file.spheres.iter().enumerate().map(|(i, row)| sphere(i, row)).collect::<Result<_, _>>()?;
        if !file.self_shadows.is_empty() && file.self_shadows.len() != spheres.len() {
            return refuse(format!("there are {} self_shadows for {} spheres", file.self_shadows.len(), spheres.len()));
        }
        let self_shadows =
            file.self_shadows.iter().enumerate().map(|(i, row)| self_shadow(i, row)).collect::<Result<_, _>>()?;
        if let Some(bones) = &file.bones {
            bones.check(spheres.len())?;
        }
        let set = Self {
            spheres,
            self_distance: file.self_distance,
            self_shadows,
            mesh_triangles: file.mesh.triangles,
            mesh_bounds: bounds,
            quality,
        };
        Ok((set, file.bones))
    }
}

fn refuse<T>(message: impl Into<String>) -> Result<T, SetFileError> {
    Err(SetFileError { message: message.into() })
}

/// A file of this format and version.
fn file(text: &str) -> Result<File, SetFileError> {
    // The format's name is checked first: other JSON is refused by its format and not by a missing key.
    let mut value = parse(text).map_err(|error| SetFileError { message: format!("not JSON: {error}") })?;
    match value.get("format").map(|format| format.as_str()) {
        Some(Some(FORMAT)) => {}
        None => return refuse(format!("no \"format\" key; it should be \"{FORMAT}\"")),
        Some(_) => return refuse(format!("\"format\" should be \"{FORMAT}\"")),
    }
    match value.get("version").map(serde_json::Value::as_u64) {
        Some(Some(version)) if version == u64::from(VERSION) => {}
        Some(Some(version)) => return refuse(format!("version {version} is not known, only {VERSION}")),
        _ => return refuse(format!("\"version\" should be {VERSION}")),
    }
    if let Some(keys) = value.as_object_mut() {
        keys.remove("format");
        keys.remove("version");
    }
    // Error messages quote keys of the file, which may hold any characters.
    let one_line = |error: serde_json::Error| error.to_string().replace(char::is_control, " ");
    serde_json::from_value(value).map_err(|error| SetFileError { message: one_line(error) })
}

fn check_length(what: &str, value: f32) -> Result<(), SetFileError> {
    match value {
        _ if !value.is_finite() => refuse(format!("{what} is not a finite number")),
        _ if value < 0.0 => refuse(format!("{what} is {value}, but should not be negative")),
        _ => Ok(()),
    }
}

fn sphere(i: usize, row: &[serde_json::Value; 4]) -> Result<Sphere, SetFileError> {
    let mut numbers = [0.0_f32; 4];
    for (number, value) in numbers.iter_mut().zip(row) {
        // A null was not a number when the file was written.
        match (value.as_f64(), value.is_null()) {
            (Some(value), _) => *number = value as f32,
            (None, true) => *number = f32::NAN,
            (None, false) => return refuse(format!("sphere {i} should be four numbers, not {value}")),
        }
    }
    let [x, y, z, radius] = numbers;
    let center = Vec3::new(x, y, z);
    if !center.is_finite() {
        return refuse(format!("the centre of sphere {i} is not finite"));
    }
    check_length(&format!("the radius of sphere {i}"), radius)?;
    Ok(Sphere { center, radius })
}

fn self_shadow(i: usize, row: &[f32]) -> Result<SelfShadow, SetFileError> {
    let (offset, radius, distance) = match *row {
        [x, y, z, radius, distance] => (Vec3::new(x, y, z), radius, distance),
        // Older files: about the sphere's own centre.
        [radius, distance] => (Vec3::ZERO, radius, distance),
        _ => return refuse(format!("self_shadow {i} should be five numbers, not {}", row.len())),
    };
    if !(0.0..=1.0).contains(&radius) {
        return refuse(format!("the radius of self_shadow {i} is {radius}, but should be 0 to 1"));
    }
    check_length(&format!("the distance of self_shadow {i}"), distance)?;
    // Allows for the rounding of numbers in the file.
    if !offset.is_finite() || offset.length() + radius > 1.001 {
        return refuse(format!("self_shadow {i} reaches out of its sphere"));
    }
    Ok(SelfShadow { offset, radius, distance })
}

/// JSON, also with the bare `NaN` and `Infinity` of some programs, which are read as null.
fn parse(text: &str) -> Result<serde_json::Value, serde_json::Error> {
    serde_json::from_str(text).or_else(|error| {
        if !text.contains("NaN") && !text.contains("Infinity") {
            return Err(error);
        }
        let text = text.replace("-Infinity", "null").replace("Infinity", "null").replace("NaN", "null");
        serde_json::from_str(&text).map_err(|_| error)
    })
}

/// JSON of a value that has one: numbers, strings, arrays and structs of them.
fn json(value: &(impl Serialize + ?Sized)) -> String {
    serde_json::to_string(value).unwrap_or_else(|_| "null".to_owned())
}
