//! Chains that are drawn the wrong way round.

use super::names::Directory;
use super::warnings::SceneWarning;
use super::{ChainSpec, ObstacleSpec, Scene, SceneError};

/// Names shown in one warning.
pub(super) const SHOWN: usize = 5;

impl ObstacleSpec {
    /// How far a point of the fixed frame is in front of a chain (m), negative behind it and `None` beyond the ends of an open one;
    /// as the scene starts.
    fn before_chain(&self, chain: &ChainSpec, point: [f64; 2]) -> Option<f64> {
        let [x, y, angle] = self.start().unwrap_or([self.position[0], self.position[1], self.angle]);
        let points: Vec<[f64; 2]> = (chain.points.iter())
            .map(|&own| {
                let [a, b] = super::obstacles::turned(own, angle);
                [x + a, y + b]
            })
            .collect();
        let last = if chain.closed { points.len() } else { points.len().saturating_sub(1) };
        // Of the segments that share the nearest point, the one whose line is farthest off tells the side.
        let mut nearest: Option<(f64, f64, bool)> = None;
        for i in 0..last {
            let (from, to) = (points[i], points[(i + 1) % points.len()]);
            let along = [to[0] - from[0], to[1] - from[1]];
            let length = along[0].hypot(along[1]);
            let off = [point[0] - from[0], point[1] - from[1]];
            let part = (off[0] * along[0] + off[1] * along[1]) / (length * length);
            let beyond = !chain.closed && (i == 0 && part < 0.0 || i + 1 == last && part > 1.0);
            let at = part.clamp(0.0, 1.0);
            let distance = (off[0] - at * along[0]).hypot(off[1] - at * along[1]);
            let side = (along[0] * off[1] - along[1] * off[0]) / length;
            let is_nearer = nearest.is_none_or(|(least, other, _)| {
                let same = (distance - least).abs() <= 1e-9 * (distance + length);
                if same { side.abs() > f64::abs(other) } else { distance < least }
            });
            if is_nearer {
                nearest = Some((distance, side, beyond));
            }
        }
        nearest.filter(|&(_, side, beyond)| !beyond && side != 0.0).map(|(_, side, _)| side)
    }
}

impl Scene {
    /// Tells of chains behind which all bodies start that may touch them. Where some start in front, those behind may have their
    /// reasons: a body below a floor, or one that comes round the end.
    pub(super) fn warn_of_chains(&self, warnings: &mut Vec<SceneWarning>) -> Result<(), SceneError> {
        if self.obstacles.iter().all(|obstacle| obstacle.chains.is_empty()) {
            return Ok(());
        }
        let directory = Directory::new(self)?;
        for (obstacle, shapes) in self.obstacles.iter().zip(&directory.obstacles) {
            let first = obstacle.discs.len() + obstacle.polygons.len();
            for (chain, names) in obstacle.chains.iter().zip(shapes.iter().skip(first)) {
                let sides = Directory::sides(self, names);
                let touches = |shapes: &Vec<_>| {
                    let meets = |own| Directory::interface_between(&Directory::sides(self, own), &sides);
                    shapes.iter().any(|own| meets(own).is_some())
                };
                let (mut behind, mut before) = (Vec::new(), 0);
                for (body, _) in self.bodies.iter().zip(&directory.contactors).filter(|(_, own)| touches(own))
                {
                    match obstacle.before_chain(chain, body.position) {
                        Some(distance) if distance < 0.0 => behind.push(body.name.clone()),
                        _ => before += 1,
                    }
                }
                if before == 0 && !behind.is_empty() {
                    let chain = format!("{}.{}", obstacle.name, chain.name);
                    warnings.push(SceneWarning::BehindChain { chain, bodies: behind });
                }
            }
        }
        Ok(())
    }
}
