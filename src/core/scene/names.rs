//! Names of a scene: who is meant by the sides of an interface.

use std::collections::{BTreeMap, BTreeSet};

use super::{Scene, SceneError};

/// The names a contactor or a half-plane answers to.
type Names = BTreeSet<String>;

/// What every contactor and half-plane is called, and the groups of those that behave alike.
pub(super) struct Directory {
    /// Names of contactor j of body i, discs before polygons.
    pub(super) contactors: Vec<Vec<Names>>,
    /// Names of shape j of obstacle i.
    pub(super) obstacles: Vec<Vec<Names>>,
    /// Names of each half-plane.
    pub(super) planes: Vec<Names>,
}

impl Directory {
    pub(super) fn new(scene: &Scene) -> Result<Self, SceneError> {
        let mut taken = BTreeSet::new();
        let mut take = |name: String| {
            if taken.insert(name.clone()) { Ok(()) } else { Err(SceneError::DuplicateName { name }) }
        };
        let mut groups = BTreeSet::new();
        let mut contactors = Vec::new();
        let mut shapes = |owner: &String, names: &mut dyn Iterator<Item = &String>, of: &[String]| {
            take(owner.clone())?;
            groups.extend(of.iter().cloned());
            let mut all = Vec::new();
            for name in names {
                let full = format!("{owner}.{name}");
                take(full.clone())?;
                all.push([owner.clone(), full].into_iter().chain(of.iter().cloned()).collect());
            }
            Ok::<Vec<Names>, SceneError>(all)
        };
        for body in &scene.bodies {
            let discs = body.discs.iter().map(|disc| &disc.name);
            let mut names = discs.chain(body.polygons.iter().map(|polygon| &polygon.name));
            contactors.push(shapes(&body.name, &mut names, &body.groups)?);
        }
        let mut obstacles = Vec::new();
        for obstacle in &scene.obstacles {
            obstacles.push(shapes(&obstacle.name, &mut obstacle.shapes(), &obstacle.groups)?);
        }
        let mut planes = Vec::new();
        for plane in &scene.half_planes {
            take(plane.name.clone())?;
            planes.push(Names::from([plane.name.clone()]));
        }
        for group in groups {
            take(group)?;
        }
        Ok(Self { contactors, obstacles, planes })
    }

    /// What is no body's: the shapes of obstacles, and half-planes.
    pub(super) fn others(&self) -> impl Iterator<Item = &Names> {
        self.obstacles.iter().flatten().chain(&self.planes)
    }

    fn all(&self) -> impl Iterator<Item = &Names> {
        self.contactors.iter().flatten().chain(self.others())
    }

    /// Checks that every side of every interface names something.
    pub(super) fn check_interfaces(&self, scene: &Scene) -> Result<(), SceneError> {
        let known: BTreeSet<&String> = self.all().flatten().collect();
        for interface in &scene.interfaces {
            for name in &interface.between {
                if !known.contains(name) {
                    let known = known.iter().map(|s| s.as_str()).collect::<Vec<_>>().join(", ");
                    let place = format!("interface {}", interface.label());
                    return Err(SceneError::UnknownName { place, name: name.clone(), known });
                }
            }
        }
        Ok(())
    }

    /// The sides of interfaces a set of names stands on, as a bit per (interface, side): things with the same
    /// sides form one group.
    pub(super) fn sides(scene: &Scene, names: &Names) -> Vec<[bool; 2]> {
        let on = |name: &String| names.contains(name);
        scene.interfaces.iter().map(|i| [on(&i.between[0]), on(&i.between[1])]).collect()
    }

    /// Index of the first interface between two groups, given the sides they stand on.
    pub(super) fn interface_between(a: &[[bool; 2]], b: &[[bool; 2]]) -> Option<usize> {
        a.iter().zip(b).position(|(a, b)| (a[0] && b[1]) || (a[1] && b[0]))
    }
}

/// Groups by the sides they stand on, numbered in order of appearance.
#[derive(Default)]
pub(super) struct Groups {
    index: BTreeMap<Vec<[bool; 2]>, usize>,
}

impl Groups {
    pub(super) fn of(&mut self, sides: Vec<[bool; 2]>) -> usize {
        let next = self.index.len();
        *self.index.entry(sides).or_insert(next)
    }

    pub(super) fn into_sides(self) -> Vec<Vec<[bool; 2]>> {
        let mut sides: Vec<_> = self.index.into_iter().collect();
        sides.sort_by_key(|&(_, index)| index);
        sides.into_iter().map(|(sides, _)| sides).collect()
    }
}
