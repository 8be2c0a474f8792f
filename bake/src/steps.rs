//! The finished steps of a bake, kept so that an interrupted one goes on.

use crate::layout::Layout;
use crate::target::Target;
use crate::{BakeError, page::State};
use glam::{Vec2, Vec3};

/// The results of a bake's steps, in their order, which [`Baker::bake_with`](crate::Baker::bake_with) keeps and takes up again: those of a
/// bake of the same file with the same settings at the same moment, by the same version. Then the result has the same bytes as without
/// an interruption.
///
/// `()` keeps nothing.
pub trait Steps {
    /// The result of the next step, if it is known.
    fn resume(&mut self) -> Option<Vec<u8>>;

    /// Takes the result of a step that was not known. All following ones are not known either.
    fn keep(&mut self, result: Vec<u8>);
}

impl Steps for () {
    fn resume(&mut self) -> Option<Vec<u8>> {
        None
    }

    fn keep(&mut self, _result: Vec<u8>) {}
}

/// Results that are kept as bytes.
pub(crate) trait Stored: Sized {
    fn write(&self, out: &mut Vec<u8>);

    /// Reads from the front of bytes; `None` where these are no such result.
    fn read(from: &mut &[u8]) -> Option<Self>;
}

/// The result of a step: the known one, or one that is made.
pub(crate) fn step<T: Stored>(
    steps: &mut dyn Steps,
    make: impl FnOnce() -> Result<T, BakeError>,
) -> Result<T, BakeError> {
    let known = steps.resume().and_then(|bytes| {
        let mut rest = &bytes[..];
        T::read(&mut rest).filter(|_| rest.is_empty())
    });
    if let Some(known) = known {
        return Ok(known);
    }
    let made = make()?;
    let mut bytes = Vec::new();
    made.write(&mut bytes);
    steps.keep(bytes);
    Ok(made)
}

macro_rules! stored_numbers {
    ($($kind:ty),*) => {$(
        impl Stored for $kind {
            fn write(&self, out: &mut Vec<u8>) {
                out.extend_from_slice(&self.to_le_bytes());
            }

            fn read(from: &mut &[u8]) -> Option<Self> {
                let (own, rest) = from.split_first_chunk()?;
                *from = rest;
                Some(Self::from_le_bytes(*own))
            }
        }
    )*};
}

stored_numbers!(u32, u64, f32, f64);

impl<T: Stored, const N: usize> Stored for [T; N] {
    fn write(&self, out: &mut Vec<u8>) {
        self.iter().for_each(|item| item.write(out));
    }

    fn read(from: &mut &[u8]) -> Option<Self> {
        let items: Vec<T> = (0..N).map(|_| T::read(from)).collect::<Option<_>>()?;
        items.try_into().ok()
    }
}

impl<T: Stored> Stored for Vec<T> {
    fn write(&self, out: &mut Vec<u8>) {
        (self.len() as u64).write(out);
        self.iter().for_each(|item| item.write(out));
    }

    fn read(from: &mut &[u8]) -> Option<Self> {
        let count = u64::read(from)?;
        // An item takes a byte at least.
        (count <= from.len() as u64).then_some(())?;
        (0..count).map(|_| T::read(from)).collect()
    }
}

impl<T: Stored> Stored for Option<T> {
    fn write(&self, out: &mut Vec<u8>) {
        u32::from(self.is_some()).write(out);
        self.iter().for_each(|item| item.write(out));
    }

    fn read(from: &mut &[u8]) -> Option<Self> {
        match u32::read(from)? {
            0 => Some(None),
            1 => Some(Some(T::read(from)?)),
            _ => None,
        }
    }
}

impl Stored for Vec2 {
    fn write(&self, out: &mut Vec<u8>) {
        self.to_array().write(out);
    }

    fn read(from: &mut &[u8]) -> Option<Self> {
        Some(Self::from_array(Stored::read(from)?))
    }
}

impl Stored for Vec3 {
    fn write(&self, out: &mut Vec<u8>) {
        self.to_array().write(out);
    }

    fn read(from: &mut &[u8]) -> Option<Self> {
        Some(Self::from_array(Stored::read(from)?))
    }
}

impl Stored for State {
    fn write(&self, out: &mut Vec<u8>) {
        out.push(*self as u8);
    }

    fn read(from: &mut &[u8]) -> Option<Self> {
        let (own, rest) = from.split_first()?;
        *from = rest;
        [Self::Empty, Self::Buried, Self::Thin, Self::Surface, Self::Around].get(usize::from(*own)).copied()
    }
}

impl Stored for Target {
    fn write(&self, out: &mut Vec<u8>) {
        [self.part, self.page, self.set].map(|number| number as u64).write(out);
        self.coordinates.write(out);
        self.triangles.write(out);
        self.origins.write(out);
    }

    fn read(from: &mut &[u8]) -> Option<Self> {
        let [part, page, set] = <[u64; 3]>::read(from)?.map(|number| number as usize);
        let (coordinates, triangles) = (Stored::read(from)?, Stored::read(from)?);
        Some(Self { part, page, set, coordinates, triangles, origins: Stored::read(from)? })
    }
}

impl Stored for Layout {
    fn write(&self, out: &mut Vec<u8>) {
        self.pages.write(out);
        self.targets.write(out);
    }

    fn read(from: &mut &[u8]) -> Option<Self> {
        Some(Self { pages: Stored::read(from)?, targets: Stored::read(from)? })
    }
}

/// Texels of a band of rows: their states, and their values layer by layer.
pub(crate) struct Band {
    pub(crate) states: Vec<State>,
    pub(crate) layers: Vec<Vec<Vec3>>,
}

impl Stored for Band {
    fn write(&self, out: &mut Vec<u8>) {
        self.states.write(out);
        self.layers.write(out);
    }

    fn read(from: &mut &[u8]) -> Option<Self> {
        Some(Self { states: Stored::read(from)?, layers: Stored::read(from)? })
    }
}

/// Light at points, and the weight of each; −1 of those inside of bodies.
pub(crate) struct PointLights {
    pub(crate) values: Vec<Vec3>,
    pub(crate) weights: Vec<f64>,
}

impl Stored for PointLights {
    fn write(&self, out: &mut Vec<u8>) {
        self.values.write(out);
        self.weights.write(out);
    }

    fn read(from: &mut &[u8]) -> Option<Self> {
        Some(Self { values: Stored::read(from)?, weights: Stored::read(from)? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_come_back() {
        let target = |origins| Target {
            part: 3,
            page: 1,
            set: 2,
            coordinates: vec![Vec2::new(0.25, -0.0), Vec2::ONE],
            triangles: vec![[0, 1, 1]],
            origins,
        };
        let layout = Layout { pages: vec![[64, 32]], targets: vec![target(None), target(Some(vec![7, 8]))] };
        let mut bytes = Vec::new();
        layout.write(&mut bytes);
        let read = Layout::read(&mut &bytes[..]).unwrap();
        assert_eq!(format!("{read:?}"), format!("{layout:?}"));
        for end in 0..bytes.len() {
            assert!(Layout::read(&mut &bytes[..end]).is_none());
        }
        let states = vec![State::Empty, State::Buried, State::Thin, State::Surface, State::Around];
        let mut bytes = Vec::new();
        states.write(&mut bytes);
        assert_eq!(Vec::<State>::read(&mut &bytes[..]), Some(states));
        bytes[8] = 9;
        assert_eq!(Vec::<State>::read(&mut &bytes[..]), None);
        // A count beyond all memory.
        assert!(Vec::<f32>::read(&mut &u64::MAX.to_le_bytes()[..]).is_none());
    }
}
