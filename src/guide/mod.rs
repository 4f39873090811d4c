//! The manual: pages about using the library and the program.

#[doc = include_str!("scene_reference.md")]
pub mod scene_reference {}
