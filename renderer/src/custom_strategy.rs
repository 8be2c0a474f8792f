use crate::{Plan, RenderError};
use core::fmt::Debug;
use scene::{Scene, Strategy};
use shading::gpu::GpuBlockers;
use visibility_mask::DynBlockers;

/// A strategy that is not built in, for the objects whose [strategy](scene::Strategy::Custom) has its name. It may keep any data.
///
/// A renderer takes it by [`put_strategy`](crate::Renderer::put_strategy). It blocks beside the built-in strategies, with every
/// method, in animations, bands and layers, and on a GPU if it has [`gpu_blockers`](Self::gpu_blockers).
///
/// `examples/open` has one for capsules.
pub trait CustomStrategy: Debug + Send + Sync {
    /// The name that objects refer to.
    fn name(&self) -> &'static str;

    /// Updates the strategy to the scene. Called before the first picture, and before each one for which objects or strategies have
    /// changed. `objects` are the numbers of the objects that block by this strategy.
    ///
    /// # Errors
    /// The reason in one sentence, if it cannot block for one of them.
    fn update(&mut self, scene: &Scene, objects: &[usize]) -> Result<(), String>;

    /// The blockers on the CPU.
    fn blockers(&self) -> &dyn DynBlockers;

    /// The same on a GPU. Provided: `None`; a GPU then refuses the strategy.
    fn gpu_blockers(&self) -> Option<&dyn GpuBlockers> {
        None
    }
}

/// The custom strategies of a renderer.
#[derive(Debug, Default)]
pub(crate) struct CustomStrategies(pub(crate) Vec<Box<dyn CustomStrategy>>);

impl CustomStrategies {
    /// Adds a strategy; replaces one of the same name.
    pub(crate) fn put(&mut self, strategy: Box<dyn CustomStrategy>) {
        self.0.retain(|known| known.name() != strategy.name());
        self.0.push(strategy);
    }

    /// Updates all strategies to the scene.
    pub(crate) fn update(&mut self, scene: &Scene, plan: &Plan) -> Result<(), RenderError> {
        let names: Vec<_> = self.0.iter().map(|strategy| strategy.name()).collect();
        for (number, object) in scene.objects.iter().enumerate() {
            match plan.of(number) {
                Strategy::Custom(name) if !names.contains(&name) => {
                    return Err(RenderError::NoStrategy { object: object.name.clone(), name });
                }
                _ => {}
            }
        }
        for strategy in &mut self.0 {
            let name = strategy.name();
            let is_own = |number: &usize| plan.of(*number) == Strategy::Custom(name);
            let objects: Vec<usize> = (0..scene.objects.len()).filter(is_own).collect();
            strategy.update(scene, &objects).map_err(|fault| RenderError::Strategy { name, fault })?;
        }
        Ok(())
    }
}
