//! Convex polygons as they are given: what is checked, mass and inertia of homogeneous ones.

use nalgebra::Vector2;

use super::body::{Body, check};
use super::identity::MOST_VERTICES;
use crate::scalar::{Scalar, all_finite, lit};
use crate::system::SystemError;

/// Twice the area of the triangle (a, b, c), positive where it turns left.
fn turn<T: Scalar>(a: &[T; 2], b: &[T; 2], c: &[T; 2]) -> T {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// What is wrong with a vertex of a concave outline.
const CONCAVE: &str = "the outline is concave there, polygons are strictly convex: split it, which a scene does by \
                       decompose = true";

pub(super) fn check_polygon<T: Scalar>(label: &str, vertices: &[[T; 2]]) -> Result<(), SystemError> {
    let n = vertices.len();
    let error = |vertex, reason| Err(SystemError::Polygon { label: label.into(), vertex, reason });
    if !(3..=MOST_VERTICES).contains(&n) {
        return error(n, "the number of vertices must be between 3 and 1024");
    }
    if let Some(vertex) = vertices.iter().position(|x| !all_finite(x)) {
        return error(vertex, "it is not finite");
    }
    let turns = |i: usize| turn(&vertices[(i + n - 1) % n], &vertices[i], &vertices[(i + 1) % n]);
    if (0..n).all(|i| turns(i) < T::zero()) {
        return error(0, "the outline runs clockwise: give its vertices in counterclockwise order");
    }
    let area = (1..n - 1).fold(T::zero(), |sum, i| sum + turn(&vertices[0], &vertices[i], &vertices[i + 1]));
    for i in 0..n {
        let [at, after] = [i, (i + 1) % n].map(|k| &vertices[k]);
        if turns(i) == T::zero() {
            return error(i, "the outline is straight there: leave the vertex out");
        }
        if !(turns(i) > T::zero()) {
            return error(i, if area > T::zero() { CONCAVE } else { "the outline must turn left there" });
        }
        // Turning left everywhere could still mean turning round twice.
        if (1..n - 1).contains(&i) && !(turn(&vertices[0], at, after) > T::zero()) {
            return error(i, "the outline winds more than once");
        }
    }
    Ok(())
}

/// Mass (density × area) and inertia of a homogeneous polygon, strictly convex and counterclockwise, and its vertices
/// from its centre of mass, with that centre: (body, vertices, centre).
///
/// # Errors
/// [`SystemError::Polygon`], [`SystemError::OutOfRange`] for a density (kg/m²) that is not positive.
#[expect(clippy::type_complexity)]
pub fn polygon_body<T: Scalar>(
    density: T,
    vertices: &[[T; 2]],
) -> Result<(Body<T>, Vec<[T; 2]>, [T; 2]), SystemError> {
    check_polygon("polygon", vertices)?;
    check(|| "density".into(), &[density], |x| x > T::zero(), "finite and > 0")?;
    // Triangles fanned from the first vertex: area A, centroid of each, and their second moments.
    let (mut area, mut first) = (T::zero(), Vector2::zeros());
    let origin = Vector2::from(vertices[0]);
    let fan = || {
        vertices[1..].windows(2).map(|pair| {
            let (a, b) = (Vector2::from(pair[0]) - origin, Vector2::from(pair[1]) - origin);
            ((a.x * b.y - a.y * b.x) * lit::<T>(0.5), a, b)
        })
    };
    for (part, a, b) in fan() {
        area += part;
        first += (a + b) * (part / lit::<T>(3.0));
    }
    let centre = first / area;
    // ∫ r² over a triangle with a vertex at the origin: A/6 (a² + a·b + b²).
    let second = fan().fold(T::zero(), |sum, (part, a, b)| {
        sum + part * (a.norm_squared() + a.dot(&b) + b.norm_squared()) / lit::<T>(6.0)
    });
    let body = Body { mass: density * area, inertia: density * (second - area * centre.norm_squared()) };
    let centre = centre + origin;
    let vertices = vertices.iter().map(|x| [x[0] - centre.x, x[1] - centre.y]).collect();
    Ok((body, vertices, centre.into()))
}
