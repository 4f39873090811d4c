//! Names of a scene: who is meant by the sides of an interface.

use std::collections::{BTreeMap, BTreeSet};

use super::{Scene, SceneError, SpaceSpec};

/// The names a contactor or a half-plane answers to.
type Names = BTreeSet<String>;

/// A body or an obstacle as the scene names it, and its shapes in the order in which they are built.
pub(super) struct Owner {
    pub(super) name: String,
    pub(super) shapes: Vec<String>,
    pub(super) groups: Vec<String>,
}

/// What every contactor and half-plane is called, and the groups of those that behave alike.
pub(super) struct Directory {
    /// The bodies.
    pub(super) bodies: Vec<Owner>,
    /// Names of contactor j of body i.
    pub(super) contactors: Vec<Vec<Names>>,
    /// Names of shape j of obstacle i.
    pub(super) obstacles: Vec<Vec<Names>>,
    /// Names of each half-plane, or half-space.
    pub(super) planes: Vec<Names>,
}

impl Scene {
    /// The bodies, discs before polygons, the obstacles and the half-planes of a scene in the plane.
    fn owners(&self) -> [Vec<Owner>; 3] {
        let bodies = self.bodies.iter().map(|body| {
            let discs = body.discs.iter().map(|disc| &disc.name);
            let shapes = discs.chain(body.polygons.iter().map(|polygon| &polygon.name)).cloned().collect();
            Owner { name: body.name.clone(), shapes, groups: body.groups.clone() }
        });
        let obstacles = self.obstacles.iter().map(|obstacle| Owner {
            name: obstacle.name.clone(),
            shapes: obstacle.shapes().cloned().collect(),
            groups: obstacle.groups.clone(),
        });
        let planes = self.half_planes.iter().map(|plane| Owner::alone(&plane.name));
        [bodies.collect(), obstacles.collect(), planes.collect()]
    }
}

impl Owner {
    /// A half-plane or half-space.
    pub(super) fn alone(name: &str) -> Self {
        Self { name: name.into(), shapes: Vec::new(), groups: Vec::new() }
    }
}

impl Directory {
    pub(super) fn new(scene: &Scene) -> Result<Self, SceneError> {
        let mut taken = BTreeSet::new();
        let mut take = |name: String| {
            if taken.insert(name.clone()) { Ok(()) } else { Err(SceneError::DuplicateName { name }) }
        };
        let [bodies, obstacles, planes] =
            scene.space.as_ref().map_or_else(|| scene.owners(), SpaceSpec::owners);
        let mut groups = BTreeSet::new();
        let mut shapes = |Owner { name: owner, shapes, groups: of }: &Owner| {
            take(owner.clone())?;
            groups.extend(of.iter().cloned());
            let mut all = Vec::new();
            for name in shapes {
                let full = format!("{owner}.{name}");
                take(full.clone())?;
                all.push([owner.clone(), full].into_iter().chain(of.iter().cloned()).collect());
            }
            Ok::<Vec<Names>, SceneError>(all)
        };
        let contactors = bodies.iter().map(&mut shapes).collect::<Result<_, _>>()?;
        let obstacles = obstacles.iter().map(&mut shapes).collect::<Result<_, _>>()?;
        planes.iter().try_for_each(|plane| shapes(plane).map(|_| ()))?;
        let planes = planes.into_iter().map(|plane| Names::from([plane.name])).collect();
        for group in groups {
            take(group)?;
        }
        Ok(Self { bodies, contactors, obstacles, planes })
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

    /// The group of every shape.
    pub(super) fn groups(&self, scene: &Scene) -> Groups {
        let mut index = BTreeMap::new();
        let mut of = |names: &Names| {
            let next = index.len();
            *index.entry(Self::sides(scene, names)).or_insert(next)
        };
        let mut of_all = |all: &[Vec<Names>]| -> Vec<Vec<usize>> {
            all.iter().map(|shapes| shapes.iter().map(&mut of).collect()).collect()
        };
        let (contactors, obstacles) = (of_all(&self.contactors), of_all(&self.obstacles));
        let planes = self.planes.iter().map(of).collect();
        let mut sides: Vec<_> = index.into_iter().collect();
        sides.sort_by_key(|&(_, index)| index);
        let sides = sides.into_iter().map(|(sides, _)| sides).collect();
        Groups { contactors, obstacles, planes, sides }
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

/// The groups of all shapes, numbered in order of appearance: what stands on the same sides of all interfaces is one.
pub(super) struct Groups {
    /// Of contactor j of body i.
    pub(super) contactors: Vec<Vec<usize>>,
    /// Of shape j of obstacle i.
    pub(super) obstacles: Vec<Vec<usize>>,
    /// Of each half-plane, or half-space.
    pub(super) planes: Vec<usize>,
    /// The sides that each group stands on.
    pub(super) sides: Vec<Vec<[bool; 2]>>,
}

impl Groups {
    /// The interfaces between groups: both groups, and which of the scene's governs them.
    pub(super) fn interfaces(&self) -> impl Iterator<Item = ([usize; 2], usize)> {
        let pairs = (0..self.sides.len()).flat_map(|a| (a..self.sides.len()).map(move |b| [a, b]));
        pairs.filter_map(|[a, b]| {
            Directory::interface_between(&self.sides[a], &self.sides[b]).map(|interface| ([a, b], interface))
        })
    }
}
