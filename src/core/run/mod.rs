//! Runs of scenes: in memory, or written as the command line writes them.
//!
//! ```
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! use nonsmooth::scene::Scene;
//!
//! # let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/bouncing_bar.toml");
//! let scene = Scene::read(path)?;
//! let runs = scene.run(&nonsmooth::registry())?;
//! println!("{} s, q = {:?}", runs[0].times[1], runs[0].q[1]);
//! # Ok(())
//! # }
//! ```
//!
//! [`Scene::run`](crate::scene::Scene::run) gives arrays, `Scene::write` (feature `runs`) the tables, the summary, the
//! figures and the checkpoints of `nonsmooth run`. A run that is to be steered step by step is a
//! [`Simulation`](crate::simulate::Simulation), which [`Scene::simulation`](crate::scene::Scene::simulation) builds.

#[cfg(feature = "runs")]
mod checkpoint;
#[cfg(feature = "runs")]
mod frames;
#[cfg(feature = "runs")]
mod manifest;
#[cfg(feature = "runs")]
mod options;
mod recorded;
#[cfg(feature = "runs")]
mod shown;
#[cfg(feature = "runs")]
mod under_way;
#[cfg(feature = "runs")]
mod warnings;
#[cfg(feature = "runs")]
mod written;

#[cfg(feature = "runs")]
pub use checkpoint::ResumeError;
#[cfg(feature = "runs")]
pub use options::{Checkpoints, WriteOptions};
pub use recorded::RunFailure;
#[cfg(feature = "runs")]
pub use warnings::Warning;
#[cfg(feature = "runs")]
pub use written::{WriteError, Written};
