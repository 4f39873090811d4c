//! One page per run that shows the motion: an HTML file that needs no network and no other file.
//!
//! Poses, contact forces and energies are kept of the start, of every k-th step, at most [`MOST_FRAMES`] however long the run
//! is as k doubles when there are more, and of the last step. At the end they are quantised (`pack`), compressed, and put
//! into a page that draws them (`viewer.html`).

mod pack;
mod shapes;

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use base64::Engine as _;
use serde::{Deserialize, Serialize};

use self::pack::pack;
use super::{Frame, ObserveError, Observer, RunInfo, Units};
use crate::contact::ContactId;
use crate::file::AtomicFile;
use crate::scalar::{Scalar, to_f64};
use crate::system::System;

/// Frames kept, beside those of the start and the end.
pub const MOST_FRAMES: usize = 500;

/// Contact forces kept of a frame, the largest.
const MOST_FORCES: usize = 800;

/// The page, with places for the title and the data.
const VIEWER: &str = include_str!("viewer.html");

/// A pose: position (m), then the unit quaternion (w, x, y, z).
type Pose = [f32; 7];

/// The percussions of a contact since the last frame, as one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Push {
    /// Where it was last.
    point: [f32; 3],
    /// Sum of the percussions (N s) in the fixed frame.
    impulse: [f32; 3],
}

impl Push {
    fn size(&self) -> f32 {
        self.impulse.iter().map(|x| x * x).sum()
    }
}

type Pushes = BTreeMap<ContactId, Push>;

/// Adds the pushes of a later time to those of an earlier one.
fn add(earlier: &mut Pushes, later: impl IntoIterator<Item = (ContactId, Push)>) {
    for (id, Push { point, impulse }) in later {
        let sum = earlier.entry(id).or_insert(Push { point, impulse: [0.0; 3] });
        sum.point = point;
        sum.impulse.iter_mut().zip(impulse).for_each(|(sum, x)| *sum += x);
    }
}

/// What is shown of a step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Still {
    /// Number of the step.
    index: u64,
    /// Time (s).
    time: f64,
    /// Poses, in the order of the bodies.
    poses: Vec<Pose>,
    /// Energies [kinetic, elastic, potential] (J).
    energies: [f64; 3],
    /// Pushes since the frame before, and how many smaller ones are left out.
    pushes: Pushes,
    left_out: u64,
}

/// What is kept of a run.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
struct Film {
    law: String,
    solver: String,
    /// The bodies that have a shape.
    bodies: Vec<u64>,
    /// Steps between frames.
    every: u64,
    stills: Vec<Still>,
    /// Pushes since the last frame.
    pending: Pushes,
}

impl Film {
    /// Drops every second frame, whose pushes go to the frame after it.
    fn thin(&mut self) {
        self.every *= 2;
        let mut kept: Vec<Still> = Vec::with_capacity(self.stills.len());
        let mut carried = Pushes::new();
        for mut still in self.stills.drain(..) {
            let pushes = std::mem::take(&mut still.pushes);
            add(&mut carried, pushes);
            if still.index.is_multiple_of(self.every) {
                (still.pushes, still.left_out) = largest(std::mem::take(&mut carried), still.left_out);
                kept.push(still);
            }
        }
        add(&mut carried, std::mem::take(&mut self.pending));
        self.pending = carried;
        self.stills = kept;
    }
}

/// The largest pushes, and how many are left out with those that were before.
fn largest(mut pushes: Pushes, before: u64) -> (Pushes, u64) {
    let Some(excess) = pushes.len().checked_sub(MOST_FORCES + 1) else { return (pushes, before) };
    let mut sizes: Vec<f32> = pushes.values().map(Push::size).collect();
    let (_, &mut least, _) = sizes.select_nth_unstable_by(excess, f32::total_cmp);
    let count = pushes.len();
    pushes.retain(|_, push| push.size() > least);
    let left_out = before + (count - pushes.len()) as u64;
    (pushes, left_out)
}

/// Where a page stands, to go on from there.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HtmlMark(Film);

/// Writes a page that shows the motion at the end of a run. Systems without [`solids`](crate::system::Describe::solids) have
/// none.
#[derive(Debug)]
pub struct HtmlPage {
    path: PathBuf,
    title: String,
    units: Units,
    film: Film,
    written: bool,
}

impl HtmlPage {
    /// The page at `path`, of a run of a scene with this title in these units.
    pub fn new(path: &Path, title: &str, units: Units) -> Self {
        Self { path: path.into(), title: title.into(), units, film: Film::default(), written: false }
    }

    /// Marks the place.
    pub fn mark(&self) -> HtmlMark {
        HtmlMark(self.film.clone())
    }

    /// Goes on from a mark.
    #[must_use]
    pub fn resume(self, mark: HtmlMark) -> Self {
        Self { film: mark.0, ..self }
    }

    /// The file, once it is written.
    pub fn written(&self) -> Option<&Path> {
        self.written.then_some(&self.path)
    }

    fn is_off(&self) -> bool {
        self.film.bodies.is_empty()
    }

    fn record<T: Scalar, const D: usize>(&mut self, frame: Frame<'_, T, D>) {
        let film = &mut self.film;
        let pose = |&body: &u64| {
            let (position, turn) = frame.system.body_pose(body as usize, &frame.state.q);
            let all = [position.as_slice(), &turn].concat();
            std::array::from_fn(|i| all[i] as f32)
        };
        let mut poses: Vec<Pose> = film.bodies.iter().map(pose).collect();
        // A run that breaks down is shown where it was last.
        if let Some(last) = film.stills.last() {
            let lost = |pose: &Pose| pose.iter().any(|x| !x.is_finite());
            let lost = poses.iter_mut().zip(&last.poses).filter(|(pose, _)| lost(pose));
            lost.for_each(|(pose, last)| *pose = *last);
        }
        let energies = frame.step.energies;
        let (pushes, left_out) = largest(std::mem::take(&mut film.pending), 0);
        film.stills.push(Still {
            index: frame.state.index as u64,
            time: to_f64(frame.state.time),
            poses,
            energies: [energies.kinetic, energies.elastic, energies.potential].map(to_f64),
            pushes,
            left_out,
        });
    }

    fn write<T: Scalar, const D: usize>(&self, system: &dyn System<T, D>) -> Result<(), ObserveError> {
        let up = up(system);
        let write = || -> std::io::Result<()> {
            let data = pack(&self.film, (&self.title, self.units), &system.solids(), up)?;
            let data = base64::engine::general_purpose::STANDARD.encode(data);
            let mut file = AtomicFile::create(&self.path)?;
            let title = escape(&format!("{} – {}", self.title, self.film.law));
            let page = VIEWER.replacen("{{title}}", &title, 1);
            let (before, after) = page.split_once("{{data}}").unwrap_or((&page, ""));
            [before, &data, after].iter().try_for_each(|part| file.write_all(part.as_bytes()))?;
            file.commit()
        };
        write().map_err(|error| ObserveError::new(&self.path, error))
    }
}

/// Text as HTML.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Where up is in a picture in space: against the constant force on the first body, or along z.
fn up<T: Scalar, const D: usize>(system: &dyn System<T, D>) -> [f64; 3] {
    let forces = system.forces().constant_part();
    let force = [0, 1, 2].map(|i| forces.get(i).map_or(0.0, |&x| to_f64(x)));
    let size = force.iter().map(|x| x * x).sum::<f64>().sqrt();
    if size > 0.0 && size.is_finite() { force.map(|x| -x / size) } else { [0.0, 0.0, 1.0] }
}

impl<T: Scalar, const D: usize> Observer<T, D> for HtmlPage {
    fn begin(&mut self, run: &RunInfo, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        let solids = frame.system.solids();
        let mut bodies: Vec<u64> = solids.iter().filter_map(|solid| Some(solid.body? as u64)).collect();
        bodies.sort_unstable();
        bodies.dedup();
        self.film =
            Film { law: run.law.clone(), solver: run.solver.clone(), bodies, every: 1, ..Film::default() };
        self.written = false;
        if !self.is_off() {
            self.record(frame);
        }
        Ok(())
    }

    fn step(&mut self, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        if self.is_off() {
            return Ok(());
        }
        let placed = frame.step.contacts.iter().filter_map(|contact| {
            if contact.percussion.iter().all(|&p| p == T::zero()) {
                return None;
            }
            let place = frame.system.contact_place(contact.id, &frame.state.q)?;
            let mut impulse = [0.0; 3];
            for (axis, &p) in place.axes.iter().zip(contact.percussion.iter()) {
                impulse.iter_mut().zip(axis).for_each(|(sum, x)| *sum += (x * to_f64(p)) as f32);
            }
            let point = place.point.map(|x| x as f32);
            let finite = impulse.iter().chain(&point).all(|x| x.is_finite());
            finite.then_some((contact.id, Push { point, impulse }))
        });
        add(&mut self.film.pending, placed);
        if (frame.state.index as u64).is_multiple_of(self.film.every.max(1)) {
            self.record(frame);
            if self.film.stills.len() > MOST_FRAMES + 1 {
                self.film.thin();
            }
        }
        Ok(())
    }

    fn end(&mut self, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        if self.is_off() {
            return Ok(());
        }
        let last = self.film.stills.last().map(|still| still.index);
        if last != Some(frame.state.index as u64) {
            self.record(frame);
        }
        self.write(frame.system)?;
        self.written = true;
        Ok(())
    }
}
