//! Shapes in space and where they meet: exact cases, and properties of random pairs.

#[path = "geometry/allocation.rs"]
mod allocation;
#[path = "geometry/broad.rs"]
mod broad;
#[path = "geometry/common.rs"]
mod common;
#[path = "geometry/contacts.rs"]
mod contacts;
#[path = "geometry/files.rs"]
mod files;
#[path = "geometry/hulls.rs"]
mod hulls;
#[path = "geometry/masses.rs"]
mod masses;
#[path = "geometry/properties.rs"]
mod properties;
#[path = "geometry/rounds.rs"]
mod rounds;
