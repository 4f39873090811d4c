//! Several systems as one: degrees of freedom and coordinates one member after another, contacts named by member.

mod joints;

use std::ops::Range;

use super::{ContactPlace, Contacts, Describe, Dynamics, Forces, Joints, Prescribed, Scales, Solid, System};
use crate::contact::{Candidate, ContactId};
use crate::linalg::{BlockRows, Symmetric};
use crate::scalar::Scalar;

/// A system of systems: rigid bodies, elastic bodies, several of each.
///
/// The degrees of freedom, coordinates, interfaces and joint rows of its members stand one after another, in the order in
/// which the members were given. Contacts within a member are found by that member; contacts across members by whatever
/// implements [`Contacts`] over the coordinates and degrees of freedom of the whole, with interfaces after those of the
/// members.
///
/// ```
/// use nalgebra::SVector;
/// use nonsmooth::linalg::Symmetric;
/// use nonsmooth::system::{Assembly, Dynamics, Lagrangian, SmoothContacts, SmoothGap};
///
/// // Two beads on a line, each a system of its own, that may hit each other.
/// let bead = || Lagrangian::<f64, 1>::new(Symmetric::diagonal(vec![1.0]).unwrap());
/// let gap = SmoothGap::new(
///     |q: &[f64]| q[1] - q[0],
///     |_: &[f64], push: &mut dyn FnMut(usize, SVector<f64, 1>)| {
///         push(0, SVector::<f64, 1>::new(-1.0));
///         push(1, SVector::<f64, 1>::new(1.0));
///     },
/// );
/// let mut across = SmoothContacts::default();
/// across.push(0, gap);
/// let pair = Assembly::new(vec![("left", Box::new(bead())), ("right", Box::new(bead()))])?.with_contacts_across(across);
/// assert_eq!(pair.dofs(), 2);
/// # Ok::<(), nonsmooth::system::AssemblyError>(())
/// ```
#[derive(Debug)]
pub struct Assembly<T: Scalar, const D: usize> {
    members: Vec<Member<T, D>>,
    across: Option<Box<dyn Contacts<T, D>>>,
    mass: Symmetric<T>,
    damping: Option<Symmetric<T>>,
    stiffness: Option<Symmetric<T>>,
    forces: Forces<T>,
    torques: Option<Forces<T>>,
    prescribed: Option<Prescribed<T>>,
    body_dofs: Option<usize>,
    coordinates: usize,
    joint_rows: usize,
    /// Candidates of one member, in its own names.
    found: Vec<Candidate<T>>,
    times: Vec<(ContactId, T)>,
}

/// A member and its places in the whole.
#[derive(Debug)]
struct Member<T: Scalar, const D: usize> {
    name: String,
    system: Box<dyn System<T, D>>,
    q: Range<usize>,
    v: Range<usize>,
    interfaces: Range<usize>,
    joint_rows: Range<usize>,
}

/// Why systems could not be assembled.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AssemblyError {
    /// More members than contact identities can tell apart.
    #[error("an assembly has {given} members, it may have {most}")]
    TooMany {
        /// Members given.
        given: usize,
        /// Most there may be.
        most: usize,
    },
    /// A member whose equations are nonlinear.
    #[error("`{member}` has nonlinear terms: a nonlinear system stands alone")]
    Nonlinear {
        /// Name of the member.
        member: String,
    },
    /// A member with prescribed motion that is not the last one.
    #[error(
        "`{member}` has degrees of freedom that move as told: they must be the last ones, and so must the member"
    )]
    Prescribed {
        /// Name of the member.
        member: String,
    },
}

impl<T: Scalar, const D: usize> Assembly<T, D> {
    /// The members, each with the name that outputs put before its own.
    ///
    /// # Errors
    /// [`AssemblyError`].
    pub fn new<N: Into<String>>(members: Vec<(N, Box<dyn System<T, D>>)>) -> Result<Self, AssemblyError> {
        let most = ContactId::MOST_MEMBERS;
        if members.len() > most {
            return Err(AssemblyError::TooMany { given: members.len(), most });
        }
        let last = members.len().saturating_sub(1);
        let [mut q, mut v, mut interfaces, mut rows] = [0; 4];
        let after = |end: &mut usize, count: usize| {
            *end += count;
            *end - count..*end
        };
        let place = |(i, (name, system)): (usize, (N, Box<dyn System<T, D>>))| {
            let name = name.into();
            if system.nonlinear().is_some() {
                return Err(AssemblyError::Nonlinear { member: name });
            }
            if i < last && system.prescribed().is_some() {
                return Err(AssemblyError::Prescribed { member: name });
            }
            Ok(Member {
                name,
                q: after(&mut q, system.coordinates()),
                v: after(&mut v, system.dofs()),
                interfaces: after(&mut interfaces, system.interfaces()),
                joint_rows: after(&mut rows, system.joints().map_or(0, Joints::rows)),
                system,
            })
        };
        let members = members.into_iter().enumerate().map(place).collect::<Result<Vec<_>, _>>()?;
        let operators = |of: fn(&dyn System<T, D>) -> Option<&Symmetric<T>>| {
            let parts = members.iter().map(|member| (of(&*member.system), member.v.len()));
            Symmetric::block_diagonal(parts)
        };
        let any_torque = members.iter().any(|member| member.system.fixed_torques().is_some());
        let torques = |member: &Member<T, D>| {
            let none = || Forces::constant(vec![T::zero(); member.v.len()]);
            member.system.fixed_torques().cloned().unwrap_or_else(none)
        };
        let mut units = members.iter().map(|member| member.system.body_dofs());
        let unit = units.next().flatten();
        Ok(Self {
            across: None,
            mass: operators(|system| Some(system.mass())).unwrap_or(Symmetric::Diagonal(Vec::new())),
            damping: operators(|system| system.damping()),
            stiffness: operators(|system| system.stiffness()),
            forces: Forces::joined(members.iter().map(|member| member.system.forces().clone())),
            torques: any_torque.then(|| Forces::joined(members.iter().map(torques))),
            prescribed: members
                .last()
                .and_then(|member| Some(member.system.prescribed()?.shifted(member.v.start))),
            body_dofs: unit.filter(|&unit| units.all(|other| other == Some(unit))),
            coordinates: q,
            joint_rows: rows,
            members,
            found: Vec::new(),
            times: Vec::new(),
        })
    }

    /// Adds contacts across members, over the coordinates and degrees of freedom of the whole; their interfaces follow those
    /// of the members.
    #[must_use]
    pub fn with_contacts_across(mut self, across: impl Contacts<T, D> + 'static) -> Self {
        self.across = Some(Box::new(across));
        self
    }

    /// Interfaces within members.
    fn inner_interfaces(&self) -> usize {
        self.members.last().map_or(0, |member| member.interfaces.end)
    }

    /// The members with their bodies; one that is none of bodies counts as one.
    fn with_bodies(&self) -> impl Iterator<Item = (&Member<T, D>, Range<usize>)> {
        self.members.iter().scan(0, |first, member| {
            let count = member.system.body_dofs().map_or(1, |dofs| member.v.len() / dofs.max(1));
            *first += count;
            Some((member, *first - count..*first))
        })
    }

    /// The member that a place of the whole falls into.
    fn at(
        &self,
        index: usize,
        places: impl Fn(&Member<T, D>) -> &Range<usize>,
    ) -> Option<(&Member<T, D>, usize)> {
        let member = self.members.iter().find(|member| places(member).contains(&index))?;
        Some((member, index - places(member).start))
    }

    /// Appends what `find` finds in every member and across, in the names of the whole.
    fn collect(
        &mut self,
        q: &[T],
        out: &mut Vec<Candidate<T>>,
        mut find: impl FnMut(&mut dyn Contacts<T, D>, &[T], Range<usize>, &mut Vec<Candidate<T>>),
    ) {
        let inner = self.inner_interfaces();
        let Self { members, across, found, .. } = self;
        for (i, member) in members.iter_mut().enumerate() {
            found.clear();
            find(&mut *member.system, &q[member.q.clone()], member.v.clone(), found);
            out.extend(found.drain(..).map(|candidate| Candidate {
                id: candidate.id.of_member(i),
                interface: member.interfaces.start.saturating_add(candidate.interface),
                ..candidate
            }));
        }
        if let Some(across) = across {
            let first = out.len();
            find(&mut **across, q, 0..self.mass.size(), out);
            out[first..].iter_mut().for_each(|candidate| candidate.interface += inner);
        }
    }
}

impl<T: Scalar, const D: usize> Dynamics<T> for Assembly<T, D> {
    fn coordinates(&self) -> usize {
        self.coordinates
    }

    fn advance(&self, q: &[T], s: &[T], out: &mut [T]) {
        for Member { system, q: place, v, .. } in &self.members {
            system.advance(&q[place.clone()], &s[v.clone()], &mut out[place.clone()]);
        }
    }

    fn difference(&self, from: &[T], to: &[T], out: &mut [T]) {
        for Member { system, q: place, v, .. } in &self.members {
            system.difference(&from[place.clone()], &to[place.clone()], &mut out[v.clone()]);
        }
    }

    fn is_flat(&self) -> bool {
        self.members.iter().all(|member| member.system.is_flat())
    }

    fn flies(&self) -> bool {
        self.members.iter().any(|member| member.system.flies())
    }

    fn fly(&self, times: &[T], q: &mut [T], v: &mut [T]) {
        for Member { system, q: place, v: dofs, .. } in &self.members {
            system.fly(&times[dofs.clone()], &mut q[place.clone()], &mut v[dofs.clone()]);
        }
    }

    fn land(&self, start: &[T], s: &[T], times: &[T], q: &mut [T], v: &mut [T]) {
        for Member { system, q: place, v: dofs, .. } in &self.members {
            let (start, s) = (&start[place.clone()], &s[dofs.clone()]);
            system.land(start, s, &times[dofs.clone()], &mut q[place.clone()], &mut v[dofs.clone()]);
        }
    }

    fn fixed_torques(&self) -> Option<&Forces<T>> {
        self.torques.as_ref()
    }

    fn pull_back(&self, q: &[T], torques: &[T], force: &mut [T]) {
        for Member { system, q: place, v: dofs, .. } in &self.members {
            system.pull_back(&q[place.clone()], &torques[dofs.clone()], &mut force[dofs.clone()]);
        }
    }

    fn mass(&self) -> &Symmetric<T> {
        &self.mass
    }

    fn damping(&self) -> Option<&Symmetric<T>> {
        self.damping.as_ref()
    }

    fn stiffness(&self) -> Option<&Symmetric<T>> {
        self.stiffness.as_ref()
    }

    fn forces(&self) -> &Forces<T> {
        &self.forces
    }

    fn potential(&self, q: &[T]) -> T {
        let of = |member: &Member<T, D>| member.system.potential(&q[member.q.clone()]);
        self.members.iter().fold(T::zero(), |sum, member| sum + of(member))
    }

    fn prescribed(&self) -> Option<&Prescribed<T>> {
        self.prescribed.as_ref()
    }

    fn joints(&self) -> Option<&dyn Joints<T>> {
        (self.joint_rows > 0).then_some(self)
    }

    fn body_dofs(&self) -> Option<usize> {
        self.body_dofs
    }

    fn turns(&self, dof: usize) -> bool {
        self.at(dof, |member| &member.v).is_some_and(|(member, dof)| member.system.turns(dof))
    }

    /// The largest of the members.
    fn scales(&self, q: &[T], v: &[T]) -> Scales<T> {
        let larger = nalgebra::RealField::max;
        let of = |member: &Member<T, D>| member.system.scales(&q[member.q.clone()], &v[member.v.clone()]);
        self.members
            .iter()
            .map(of)
            .reduce(|a, b| Scales { length: larger(a.length, b.length), speed: larger(a.speed, b.speed) })
            .unwrap_or_else(|| Scales::of(&[], &[]))
    }
}

impl<T: Scalar, const D: usize> Contacts<T, D> for Assembly<T, D> {
    fn interfaces(&self) -> usize {
        self.inner_interfaces() + self.across.as_ref().map_or(0, |across| across.interfaces())
    }

    fn constant_jacobian(&self) -> bool {
        self.members.iter().all(|member| member.system.constant_jacobian())
            && self.across.as_ref().is_none_or(|across| across.constant_jacobian())
    }

    fn candidates(&mut self, q: &[T], reach: T, out: &mut Vec<Candidate<T>>) {
        self.collect(q, out, |contacts, q, _, out| contacts.candidates(q, reach, out));
    }

    fn awake_candidates(&mut self, q: &[T], reach: T, asleep: &[bool], out: &mut Vec<Candidate<T>>) {
        let unit = self.body_dofs.unwrap_or(1);
        self.collect(q, out, |contacts, q, dofs, out| {
            let asleep = asleep.get(dofs.start / unit..dofs.end / unit).unwrap_or(&[]);
            contacts.awake_candidates(q, reach, asleep, out);
        });
    }

    fn swept_candidates(
        &mut self,
        q: &[T],
        (step, path): (T, &[T]),
        asleep: &[bool],
        out: &mut Vec<Candidate<T>>,
        times: &mut Vec<(ContactId, T)>,
    ) {
        let unit = self.body_dofs.unwrap_or(1);
        let inner = self.inner_interfaces();
        let Self { members, across, found, times: met, .. } = self;
        let mut visit = |member: Option<usize>,
                         contacts: &mut dyn Contacts<T, D>,
                         (q, v): (&[T], Range<usize>),
                         first: usize| {
            // Those of this member, in its own names, are taken out and come back.
            found.clear();
            met.clear();
            let own = |id: ContactId| match (id.in_member(), member) {
                (Some((of, id)), Some(member)) if of == member => Some(id),
                (None, None) => Some(id),
                _ => None,
            };
            let asleep = asleep.get(v.start / unit..v.end / unit).unwrap_or(&[]);
            found.extend(out.iter().filter_map(|candidate| {
                let id = own(candidate.id)?;
                Some(Candidate { id, interface: candidate.interface - first, ..*candidate })
            }));
            contacts.swept_candidates(q, (step, &path[v]), asleep, found, met);
            if met.is_empty() {
                return;
            }
            let named = |id: ContactId| member.map_or(id, |member| id.of_member(member));
            out.retain(|candidate| own(candidate.id).is_none());
            out.extend(found.iter().map(|candidate| Candidate {
                id: named(candidate.id),
                interface: candidate.interface + first,
                ..*candidate
            }));
            times.extend(met.iter().map(|&(id, time)| (named(id), time)));
        };
        for (i, member) in members.iter_mut().enumerate() {
            let place = (&q[member.q.clone()], member.v.clone());
            visit(Some(i), &mut *member.system, place, member.interfaces.start);
        }
        if let Some(across) = across {
            visit(None, &mut **across, (q, 0..path.len()), inner);
        }
    }

    fn jacobian(&self, contact: ContactId, q: &[T], out: &mut BlockRows<T, D>) {
        match contact.in_member() {
            Some((i, contact)) => {
                let Member { system, q: place, v, .. } = &self.members[i];
                system.jacobian(contact, &q[place.clone()], out);
                out.shift_row(out.rows() - 1, v.start);
            }
            None => match &self.across {
                Some(across) => across.jacobian(contact, q, out),
                None => out.start_row(),
            },
        }
    }

    fn gap(&self, contact: ContactId, q: &[T]) -> T {
        match contact.in_member() {
            Some((i, contact)) => self.members[i].system.gap(contact, &q[self.members[i].q.clone()]),
            None => self.across.as_ref().map_or_else(T::infinity_impl, |across| across.gap(contact, q)),
        }
    }
}

impl<T: Scalar, const D: usize> Describe<T> for Assembly<T, D> {
    fn dof_label(&self, dof: usize) -> String {
        let found = self.at(dof, |member| &member.v);
        found.map_or_else(String::new, |(m, dof)| format!("{}.{}", m.name, m.system.dof_label(dof)))
    }

    fn dof_unit(&self, dof: usize) -> &'static str {
        self.at(dof, |member| &member.v).map_or("m", |(member, dof)| member.system.dof_unit(dof))
    }

    fn coordinate_of(&self, dof: usize) -> usize {
        let found = self.at(dof, |member| &member.v);
        found.map_or(dof, |(member, i)| member.q.start + member.system.coordinate_of(i))
    }

    fn coordinate_label(&self, coordinate: usize) -> String {
        let found = self.at(coordinate, |member| &member.q);
        found.map_or_else(String::new, |(m, i)| format!("{}.{}", m.name, m.system.coordinate_label(i)))
    }

    fn contact_label(&self, contact: ContactId) -> String {
        match contact.in_member() {
            Some((i, contact)) => {
                format!("{}.{}", self.members[i].name, self.members[i].system.contact_label(contact))
            }
            None => format!("across.{}", contact.number()),
        }
    }

    fn solids(&self) -> Vec<Solid> {
        let of = |(member, bodies): (&Member<T, D>, Range<usize>)| {
            let named = |solid: Solid| Solid {
                name: format!("{}.{}", member.name, solid.name),
                body: solid.body.map(|body| bodies.start + body),
                ..solid
            };
            member.system.solids().into_iter().map(named).collect::<Vec<_>>()
        };
        self.with_bodies().flat_map(of).collect()
    }

    fn body_pose(&self, body: usize, q: &[T]) -> ([f64; 3], [f64; 4]) {
        match self.with_bodies().find(|(_, bodies)| bodies.contains(&body)) {
            Some((m, bodies)) => m.system.body_pose(body - bodies.start, &q[m.q.clone()]),
            None => ([0.0; 3], [1.0, 0.0, 0.0, 0.0]),
        }
    }

    fn body_velocity(&self, body: usize, q: &[T], v: &[T]) -> ([f64; 3], [f64; 3]) {
        match self.with_bodies().find(|(_, bodies)| bodies.contains(&body)) {
            Some((m, bodies)) => {
                m.system.body_velocity(body - bodies.start, &q[m.q.clone()], &v[m.v.clone()])
            }
            None => ([0.0; 3], [0.0; 3]),
        }
    }

    fn contact_place(&self, contact: ContactId, q: &[T]) -> Option<ContactPlace> {
        let (member, contact) = contact.in_member()?;
        let Member { system, q: place, .. } = &self.members[member];
        system.contact_place(contact, &q[place.clone()])
    }

    fn outlines(&self, q: &[T], sides: usize) -> Vec<Vec<[T; 2]>> {
        self.members.iter().flat_map(|member| member.system.outlines(&q[member.q.clone()], sides)).collect()
    }
}
