//! Key frames of a scene file.

use crate::origin::relative;
use crate::toml_reader::{Table, Value};
use crate::turns::{linear_turn, one_axis, smooth_turn};
use glam::{DVec3, Mat4, Vec3};
use scene::motion::{
    CameraKeys, Clock, Interpolation, Keyed, MAX_SECONDS, Meaning, Origins, Placement, ProjectionKeys, Track,
    fine_rotation, rotation,
};
use scene::{Camera, MAX_COORDINATE, Projection, SceneError};

/// `keys`, `interpolate` and `loop` of an object, a light or the camera.
pub(crate) struct Keys<'s> {
    place: Value<'s>,
    times: Vec<f32>,
    tables: Vec<Table<'s>>,
    smooth: bool,
    clock: Clock,
}

/// The placement of an object where no key changes it.
#[derive(Clone, Copy)]
pub(crate) struct Stand {
    pub(crate) scale: Vec3,
    pub(crate) axis: Vec3,
    pub(crate) degrees: f32,
    /// Without [`Origins::shift`].
    pub(crate) translation: Vec3,
}

impl Stand {
    pub(crate) const ORIGIN: Self = Self { scale: Vec3::ONE, axis: Vec3::Y, degrees: 0.0, translation: Vec3::ZERO };

    pub(crate) fn matrix(&self, origins: &Origins) -> Mat4 {
        let turn = rotation(self.axis, self.degrees);
        let matrix = Mat4::from_scale_rotation_translation(self.scale, turn, self.translation);
        let fine = fine_rotation(self.axis, self.degrees);
        origins.place(matrix, |p| fine * (self.scale.as_dvec3() * p))
    }
}

impl<'s> Keys<'s> {
    /// Takes the keys of motion out of a table.
    pub(crate) fn read(t: &mut Table<'s>) -> Result<Option<Self>, SceneError> {
        let (keys, interpolate, repeats) = (t.get("keys"), t.get("interpolate"), t.get("loop"));
        let Some(place) = keys else {
            return match interpolate.or(repeats) {
                Some(lonely) => Err(lonely.error("there are no keys")),
                None => Ok(None),
            };
        };
        let smooth = match interpolate {
            None => false,
            Some(v) => match v.string()? {
                "linear" => false,
                "smooth" => true,
                other => return Err(v.error(format!("found \"{other}\": expected \"linear\" or \"smooth\""))),
            },
        };
        let repeats = repeats.map_or(Ok(false), |v| v.boolean())?;
        let (mut times, mut tables) = (Vec::new(), Vec::new());
        for key in place.elements("[{ time = 0, … }, …]")? {
            let mut t = key.table()?;
            let value = t.require("time")?;
            let time = value.number()?;
            if !(0.0..=MAX_SECONDS).contains(&time) {
                return Err(value.error(format!("{time} must lie between 0 and {MAX_SECONDS} seconds")));
            }
            if times.last().is_some_and(|&last| time <= last) {
                return Err(value.error(format!("{time} is not later than the key before")));
            }
            times.push(time);
            tables.push(t);
        }
        let (Some(&first), Some(&last)) = (times.first(), times.last()) else {
            return Err(place.error("expected at least one key"));
        };
        Ok(Some(Self { place, times, tables, smooth, clock: Clock { first, last, repeats } }))
    }

    pub(crate) fn error(&self, message: impl std::fmt::Display) -> SceneError {
        self.place.error(message)
    }

    /// The keys that have a value, with their times; the first one has `own` where it says nothing.
    fn values<T>(
        &mut self,
        key: &'static str,
        own: T,
        read: impl Fn(Value<'s>) -> Result<T, SceneError>,
    ) -> Result<(Vec<f32>, Vec<T>), SceneError> {
        let (mut times, mut values, mut own) = (Vec::new(), Vec::new(), Some(own));
        for (table, &time) in self.tables.iter_mut().zip(&self.times) {
            let given = table.get(key).map(&read).transpose()?;
            if let Some(value) = given.or_else(|| own.take().filter(|_| values.is_empty())) {
                times.push(time);
                values.push(value);
            }
        }
        Ok((times, values))
    }

    /// Whether a track through these times repeats: its last key is followed by its first.
    fn closed(&self, times: &[f32]) -> bool {
        self.clock.repeats && times.len() > 1 && times.last() == Some(&self.clock.last)
    }

    fn track(&self, times: Vec<f32>, values: &[f32], width: usize) -> Track {
        if self.smooth {
            let closed = self.closed(&times);
            Track::smooth(times, values, width, closed, Meaning::Numbers)
        } else {
            Track::new(times, values.to_vec(), width, Interpolation::Linear, Meaning::Numbers)
        }
    }

    /// Vectors without `shift`; `own` is without it.
    fn vectors(&mut self, key: &'static str, own: Vec3, shift: DVec3) -> Result<Track, SceneError> {
        let (times, values) = self.values(key, own, |v| {
            let p = v.relative(shift)?;
            if p.abs().max_element() > MAX_COORDINATE {
                return Err(v.error(format!("{p}: coordinates must lie within ±1e9")));
            }
            Ok(p)
        })?;
        Ok(self.track(times, &flat(&values), 3))
    }

    fn finish(self) -> Result<Clock, SceneError> {
        for table in self.tables {
            table.finish()?;
        }
        Ok(self.clock)
    }

    /// The placement that the keys of an object describe; `check` refuses scales that don't suit it.
    pub(crate) fn placement(
        mut self,
        own: Stand,
        origins: Origins,
        check: impl Fn(Value<'s>, Vec3) -> Result<(), SceneError>,
    ) -> Result<Placement, SceneError> {
        let (times, scales) = self.values("scale", own.scale, |v| {
            let scale = read_scale(v)?;
            check(v, scale).map(|()| scale)
        })?;
        let scale = self.track(times, &flat(&scales), 3);
        self.rigid(own, scale, origins)
    }

    /// The placement that the keys of a light describe: it turns and moves only.
    pub(crate) fn rigid_placement(self, origins: Origins) -> Result<Placement, SceneError> {
        let own = Stand { translation: relative(DVec3::ZERO, origins.shift()), ..Stand::ORIGIN };
        self.rigid(own, Track::constant(&[1.0; 3]), origins)
    }

    fn rigid(mut self, own: Stand, scale: Track, origins: Origins) -> Result<Placement, SceneError> {
        let translation = self.vectors("translate", own.translation, origins.shift())?;
        let (times, turns) = self.values("rotate", (own.axis, own.degrees), read_rotation)?;
        let turn = if self.smooth {
            if one_axis(&turns).is_none() {
                for pair in turns.windows(2) {
                    if let Some((_, d)) = one_axis(pair)
                        && (d[1] - d[0]).abs() > 180.0
                    {
                        return Err(self.place.error(
                            "a smooth rotation about changing axes turns by 180° at most from key to key: add keys",
                        ));
                    }
                }
            }
            smooth_turn(&times, &turns, self.closed(&times))
        } else {
            linear_turn(&times, &turns)
        };
        let clock = self.finish()?;
        Ok(Placement::Keys(Box::new(Keyed { clock, scale, turn, translation, origins })))
    }

    /// The camera's way, relative to an origin. Every key is a valid view.
    pub(crate) fn camera(mut self, own: Camera, origin: DVec3) -> Result<CameraKeys, SceneError> {
        let place = self.place;
        let eye = self.vectors("eye", own.eye, origin)?;
        let target = self.vectors("target", own.target, origin)?;
        let up = self.vectors("up", own.up, DVec3::ZERO)?;
        let projection = match own.projection {
            Projection::Perspective { vertical_fov } => {
                let (times, fovs) = self.values("fov", vertical_fov, |v| v.number().map(f32::to_radians))?;
                ProjectionKeys::Perspective(self.track(times, &fovs, 1))
            }
            Projection::Orthographic { height } => {
                let (times, heights) = self.values("height", height, |v| v.number())?;
                ProjectionKeys::Orthographic(self.track(times, &heights, 1))
            }
            Projection::Panoramic => ProjectionKeys::Panoramic,
        };
        let times = self.times.clone();
        let keys = CameraKeys { clock: self.finish()?, eye, target, up, projection };
        for time in times {
            keys.at(time).validate().map_err(|e| place.error(format!("at {time} s: {e}")))?;
        }
        Ok(keys)
    }
}

/// One number or three, none of them 0.
pub(crate) fn read_scale(v: Value<'_>) -> Result<Vec3, SceneError> {
    let s = v.number().map(Vec3::splat).or_else(|_| v.vec3())?;
    if s.abs().min_element() > 0.0 { Ok(s) } else { Err(v.error("a scale must not be 0")) }
}

/// `{ axis = [x, y, z], degrees = d }`.
pub(crate) fn read_rotation(v: Value<'_>) -> Result<(Vec3, f32), SceneError> {
    let mut t = v.table()?;
    let axis = t.require("axis")?.direction()?;
    let degrees = t.require("degrees")?.number()?;
    t.finish()?;
    Ok((axis, degrees))
}

fn flat(vectors: &[Vec3]) -> Vec<f32> {
    vectors.iter().flat_map(|v| v.to_array()).collect()
}
