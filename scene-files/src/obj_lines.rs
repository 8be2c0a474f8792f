//! The lines of an OBJ file, read on all threads: runs of lines, each with lists of its own.

use crate::decimal;
use glam::{DVec3, Vec2, Vec3};
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::BTreeSet;

/// Bytes of a run of lines.
const RUN: usize = 1 << 18;
/// No number is written there.
pub(crate) const ABSENT: i32 = i32::MIN;

/// Elements that are not read, and their names.
pub(crate) const UNREAD: [(&str, &str); 4] = [("p", "point"), ("l", "line"), ("curv", "curve"), ("surf", "surface")];

/// Words that change no triangle alone: groups, the parts of curves and surfaces, and how another program is to draw them.
const HARMLESS: &str = "o g mg vp cstype deg bmat step parm trim hole scrv sp end con curv2 bevel c_interp d_interp lod shadow_obj trace_obj \
    ctech stech";
/// The most other words of a run that are named, and letters of each.
const MOST_UNKNOWN: usize = 8;
const MOST_LETTERS: usize = 24;

/// Some lines of a file.
#[derive(Default)]
pub(crate) struct Run<'t> {
    pub(crate) positions: Vec<Vec3>,
    /// Of the first positions, until one has none.
    pub(crate) colors: Vec<Vec3>,
    pub(crate) normals: Vec<Vec3>,
    pub(crate) uvs: Vec<Vec2>,
    /// Of all faces: the numbers of position, texture coordinates and normal as written.
    pub(crate) corners: Vec<[i32; 3]>,
    pub(crate) faces: Vec<FaceLine>,
    /// Positions with a colour.
    pub(crate) colored: usize,
    /// Elements of each kind that is not read.
    pub(crate) unread: [usize; UNREAD.len()],
    pub(crate) others: Vec<Statement<'t>>,
    /// First words of lines of no known kind.
    pub(crate) unknown: BTreeSet<String>,
    /// Lines, which are counted in the file.
    pub(crate) lines: usize,
    /// The first line that cannot be read, after which nothing is: its number in the run, and why.
    pub(crate) fault: Option<(usize, String)>,
}

/// A face.
pub(crate) struct FaceLine {
    /// The end of its corners in the list of all.
    pub(crate) end: usize,
    /// How many positions, texture coordinates and normals the run has before it.
    pub(crate) before: [u32; 3],
    /// Number of the line in the run, from 1.
    pub(crate) line: u32,
}

/// A line of another kind.
pub(crate) struct Statement<'t> {
    /// Faces of the run before it.
    pub(crate) faces: usize,
    pub(crate) text: Cow<'t, str>,
}

/// Reads all lines of a text without carriage returns. Positions are relative to an origin.
pub(crate) fn read(text: &str, origin: DVec3) -> Vec<Run<'_>> {
    runs(text).into_par_iter().map(|text| Run::read(text, origin)).collect()
}

/// Whether the text continues in the next line.
fn continues(line: &str) -> bool {
    line.trim_end().ends_with('\\')
}

/// A line without the backslash that continues it in the next one. A comment ends with its line, and where names are, which may be paths,
/// the backslash stands alone.
fn continued(line: &str) -> Option<&str> {
    const NAMES: [&str; 6] = ["o", "g", "usemtl", "mtllib", "usemap", "maplib"];
    let head = line.trim_end().strip_suffix('\\')?;
    let is_alone = head.is_empty() || head.ends_with(char::is_whitespace);
    let has_names =
        line.split_whitespace().next().is_some_and(|word| NAMES.iter().any(|name| name.eq_ignore_ascii_case(word)));
    (!head.contains('#') && (is_alone || !has_names)).then_some(head)
}

/// Whether its last byte does not say that it ends there.
fn may_continue(line: &str) -> bool {
    line.as_bytes().last().is_some_and(|last| matches!(last, b'\\' | 0..=b' ' | 128..))
}

/// A text in parts that end with lines.
fn runs(text: &str) -> Vec<&str> {
    let mut parts = Vec::with_capacity(text.len() / RUN + 1);
    let mut rest = text;
    while rest.len() > RUN {
        // A byte of a newline is never inside of another character.
        let bytes = rest.as_bytes();
        let mut end = RUN;
        loop {
            let Some(next) = bytes[end..].iter().position(|b| *b == b'\n') else {
                end = rest.len();
                break;
            };
            let line = bytes[..end + next].iter().rposition(|b| *b == b'\n').map_or(0, |place| place + 1);
            end += next + 1;
            if !continues(&rest[line..end - 1]) {
                break;
            }
        }
        let (part, after) = rest.split_at(end);
        parts.push(part);
        rest = after;
    }
    parts.push(rest);
    parts
}

impl<'t> Run<'t> {
    fn read(text: &'t str, origin: DVec3) -> Self {
        let mut run = Self::default();
        let mut lines = text.split('\n');
        // A run ends with a newline, after which there is no further line.
        let newlines = text.bytes().filter(|b| *b == b'\n').count();
        let count = newlines + usize::from(!text.ends_with('\n'));
        while run.lines < count {
            let Some(line) = lines.next() else { break };
            run.lines += 1;
            let first = run.lines;
            let mut line = Cow::Borrowed(line);
            while may_continue(&line)
                && let Some(head) = continued(&line)
            {
                line = Cow::Owned(format!("{head} {}", lines.next().unwrap_or("")));
                run.lines += 1;
            }
            if let Err(fault) = run.statement(line, first, origin) {
                run.fault = Some((first, fault));
                break;
            }
        }
        run
    }

    /// Reads a line. One that was written as several is not kept in the text.
    fn statement(&mut self, line: Cow<'t, str>, number: usize, origin: DVec3) -> Result<(), String> {
        if self.plain_statement(&line, number, origin) {
            return Ok(());
        }
        let content = line.split('#').next().unwrap_or("").trim_start();
        let end = content.find(char::is_whitespace).unwrap_or(content.len());
        let (word, rest) = content.split_at(end);
        let word = &*word.to_ascii_lowercase();
        match word {
            "v" | "vn" | "vt" => self.list(word, rest, origin)?,
            // The older word of the format.
            "f" | "fo" => {
                rest.split_whitespace().try_for_each(|word| self.corner(word))?;
                self.end_face(number);
            }
            "usemtl" | "s" | "mtllib" => self.others.push(Statement { faces: self.faces.len(), text: line }),
            _ => {
                if let Some(kind) = UNREAD.iter().position(|(unread, _)| *unread == word) {
                    self.unread[kind] += 1;
                } else if self.unknown.len() < MOST_UNKNOWN
                    && !word.is_empty()
                    && HARMLESS.split(' ').all(|known| known != word)
                {
                    self.unknown.insert(word.chars().take(MOST_LETTERS).collect());
                }
            }
        }
        Ok(())
    }

    /// Reads a line as most are: two or three numbers, or a face, in ASCII. Returns whether it is one; nothing is read of others.
    fn plain_statement(&mut self, line: &str, number: usize, origin: DVec3) -> bool {
        if !line.is_ascii() {
            return false;
        }
        let mut words = Words(line);
        match words.next() {
            Some(word @ ("v" | "vn" | "vt")) if word != "v" || origin == DVec3::ZERO => {
                let mut next = || words.next().and_then(decimal::parse);
                let (Some(x), Some(y)) = (next(), next()) else { return false };
                let z = if word == "vt" { Some(0.0) } else { next() };
                let (Some(z), None) = (z, words.next()) else { return false };
                match word {
                    "v" => self.positions.push(Vec3::new(x, y, z)),
                    "vn" => self.normals.push(Vec3::new(x, y, z)),
                    _ => self.uvs.push(Vec2::new(x, 1.0 - y)),
                }
            }
            Some("f") => {
                let before = self.corners.len();
                for word in words {
                    let Some(corner) = plain_corner(word) else {
                        self.corners.truncate(before);
                        return false;
                    };
                    self.corners.push(corner);
                }
                self.end_face(number);
            }
            _ => return false,
        }
        true
    }

    /// Adds a face of the corners since the last one.
    fn end_face(&mut self, number: usize) {
        let before = [self.positions.len(), self.uvs.len(), self.normals.len()].map(|count| count as u32);
        self.faces.push(FaceLine { end: self.corners.len(), before, line: number as u32 });
    }

    fn list(&mut self, word: &str, rest: &str, origin: DVec3) -> Result<(), String> {
        let mut words = rest.split_whitespace();
        match word {
            "v" => {
                let (position, color) = vertex(words, origin)?;
                self.colored += usize::from(color.is_some());
                self.colors.extend(color.filter(|_| self.colors.len() == self.positions.len()));
                self.positions.push(position);
            }
            "vn" => self.normals.push(Vec3::from_array(numbers(&mut words)?)),
            _ => self.uvs.push(texture_coordinates(words)?),
        }
        Ok(())
    }

    /// Reads `p`, `p/t`, `p//n` or `p/t/n`.
    fn corner(&mut self, word: &str) -> Result<(), String> {
        let unreadable = || format!("cannot read face corner '{word}'");
        // Numbers that no list has stay such numbers.
        let number = |field: &str| -> Result<i32, String> {
            let number: i64 = field.parse().map_err(|_| unreadable())?;
            Ok(number.clamp(-i64::from(i32::MAX), i64::from(i32::MAX)) as i32)
        };
        let mut fields = word.split('/');
        let p = number(fields.next().unwrap_or(""))?;
        let t = match fields.next() {
            None | Some("") => ABSENT,
            // Files that name coordinates that they do not have are drawn without.
            Some(field) => number(field).unwrap_or(ABSENT),
        };
        let n = match fields.next() {
            None | Some("") => ABSENT,
            Some(field) => number(field)?,
        };
        if fields.next().is_some_and(|f| !f.is_empty()) {
            return Err(unreadable());
        }
        self.corners.push([p, t, n]);
        Ok(())
    }
}

pub(crate) fn number(word: &str) -> Result<f32, String> {
    decimal::parse(word).ok_or_else(|| format!("cannot read number '{word}'"))
}

/// Whether a byte is white space in a line that is ASCII.
fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t'..=b'\r')
}

/// The words of a text that is ASCII: those of `str::split_whitespace`.
#[derive(Clone)]
struct Words<'t>(&'t str);

impl<'t> Iterator for Words<'t> {
    type Item = &'t str;

    fn next(&mut self) -> Option<&'t str> {
        let bytes = self.0.as_bytes();
        let begin = bytes.iter().position(|b| !is_blank(*b))?;
        let end = bytes[begin..].iter().position(|b| is_blank(*b)).map_or(bytes.len(), |length| begin + length);
        let (word, rest) = (&self.0[begin..end], &self.0[end..]);
        self.0 = rest;
        Some(word)
    }
}

/// A corner of up to three whole numbers of up to nine digits; `None` for others, which may be readable.
fn plain_corner(word: &str) -> Option<[i32; 3]> {
    let mut corner = [ABSENT; 3];
    let mut bytes = word.as_bytes();
    for (k, number) in corner.iter_mut().enumerate() {
        let (is_negative, digits) = match bytes {
            [b'-', rest @ ..] => (true, rest),
            _ => (false, bytes),
        };
        let length = digits.iter().take_while(|b| b.is_ascii_digit()).count();
        let is_number = (1..=9).contains(&length);
        if is_number {
            let size = digits[..length].iter().fold(0, |sum, digit| 10 * sum + i32::from(digit - b'0'));
            *number = if is_negative { -size } else { size };
        } else if length > 9 || is_negative || k == 0 {
            return None;
        }
        match digits[length..] {
            [] => return Some(corner),
            [b'/', ref rest @ ..] => bytes = rest,
            _ => return None,
        }
    }
    None
}

fn numbers<'w>(words: &mut impl Iterator<Item = &'w str>) -> Result<[f32; 3], String> {
    let mut out = [0.0; 3];
    for slot in &mut out {
        *slot = number(words.next().ok_or("expected three numbers")?)?;
    }
    Ok(out)
}

/// `u`, `u v` or `u v w`; v counts from the lower edge of the image.
fn texture_coordinates<'w>(mut words: impl Iterator<Item = &'w str>) -> Result<Vec2, String> {
    let u = number(words.next().ok_or("expected a number")?)?;
    let v = words.next().map_or(Ok(0.0), number)?;
    Ok(Vec2::new(u, 1.0 - v))
}

/// `x y z`, `x y z w` (homogeneous) or `x y z r g b`, perhaps with alpha, which means nothing: a position, relative to an origin, and an
/// sRGB colour of any range.
fn vertex<'w>(words: impl Iterator<Item = &'w str> + Clone, origin: DVec3) -> Result<(Vec3, Option<Vec3>), String> {
    let mut more = words.clone().skip(3);
    let color = match [more.next(), more.next(), more.next()] {
        [Some(r), Some(g), Some(b)] => Some(Vec3::new(number(r)?, number(g)?, number(b)?)),
        _ => None,
    };
    Ok((position(words, origin)?, color))
}

fn position<'w>(mut words: impl Iterator<Item = &'w str> + Clone, origin: DVec3) -> Result<Vec3, String> {
    let fine = words.clone();
    let p = Vec3::from_array(numbers(&mut words)?);
    let (weight, mut is_one) = (words.next().map(number).transpose()?, true);
    for word in words {
        number(word)?;
        is_one = false;
    }
    if origin != DVec3::ZERO {
        let fine: Vec<f64> = fine.filter_map(|word| word.parse().ok()).collect();
        let w = if let [_, _, _, w] = fine[..] { w } else { 1.0 };
        return Ok((DVec3::from_slice(&fine) / w - origin).as_vec3());
    }
    match weight.filter(|_| is_one) {
        Some(w) if w != 0.0 => Ok(p / w),
        Some(_) => Err("vertex weight is 0".to_owned()),
        None => Ok(p),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_end_with_lines_that_do_not_continue() {
        let lines: Vec<String> = (0..60_000)
            .map(|k| match k % 5 {
                0 => format!("v {k} 1 2 \\"),
                1 => "3".to_owned(),
                2 => format!("# ä {k}"),
                _ => format!("f 1 {k} 2"),
            })
            .collect();
        let text = lines.join("\n");
        let parts = runs(&text);
        assert!(parts.len() > 1 && parts.concat() == text);
        for part in &parts[..parts.len() - 1] {
            let last = part.trim_end_matches('\n').rsplit('\n').next().unwrap_or_default();
            assert!(part.ends_with('\n') && !continues(last), "{last}");
        }
        let read = read(&text, DVec3::ZERO);
        assert_eq!(read.iter().map(|run| run.lines).sum::<usize>(), lines.len());
        assert_eq!(read.iter().map(|run| run.positions.len()).sum::<usize>(), 12_000);
        assert_eq!(read.iter().map(|run| run.faces.len()).sum::<usize>(), 24_000);
    }

    #[test]
    fn comments_and_paths_end_with_their_lines() {
        let text = "# C:\\models\\\nv 1 2 3\no C:\\x\\\nv 4 5 6 # \\\nv 7 8 \\\n9\ng a \\\nb\nf 1 2\\\n 3\n";
        let run = Run::read(text, DVec3::ZERO);
        assert_eq!((run.positions.len(), run.corners.len(), run.lines), (3, 3, 10), "{:?}", run.positions);
        assert_eq!(run.positions[2], Vec3::new(7.0, 8.0, 9.0));
        assert!(run.fault.is_none());
    }

    /// A comment that is not ASCII lets a line be read in the general way.
    #[test]
    fn plain_lines_are_read_as_all_others() {
        let lines = [
            "v 1 2 3",
            " v\t-1.5\x0b2e3  .5 ",
            "v 1 2",
            "v 1 2 3 4",
            "v 1 2 3 0",
            "v 1 2 3 .1 .2 .3",
            "v 1 2 3 .1 .2 .3 1",
            "v 1 x 3",
            "v 1 2 3 x",
            "v",
            "v1 2 3",
            "vn 0 0 1",
            "vn 0 1",
            "vn 1 2 3 4",
            "vt .25 .75",
            "vt .5",
            "vt .1 .2 .3",
            "vt .1 .2 x",
            "vt",
            "vp 1 2 3",
            "f 1 2 3",
            "f 1/2 3/4 -5/-6",
            "f 1//2 3//4 5//6",
            "f 1/2/3 4/5/6 7/8/9 1/2/3",
            "f",
            "f 1 2",
            "f 1/ 2/ 3/",
            "f 1/2/ 3 4",
            "f 1/2/3/ 4 5",
            "f 1/2/3/4 5 6",
            "f /2 3 4",
            "f 1/x 2 3",
            "f 1//x 2 3",
            "f 1/-/2 3 4",
            "f - 1 2",
            "f -0 1 2",
            "f +1 2 3",
            "f 0000000001 2 3",
            "f 99999999999 1 2",
            "f 1.5 2 3",
            "f 1e0 2 3",
            "s 1",
            "usemtl a b",
            "o f 1 2 3",
            "",
        ];
        let lists = |run: Run<'_>| {
            let faces: Vec<_> = run.faces.iter().map(|face| (face.end, face.before, face.line)).collect();
            (
                run.positions,
                run.colors,
                run.normals,
                run.uvs,
                run.corners,
                faces,
                run.others.len(),
                run.lines,
                run.fault,
            )
        };
        for origin in [DVec3::ZERO, DVec3::X] {
            for line in lines {
                let [own, wanted] =
                    [line.to_owned(), format!("{line} # ä")].map(|line| format!("vn 1 0 0\n{line}\nf 7 8 9"));
                assert_eq!(lists(Run::read(&own, origin)), lists(Run::read(&wanted, origin)), "{line}");
            }
        }
    }

    #[test]
    fn the_first_fault_ends_a_run() {
        let run = Run::read("v 1 2 3\nf 1 2 3\nv 1 x 3\nf 1 y\n", DVec3::ZERO);
        assert_eq!(run.fault, Some((3, "cannot read number 'x'".to_owned())));
        assert_eq!((run.faces.len(), run.positions.len()), (1, 1));
    }
}
