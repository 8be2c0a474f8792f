use brdf::Material;
use scene::Surface;
use scene::cut_out::CutOut;

/// A material, its textures and its emission.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Appearance {
    pub(crate) material: Material,
    pub(crate) surface: Surface,
    /// The alpha mask of its surfaces; `None` if they are opaque.
    pub(crate) cut_out: Option<CutOut>,
}

impl<M: Into<Material>> From<M> for Appearance {
    fn from(material: M) -> Self {
        Self { material: material.into(), surface: Surface::default(), cut_out: None }
    }
}

impl Appearance {
    /// Materials and surfaces of a scene; no surfaces where all are plain.
    pub(crate) fn parted(appearances: Vec<Self>) -> (Vec<Material>, Vec<Surface>) {
        let is_plain = appearances.iter().all(|appearance| appearance.surface.is_plain());
        let (materials, surfaces) =
            appearances.into_iter().map(|appearance| (appearance.material, appearance.surface)).unzip();
        (materials, if is_plain { Vec::new() } else { surfaces })
    }
}
