//! What a figure is made of.

/// Dashes of a curve, other than those that tell its rank in greyscale too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dash {
    /// An unbroken line.
    Solid = 0,
    /// Round dots.
    Dotted = 2,
}

/// How the points of a series are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Style {
    /// Points joined by straight lines.
    #[default]
    Line,
    /// Isolated points.
    Markers,
    /// Points joined by straight lines and marked.
    LineAndMarkers,
    /// Piecewise constant, each value holding until the next abscissa.
    Steps,
    /// Vertical bars from zero, for impulsive quantities.
    Stems,
}

/// One curve, cloud of points or set of bars.
///
/// Points with a non-finite coordinate are not drawn and interrupt the curve; if `x` and `y` differ in length, the
/// excess is ignored. Labels and titles may have indices and exponents between dollars: `$u_N$`, `$10^{−3}$`.
#[derive(Clone, Debug)]
pub struct Series {
    pub(super) label: String,
    pub(super) x: Vec<f64>,
    pub(super) y: Vec<f64>,
    pub(super) style: Style,
    pub(super) color: Option<usize>,
    pub(super) dash: Option<Dash>,
    pub(super) width: f64,
}

impl Series {
    /// A series of the given style; colour, dashes and markers follow from its rank in the panel. An empty label stays
    /// out of the legend.
    pub fn new(label: impl Into<String>, style: Style, x: Vec<f64>, y: Vec<f64>) -> Self {
        Self { label: label.into(), x, y, style, color: None, dash: None, width: 1.2 }
    }

    /// Separate straight edges `[x0, y0, x1, y1]` as one set of thin lines: a mesh, for instance.
    pub fn edges(label: impl Into<String>, edges: &[[f64; 4]]) -> Self {
        let x = edges.iter().flat_map(|e| [e[0], e[2], f64::NAN]).collect();
        let y = edges.iter().flat_map(|e| [e[1], e[3], f64::NAN]).collect();
        Self { width: 0.4, ..Self::new(label, Style::Line, x, y) }
    }

    /// Sets the index of the colour and of the marker.
    pub fn color(self, index: usize) -> Self {
        Self { color: Some(index), ..self }
    }

    /// Sets the dash pattern.
    pub fn dash(self, dash: Dash) -> Self {
        Self { dash: Some(dash), ..self }
    }

    /// Sets the line width in pixels.
    pub fn width(self, width: f64) -> Self {
        Self { width, ..self }
    }

    /// The points, whatever their value.
    pub(super) fn points(&self) -> impl Iterator<Item = (f64, f64)> {
        self.x.iter().copied().zip(self.y.iter().copied())
    }
}

/// Scale of an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scale {
    /// Proportional to the value.
    #[default]
    Linear,
    /// Proportional to the decimal logarithm; values ≤ 0 are not drawn.
    Log10,
}

/// One set of axes with its curves; the legend goes where it hides no data.
#[derive(Clone, Debug, Default)]
pub struct Panel {
    /// Title, printed after the letter of the panel.
    pub title: String,
    /// Label of the horizontal axis, unit last: `"t (s)"`.
    pub x_label: String,
    /// Label of the vertical axis, unit last: `"w (J)"`.
    pub y_label: String,
    /// The curves.
    pub series: Vec<Series>,
    /// Scale of the horizontal axis.
    pub x_scale: Scale,
    /// Scale of the vertical axis.
    pub y_scale: Scale,
    /// Range of the horizontal axis; by default that of the data.
    pub x_limits: Option<(f64, f64)>,
    /// Range of the vertical axis; by default that of the data.
    pub y_limits: Option<(f64, f64)>,
    /// Draws a thin line at ordinate zero.
    pub zero_line: bool,
    /// Gives both axes the same length per unit (linear axes only).
    pub equal_aspect: bool,
}

impl Panel {
    /// An empty panel with linear axes.
    pub fn new(title: impl Into<String>, x_label: impl Into<String>, y_label: impl Into<String>) -> Self {
        Self { title: title.into(), x_label: x_label.into(), y_label: y_label.into(), ..Self::default() }
    }

    /// Adds a series.
    pub fn with(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }

    /// Makes both axes logarithmic.
    pub fn log_log(self) -> Self {
        Self { x_scale: Scale::Log10, y_scale: Scale::Log10, ..self }
    }

    /// Draws a thin line at ordinate zero.
    pub fn zero_line(self) -> Self {
        Self { zero_line: true, ..self }
    }
}

/// A figure: panels in rows of `columns`, lettered when there are several, at the size it has on paper.
///
/// Lengths are in pixels of 1/96 inch, so 322 px is a journal column of 8.5 cm.
#[derive(Clone, Debug)]
pub struct Figure {
    pub(super) panels: Vec<Panel>,
    pub(super) columns: usize,
    pub(super) width_px: f64,
    pub(super) panel_height_px: f64,
}

impl Figure {
    /// A figure one journal column wide with `columns` panels in a row.
    pub fn new(columns: usize, panels: Vec<Panel>) -> Self {
        Self { panels, columns, width_px: 322.0, panel_height_px: 140.0 }
    }

    /// Sets the width of the figure and the height of a row of panels.
    pub fn size(self, width_px: f64, panel_height_px: f64) -> Self {
        Self { width_px, panel_height_px, ..self }
    }
}
