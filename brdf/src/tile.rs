use crate::Material;
use crate::lafortune::LafortuneTerm;
use crate::term::{Diffuse, Mirror, Shape, Term};
use core::marker::PhantomData;
use glam::Vec3;
use lobe_core::lanes::{Columns, Lane, Level, WIDTH, map, row, set_row};
use lobe_core::{BrdfLobes, Lobe, OWN_NONE, Receiver, Tile, TileLobes};

/// Lobes of all receivers of a tile, receiver `i` of material `of[i]`: those that
/// [`brdf_lobes`](lobe_core::BrdfLobes::brdf_lobes) gives, in the same order, bit for bit.
///
/// # Cost
/// Sixteen at a time, as many in one instruction as the processor offers; least where neighbours have the same material.
///
/// # Panics
/// When `of` is not as long as the tile, or a number in it is not that of a material.
///
/// ```
/// use brdf::{Material, tile_lobes};
/// use glam::Vec3;
/// use lobe_core::{OWN_NONE, Receiver, Tile, TileLobes};
/// let at = Receiver { position: Vec3::ZERO, normal: Vec3::Z, face: Vec3::Z, view: Vec3::Z, object: OWN_NONE };
/// let (mut tile, mut lobes) = (Tile::default(), TileLobes::default());
/// tile.set(&[at; 3]);
/// tile_lobes(&[Material::lambert(Vec3::X), Material::lambert(Vec3::Y)], &[0, 1, 0], &tile, &mut lobes);
/// assert_eq!(lobes.of(1).next().unwrap().1.flux, Vec3::Y);
/// ```
pub fn tile_lobes(materials: &[Material], of: &[u32], tile: &Tile, out: &mut TileLobes) {
    lobes_at(Level::new(), materials, of, tile, out);
}

pub(crate) fn lobes_at(level: Level, materials: &[Material], of: &[u32], tile: &Tile, out: &mut TileLobes) {
    assert_eq!(of.len(), tile.len(), "one material a receiver");
    let mut places = 0;
    let mut last = None;
    for number in of {
        // Neighbours mostly have the same.
        if last != Some(number) {
            places = places.max(materials[*number as usize].max_lobes());
            last = Some(number);
        }
    }
    out.reset(tile, places);
    let mut own = (Several::<Diffuse, 3>::new(), Several::<Mirror, 5>::new(), Several::<LafortuneTerm, 25>::new());
    for (block, of) in of.chunks(WIDTH).enumerate() {
        let at = tile.block(block);
        let first = &materials[of[0] as usize];
        let one = of.iter().all(|number| *number == of[0]);
        for place in 0..places {
            let lobes = out.block_mut(place, block);
            if one {
                match first.term(place) {
                    None => *lobes = [[0.0; WIDTH]; 8],
                    Some(Term::Diffuse(shape)) => map(level, &Same(shape), at, &[], lobes),
                    Some(Term::Mirror(shape)) => map(level, &Same(shape), at, &[], lobes),
                    Some(Term::Lafortune(shape)) => map(level, &Same(*shape), at, &[], lobes),
                }
                continue;
            }
            let (mut last, mut term) = (of[0], first.term(place));
            for (j, number) in of.iter().enumerate() {
                if *number != last {
                    (last, term) = (*number, materials[*number as usize].term(place));
                }
                match &term {
                    None => {}
                    Some(Term::Diffuse(shape)) => own.0.set(j, shape),
                    Some(Term::Mirror(shape)) => own.1.set(j, shape),
                    Some(Term::Lafortune(shape)) => own.2.set(j, shape),
                }
            }
            if [own.0.count, own.1.count, own.2.count].iter().all(|count| *count < WIDTH) {
                *lobes = [[0.0; WIDTH]; 8];
            }
            own.0.write(level, at, lobes);
            own.1.write(level, at, lobes);
            own.2.write(level, at, lobes);
        }
        for (j, number) in of.iter().enumerate() {
            if let Material::MetallicRoughness(material) = &materials[*number as usize] {
                let [_, _, _, x, y, z, view @ ..] = row(at, j);
                let normal = Vec3::new(x, y, z);
                let at = Receiver {
                    position: Vec3::ZERO,
                    normal,
                    face: normal,
                    view: Vec3::from_array(view),
                    object: OWN_NONE,
                };
                for (place, lobe) in material.lobes(&at).enumerate() {
                    set_row(out.block_mut(place, block), j, &bytemuck::cast(lobe));
                }
            }
        }
    }
}

/// Those receivers of a block whose lobes are of one shape, each with constants of its own.
struct Several<S, const P: usize> {
    constants: Columns<P>,
    rows: [bool; WIDTH],
    count: usize,
    shape: PhantomData<S>,
}

impl<S: Shape<P>, const P: usize> Several<S, P> {
    fn new() -> Self {
        Self { constants: [[0.0; WIDTH]; P], rows: [false; WIDTH], count: 0, shape: PhantomData }
    }

    #[inline(always)]
    fn set(&mut self, j: usize, shape: &S) {
        set_row(&mut self.constants, j, bytemuck::cast_ref(shape));
        self.rows[j] = true;
        self.count += 1;
    }

    /// Writes their lobes, and forgets them.
    fn write(&mut self, level: Level, at: &Columns<9>, out: &mut Columns<8>) {
        match core::mem::take(&mut self.count) {
            0 => return,
            WIDTH => map(level, &Own::<S, P>(PhantomData), at, &self.constants, out),
            _ => {
                let mut lobes = [[0.0; WIDTH]; 8];
                map(level, &Own::<S, P>(PhantomData), at, &self.constants, &mut lobes);
                for (j, _) in self.rows.iter().enumerate().filter(|(_, is_own)| **is_own) {
                    set_row(out, j, &row(&lobes, j));
                }
            }
        }
        self.rows = [false; WIDTH];
    }
}

/// The same constants for all rows.
struct Same<S, const P: usize>(S);

/// Constants of its own for each.
struct Own<S, const P: usize>(PhantomData<S>);

#[inline(always)]
fn lobe<S: Shape<P>, const P: usize>(shape: &S, [_, _, _, n @ .., x, y, z]: [f32; 9]) -> [f32; 8] {
    bytemuck::cast::<Lobe, _>(shape.lobe(Vec3::from_array(n), Vec3::new(x, y, z)))
}

impl<S: Shape<P>, const P: usize> Lane<9, 0, 8> for Same<S, P> {
    #[inline(always)]
    fn value(&self, at: [f32; 9], []: [f32; 0]) -> [f32; 8] {
        lobe(&self.0, at)
    }
}

impl<S: Shape<P>, const P: usize> Lane<9, P, 8> for Own<S, P> {
    #[inline(always)]
    fn value(&self, at: [f32; 9], constants: [f32; P]) -> [f32; 8] {
        lobe(bytemuck::cast_ref::<_, S>(&constants), at)
    }
}
