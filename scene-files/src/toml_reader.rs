//! TOML with places: every value knows its line, and every message names it.

use glam::{DVec3, Mat3, Mat4, Vec2, Vec3, Vec4};
use lobe_core::Sphere;
use scene::{MAX_COORDINATE, SceneError};
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A text file that messages refer to.
#[derive(Clone, Copy)]
pub(crate) struct Source<'a> {
    pub(crate) path: &'a Path,
    pub(crate) text: &'a str,
}

impl Source<'_> {
    /// An error at a byte offset.
    pub(crate) fn error(&self, offset: usize, message: impl Into<String>) -> SceneError {
        let mut offset = offset.min(self.text.len());
        while !self.text.is_char_boundary(offset) {
            offset -= 1;
        }
        let before = &self.text[..offset];
        let line = before.matches('\n').count() + 1;
        let column = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
        SceneError::Parse { path: self.path.to_owned(), line, column, message: message.into() }
    }
}

/// A value, the place that it stands at, and its name in messages.
#[derive(Clone, Copy)]
pub(crate) struct Value<'s> {
    source: Source<'s>,
    value: &'s Spanned<DeValue<'s>>,
    name: &'s str,
}

impl<'s> Value<'s> {
    pub(crate) fn error(&self, message: impl std::fmt::Display) -> SceneError {
        self.source.error(self.value.span().start, format!("{}: {message}", self.name))
    }

    fn expected<T>(&self, what: &str) -> Result<T, SceneError> {
        let found = match self.value.get_ref() {
            DeValue::String(_) => "a string",
            DeValue::Integer(_) | DeValue::Float(_) => "a number",
            DeValue::Boolean(_) => "true or false",
            DeValue::Datetime(_) => "a date",
            DeValue::Array(_) => "an array",
            DeValue::Table(_) => "a table",
        };
        Err(self.error(format!("expected {what}, found {found}")))
    }

    /// The digits of a number, as a whole one or with a point.
    fn digits(&self) -> Result<String, SceneError> {
        match self.value.get_ref() {
            DeValue::Integer(i) => match i64::from_str_radix(i.as_str(), i.radix()) {
                Ok(whole) => Ok(whole.to_string()),
                Err(_) => Err(self.error(format!("{} is out of range", i.as_str()))),
            },
            DeValue::Float(f) => Ok(f.as_str().to_owned()),
            _ => self.expected("a number"),
        }
    }

    /// A finite number.
    pub(crate) fn number(&self) -> Result<f32, SceneError> {
        let text = self.digits()?;
        match text.parse::<f32>() {
            Ok(x) if x.is_finite() => Ok(x),
            _ => Err(self.error(format!("{text} is not a finite number of single precision"))),
        }
    }

    /// The same in double precision.
    fn fine_number(&self) -> Result<f64, SceneError> {
        self.number()?;
        let text = self.digits()?;
        text.parse().map_err(|_| self.error(format!("{text} is not a number")))
    }

    pub(crate) fn positive(&self) -> Result<f32, SceneError> {
        let x = self.number()?;
        if x > 0.0 { Ok(x) } else { Err(self.error(format!("{x} must be greater than 0"))) }
    }

    pub(crate) fn whole(&self, from: u32, to: u32) -> Result<u32, SceneError> {
        let range = format!("a whole number from {from} to {to}");
        let DeValue::Integer(i) = self.value.get_ref() else { return self.expected(&range) };
        match i64::from_str_radix(i.as_str(), i.radix()).ok().and_then(|x| u32::try_from(x).ok()) {
            Some(x) if (from..=to).contains(&x) => Ok(x),
            _ => Err(self.error(format!("{} is not {range}", i.as_str()))),
        }
    }

    pub(crate) fn string(&self) -> Result<&'s str, SceneError> {
        match self.value.get_ref() {
            DeValue::String(s) => Ok(s),
            _ => self.expected("a string"),
        }
    }

    pub(crate) fn boolean(&self) -> Result<bool, SceneError> {
        match self.value.get_ref() {
            DeValue::Boolean(b) => Ok(*b),
            _ => self.expected("true or false"),
        }
    }

    pub(crate) fn elements(&self, what: &str) -> Result<Vec<Self>, SceneError> {
        let DeValue::Array(array) = self.value.get_ref() else { return self.expected(what) };
        Ok(array.iter().map(|value| Self { value, ..*self }).collect())
    }

    fn numbers<const N: usize>(&self, what: &str) -> Result<[f32; N], SceneError> {
        let elements = self.elements(what)?;
        if elements.len() != N {
            return Err(self.error(format!("expected {what}, found {} values", elements.len())));
        }
        let mut out = [0.0; N];
        for (slot, element) in out.iter_mut().zip(elements) {
            *slot = element.number()?;
        }
        Ok(out)
    }

    pub(crate) fn vec2(&self) -> Result<Vec2, SceneError> {
        self.numbers("[x, y]").map(Vec2::from_array)
    }

    /// `[x, y]`, or one number for both.
    pub(crate) fn vec2_or_number(&self) -> Result<Vec2, SceneError> {
        match self.value.get_ref() {
            DeValue::Integer(_) | DeValue::Float(_) => self.number().map(Vec2::splat),
            _ => Ok(Vec2::from_array(self.numbers("[x, y] or one number")?)),
        }
    }

    pub(crate) fn vec3(&self) -> Result<Vec3, SceneError> {
        self.numbers("[x, y, z]").map(Vec3::from_array)
    }

    /// A position in double precision.
    pub(crate) fn place(&self) -> Result<DVec3, SceneError> {
        self.vec3()?;
        let of = |e: &Self| e.fine_number();
        let [x, y, z] = self.elements("[x, y, z]")?[..] else { return self.expected("[x, y, z]") };
        Ok(DVec3::new(of(&x)?, of(&y)?, of(&z)?))
    }

    /// A position relative to an origin.
    pub(crate) fn relative(&self, origin: DVec3) -> Result<Vec3, SceneError> {
        // Rounded once.
        if origin == DVec3::ZERO { self.vec3() } else { Ok(crate::origin::relative(self.place()?, origin)) }
    }

    pub(crate) fn nonzero_vec3(&self) -> Result<Vec3, SceneError> {
        let v = self.vec3()?;
        if v.length() > 1e-18 { Ok(v) } else { Err(self.error("vector has length zero")) }
    }

    /// Half a side of a flat shape.
    fn half_side(&self) -> Result<Vec3, SceneError> {
        let v = self.nonzero_vec3()?;
        if v.abs().max_element() > MAX_COORDINATE {
            return Err(self.error(format!("half a side is {:.3e} long: expected at most 1e9", v.as_dvec3().length())));
        }
        Ok(v)
    }

    /// The half sides `u` and `v` of a parallelogram.
    pub(crate) fn half_sides(u: &Self, v: &Self) -> Result<[Vec3; 2], SceneError> {
        let sides = [u.half_side()?, v.half_side()?];
        let [a, b] = sides.map(|side| side.as_dvec3().normalize());
        if a.cross(b).length() < 1e-6 { Err(v.error("u and v are parallel")) } else { Ok(sides) }
    }

    /// A direction of any length, as a unit vector.
    pub(crate) fn direction(&self) -> Result<Vec3, SceneError> {
        let v = self.vec3()?;
        let (length, fine) = (v.length(), v.as_dvec3());
        if length > 1e-18 && length.is_finite() {
            Ok(v.normalize())
        } else if fine.length() > 0.0 {
            // Its square leaves single precision.
            Ok(fine.normalize().as_vec3())
        } else {
            Err(self.error("vector has length zero"))
        }
    }

    /// `[r, g, b]`, or one number for a grey; not negative.
    pub(crate) fn color(&self) -> Result<Vec3, SceneError> {
        let c = match self.value.get_ref() {
            DeValue::Array(_) => Vec3::from_array(self.numbers("[r, g, b] or one number")?),
            DeValue::Integer(_) | DeValue::Float(_) => Vec3::splat(self.number()?),
            _ => return self.expected("[r, g, b] or one number"),
        };
        if c.min_element() < 0.0 { Err(self.error(format!("{c} must not be negative"))) } else { Ok(c) }
    }

    pub(crate) fn mat3(&self) -> Result<Mat3, SceneError> {
        let what = "three rows of three numbers";
        let rows = self.elements(what)?;
        let [a, b, c] = rows[..] else { return Err(self.error(format!("expected {what}"))) };
        let row = |r: Value<'_>| r.numbers(what).map(Vec3::from_array);
        Ok(Mat3::from_cols(row(a)?, row(b)?, row(c)?).transpose())
    }

    pub(crate) fn mat4(&self) -> Result<Mat4, SceneError> {
        let what = "four rows of four numbers";
        let rows = self.elements(what)?;
        let [a, b, c, d] = rows[..] else { return Err(self.error(format!("expected {what}"))) };
        let row = |r: Value<'_>| r.numbers(what).map(Vec4::from_array);
        let m = Mat4::from_cols(row(a)?, row(b)?, row(c)?, row(d)?).transpose();
        if m.row(3) == Vec4::W { Ok(m) } else { Err(self.error("the last row must be [0, 0, 0, 1]")) }
    }

    /// The translation of a matrix in double precision.
    pub(crate) fn translation(&self) -> Result<DVec3, SceneError> {
        self.mat4()?;
        let mut column = DVec3::ZERO;
        for (k, row) in self.elements("rows")?.iter().take(3).enumerate() {
            column[k] = row.elements("numbers")?[3].fine_number()?;
        }
        Ok(column)
    }

    /// The centre of the first of `[[x, y, z, radius], …]`, in double precision.
    pub(crate) fn first_place(&self) -> Result<DVec3, SceneError> {
        self.spheres(DVec3::ZERO)?;
        let mut place = DVec3::ZERO;
        for (k, number) in self.elements("spheres")?[0].elements("numbers")?.iter().take(3).enumerate() {
            place[k] = number.fine_number()?;
        }
        Ok(place)
    }

    /// `[[x, y, z, radius], …]`, at least one; relative to an origin.
    pub(crate) fn spheres(&self, origin: DVec3) -> Result<Vec<Sphere>, SceneError> {
        let what = "[[x, y, z, radius], …]";
        let elements = self.elements(what)?;
        if elements.is_empty() {
            return Err(self.error("expected at least one sphere"));
        }
        let sphere = |e: Self| {
            let [x, y, z, radius] = e.numbers("[x, y, z, radius]")?;
            let mut center = Vec3::new(x, y, z);
            if origin != DVec3::ZERO {
                for (k, number) in e.elements("numbers")?.iter().take(3).enumerate() {
                    center[k] = (number.fine_number()? - origin[k]) as f32;
                }
            }
            if radius > 0.0 {
                Ok(Sphere { center, radius })
            } else {
                Err(e.error(format!("radius {radius} must be greater than 0")))
            }
        };
        elements.into_iter().map(sphere).collect()
    }

    pub(crate) fn is_string(&self) -> bool {
        matches!(self.value.get_ref(), DeValue::String(_))
    }

    pub(crate) fn table(&self) -> Result<Table<'s>, SceneError> {
        match self.value.get_ref() {
            DeValue::Table(table) => Ok(Table::new(self.source, self.value.span().start, self.name, table)),
            _ => self.expected("a table"),
        }
    }
}

/// A table whose keys are read one by one; [`finish`](Self::finish) refuses keys that were not read.
pub(crate) struct Table<'s> {
    source: Source<'s>,
    at: usize,
    name: &'s str,
    table: &'s DeTable<'s>,
    asked: Vec<&'static str>,
}

impl<'s> Table<'s> {
    pub(crate) fn new(source: Source<'s>, at: usize, name: &'s str, table: &'s DeTable<'s>) -> Self {
        Self { source, at, name, table, asked: Vec::new() }
    }

    /// An error at the head of the table.
    pub(crate) fn error(&self, message: impl std::fmt::Display) -> SceneError {
        self.source.error(self.at, format!("{}: {message}", self.name))
    }

    pub(crate) fn get(&mut self, key: &'static str) -> Option<Value<'s>> {
        self.asked.push(key);
        let value = self.table.get(key)?;
        Some(Value { source: self.source, value, name: key })
    }

    pub(crate) fn require(&mut self, key: &'static str) -> Result<Value<'s>, SceneError> {
        self.get(key).ok_or_else(|| self.missing(&[key], format!("key \"{key}\" is missing")))
    }

    /// An error at the key that was meant for one of `keys`, if one looks so, else at the head of the table.
    fn missing(&self, keys: &[&str], message: String) -> SceneError {
        let meant = |found: &str| keys.iter().any(|key| edits(found, key) <= key.len() / 3);
        let found = self.table.keys().find(|k| !self.asked.contains(&k.get_ref().as_ref()) && meant(k.get_ref()));
        match found {
            None => self.error(message),
            Some(k) => {
                let message = format!("{}: {message}: found the unknown key \"{}\"", self.name, k.get_ref());
                self.source.error(k.span().start, message)
            }
        }
    }

    /// All entries: for tables of named things.
    pub(crate) fn entries(&self) -> Vec<Value<'s>> {
        // Names in the order of the file, not of the alphabet.
        let mut all: Vec<_> = self
            .table
            .iter()
            .map(|(key, value)| Value { source: self.source, value, name: key.get_ref().as_ref() })
            .collect();
        all.sort_by_key(|v| v.value.span().start);
        all
    }

    /// The one key of `choices` that is present.
    pub(crate) fn one_of(&mut self, choices: &[&'static str]) -> Result<(&'static str, Value<'s>), SceneError> {
        let found: Vec<_> = choices.iter().filter_map(|&key| Some((key, self.get(key)?))).collect();
        match found[..] {
            [one] => Ok(one),
            [] => Err(self.missing(choices, format!("expected one of the keys {}", list(choices)))),
            [_, (key, second), ..] => {
                Err(second.error(format!("only one of {} may be given, \"{key}\" is too many", list(choices))))
            }
        }
    }

    /// Refuses keys that were not read.
    pub(crate) fn finish(self) -> Result<(), SceneError> {
        let unknown = self.table.keys().find(|key| !self.asked.contains(&key.get_ref().as_ref()));
        match unknown {
            None => Ok(()),
            Some(key) => Err(self.source.error(
                key.span().start,
                format!("{}: unknown key \"{}\": expected one of {}", self.name, key.get_ref(), list(&self.asked)),
            )),
        }
    }
}

impl<'s> Value<'s> {
    /// The key that the value stands under.
    pub(crate) const fn name(&self) -> &'s str {
        self.name
    }
}

fn list(keys: &[&str]) -> String {
    keys.iter().map(|k| format!("\"{k}\"")).collect::<Vec<_>>().join(", ")
}

/// The number of letters to insert, delete or replace to turn one word into the other (Levenshtein).
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, y) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(x != *y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}
