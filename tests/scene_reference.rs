//! The reference of scene files, `src/guide/scene_reference.md`, is what the types that read them say.
//!
//! `UPDATE=1 cargo test --test scene_reference` writes it anew. It is made from the documentation and the serde attributes of
//! the types in `src/scene`, and from the registry; a key whose documentation names no unit fails the test.

#[path = "reference/page.rs"]
mod page;
#[path = "reference/source.rs"]
mod source;

use std::path::Path;

#[test]
#[cfg(feature = "clarabel")]
fn the_reference_of_scene_files_is_that_of_the_types() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/guide/scene_reference.md");
    let generated = page::page();
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(&path, &generated).expect("the page can be written");
        return;
    }
    let stored = std::fs::read_to_string(&path).expect("the page");
    let differs = stored.lines().zip(generated.lines()).position(|(a, b)| a != b);
    assert!(
        stored == generated,
        "src/guide/scene_reference.md is not what the types say (first at line {:?}): UPDATE=1 cargo test --test \
         scene_reference writes it anew",
        differs.map(|line| line + 1)
    );
}

#[test]
fn every_key_of_a_scene_is_on_the_page_and_in_the_examples_known() {
    let page = page::page();
    for key in
        ["title", "laws", "step", "tolerance", "figure_contact", "stiffness", "between", "preload", "pattern"]
    {
        assert!(page.contains(&format!("| `{key}` |")), "{key} is not on the page");
    }
}
