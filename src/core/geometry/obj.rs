//! Wavefront OBJ files: vertices and faces, whatever else they hold.

use super::stl::numbers;
use super::surface::{Points, Surface, SurfaceError};
use crate::scalar::Scalar;

impl<T: Scalar> Surface<T> {
    /// Reads the vertices `v x y z` and the faces `f a b c …` of an OBJ file, with corners `a`, `a/t`, `a//n` or `a/t/n` counted
    /// from 1, or from the end where negative; other lines are skipped. Vertices that are equal to the last digit are one point.
    ///
    /// # Errors
    ///
    /// [`SurfaceError::Text`] with the line, and [`SurfaceError::Empty`] without faces.
    pub fn from_obj(text: &str) -> Result<Self, SurfaceError> {
        let (mut surface, mut known) = (Self { points: vec![], faces: vec![] }, Points::default());
        let mut vertices = Vec::<u32>::new();
        for (line, content) in (1..).zip(text.lines()) {
            let content = content.split('#').next().unwrap_or_default();
            let wrong = |message: String| SurfaceError::Text { line, message };
            let mut words = content.split_whitespace();
            match words.next() {
                Some("v") => {
                    // A weight or a colour may follow.
                    let x = numbers(words.take(3));
                    let x = x.ok_or_else(|| {
                        wrong(format!("`{}` is no vertex of three numbers", content.trim()))
                    })?;
                    vertices.push(known.place(&mut surface.points, x));
                }
                Some("f") => {
                    let mut face = Vec::new();
                    for word in words {
                        let place = corner(word, vertices.len());
                        let place = place.ok_or_else(|| {
                            wrong(format!("corner `{word}` is none of the {} vertices", vertices.len()))
                        })?;
                        face.push(vertices[place]);
                    }
                    if face.len() < 3 {
                        return Err(wrong(format!("a face of {} corners; it has three or more", face.len())));
                    }
                    surface.faces.push(face);
                }
                _ => {}
            }
        }
        if surface.faces.is_empty() { Err(SurfaceError::Empty) } else { Ok(surface) }
    }
}

/// The place, from 0, that a corner names among `count` vertices.
fn corner(word: &str, count: usize) -> Option<usize> {
    let index: i64 = word.split('/').next()?.parse().ok()?;
    let place = if index > 0 { index - 1 } else { i64::try_from(count).ok()? + index };
    usize::try_from(place).ok().filter(|&place| index != 0 && place < count)
}
