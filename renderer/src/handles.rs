/// An object of a [`Renderer`](crate::Renderer). The handle stays valid while other objects are added and removed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ObjectHandle(pub(crate) u64);

/// A light of a [`Renderer`](crate::Renderer).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LightHandle(pub(crate) u64);

/// A material of a [`Renderer`](crate::Renderer).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct MaterialHandle(pub(crate) u64);

/// The handles of a list that grows at its end: increasing numbers, none of which is used twice.
#[derive(Clone, Debug)]
pub(crate) struct Handles {
    list: Vec<u64>,
    next: u64,
}

impl Handles {
    pub(crate) fn new(count: usize) -> Self {
        let next = count as u64;
        Self { list: (0..next).collect(), next }
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = u64> + '_ {
        self.list.iter().copied()
    }

    /// The handle at a place.
    pub(crate) fn at(&self, place: usize) -> u64 {
        self.list[place]
    }

    /// The place of a handle in the list; `None` if it was removed.
    pub(crate) fn place(&self, handle: u64) -> Option<usize> {
        self.list.binary_search(&handle).ok()
    }

    pub(crate) fn push(&mut self) -> u64 {
        self.list.push(self.next);
        self.next += 1;
        self.next - 1
    }

    pub(crate) fn remove(&mut self, place: usize) {
        self.list.remove(place);
    }

    /// The place in the list that a handle has which is put back. `None` if it is there, or never was.
    pub(crate) fn gap(&self, handle: u64) -> Option<usize> {
        self.list.binary_search(&handle).err().filter(|_| handle < self.next)
    }

    /// Puts a handle back at its [gap](Self::gap).
    pub(crate) fn put(&mut self, place: usize, handle: u64) {
        self.list.insert(place, handle);
    }
}
