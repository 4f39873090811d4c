//! The energy certificate: random impacts under every registered law, in dimensions 1, 2 and 3, and the largest work a
//! contact did. A law that claims dissipation does none above 1e-13 of the energy.
//!
//! ```text
//! cargo run --release --example energy_certificate              # 10⁶ impacts for every law that claims, and the figure
//! cargo run --release --example energy_certificate -- 10000
//! ```

mod impacts;

use std::path::Path;

use impacts::{Stream, Tally, impacts};
use nonsmooth::laws::LAWS;
use nonsmooth::plot::{Figure, Panel, Scale, Series, Style};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let asked = std::env::args().nth(1).map(|n| n.parse::<usize>()).transpose()?;
    let total = asked.unwrap_or(1_000_000);
    println!(
        "{:8} {:>9} {:>9} {:>9} {:>16} {:>16} {:>8}",
        "law", "impacts", "systems", "unsolved", "max work / E", "max imbalance/E", "time"
    );
    let mut panel = Panel::new("energy certificate", "work / E", "contacts with more work");
    panel.x_scale = Scale::Log10;
    panel.y_scale = Scale::Log10;
    let mut broken = false;
    for law in LAWS {
        let clock = std::time::Instant::now();
        let mut stream = Stream(2026);
        let third = total.div_ceil(3);
        let parts = [
            impacts::<1>(law.name, third, &mut stream),
            impacts::<2>(law.name, third, &mut stream),
            impacts::<3>(law.name, third, &mut stream),
        ];
        let sum = |part: fn(&Tally) -> usize| parts.iter().map(part).sum::<usize>();
        let worst = parts.iter().map(|t| t.worst).fold(f64::MIN, f64::max);
        let imbalance = parts.iter().map(|t| t.imbalance).fold(0.0, f64::max);
        println!(
            "{:8} {:>9} {:>9} {:>9} {worst:>16.3e} {imbalance:>16.3e} {:>6.1} s",
            law.name,
            sum(|t| t.contacts),
            sum(|t| t.systems),
            sum(|t| t.unsolved),
            clock.elapsed().as_secs_f64()
        );
        let claims = nonsmooth::laws::build::<f64, 2>(law.name, &[0.5, 0.5])?.dissipative_theta().is_some();
        broken |= claims && worst > 1e-13;
        // Contacts with more than 10^(i − 20) E of work.
        let above = |i: usize| parts.iter().map(|t| t.decades[i + 1..].iter().sum::<usize>()).sum::<usize>();
        let x: Vec<f64> = (0..20).map(|i| 10.0_f64.powi(i - 20)).collect();
        let y: Vec<f64> = (0..20).map(|i| above(i) as f64).collect();
        panel = panel.with(Series::new(law.name, Style::LineAndMarkers, x, y));
    }
    if asked.is_none() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/figures");
        Figure::new(1, vec![panel])
            .size(322.0, 200.0)
            .write_png(&folder.join("energy_certificate.png"), 200.0)?;
    }
    if broken { Err("a law did work it claims not to do".into()) } else { Ok(()) }
}
