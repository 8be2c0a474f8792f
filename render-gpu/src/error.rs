/// Why the GPU could not do the work.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// No adapter was found.
    #[error(
        "no GPU adapter: {reason}; install a Vulkan driver (software: package mesa-vulkan-drivers), or use the CPU"
    )]
    NoAdapter {
        /// The message of the search.
        reason: String,
    },
    /// The adapter gave no device.
    #[error("{adapter}: no device: {reason}")]
    NoDevice {
        /// The adapter's name.
        adapter: String,
        /// The adapter's message.
        reason: String,
    },
    /// The device's limits are too small for this.
    #[error("the GPU's limits are too small: {what} takes {needed}, it allows {allowed}; use the CPU")]
    Limits {
        /// The item that does not fit.
        what: &'static str,
        /// The amount that it takes.
        needed: u64,
        /// The amount that the device allows.
        allowed: u64,
    },
    /// The device has no more memory.
    #[error("the GPU is out of memory; use fewer points at a time, or the CPU")]
    OutOfMemory,
    /// The device was lost or destroyed.
    #[error("the GPU device was lost: {reason}")]
    Lost {
        /// The known cause of the loss.
        reason: String,
    },
    /// The driver ended loops before they were done. Mesa's software driver does so after 65 535 rounds of all loops of a thread.
    #[error(
        "the GPU's driver ended the loops of {threads} threads too early, as Mesa's software driver does after 65 535 rounds; \
         use fewer blockers, another device, or the CPU"
    )]
    LoopsCut {
        /// Number of such threads.
        threads: u32,
    },
    /// A shader or a command was refused: a defect of this crate or of the driver.
    #[error("the GPU refused {what}: {reason}")]
    Refused {
        /// The shader or command that was refused.
        what: &'static str,
        /// The device's message.
        reason: String,
    },
    /// A pose does not fit the spheres that follow it.
    #[error("the pose does not fit the spheres: {0}")]
    Bind(#[from] sphere_sets::BindError),
    /// The GPU has no implementation of this.
    #[error("the GPU cannot do this: {0}")]
    Unsupported(String),
}
