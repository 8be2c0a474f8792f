/// Any of the built-in models: the closed set that scene files name. The open set is the [`Brdf`](crate::Brdf) trait.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Material {}
