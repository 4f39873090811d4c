//! Figures of runs: the six panels of the paper's Figures 2 and 3, and two runs or more side by side.

use super::{RunSeries, Units};
use crate::mesh::Mesh;
use crate::plot::{Dash, Figure, Panel, Series, Style};

/// Width (px at 96 dpi) that fits a journal column of 8.5 cm, and the height of a panel.
const COLUMN: (f64, f64) = (322.0, 140.0);

/// Displacements, velocities, local velocities, percussions, contact works and energies of a run.
pub fn run_figure(series: &RunSeries, units: &Units) -> Figure {
    let t = &series.time;
    let end = t.last().copied().unwrap_or(1.0);
    let line = |label: String, y: &[f64]| Series::new(label, Style::Line, t.clone(), y.to_vec());
    let over_time = |title: &str, label: &str| {
        let mut panel = Panel::new(title, format!("t ({})", units.time), label);
        panel.x_limits = Some((0.0, end));
        panel
    };
    let axes = |symbol: &str, n: usize| {
        let name = move |i: usize| if n == 2 && i == 1 { "T" } else { series.components(n)[i] };
        (0..n).map(|i| format!("${symbol}_{{{}}}$", name(i))).collect::<Vec<_>>()
    };

    let mut displacement = over_time("displacements", &format!("q ({})", dof_units(series, units, "")));
    let mut velocity =
        over_time("velocities", &format!("v ({})", dof_units(series, units, &format!("/{}", units.time))))
            .zero_line();
    for (i, (name, _)) in series.dofs.iter().enumerate() {
        let short = name.rsplit('.').next().unwrap_or(name);
        let symbol = if short == "angle" { "γ" } else { short };
        displacement = displacement.with(line(symbol.into(), &series.q[i]));
        let rate = if symbol == "γ" { "ω".into() } else { format!("$v_{{{symbol}}}$") };
        velocity = velocity.with(line(rate, &series.v[i]));
    }
    let mut local =
        over_time("local velocities", &format!("u ({}/{})", units.length, units.time)).zero_line();
    for (name, u) in axes("u", series.u.len()).into_iter().zip(&series.u) {
        local = local.with(line(name, u));
    }
    let mut percussions = over_time("percussions", &format!("p ({})", units.percussion)).zero_line();
    for (name, p) in axes("p", series.p.len()).into_iter().zip(&series.p) {
        percussions = percussions.with(stems(name, t, p));
    }
    let mut works = over_time("contact works", &format!("w ({})", units.energy)).zero_line();
    for (name, work) in axes("w", 2).into_iter().zip(&series.work) {
        works = works.with(stems(name, t, work));
    }
    let [kinetic, elastic, potential] = &series.energy;
    let mut energies =
        over_time("energies", &format!("E ({})", units.energy)).with(line("kinetic".into(), kinetic));
    if elastic.iter().any(|&e| e != 0.0) {
        energies = energies.with(line("elastic".into(), elastic));
    }
    energies = energies.with(line("potential".into(), potential)).with(line("total".into(), &total(series)));
    let panels = vec![displacement, velocity, local, percussions, works, energies];
    Figure::new(2, panels).size(COLUMN.0, COLUMN.1)
}

/// Tangential contact work and total energy of several runs side by side.
pub fn comparison_figure(runs: &[RunSeries], units: &Units) -> Figure {
    let time = format!("t ({})", units.time);
    let mut work = Panel::new("tangential work", &time, format!("$w_T$ ({})", units.energy)).zero_line();
    let mut energy = Panel::new("total energy", &time, format!("E ({})", units.energy));
    let end = runs.iter().filter_map(|run| run.time.last().copied()).fold(0.0, f64::max);
    let several_solvers = runs.iter().any(|run| run.solver != runs[0].solver);
    for run in runs {
        let label = if several_solvers { format!("{}, {}", run.law, run.solver) } else { run.law.clone() };
        work = work.with(stems(label.clone(), &run.time, &run.work[1]));
        energy = energy.with(Series::new(label, Style::Line, run.time.clone(), total(run)));
    }
    for panel in [&mut work, &mut energy] {
        panel.x_limits = (end > 0.0).then_some((0.0, end));
    }
    Figure::new(2, vec![work, energy]).size(COLUMN.0, COLUMN.1)
}

/// The paper's Figures 6 and 7 of a run of an elastic body: individual energies, works and dissipation against the
/// total energy, the largest tangential work of a contact in each step, and the contact shown.
pub fn elastic_figure(series: &RunSeries, units: &Units) -> Figure {
    let t = &series.time;
    let end = t.last().copied().unwrap_or(1.0);
    let line = |label: &str, y: Vec<f64>| Series::new(label, Style::Line, t.clone(), y);
    let over_time = |title: &str, label: &str| {
        let mut panel = Panel::new(title, format!("t ({})", units.time), label);
        panel.x_limits = Some((0.0, end));
        panel
    };
    let [kinetic, elastic, _] = &series.energy;
    let mechanical: Vec<f64> = kinetic.iter().zip(elastic).map(|(k, e)| k + e).collect();
    let energies = over_time("energies", &format!("E ({})", units.energy))
        .with(line("kinetic", kinetic.clone()))
        .with(line("elastic", elastic.clone()))
        .with(line("total", mechanical.clone()));
    let [external, smooth, contact] = &series.sums;
    let mut works = over_time("works and total energy", &format!("W, E ({})", units.energy)).zero_line();
    works = works.with(line("external", external.clone())).with(line("contact", contact.clone()));
    if smooth.iter().any(|&w| w != 0.0) {
        works = works.with(line("damping", smooth.clone()));
    }
    let first = mechanical.first().copied().unwrap_or(0.0);
    let sum = (0..t.len()).map(|i| first + external[i] + smooth[i] + contact[i]).collect();
    works = works.with(line("$E_0$ + all", sum)).with(line("E", mechanical).dash(Dash::Dotted).width(2.0));
    let largest = over_time("largest tangential work", &format!("max $w_T$ ({})", units.energy))
        .zero_line()
        .with(Series::new("", Style::Markers, t.clone(), series.largest_work.clone()));
    let mut percussions =
        over_time("percussions at one contact", &format!("p ({})", units.percussion)).zero_line();
    for (i, p) in series.p.iter().enumerate() {
        let name = if series.p.len() == 2 && i == 1 { "T" } else { series.components(series.p.len())[i] };
        percussions = percussions.with(line(&format!("$p_{{{name}}}$"), p.clone()));
    }
    // Without friction there is no tangential work to show.
    let tangential = (series.p.len() > 1).then_some(largest);
    let panels = [energies, works].into_iter().chain(tangential).chain([percussions]).collect();
    Figure::new(2, panels).size(2.0 * COLUMN.0, 1.4 * COLUMN.1)
}

/// The paper's Figure 5: a mesh.
pub fn mesh_figure(mesh: &Mesh, units: &Units) -> Figure {
    let mut edges = std::collections::BTreeSet::new();
    for element in mesh.body() {
        let nodes = element.shape.nodes();
        for (i, &a) in nodes.iter().enumerate() {
            let b = nodes[(i + 1) % nodes.len()];
            edges.insert((a.min(b), a.max(b)));
        }
    }
    let at = |node: usize| mesh.nodes()[node].position;
    let lines: Vec<[f64; 4]> =
        edges.into_iter().map(|(a, b)| [at(a)[0], at(a)[1], at(b)[0], at(b)[1]]).collect();
    let axis = |symbol: &str| format!("{symbol} ({})", units.length);
    let mut panel = Panel::new("mesh", axis("x"), axis("y")).with(Series::edges("", &lines));
    panel.equal_aspect = true;
    Figure::new(1, vec![panel]).size(COLUMN.0, 0.75 * COLUMN.0)
}

fn total(series: &RunSeries) -> Vec<f64> {
    let [kinetic, elastic, potential] = &series.energy;
    (0..kinetic.len()).map(|i| kinetic[i] + elastic[i] + potential[i]).collect()
}

/// Impulsive quantities: a stem where there is something, or steps where there is something most of the time.
fn stems(label: String, time: &[f64], y: &[f64]) -> Series {
    let events: Vec<usize> = (0..y.len()).filter(|&i| y[i] != 0.0).collect();
    if events.len() > y.len() / 4 {
        return Series::new(label, Style::Line, time.to_vec(), y.to_vec());
    }
    let at = |column: &[f64]| events.iter().map(|&i| column[i]).collect();
    Series::new(label, Style::Stems, at(time), at(y))
}

/// The units of the degrees of freedom shown, each once.
fn dof_units(series: &RunSeries, names: &Units, suffix: &str) -> String {
    let mut units: Vec<String> = Vec::new();
    for (_, unit) in &series.dofs {
        let unit = format!("{}{suffix}", names.rename(unit));
        if !units.contains(&unit) {
            units.push(unit);
        }
    }
    units.join(", ")
}
