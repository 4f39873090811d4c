//! Figures of whatever is drawn: documents that hold together, of a sensible size, the same whenever drawn.

use std::path::Path;

use nonsmooth::plot::{Figure, Panel, PlotError, Series, Style};

fn ramp(n: usize) -> Vec<f64> {
    (0..n).map(|i| i as f64 / n as f64).collect()
}

fn panels(series: Vec<Series>) -> [Panel; 2] {
    let mut panel = Panel::new("title & <more>", "t (s)", "$u_N$ (m/s)").zero_line();
    panel.series = series;
    let log = panel.clone().log_log();
    [panel, log]
}

fn figure(series: Vec<Series>) -> Figure {
    Figure::new(2, panels(series).into())
}

const STYLES: [Style; 5] = [Style::Line, Style::Markers, Style::LineAndMarkers, Style::Steps, Style::Stems];

/// The figure as SVG, whose elements must balance.
fn check(figure: &Figure) -> String {
    let svg = figure.svg().expect("svg");
    assert!(svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>"));
    assert_eq!(svg.matches("<text").count(), svg.matches("</text>").count());
    assert_eq!(svg.matches("<tspan").count(), svg.matches("</tspan>").count());
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
    svg
}

fn check_image(figure: &Figure) {
    check(figure);
    let png = figure.png(48.0).expect("png");
    assert!(png.starts_with(b"\x89PNG"));
}

#[test]
fn empty_figures_panels_and_series_are_drawn() {
    check_image(&Figure::new(2, vec![]));
    check_image(&Figure::new(0, vec![Panel::default()]));
    check_image(&figure(vec![]));
    for style in STYLES {
        check(&figure(vec![Series::new("none", style, vec![], vec![])]));
        check(&figure(vec![Series::new("uneven", style, ramp(5), ramp(1))]));
    }
}

#[test]
fn no_value_is_too_odd() {
    let odd = [
        vec![f64::NAN; 4],
        vec![f64::INFINITY, 1.0, f64::NEG_INFINITY, 2.0],
        vec![7.0; 4],
        vec![0.0; 4],
        vec![f64::MAX, -f64::MAX, 1e-320, 0.0],
        vec![1e300, 1e-300, 1.0, f64::NAN],
    ];
    for style in STYLES {
        for x in &odd {
            for y in &odd {
                let mut panels = panels(vec![Series::new("odd", style, x.clone(), y.clone())]);
                if x == y {
                    check_image(&Figure::new(2, panels.clone().into()));
                }
                panels[0].equal_aspect = true;
                panels[1].x_limits = Some((1e-3, 1e3));
                panels[1].y_limits = Some((5.0, 1.0));
                check(&Figure::new(2, panels.into()));
            }
        }
    }
}

/// Curves that leave no corner free get a legend above or below them.
#[test]
fn legends_find_room() {
    let zigzag = |n: usize| (0..n).map(|i| (i % 2) as f64).collect();
    let series = (0..4).map(|_| Series::new("a long label", Style::Line, ramp(90), zigzag(90)));
    let svg = check(&figure(series.collect()));
    assert!(!svg.contains("fill-opacity") && !svg.contains(" opacity"));
    let label = "an absurdly long label ".repeat(9);
    let many = (0..40).map(|i| Series::new(label.as_str(), STYLES[i % 5], ramp(90), zigzag(90)));
    check_image(&figure(many.collect()));
}

#[test]
fn labels_are_escaped() {
    let svg = check(&figure(vec![Series::new("a<b", Style::Line, ramp(3), ramp(3))]));
    assert!(svg.contains("a&lt;b") && svg.contains("title &amp; &lt;more&gt;"));
}

#[test]
fn odd_settings_are_clamped_or_refused() {
    let drawn = figure(vec![Series::new("s", Style::Line, ramp(9), ramp(9)).color(999).width(f64::NAN)]);
    check(&drawn);
    for size in [0.0, 30.0, -1.0, f64::NAN, f64::INFINITY, 1e9] {
        let refused = drawn.clone().size(size, 140.0).svg();
        assert!(matches!(refused, Err(PlotError::Size { .. })), "{size}");
        let refused = drawn.clone().size(322.0, size).svg();
        assert!(matches!(refused, Err(PlotError::Size { .. })), "{size}");
    }
    for dpi in [0.0, -96.0, f64::NAN, 1e9] {
        assert!(matches!(drawn.png(dpi), Err(PlotError::Size { .. })));
    }
}

#[test]
fn long_noisy_series_give_small_files() {
    let t = ramp(300_000);
    let noise = |k: f64| t.iter().map(|t| (t * 1e6 * k).sin()).collect();
    let panel = |k| Panel::new("", "t (s)", "u (m)").with(Series::new("u", Style::Line, t.clone(), noise(k)));
    let figure = Figure::new(2, (1..=6).map(|k| panel(f64::from(k))).collect());
    let size = check(&figure).len();
    assert!(size < 300_000, "{size}");
}

#[test]
fn same_figure_same_bytes() {
    let make = || {
        let series = STYLES.map(|style| Series::new("s", style, ramp(2000), ramp(2000)));
        figure(series.to_vec())
    };
    assert_eq!(make().svg().ok(), make().svg().ok());
    assert_eq!(make().png(96.0).ok(), make().png(96.0).ok());
}

#[test]
fn files_are_replaced_and_errors_typed() {
    let folder = tempfile::tempdir().expect("folder");
    let drawn = figure(vec![Series::new("s", Style::Line, ramp(9), ramp(9))]);
    for _ in 0..2 {
        let paths = drawn.save(&folder.path().join("run.1")).expect("saved");
        assert!(paths.iter().all(|p| p.is_file()));
    }
    let files = std::fs::read_dir(folder.path()).expect("list").count();
    assert_eq!(files, 2, "no draft must remain");
    let missing = folder.path().join("missing").join("run.svg");
    let refused = drawn.write_svg(&missing);
    assert!(matches!(refused, Err(PlotError::Write { path, .. }) if path == missing));
    assert!(drawn.write_svg(Path::new("/")).is_err());
}

#[test]
fn small_values_share_a_power_of_ten() {
    let x = vec![1.0, 2.0];
    let panel = |label| {
        Panel::new("", "t (s)", label).with(Series::new("", Style::Line, x.clone(), vec![-7e-4, 7e-4]))
    };
    let svg = check(&Figure::new(1, vec![panel("w (J)")]));
    assert!(svg.contains(">w (×10⁻⁴ J)<") && svg.contains(">−5<") && svg.contains(">5<"));
    assert!(check(&Figure::new(1, vec![panel("f")])).contains(">f (×10⁻⁴)<"));
    let log = Panel::new("", "", "").with(Series::new("", Style::Line, vec![2e-16, 30.0], vec![2e-3, 30.0]));
    let svg = check(&Figure::new(1, vec![log.log_log()]));
    assert!([">10⁻²<", ">10⁻¹<", ">10⁰<", ">10¹<", ">10⁻¹²<"].iter().all(|decade| svg.contains(decade)));
}

#[test]
fn spikes_of_a_single_sample_survive() {
    let drawn = |spike: f64| {
        let y = (0..1_000_000).map(|i| if i == 700_123 { spike } else { 0.0 });
        let series = Series::new("", Style::Line, ramp(1_000_000), y.collect());
        let mut panel = Panel::new("", "", "").with(series);
        panel.y_limits = Some((-1.0, 6.0));
        check(&Figure::new(1, vec![panel]))
    };
    assert_ne!(drawn(0.0), drawn(5.0));
}
