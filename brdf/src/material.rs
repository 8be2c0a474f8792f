use crate::{
    Brdf, BrdfSample, Factors, HalfVector, Lafortune, Lambert, MaterialError, MetallicRoughness, Model, ModifiedPhong,
    Neumann, Phong,
};
use glam::Vec3;
use lobe_core::Receiver;
use std::sync::Arc;

/// The enum with a variant for each built-in model of the same name, and its conversions.
macro_rules! materials {
    ($($(#[$doc:meta])* $model:ident,)*) => {
        /// Any model. The built-in ones have variants of their own, so that many receivers are shaded at once; all others are
        /// [`Custom`](Self::Custom).
        #[derive(Clone, Debug, PartialEq)]
        #[non_exhaustive]
        pub enum Material {
            $($(#[$doc])* $model($model),)*
            /// Anybody's model.
            Custom(Arc<dyn Model>),
        }

        impl Material {
            /// The model.
            #[must_use]
            pub fn model(&self) -> &dyn Model {
                match self {
                    $(Self::$model(model) => model,)*
                    Self::Custom(model) => &**model,
                }
            }

            /// One material of each built-in model, with the parameters of its [`Default`].
            #[must_use]
            pub fn built_in() -> Vec<Self> {
                vec![$($model::default().into()),*]
            }
        }

        $(impl From<$model> for Material {
            fn from(model: $model) -> Self {
                Self::$model(model)
            }
        })*
    };
}

materials! {
    /// Ideally diffuse.
    Lambert,
    /// The paper's Phong model, without cosine on the specular term.
    Phong,
    /// Normalised Phong.
    ModifiedPhong,
    /// Lafortune.
    Lafortune,
    /// glTF's metallic–roughness model.
    MetallicRoughness,
    /// Neumann et al.'s metals.
    Neumann,
    /// Lobes about the half vector.
    HalfVector,
}

impl Material {
    /// A diffuse material.
    #[must_use]
    pub const fn lambert(albedo: Vec3) -> Self {
        Self::Lambert(Lambert { albedo })
    }

    /// Checks the model's parameters.
    ///
    /// # Errors
    /// [`MaterialError`] that names what is wrong.
    pub fn validate(&self) -> Result<(), MaterialError> {
        self.model().validate()
    }

    /// The model's [name](Model::name).
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.model().name()
    }

    /// The material as it is at a point of this normal with this tangent ([`Lafortune::turned`]); none if the tangent has no say.
    #[must_use]
    pub fn turned(&self, normal: Vec3, tangent: Vec3) -> Option<Self> {
        self.model().turned(normal, tangent)
    }

    /// The material with its parameters times factors, which are taken within [0, 1]: [valid](Self::validate) if this one is. The same if
    /// [textures have no say](Self::takes_textures).
    ///
    /// Of metallic–roughness and half-vector lobes, the cosine lobes are those of the nearest of 256 roughnesses and four reflectances; their
    /// microfacets are exact.
    ///
    /// # Cost
    /// Some nanoseconds, and an allocation for Lafortune's.
    #[must_use]
    pub fn scaled(&self, by: &Factors) -> Self {
        self.model().scaled(&by.clamped()).unwrap_or_else(|| self.clone())
    }

    /// The material with a clear coat of this normal, where a normal map turns the base alone; none without such a coat.
    #[must_use]
    pub fn with_clearcoat_normal(&self, normal: Vec3) -> Option<Self> {
        self.model().with_clearcoat_normal(normal)
    }

    /// The part of its emission that reaches the eye: what a clear coat above does not reflect.
    #[must_use]
    pub fn lets_out(&self, at: &Receiver) -> f32 {
        self.model().lets_out(at)
    }

    /// Whether textures can scale its parameters.
    #[must_use]
    pub fn takes_textures(&self) -> bool {
        self.model().scaled(&Factors::ONE).is_some()
    }
}

impl Brdf for Material {
    fn eval(&self, at: &Receiver, v: Vec3) -> Vec3 {
        self.model().eval(at, v)
    }

    fn sample(&self, at: &Receiver, u: [f32; 3]) -> Option<BrdfSample> {
        self.model().sample(at, u)
    }

    fn pdf(&self, at: &Receiver, v: Vec3) -> f32 {
        self.model().pdf(at, v)
    }
}
