//! Figures of curves for papers, written as SVG and PNG.
//!
//! The page has the size it has on paper; colours are safe for colour-blind readers, and curves differ in dashes and
//! markers as well. No font has to be installed.
//!
//! Axes, ticks, labels and curves are drawn by `kuva`, and images of them by `resvg`. Kept here is what `kuva` 0.6 fails
//! at: logarithms below 10⁻¹⁰, a power of ten common to the labels of an axis, a legend that has lines *and* markers and
//! gives way to the data, margins common to panels, letters as indices, long series, and smooth images. Other libraries
//! fail at more: `plotters` 0.3 at indices and at images without installed fonts, `plotive` 0.6 at text that stays text
//! and at numbers (`1.00e-5`), `plotine` 0.5 at small panels (its margins are fixed) and at markers in legends,
//! `plotkit` 1.0 at letters as indices and at legends beside the data.
//!
//! ```
//! use nonsmooth::plot::{Figure, Panel, Series, Style};
//!
//! let t: Vec<f64> = (0..200).map(|i| 0.01 * f64::from(i)).collect();
//! let gap = t.iter().map(|t| (3.0 * t).cos().abs()).collect();
//! let panel = Panel::new("gap", "t (s)", "$g_N$ (m)").with(Series::new("", Style::Line, t, gap));
//! let svg = Figure::new(1, vec![panel]).svg()?;
//! assert!(svg.starts_with("<svg"));
//! # Ok::<(), nonsmooth::plot::PlotError>(())
//! ```

mod axis;
mod legend;
mod model;
mod page;
mod shape;
mod text;

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use kuva::backend::svg::SvgBackend;
use resvg::{tiny_skia, usvg};

use crate::file::AtomicFile;

pub use model::{Dash, Figure, Panel, Scale, Series, Style};

/// Pixels per inch of the lengths of a figure.
const BASE_DPI: f64 = 96.0;

/// Largest side of a figure, and largest image, in pixels.
const MOST: (f64, f64) = (20_000.0, 1e8);

/// Why a figure could not be produced.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    /// The size, resolution or number of columns leaves no room for the panels or asks for too large an image.
    #[error("cannot draw a figure of {width} × {height} pixels with such panels")]
    Size {
        /// Width of the figure or image.
        width: f64,
        /// Height of the figure or image.
        height: f64,
    },
    /// The drawing could not be read by the renderer of images.
    #[error("cannot draw the image: {0}")]
    Draw(#[from] usvg::Error),
    /// The image could not be encoded.
    #[error("cannot encode the image: {0}")]
    Encode(#[from] png::EncodingError),
    /// The file could not be written.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system reported.
        source: io::Error,
    },
}

impl Figure {
    /// The figure as an SVG document.
    pub fn svg(&self) -> Result<String, PlotError> {
        let rows = self.panels.len().div_ceil(self.columns.max(1)).max(1);
        let columns = self.columns.clamp(1, self.panels.len().max(1));
        let (width, height) = (self.width_px, self.panel_height_px * rows as f64);
        let roomy = width / columns as f64 >= 88.0 && self.panel_height_px >= 66.0;
        if !(roomy && width <= MOST.0 && height <= MOST.0) {
            return Err(PlotError::Size { width, height });
        }
        let mut scene = page::draw(self);
        text::mark(&mut scene);
        let svg = SvgBackend::new().render_scene(&scene);
        let size = format!(r#" viewBox="0 0 {width} {height}">"#);
        Ok(text::finish(&svg.replacen('>', &size, 1)))
    }

    /// The figure as a PNG image of the given resolution.
    pub fn png(&self, dpi: f64) -> Result<Vec<u8>, PlotError> {
        let svg = self.svg()?;
        let mut options = usvg::Options { font_family: "DejaVu Sans".to_owned(), ..usvg::Options::default() };
        Arc::make_mut(&mut options.fontdb).load_font_data(dejavu::sans::regular().to_vec());
        let tree = usvg::Tree::from_str(&svg, &options)?;
        let scale = dpi / BASE_DPI;
        let (width, height) =
            (f64::from(tree.size().width()) * scale, f64::from(tree.size().height()) * scale);
        let sound = width >= 1.0 && height >= 1.0 && width * height <= MOST.1;
        let canvas = || tiny_skia::Pixmap::new(width.ceil() as u32, height.ceil() as u32);
        let mut pixels = sound.then(canvas).flatten().ok_or(PlotError::Size { width, height })?;
        pixels.fill(tiny_skia::Color::WHITE);
        resvg::render(
            &tree,
            tiny_skia::Transform::from_scale(scale as f32, scale as f32),
            &mut pixels.as_mut(),
        );
        let rgb: Vec<u8> = pixels.data().chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, pixels.width(), pixels.height());
        encoder.set_color(png::ColorType::Rgb);
        let per_metre = (dpi / 0.0254).round() as u32;
        let unit = png::Unit::Meter;
        encoder.set_pixel_dims(Some(png::PixelDimensions { xppu: per_metre, yppu: per_metre, unit }));
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&rgb)?;
        writer.finish()?;
        Ok(bytes)
    }

    /// Writes the figure as SVG, in one go: an interrupted write leaves the former file intact.
    pub fn write_svg(&self, path: &Path) -> Result<(), PlotError> {
        write(path, self.svg()?.as_bytes())
    }

    /// Writes the figure as PNG of the given resolution, in one go as well.
    pub fn write_png(&self, path: &Path, dpi: f64) -> Result<(), PlotError> {
        write(path, &self.png(dpi)?)
    }

    /// Writes `stem.svg` and `stem.png`, the latter at 300 dpi, and returns both paths.
    pub fn save(&self, stem: &Path) -> Result<[PathBuf; 2], PlotError> {
        let paths = ["svg", "png"].map(|extension| {
            let mut name = stem.as_os_str().to_owned();
            name.push(format!(".{extension}"));
            PathBuf::from(name)
        });
        self.write_svg(&paths[0])?;
        self.write_png(&paths[1], 300.0)?;
        Ok(paths)
    }
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), PlotError> {
    let written = || -> io::Result<()> {
        let mut file = AtomicFile::create(path)?;
        file.write_all(bytes)?;
        file.commit()
    };
    written().map_err(|source| PlotError::Write { path: path.to_owned(), source })
}
