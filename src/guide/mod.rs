//! The manual: one page for each thing one comes to do.
//!
//! | page | for whom |
//! |---|---|
//! | [`first_scene`] | who has a scene and wants its motion, energies and pictures |
//! | [`scene_file`] | every key of a scene file, with unit and default |
//! | [`outputs`] | who reads the tables and the summary |
//! | [`choosing`] | θ, rule of the active set, solver, tolerance, step |
//! | [`elastic_bodies`] | meshes, preloads, VTK |
//! | [`references_and_studies`] | errors against a reference, and what they cost |
//! | [`cone_problems`] | from a problem file to a performance profile |
//! | [`add_a_law`] | a law of one's own, with its dissipation tested |
//! | [`add_a_cone`] | a cone of one's own, rolling resistance being one |
//! | [`add_a_solver`] | a cone solver of one's own |
//! | [`add_a_system`] | a mechanical system of one's own, and assemblies |
//! | [`house`] | where things are, and how data flows |

#[doc = include_str!("first_scene.md")]
pub mod first_scene {}
#[doc = include_str!("scene_reference.md")]
pub mod scene_file {}
#[doc = include_str!("outputs.md")]
pub mod outputs {}
#[doc = include_str!("choosing.md")]
pub mod choosing {}
#[doc = include_str!("elastic_bodies.md")]
pub mod elastic_bodies {}
#[doc = include_str!("references_and_studies.md")]
pub mod references_and_studies {}
#[doc = include_str!("cone_problems.md")]
pub mod cone_problems {}
#[doc = include_str!("add_a_law.md")]
pub mod add_a_law {}
#[doc = include_str!("add_a_cone.md")]
pub mod add_a_cone {}
#[doc = include_str!("add_a_solver.md")]
pub mod add_a_solver {}
#[doc = include_str!("add_a_system.md")]
pub mod add_a_system {}
#[doc = include_str!("house.md")]
pub mod house {}
