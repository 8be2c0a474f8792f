/// Why the GPU could not do it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// No adapter was found.
    #[error(
        "no GPU adapter: {reason}; install a Vulkan driver (software: package mesa-vulkan-drivers), or use the CPU"
    )]
    NoAdapter {
        /// What the search said.
        reason: String,
    },
    /// The adapter gave no device.
    #[error("{adapter}: no device: {reason}")]
    NoDevice {
        /// The adapter's name.
        adapter: String,
        /// What it said.
        reason: String,
    },
    /// The device's limits are too small for this.
    #[error("the GPU's limits are too small: {what} takes {needed}, it allows {allowed}; use the CPU")]
    Limits {
        /// What does not fit.
        what: &'static str,
        /// How much it takes.
        needed: u64,
        /// How much there may be.
        allowed: u64,
    },
    /// The device has no more memory.
    #[error("the GPU is out of memory; use fewer points at a time, or the CPU")]
    OutOfMemory,
    /// The device was lost or destroyed.
    #[error("the GPU device was lost: {reason}")]
    Lost {
        /// What is known of it.
        reason: String,
    },
    /// The driver ended loops before they were done: Mesa's software one after 65 535 rounds of all loops of a thread.
    #[error(
        "the GPU's driver ended the loops of {threads} threads too early, as Mesa's software driver does after 65 535 rounds; \
         use fewer blockers, another device, or the CPU"
    )]
    LoopsCut {
        /// How many threads.
        threads: u32,
    },
    /// A shader or a command was refused: a defect of this crate or of the driver.
    #[error("the GPU refused {what}: {reason}")]
    Refused {
        /// What was refused.
        what: &'static str,
        /// What the device said.
        reason: String,
    },
    /// A pose does not fit the spheres that follow it.
    #[error("the pose does not fit the spheres: {0}")]
    Bind(#[from] sphere_sets::BindError),
    /// The GPU has no implementation of this.
    #[error("the GPU cannot do this: {0}")]
    Unsupported(String),
}
