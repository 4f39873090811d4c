//! Scenes in space: the same file with places of three numbers.

mod build;
mod format;
mod heights;
mod joints;
mod repeat;
mod shape;

use serde::Deserialize;

pub use format::{SpaceBodySpec, SpaceHalfSpec, SpaceLoadSpec, SpaceObstacleSpec, SpaceScene, SpaceSpec};
pub use heights::HeightsSpec;
pub use joints::{SpaceJointKind, SpaceJointSpec, SpaceMotionSpec, SpaceSpringSpec};
pub use repeat::RepeatSpec;
pub use shape::ShapeSpec;

use super::Scene;

/// Whether a table is that of a scene in space: it says so, or its gravity or a place in it has three numbers.
pub(super) fn is_spatial(table: &toml::Table) -> bool {
    if let Some(dimension) = table.get("dimension") {
        return dimension.as_integer() == Some(3);
    }
    let three = |value: Option<&toml::Value>| {
        value.and_then(toml::Value::as_array).is_some_and(|numbers| numbers.len() == 3)
    };
    let places = |key: &str, of: &str| {
        let list = table.get(key).and_then(toml::Value::as_array);
        list.is_some_and(|list| list.iter().any(|entry| three(entry.get(of))))
    };
    three(table.get("gravity")) || places("bodies", "position") || table.contains_key("half_spaces")
}

/// Reads the table of a scene in space.
pub(super) fn from_table(table: toml::Table) -> Result<Scene, toml::de::Error> {
    SpaceScene::deserialize(toml::Value::Table(table)).map(SpaceScene::into_scene)
}
