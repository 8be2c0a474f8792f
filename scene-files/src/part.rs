//! A mesh of a file before it is an object: its appearance, its rig and its place.

use crate::Normals;
use crate::appearance::Appearance;
use glam::{Mat4, Vec3};
use scene::motion::{Body, Carrier, Deformer, Mover, Placement};
use scene::{Bounds, Instances, Mesh, SceneError, Shape};

/// A mesh of a file, with the appearance that the file gives it: a number that is the same for the same appearance, and it.
#[derive(Clone)]
pub(crate) struct Part {
    pub(crate) name: String,
    pub(crate) mesh: Mesh,
    /// A shared mesh in place of `mesh`, which is empty then.
    pub(crate) instances: Option<Instances>,
    pub(crate) repaired: Repaired,
    pub(crate) material: Option<(usize, Appearance)>,
    /// The joints that move it, if its file has any.
    pub(crate) rig: Option<(Deformer, Carrier)>,
    /// Whether its file says nothing about its normals.
    pub(crate) is_bare: bool,
    /// Its place among the parts of a [`GltfDocument`](crate::GltfDocument), if that is kept.
    pub(crate) source: Option<usize>,
}

/// The numbers of triangles and normals that were changed as a shared mesh was read.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Repaired {
    /// Triangles without area.
    pub(crate) dropped: usize,
    /// Normals that were turned round.
    pub(crate) turned: usize,
    /// Faces that have normals to both sides.
    pub(crate) mixed: usize,
}

impl Part {
    pub(crate) fn fixed(name: String, mesh: Mesh, material: Option<(usize, Appearance)>) -> Self {
        let is_bare = mesh.normals.is_empty();
        let repaired = Repaired::default();
        Self { name, mesh, instances: None, repaired, material, rig: None, is_bare, source: None }
    }

    /// Whether it has no triangles.
    pub(crate) fn is_empty(&self) -> bool {
        self.mesh.triangles.is_empty() && self.instances.is_none()
    }

    pub(crate) fn bounds(&self) -> Bounds {
        self.instances.as_ref().map_or_else(|| self.mesh.bounds(), Instances::bounds)
    }

    fn area(&self) -> f64 {
        let of = |all: &Instances| {
            let area = |[a, b, c]: [Vec3; 3]| 0.5 * (b - a).as_dvec3().cross((c - a).as_dvec3()).length();
            (0..all.triangle_count()).map(|t| area(all.corners(t))).sum()
        };
        self.instances.as_ref().map_or_else(|| self.mesh.area(), of)
    }

    pub(crate) fn validate(&self) -> Result<(), SceneError> {
        if self.instances.is_some() { Ok(()) } else { self.mesh.validate() }
    }

    /// The triangles, in their own coordinates if they are shared.
    pub(crate) fn shown(&self) -> &Mesh {
        self.instances.as_ref().map_or(&self.mesh, |instances| instances.mesh())
    }

    /// Copies a shared mesh, so that it can be changed.
    pub(crate) fn own(&mut self) -> &mut Mesh {
        if let Some(instances) = self.instances.take() {
            self.mesh = match instances.places() {
                // Its bits stay, normals included.
                [place] if *place == Mat4::IDENTITY => Mesh::clone(instances.mesh()),
                _ => instances.expanded(),
            };
        }
        &mut self.mesh
    }

    pub(crate) fn into_shape(self) -> Shape {
        self.instances.map_or(Shape::Mesh(self.mesh), Shape::Instances)
    }

    /// Removes the triangles that never have an area and returns their number. Removes repeated triangles, too.
    pub(crate) fn clean(&mut self) -> usize {
        let dropped = match self.rig {
            None => self.mesh.remove_degenerate(),
            // A triangle that is flat at the first moment may open later.
            Some(_) => self.mesh.remove_repeated(),
        };
        self.mesh.remove_doubles(self.rig.is_some());
        dropped
    }

    /// Gives the mesh its normals and its first pose; returns its motion, if it moves.
    pub(crate) fn place(&mut self, normals: Normals, placement: &Placement) -> Option<Mover> {
        if let (Some(instances), Normals::File, true) = (&self.instances, normals, placement.is_fixed()) {
            let matrix = placement.at(0.0);
            let moved = if matrix == Mat4::IDENTITY { Ok(instances.clone()) } else { instances.moved(&matrix) };
            if let Ok(moved) = moved {
                self.instances = Some(moved);
                return None;
            }
        }
        self.own();
        match normals {
            Normals::File => {}
            Normals::Face => self.mesh.normals.clear(),
            Normals::Smooth { crease } if crease < 180.0 => {
                let split = self.mesh.split_at_creases(crease);
                self.mesh.smooth_normals_of(&split.groups);
                if let Some((deformer, _)) = &mut self.rig {
                    deformer.split(&split, &self.mesh);
                }
            }
            Normals::Smooth { .. } => {
                self.mesh.smooth_normals();
                if let Some((deformer, _)) = &mut self.rig {
                    deformer.smooth_normals(&self.mesh);
                }
            }
        }
        let body = match self.rig.take() {
            Some((mut deformer, carrier)) => {
                if normals == Normals::Face {
                    deformer.drop_normals();
                }
                Some(Body::Mesh(Box::new(deformer), Some(carrier)))
            }
            None if placement.is_fixed() => None,
            None => Some(Body::Mesh(Box::new(Deformer::rigid(&self.mesh)), None)),
        };
        self.mesh.transform(&placement.at(0.0));
        let fixed = body.is_none();
        if fixed {
            self.mesh.remove_degenerate();
        }
        body.map(|body| Mover { placement: placement.clone(), body, proxy: Vec::new() })
    }
}

/// Distributes a number of spheres over parts in proportion to their areas, at least four each (fewer if the total is
/// too small).
pub(crate) fn share_out(total: usize, parts: &[Part]) -> Vec<usize> {
    if parts.len() == 1 {
        return vec![total];
    }
    let areas: Vec<f64> = parts.iter().map(Part::area).collect();
    let sum: f64 = areas.iter().sum();
    let least = total.min(4);
    areas.iter().map(|a| ((total as f64 * a / sum).round() as usize).max(least)).collect()
}
