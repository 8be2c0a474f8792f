use brdf::Material;
use scene::Surface;
use scene::cut_out::CutOut;

/// A material, its textures and its emission.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Look {
    pub(crate) material: Material,
    pub(crate) surface: Surface,
    /// The alpha mask of its surfaces; `None` if they are opaque.
    pub(crate) cut_out: Option<CutOut>,
}

impl<M: Into<Material>> From<M> for Look {
    fn from(material: M) -> Self {
        Self { material: material.into(), surface: Surface::default(), cut_out: None }
    }
}

impl Look {
    /// Materials and surfaces of a scene; no surfaces where all are plain.
    pub(crate) fn parted(looks: Vec<Self>) -> (Vec<Material>, Vec<Surface>) {
        let is_plain = looks.iter().all(|look| look.surface.is_plain());
        let (materials, surfaces) = looks.into_iter().map(|look| (look.material, look.surface)).unzip();
        (materials, if is_plain { Vec::new() } else { surfaces })
    }
}
