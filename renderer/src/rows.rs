use glam::Mat4;
use lobe_core::Sphere;
use render_cpu::Revision;
use scene::{Object, Proxy, Scene, Shape};

/// The objects of the scene in order: their identities, and the initial shapes of those that were moved.
#[derive(Debug)]
pub(crate) struct Rows {
    revisions: Vec<Revision>,
    rests: Vec<Option<Rest>>,
    next: u64,
}

/// All that is known of one object.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    revision: Revision,
    rest: Option<Rest>,
}

/// An object's initial shape and proxy.
#[derive(Clone, Debug)]
struct Rest {
    shape: Shape,
    proxy: Proxy,
}

impl Rows {
    pub(crate) fn new(count: usize) -> Self {
        let rests = (0..count).map(|_| None).collect();
        Self { revisions: Revision::unedited(count), rests, next: count as u64 }
    }

    pub(crate) fn revisions(&self) -> &[Revision] {
        &self.revisions
    }

    pub(crate) fn place(&self, handle: u64) -> Option<usize> {
        self.revisions.binary_search_by_key(&handle, |row| row.object).ok()
    }

    pub(crate) fn push(&mut self) -> u64 {
        let object = self.number();
        self.revisions.push(Revision { object, form: 0, place: 0, transform: Mat4::IDENTITY });
        self.rests.push(None);
        object
    }

    pub(crate) fn remove(&mut self, object: usize) -> Row {
        Row { revision: self.revisions.remove(object), rest: self.rests.remove(object) }
    }

    /// Puts a row back that was removed; its place. `None` if it is there.
    pub(crate) fn insert(&mut self, row: Row) -> Option<usize> {
        let place = self.revisions.binary_search_by_key(&row.revision.object, |row| row.object).err()?;
        self.revisions.insert(place, row.revision);
        self.rests.insert(place, row.rest);
        Some(place)
    }

    /// A number that no handle and no revision has had.
    fn number(&mut self) -> u64 {
        self.next += 1;
        self.next - 1
    }

    /// Gives the object a new identity of its shape; its present place becomes the initial one.
    pub(crate) fn renew(&mut self, object: usize) {
        let form = self.number();
        self.rests[object] = None;
        self.revisions[object] = Revision { form, place: form, transform: Mat4::IDENTITY, ..self.revisions[object] };
    }

    pub(crate) fn bump_places(&mut self, moves: impl Fn(usize) -> bool) {
        for object in (0..self.revisions.len()).filter(|o| moves(*o)) {
            self.revisions[object].place = self.number();
        }
    }

    pub(crate) fn transform(&self, object: usize) -> Mat4 {
        self.revisions[object].transform
    }

    /// Moves an object from its initial place by a matrix.
    pub(crate) fn put(&mut self, number: usize, object: &mut Object, matrix: Mat4) {
        let rest =
            self.rests[number].get_or_insert_with(|| Rest { shape: object.shape.clone(), proxy: object.proxy.clone() });
        match (&mut object.shape, &rest.shape) {
            (Shape::Mesh(mesh), Shape::Mesh(own)) => {
                mesh.positions.clone_from(&own.positions);
                mesh.normals.clone_from(&own.normals);
                mesh.triangles.clone_from(&own.triangles);
                if matrix != Mat4::IDENTITY {
                    mesh.transform(&matrix);
                }
            }
            (Shape::Instances(all), Shape::Instances(own)) => {
                // Edits check the matrix first.
                if let Ok(moved) = own.moved(&matrix) {
                    *all = if matrix == Mat4::IDENTITY { own.clone() } else { moved };
                }
            }
            (Shape::Spheres(spheres), Shape::Spheres(own)) => *spheres = moved(own, &matrix),
            _ => {}
        }
        object.proxy = moved_proxy(&rest.proxy, &matrix);
        let place = self.number();
        self.revisions[number] = Revision { place, transform: matrix, ..self.revisions[number] };
    }

    /// Exchanges all moved objects with their initial shapes, or back.
    pub(crate) fn swap_rest(&mut self, scene: &mut Scene) {
        for (object, rest) in scene.objects.iter_mut().zip(&mut self.rests) {
            if let Some(rest) = rest {
                core::mem::swap(&mut object.shape, &mut rest.shape);
                core::mem::swap(&mut object.proxy, &mut rest.proxy);
            }
        }
    }

    /// Moves proxies that were found at the initial places to their objects.
    pub(crate) fn follow_proxies(&self, scene: &mut Scene) {
        for ((object, rest), row) in scene.objects.iter_mut().zip(&self.rests).zip(&self.revisions) {
            if let Some(rest) = rest {
                object.proxy = moved_proxy(&rest.proxy, &row.transform);
            }
        }
    }
}

fn moved(spheres: &[Sphere], matrix: &Mat4) -> Vec<Sphere> {
    if *matrix == Mat4::IDENTITY {
        return spheres.to_vec();
    }
    let scale = matrix.x_axis.truncate().length();
    spheres.iter().map(|s| Sphere { center: matrix.transform_point3(s.center), radius: s.radius * scale }).collect()
}

fn moved_proxy(proxy: &Proxy, matrix: &Mat4) -> Proxy {
    match proxy {
        Proxy::Spheres(spheres) => Proxy::Spheres(moved(spheres, matrix)),
        Proxy::File { path, placement } => Proxy::File { path: path.clone(), placement: *matrix * *placement },
        other => other.clone(),
    }
}
