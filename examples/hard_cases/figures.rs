//! The arch, the stack and the chain, looked at: figures, times per step and iterations with the default solver.

use std::fmt::Write as _;
use std::path::Path;

use nonsmooth::plot::{Figure, Panel, PlotError, Series, Style};
use nonsmooth::system::Describe;

use crate::cases::support::{Outcome, Scheme, drive};
use crate::cases::{Choice, masonry, pendulum, stacks};

/// The outlines of the bodies, a gap between one and the next.
fn shapes(title: &str, system: &dyn Describe<f64>, q: &[f64], take: usize) -> Panel {
    let (mut x, mut y) = (Vec::new(), Vec::new());
    for outline in system.outlines(q, 24).into_iter().take(take) {
        x.extend(outline.iter().map(|p| p[0]).chain([f64::NAN]));
        y.extend(outline.iter().map(|p| p[1]).chain([f64::NAN]));
    }
    let mut panel = Panel::new(title, "x (m)", "y (m)").with(Series::new("", Style::Line, x, y).width(1.0));
    panel.equal_aspect = true;
    panel
}

/// Runs `steps` steps and adds a line to the table.
fn measure<const D: usize>(
    what: &str,
    scheme: &mut Scheme<f64, D>,
    steps: usize,
    table: &mut String,
) -> Result<(), String> {
    let mut outcome = Outcome::default();
    drive(scheme, 1, &mut outcome, |_| ())?;
    let first = outcome.iterations;
    let mut warm = Outcome::default();
    let mut contacts = 0;
    drive(scheme, steps - 1, &mut warm, |scheme| contacts += scheme.last_step().contacts.len())?;
    let per = |total: f64, count: usize| total / count.max(1) as f64;
    let _ = writeln!(
        table,
        "| {what} | {steps} | {:.0} | {first} | {:.1} | {:.1} |",
        per(contacts as f64, warm.steps),
        per(warm.iterations as f64, warm.solves),
        per(warm.seconds * 1e6, warm.steps)
    );
    Ok(())
}

/// Writes `examples/figures/hard_cases.{svg,png}` and returns the table of the runs in Markdown.
pub(crate) fn save() -> Result<String, Box<dyn std::error::Error>> {
    let choice = Choice { law: "fremond", solver: nonsmooth::solver::DEFAULT, full: true };
    let mut table = String::from(
        "| scene | steps | contacts | iterations, first step | iterations, warm step | µs per warm step |\n\
         |---|---|---|---|---|---|\n",
    );
    let voussoirs = masonry::VOUSSOIRS;
    let mut stands = masonry::arch::<f64>(&choice, 0.12, voussoirs, 1e-3, 1e-8)?;
    measure("arch, t/R = 0.12", &mut stands, 2000, &mut table)?;
    let mut falls = masonry::arch::<f64>(&choice, 0.10, voussoirs, 1e-3, 1e-8)?;
    measure("arch, t/R = 0.10, falling", &mut falls, 700, &mut table)?;
    let mut stack = stacks::stack::<f64>(&choice, 10, 1.0, (0.5, 1e-3), 1e-10)?;
    measure("stack of ten squares", &mut stack, 2000, &mut table)?;
    let links = 1000;
    let mut chain = stacks::hanging::<f64>(&choice, links, 1e-3, 1e-11)?;
    measure("chain of 1,000 links", &mut chain, 1000, &mut table)?;

    for (resting, sleep) in [(0, false), (1000, false), (1000, true), (10_000, true)] {
        let mut scene = stacks::disc_among_squares::<f64>(&choice, resting, sleep, 1e-3)?;
        // The steps in which they fall asleep are not counted.
        drive(&mut scene, 20, &mut Outcome::default(), |_| ())?;
        let how = if sleep { ", asleep" } else { "" };
        measure(&format!("a bouncing disc, {resting} squares at rest{how}"), &mut scene, 2000, &mut table)?;
    }

    let mut forces: Vec<f64> = chain.last_step().contacts.iter().map(|c| c.percussion[0] / 1e-3).collect();
    forces.sort_by(|a, b| b.total_cmp(a));
    let index = (0..links).map(|i| (i + 1) as f64).collect();
    let mut tension = Panel::new("chain: tension", "link", "force (kN)");
    tension = tension.with(Series::new("", Style::Line, index, forces.iter().map(|f| f * 1e-3).collect()));
    let mut kane = Panel::new("Kane's pendulum, e = 0.5", "t (s)", "energy (J)");
    for law in ["newton", "fremond"] {
        let [t, energy] = pendulum::energies(&Choice { law, ..choice }, 0.5, 10_000)?;
        kane = kane.with(Series::new(law, Style::Line, t, energy).width(1.0));
    }
    let panels = vec![
        shapes("arch, t/R = 0.12, after 2 s", stands.system(), &stands.state().q, usize::MAX),
        shapes("arch, t/R = 0.10, after 0.7 s", falls.system(), &falls.state().q, usize::MAX),
        shapes("stack, after 2 s", stack.system(), &stack.state().q, usize::MAX),
        shapes("chain, upper links", chain.system(), &chain.state().q, 16),
        tension,
        kane,
    ];
    write(&Figure::new(2, panels).size(322.0, 200.0))?;
    Ok(table)
}

fn write(figure: &Figure) -> Result<(), PlotError> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/figures");
    figure.write_svg(&folder.join("hard_cases.svg"))?;
    figure.write_png(&folder.join("hard_cases.png"), 200.0)
}
