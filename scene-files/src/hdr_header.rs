//! Headers of Radiance pictures, of which the decoder knows one kind.
//!
//! Greg Ward, "Real Pixels", Graphics Gems II (1991), and the format's text: pixels are radiance times all that EXPOSURE and COLORCORR say.

use crate::exr_colors::to_srgb;
use glam::{Mat3, UVec2, Vec3};

/// Linear sRGB of CIE XYZ: IEC 61966-2-1.
pub(crate) const RGB_OF_XYZ: Mat3 = Mat3::from_cols(
    Vec3::new(3.240_454_2, -0.969_266, 0.055_643_4),
    Vec3::new(-1.537_138_5, 1.876_010_8, -0.204_025_9),
    Vec3::new(-0.498_531_4, 0.041_556, 1.057_225_2),
);

/// The words of a header that change how pixels are read.
pub(crate) struct HdrHeader {
    /// Products of all EXPOSURE and COLORCORR lines.
    factor: Vec3,
    is_xyz: bool,
    /// Whether rows go from the bottom to the top, and pixels from the right to the left.
    is_flipped: [bool; 2],
    /// Whether scan lines are columns.
    by_columns: bool,
    /// Across and down.
    size: UVec2,
    /// Lines that are not read, though they mean something.
    pub(crate) notes: Vec<String>,
}

impl HdrHeader {
    /// The header, and the same picture with the plainest header, whose scan lines the decoder takes as rows from the top. `None` for
    /// other formats.
    pub(crate) fn read(bytes: &[u8]) -> Option<Result<(Self, Vec<u8>), String>> {
        bytes.starts_with(b"#?").then(|| Self::parse(bytes))
    }

    fn parse(bytes: &[u8]) -> Result<(Self, Vec<u8>), String> {
        let mut header = Self {
            factor: Vec3::ONE,
            is_xyz: false,
            is_flipped: [false; 2],
            by_columns: false,
            size: UVec2::ZERO,
            notes: Vec::new(),
        };
        let mut rest = bytes;
        loop {
            let line = take_line(&mut rest).ok_or("the header has no end")?;
            if line.is_empty() {
                break;
            }
            header.line(&line)?;
        }
        let resolution = take_line(&mut rest).ok_or("the header has no size")?;
        let [lines, pixels] = header.resolution(&resolution)?;
        let mut plain = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {lines} +X {pixels}\n").into_bytes();
        plain.extend_from_slice(rest);
        Ok((header, plain))
    }

    /// Reads a variable. A line that begins with a blank is the history of the picture: what it says is in the pixels already.
    fn line(&mut self, line: &str) -> Result<(), String> {
        if line.starts_with([' ', '\t']) {
            return Ok(());
        }
        let Some((key, value)) = line.split_once('=') else { return Ok(()) };
        let value = value.trim();
        let numbers = || -> Vec<f32> { value.split_whitespace().filter_map(|word| word.parse().ok()).collect() };
        let usable = |x: &f32| *x > 0.0 && x.is_finite();
        let fault = || format!("cannot read {key}={value} of the header");
        match key.trim() {
            "FORMAT" => match value {
                "32-bit_rle_rgbe" => self.is_xyz = false,
                "32-bit_rle_xyze" => self.is_xyz = true,
                _ => return Err(format!("format {value}: expected 32-bit_rle_rgbe or 32-bit_rle_xyze")),
            },
            "EXPOSURE" => self.factor *= numbers().first().copied().filter(usable).ok_or_else(fault)?,
            "COLORCORR" => match numbers()[..] {
                [r, g, b] if [r, g, b].iter().all(usable) => self.factor *= Vec3::new(r, g, b),
                _ => return Err(fault()),
            },
            "PRIMARIES" if !is_usual(&numbers()) => self.notes.push(unread(key, value)),
            "GAMMA" if numbers() != [1.0] => self.notes.push(unread(key, value)),
            _ => {}
        }
        Ok(())
    }

    /// The numbers of scan lines and of pixels in each.
    fn resolution(&mut self, line: &str) -> Result<[u32; 2], String> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let fault = || format!("cannot read the size \"{line}\": expected -Y rows +X columns");
        let [first, lines, second, pixels] = words[..] else { return Err(fault()) };
        let number = |word: &str| word.parse::<u32>().map_err(|_| fault());
        let (lines, pixels) = (number(lines)?, number(pixels)?);
        self.by_columns = match (first, second) {
            ("-Y" | "+Y", "-X" | "+X") => false,
            ("-X" | "+X", "-Y" | "+Y") => true,
            _ => return Err(fault()),
        };
        let says = |word| first == word || second == word;
        self.is_flipped = [says("+Y"), says("-X")];
        self.size = if self.by_columns { UVec2::new(lines, pixels) } else { UVec2::new(pixels, lines) };
        Ok([lines, pixels])
    }

    /// Radiance, the top row first, of pixels in the order of the file, and a line about what is not as the file says.
    pub(crate) fn radiance(&self, mut pixels: Vec<Vec3>) -> (UVec2, Vec<Vec3>, Option<String>) {
        let UVec2 { x: width, y: height } = self.size;
        let note = if self.is_xyz { to_srgb(RGB_OF_XYZ, &mut pixels) } else { None };
        let scale = self.factor.recip();
        let [bottom_up, right_to_left] = self.is_flipped;
        let place = |x: u32, y: u32| {
            let x = if right_to_left { width - 1 - x } else { x };
            let y = if bottom_up { height - 1 - y } else { y };
            if self.by_columns { (x * height + y) as usize } else { (y * width + x) as usize }
        };
        let all = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        (self.size, all.map(|(x, y)| pixels[place(x, y)] * scale).collect(), note)
    }
}

fn unread(key: &str, value: &str) -> String {
    format!("{key}={value} of the header is not read")
}

/// Whether primaries are those of sRGB or, a little different, those that the format takes where none are named.
fn is_usual(primaries: &[f32]) -> bool {
    const USUAL: [f32; 6] = [0.64, 0.33, 0.295, 0.6, 0.15, 0.06];
    primaries.len() == 8 && primaries.iter().zip(USUAL).all(|(a, b)| (a - b).abs() < 0.012)
}

/// The next line without its end, of any encoding.
fn take_line(rest: &mut &[u8]) -> Option<String> {
    let end = rest.iter().position(|b| *b == b'\n')?;
    let line = String::from_utf8_lossy(&rest[..end]).trim_end_matches('\r').to_owned();
    *rest = &rest[end + 1..];
    Some(line)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four pixels, three of them unlike: 1 2 / 3 4 in units of 1/8.
    fn picture(header: &str, order: [u8; 4]) -> Result<(UVec2, Vec<Vec3>), String> {
        let mut file = header.as_bytes().to_vec();
        for k in order {
            file.extend([32 * k, 16 * k, 8 * k, 129]);
        }
        let (header, plain) = HdrHeader::read(&file).expect("a picture of this format")?;
        let image = image::load_from_memory_with_format(&plain, image::ImageFormat::Hdr).map_err(|e| e.to_string())?;
        let pixels: Vec<Vec3> = image.into_rgb32f().pixels().map(|p| Vec3::from_array(p.0)).collect();
        let (size, radiance, _) = header.radiance(pixels);
        Ok((size, radiance))
    }

    #[test]
    fn exposures_and_corrections_are_divided_out() {
        let red = |lines: &str| picture(&format!("#?RADIANCE\n{lines}\n-Y 2 +X 2\n"), [1, 2, 3, 4]).map(|p| p.1[0]);
        let plain = red("FORMAT=32-bit_rle_rgbe\n").unwrap();
        assert!((plain - Vec3::new(0.25, 0.125, 0.0625)).length() < 1e-6, "{plain}");
        assert_eq!(red("EXPOSURE=2.0\nFORMAT=32-bit_rle_rgbe\nEXPOSURE= 4\n").unwrap(), plain / 8.0);
        assert_eq!(red("COLORCORR=2 1 4\nCOLORCORR= 1 1 2\n").unwrap(), plain / Vec3::new(2.0, 1.0, 8.0));
        for bad in ["EXPOSURE=0\n", "EXPOSURE=x\n", "COLORCORR=1 2\n", "FORMAT=raw\n"] {
            assert!(red(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn lines_of_history_are_not_read() {
        let read =
            |lines: &str| HdrHeader::read(format!("#?RADIANCE\n{lines}\n-Y 1 +X 1\n").as_bytes()).unwrap().unwrap().0;
        let plain = read("FORMAT=32-bit_rle_rgbe\n");
        let variables = [
            "EXPOSURE=9",
            "COLORCORR=2 1 1",
            "FORMAT=32-bit_rle_xyze",
            "FORMAT=raw",
            "PRIMARIES=1 0 0 1 0 0 0 0",
            "GAMMA=2",
        ];
        for (variable, blank) in variables.iter().flat_map(|variable| [" ", "\t"].map(|blank| (variable, blank))) {
            let old = read(&format!("{blank}{variable}\n"));
            assert_eq!((old.factor, old.is_xyz, &old.notes), (plain.factor, plain.is_xyz, &plain.notes), "{variable}");
        }
    }

    #[test]
    fn all_orders_of_pixels_give_one_picture() {
        let usual = picture("#?RGBE\n\n-Y 2 +X 2\n", [1, 2, 3, 4]).unwrap();
        for (size, order) in [
            ("+Y 2 +X 2", [3, 4, 1, 2]),
            ("-Y 2 -X 2", [2, 1, 4, 3]),
            ("+Y 2 -X 2", [4, 3, 2, 1]),
            ("+X 2 -Y 2", [1, 3, 2, 4]),
            ("-X 2 +Y 2", [4, 2, 3, 1]),
        ] {
            assert_eq!(picture(&format!("#?RADIANCE\r\n\r\n{size}\n"), order).unwrap(), usual, "{size}");
        }
        let wide = picture("#?RGBE\n\n+X 4 -Y 1\n", [1, 2, 3, 4]).unwrap();
        assert_eq!((wide.0, wide.1[2].x), (UVec2::new(4, 1), 0.75));
        assert!(picture("#?RGBE\n\n-Y 2 +Z 2\n", [1; 4]).is_err());
    }

    #[test]
    fn colours_of_the_cie_become_those_of_the_screen() {
        // Of white in XYZ: 0.9505, 1, 1.089.
        let mut file = b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n".to_vec();
        file.extend([122, 128, 139, 129]);
        let (header, _) = HdrHeader::read(&file).unwrap().unwrap();
        let (_, pixels, note) = header.radiance(vec![Vec3::new(122.0, 128.0, 139.4) / 128.0]);
        assert_eq!(note, None);
        let white = pixels[0];
        assert!((white - Vec3::ONE).abs().max_element() < 0.01, "{white}");
        let (header, _) =
            HdrHeader::read(b"#?RGBE\nGAMMA=2.2\nPRIMARIES=.7 .3 .2 .7 .1 .1 .3 .3\n\n-Y 1 +X 1\n").unwrap().unwrap();
        assert_eq!(header.notes.len(), 2);
        // A green that no screen has.
        let (header, _) = HdrHeader::read(&file).unwrap().unwrap();
        let (_, pixels, note) = header.radiance(vec![Vec3::new(0.1, 0.8, 0.1)]);
        assert_eq!(pixels[0].x, 0.0);
        assert!(note.is_some_and(|note| note.contains("sRGB lacks")));
    }
}
