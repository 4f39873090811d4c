//! What a figure is made of.

/// Dash pattern of a curve, so that curves differ in greyscale too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dash {
    /// An unbroken line.
    Solid,
    /// Medium dashes.
    Dashed,
    /// Round dots.
    Dotted,
    /// Alternating dashes and dots.
    DashDot,
    /// Long dashes.
    LongDash,
}

/// Shape drawn at a data point; filled and open shapes alternate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marker {
    /// Filled disc.
    Disc,
    /// Open square.
    Square,
    /// Filled triangle.
    Triangle,
    /// Open diamond.
    Diamond,
    /// Diagonal cross.
    Cross,
    /// Open circle.
    Circle,
}

/// The markers in the order in which series take them.
pub const MARKERS: [Marker; 6] =
    [Marker::Disc, Marker::Square, Marker::Triangle, Marker::Diamond, Marker::Cross, Marker::Circle];

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
/// Points with a non-finite coordinate are not drawn and interrupt the curve;
/// if `x` and `y` differ in length, the excess is ignored. Labels and titles may
/// contain indices and exponents between dollars: `$u_N$`, `$\gamma$` is written
/// `γ`, `$p_{max}$`, `$10^{-3}$`.
#[derive(Clone, Debug)]
pub struct Series {
    /// Name in the legend; an empty label stays out of it.
    pub label: String,
    /// Abscissae.
    pub x: Vec<f64>,
    /// Ordinates.
    pub y: Vec<f64>,
    /// How the points are shown.
    pub style: Style,
    /// Index into the palette; by default the rank of the series in its panel.
    pub color: Option<usize>,
    /// Dash pattern; by default chosen from the rank of the series.
    pub dash: Option<Dash>,
    /// Marker shape; by default chosen from the rank of the series.
    pub marker: Option<Marker>,
    /// Line width in pixels.
    pub width: f64,
}

impl Series {
    /// A series of the given style with default colour, dashes and markers.
    pub fn new(label: impl Into<String>, style: Style, x: Vec<f64>, y: Vec<f64>) -> Self {
        Self { label: label.into(), x, y, style, color: None, dash: None, marker: None, width: 1.2 }
    }

    /// Separate straight edges `[x0, y0, x1, y1]`, drawn as one set of thin lines:
    /// a mesh, for instance, in a panel with `equal_aspect`.
    pub fn edges(label: impl Into<String>, edges: &[[f64; 4]]) -> Self {
        let mut x = Vec::with_capacity(3 * edges.len());
        let mut y = Vec::with_capacity(3 * edges.len());
        for &[x0, y0, x1, y1] in edges {
            x.extend([x0, x1, f64::NAN]);
            y.extend([y0, y1, f64::NAN]);
        }
        Self { width: 0.4, ..Self::new(label, Style::Line, x, y) }
    }

    /// Sets the palette index.
    pub fn color(mut self, index: usize) -> Self {
        self.color = Some(index);
        self
    }

    /// Sets the dash pattern.
    pub fn dash(mut self, dash: Dash) -> Self {
        self.dash = Some(dash);
        self
    }

    /// Sets the marker shape.
    pub fn marker(mut self, marker: Marker) -> Self {
        self.marker = Some(marker);
        self
    }

    /// Sets the line width in pixels.
    pub fn width(mut self, width: f64) -> Self {
        self.width = width;
        self
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

/// Where the legend goes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Legend {
    /// Where it hides no data, making room above the data if need be.
    #[default]
    Auto,
    /// No legend.
    None,
}

/// One set of axes with its curves.
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
    /// Where the legend goes.
    pub legend: Legend,
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
    pub fn log_log(mut self) -> Self {
        self.x_scale = Scale::Log10;
        self.y_scale = Scale::Log10;
        self
    }

    /// Draws a thin line at ordinate zero.
    pub fn zero_line(mut self) -> Self {
        self.zero_line = true;
        self
    }
}

/// A figure: panels in rows of `columns`, at the size it has on paper.
///
/// Lengths are in pixels of 1/96 inch, so 322 px is a journal column of 8.5 cm
/// and 12 px is 9 pt.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Title above all panels.
    pub title: Option<String>,
    /// The panels, row by row; lettered when there are several.
    pub panels: Vec<Panel>,
    /// Number of panels in a row.
    pub columns: usize,
    /// Width of the figure.
    pub width_px: f64,
    /// Height of one row of panels, labels included.
    pub panel_height_px: f64,
    /// Size of the labels; tick labels are one pixel smaller.
    pub font_px: u32,
}

impl Default for Figure {
    fn default() -> Self {
        Self {
            title: None,
            panels: Vec::new(),
            columns: 2,
            width_px: 322.0,
            panel_height_px: 140.0,
            font_px: 11,
        }
    }
}

impl Figure {
    /// A figure one journal column wide with `columns` panels in a row.
    pub fn new(columns: usize, panels: Vec<Panel>) -> Self {
        Self { panels, columns, ..Self::default() }
    }

    /// Sets the width of the figure and the height of a row of panels.
    pub fn size(mut self, width_px: f64, panel_height_px: f64) -> Self {
        self.width_px = width_px;
        self.panel_height_px = panel_height_px;
        self
    }
}
