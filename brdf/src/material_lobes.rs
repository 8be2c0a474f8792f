//! The lobes of materials: receiver by receiver, and of tiles sixteen receivers at a time.

use crate::lafortune_term::{IsotropicTerm, LafortuneTerm};
use crate::shape::{Diffuse, Mirror, Shape};
use crate::term::Term;
use crate::{Material, Model};
use core::cell::RefCell;
use core::marker::PhantomData;
use glam::Vec3;
use lobe_core::lanes::{Columns, Lane, Level, WIDTH, map, row, set_row};
use lobe_core::{BrdfLobe, PackedLobe, Receiver, Tile, TileLobes};
use shading::BrdfLobes;

impl Material {
    /// The constants of the lobe at a place. There are none beyond the last, and none of models whose lobes have no such constants.
    pub(crate) fn term(&self, place: usize) -> Option<Term<'_>> {
        match self {
            Self::Lambert(m) => m.term(place),
            Self::Phong(m) => m.term(place),
            Self::ModifiedPhong(m) => m.term(place),
            Self::Lafortune(m) => m.term(place),
            _ => None,
        }
    }
}

impl BrdfLobes for Material {
    fn brdf_lobes(&self, at: &Receiver, out: &mut Vec<BrdfLobe>) {
        self.model().brdf_lobes(at, out);
    }

    fn cosine_lobes(&self, at: &Receiver, out: &mut Vec<BrdfLobe>) {
        self.model().cosine_lobes(at, out);
    }

    /// Sixteen receivers at a time, as many in one instruction as the processor offers; least where neighbours have the same material.
    fn tile_lobes(materials: &[Self], of: &[u32], at: &[Receiver], tile: &Tile, out: &mut TileLobes) {
        lobes_at::<ByModel>(Level::new(), materials, (of, at), tile, out);
    }

    fn tile_cosine_lobes(materials: &[Self], of: &[u32], at: &[Receiver], tile: &Tile, out: &mut TileLobes) {
        lobes_at::<ByCosines>(Level::new(), materials, (of, at), tile, out);
    }
}

/// Which of a material's lobes a tile has.
pub(crate) trait Which {
    fn count(model: &dyn Model) -> usize;

    /// Those of any model.
    fn lobes(model: &dyn Model, at: &Receiver, out: &mut Vec<BrdfLobe>);

    /// Those that come from a built-in model's table.
    fn of_table(material: &Material, at: &Receiver, write: impl FnMut((usize, PackedLobe)));
}

/// [`BrdfLobes::brdf_lobes`].
pub(crate) struct ByModel;

impl Which for ByModel {
    fn count(model: &dyn Model) -> usize {
        model.lobe_count()
    }

    fn lobes(model: &dyn Model, at: &Receiver, out: &mut Vec<BrdfLobe>) {
        model.brdf_lobes(at, out);
    }

    fn of_table(material: &Material, at: &Receiver, write: impl FnMut((usize, PackedLobe))) {
        match material {
            Material::MetallicRoughness(m) => m.lobes(at).map(PackedLobe::from).enumerate().for_each(write),
            Material::HalfVector(m) => m.lobes(at).map(PackedLobe::from).enumerate().for_each(write),
            Material::Neumann(m) => m.lobes(at).map(PackedLobe::from).enumerate().for_each(write),
            _ => {}
        }
    }
}

/// [`BrdfLobes::cosine_lobes`].
pub(crate) struct ByCosines;

impl Which for ByCosines {
    fn count(model: &dyn Model) -> usize {
        model.cosine_lobe_count()
    }

    fn lobes(model: &dyn Model, at: &Receiver, out: &mut Vec<BrdfLobe>) {
        model.cosine_lobes(at, out);
    }

    fn of_table(material: &Material, at: &Receiver, write: impl FnMut((usize, PackedLobe))) {
        match material {
            Material::MetallicRoughness(m) => m.cosines(at).map(PackedLobe::from).enumerate().for_each(write),
            Material::HalfVector(m) => m.cosines(at).map(PackedLobe::from).enumerate().for_each(write),
            _ => ByModel::of_table(material, at, write),
        }
    }
}

/// The lobes of receivers, each with the number of its material.
pub(crate) fn lobes_at<W: Which>(
    level: Level,
    materials: &[Material],
    (of, receivers): (&[u32], &[Receiver]),
    tile: &Tile,
    out: &mut TileLobes,
) {
    assert!(of.len() == tile.len() && receivers.len() == tile.len(), "one material a receiver");
    // One a thread: no caller needs to keep or clear it.
    thread_local! {
        static SHAPES: RefCell<Shapes> = const { RefCell::new(Shapes::new()) };
    }
    let mut places = 0;
    let mut last = None;
    for number in of {
        // Neighbours mostly have the same.
        if last != Some(number) {
            places = places.max(W::count(materials[*number as usize].model()));
            last = Some(number);
        }
    }
    out.reset(tile, places);
    SHAPES.with_borrow_mut(|shapes| {
        for (block, (of, receivers)) in of.chunks(WIDTH).zip(receivers.chunks(WIDTH)).enumerate() {
            let at = tile.block(block);
            for place in 0..places {
                shapes.lobes(level, materials, of, place, at, out.block_mut(place, block));
            }
            one_by_one::<W>(materials, (of, receivers), at, block, out);
        }
    });
}

/// Lobes that come from a built-in model's table, and those of other models, one receiver after the other.
fn one_by_one<W: Which>(
    materials: &[Material],
    (of, receivers): (&[u32], &[Receiver]),
    at: &Columns<9>,
    block: usize,
    out: &mut TileLobes,
) {
    for (j, number) in of.iter().enumerate() {
        let material = &materials[*number as usize];
        if let Material::Custom(model) = material {
            out.set_row(block * WIDTH + j, |lobes| W::lobes(&**model, &receivers[j], lobes));
            continue;
        }
        let [_, _, _, x, y, z, view @ ..] = row(at, j);
        let (normal, view) = (Vec3::new(x, y, z), Vec3::from_array(view));
        let at = Receiver::on_surface(Vec3::ZERO, normal, view);
        W::of_table(material, &at, |(place, lobe)| {
            set_row(out.block_mut(place, block), j, &bytemuck::cast(lobe));
        });
    }
}

/// Receivers of a block that differ in their materials, by the shape of their lobes.
struct Shapes {
    diffuse: Several<Diffuse, 3>,
    mirror: Several<Mirror, 5>,
    lafortune: Several<LafortuneTerm, 25>,
    isotropic: Several<IsotropicTerm, 8>,
}

impl Shapes {
    const fn new() -> Self {
        Self { diffuse: Several::new(), mirror: Several::new(), lafortune: Several::new(), isotropic: Several::new() }
    }

    /// The lobes of a block at one place.
    fn lobes(
        &mut self,
        level: Level,
        materials: &[Material],
        of: &[u32],
        place: usize,
        at: &Columns<9>,
        out: &mut Columns<8>,
    ) {
        let first = materials[of[0] as usize].term(place);
        if of.iter().all(|number| *number == of[0]) {
            match first {
                None => *out = [[0.0; WIDTH]; 8],
                Some(Term::Diffuse(shape)) => map(level, &Same(shape), at, &[], out),
                Some(Term::Mirror(shape)) => map(level, &Same(shape), at, &[], out),
                Some(Term::Lafortune(shape)) => map(level, &Same(*shape), at, &[], out),
                Some(Term::Isotropic(shape)) => map(level, &Same(*shape), at, &[], out),
            }
            return;
        }
        let (mut last, mut term) = (of[0], first);
        for (j, number) in of.iter().enumerate() {
            if *number != last {
                (last, term) = (*number, materials[*number as usize].term(place));
            }
            match &term {
                None => {}
                Some(Term::Diffuse(shape)) => self.diffuse.set(j, shape),
                Some(Term::Mirror(shape)) => self.mirror.set(j, shape),
                Some(Term::Lafortune(shape)) => self.lafortune.set(j, shape),
                Some(Term::Isotropic(shape)) => self.isotropic.set(j, shape),
            }
        }
        let counts = [self.diffuse.count, self.mirror.count, self.lafortune.count, self.isotropic.count];
        if counts.iter().all(|count| *count < WIDTH) {
            *out = [[0.0; WIDTH]; 8];
        }
        self.diffuse.write(level, at, out);
        self.mirror.write(level, at, out);
        self.lafortune.write(level, at, out);
        self.isotropic.write(level, at, out);
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
    const fn new() -> Self {
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
    bytemuck::cast(PackedLobe::from(shape.lobe(Vec3::from_array(n), Vec3::new(x, y, z))))
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
