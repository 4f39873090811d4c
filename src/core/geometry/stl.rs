//! STL files, text and binary.

use super::surface::{Points, Surface, SurfaceError};
use crate::scalar::Scalar;

/// Bytes before the triangles of a binary file, and of one triangle: its normal, three corners, and two bytes for others.
const HEAD: usize = 84;
const TRIANGLE: usize = 50;

impl<T: Scalar> Surface<T> {
    /// Reads an STL file, text or binary: a binary one has the length that its number of triangles asks for. The normals in
    /// it are ignored, the order of the corners counts. Corners that are equal to the last digit are one point.
    ///
    /// # Errors
    ///
    /// [`SurfaceError::Text`], [`SurfaceError::Length`], and [`SurfaceError::Empty`] without triangles.
    pub fn from_stl(bytes: &[u8]) -> Result<Self, SurfaceError> {
        let announced = bytes.get(80..HEAD).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
        let expected = announced.map(|n| (n as usize).saturating_mul(TRIANGLE).saturating_add(HEAD));
        let text = std::str::from_utf8(bytes).ok().filter(|text| text.trim_start().starts_with("solid"));
        let surface = match (text, announced, expected) {
            (_, _, Some(expected)) if expected == bytes.len() => binary(bytes),
            (Some(text), _, _) => from_text(text)?,
            (None, Some(triangles), Some(expected)) => {
                return Err(SurfaceError::Length {
                    triangles: triangles as usize,
                    expected,
                    bytes: bytes.len(),
                });
            }
            _ => {
                let message =
                    "an STL file begins with `solid`, or is binary and has 84 bytes at least".into();
                return Err(SurfaceError::Text { line: 1, message });
            }
        };
        if surface.faces.is_empty() { Err(SurfaceError::Empty) } else { Ok(surface) }
    }
}

fn binary<T: Scalar>(bytes: &[u8]) -> Surface<T> {
    let (mut surface, mut known) = (Surface { points: vec![], faces: vec![] }, Points::default());
    for triangle in bytes[HEAD..].chunks_exact(TRIANGLE) {
        let number = |k: usize| {
            let bytes = [0, 1, 2, 3].map(|b| triangle[12 + 4 * k + b]);
            f64::from(f32::from_le_bytes(bytes))
        };
        let corner = |k: usize| [number(3 * k), number(3 * k + 1), number(3 * k + 2)];
        surface.faces.push([0, 1, 2].map(|k| known.place(&mut surface.points, corner(k))).to_vec());
    }
    surface
}

fn from_text<T: Scalar>(text: &str) -> Result<Surface<T>, SurfaceError> {
    let (mut surface, mut known) = (Surface { points: vec![], faces: vec![] }, Points::default());
    let mut corners = Vec::new();
    for (line, content) in (1..).zip(text.lines()) {
        let wrong = |message: String| Err(SurfaceError::Text { line, message });
        let mut words = content.split_whitespace();
        match words.next().map(str::to_ascii_lowercase).as_deref() {
            Some("vertex") => {
                let x = numbers(words).ok_or_else(|| SurfaceError::Text {
                    line,
                    message: format!("`{}` is no vertex of three numbers", content.trim()),
                })?;
                corners.push(known.place(&mut surface.points, x));
            }
            Some("endfacet") => match corners.len() {
                3 => surface.faces.push(std::mem::take(&mut corners)),
                n => return wrong(format!("a facet of {n} corners; it has three")),
            },
            None | Some("solid" | "facet" | "outer" | "endloop" | "endsolid") => {}
            Some(other) => return wrong(format!("`{other}` is no word of an STL file")),
        }
    }
    if corners.is_empty() {
        return Ok(surface);
    }
    Err(SurfaceError::Text { line: text.lines().count(), message: "the last facet does not end".into() })
}

/// Three finite numbers and no more.
pub(super) fn numbers<'a>(mut words: impl Iterator<Item = &'a str>) -> Option<[f64; 3]> {
    let mut next = || words.next()?.parse().ok().filter(|x: &f64| x.is_finite());
    let x = [next()?, next()?, next()?];
    words.next().is_none().then_some(x)
}
