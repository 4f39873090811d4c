//! Figures of curves for papers, written as SVG and PNG.
//!
//! Panels are laid out at the size they have on paper; colours are safe for
//! colour-blind readers and curves differ in dashes and markers as well. Fonts
//! come with the drawing library, so nothing needs to be installed.
//!
//! ```
//! use nonsmooth::plot::{Figure, Panel, Series, Style};
//!
//! let t: Vec<f64> = (0..200).map(|i| 0.01 * f64::from(i)).collect();
//! let gap = t.iter().map(|t| (3.0 * t).cos().abs()).collect();
//! let panel = Panel::new("gap", "t (s)", "$g_N$ (m)")
//!     .with(Series::new("", Style::Line, t, gap));
//! let svg = Figure::new(1, vec![panel]).svg()?;
//! assert!(svg.starts_with("<svg"));
//! # Ok::<(), nonsmooth::plot::PlotError>(())
//! ```

mod axis;
mod decimate;
mod draw;
mod layout;
mod legend;
mod model;
mod raster;
mod shape;
#[cfg(test)]
mod tests;
mod text;

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use kuva::backend::svg::SvgBackend;
use kuva::render::render::{Primitive, Scene};

use crate::file::AtomicFile;

pub use decimate::decimate;
pub use model::{Dash, Figure, Legend, MARKERS, Marker, Panel, Scale, Series, Style};

/// Fonts of SVG text, the one the layout is computed with first.
const FONTS: &str = "DejaVu Sans, Verdana, Liberation Sans, Arial, sans-serif";

/// Resolution of the images written by [`Figure::save`].
const PRINT_DPI: f64 = 300.0;

/// Pixels per inch of the lengths of a figure.
const BASE_DPI: f64 = 96.0;

/// Largest side of a figure.
const MAX_SIDE: f64 = 20_000.0;

/// Largest image.
const MAX_PIXELS: f64 = 1e8;

/// Why a figure could not be produced.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    /// The size, resolution or number of columns leaves no room for the panels
    /// or asks for an unreasonably large image.
    #[error("cannot draw a figure of {width} × {height} pixels with such panels")]
    Size {
        /// Width of the figure or image.
        width: f64,
        /// Height of the figure or image.
        height: f64,
    },
    /// The image could not be encoded.
    #[error("cannot encode the image: {0}")]
    Encode(String),
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
        let scene = self.scene(false)?;
        let svg = SvgBackend::new().render_scene(&scene);
        let size = format!(r#" viewBox="0 0 {} {}">"#, scene.width, scene.height);
        Ok(text::finish_svg(&svg.replacen('>', &size, 1)))
    }

    /// The figure as a PNG image of the given resolution.
    pub fn png(&self, dpi: f64) -> Result<Vec<u8>, PlotError> {
        let scene = self.scene(true)?;
        let scale = dpi / BASE_DPI;
        let (width, height) = (scene.width * scale, scene.height * scale);
        let sound = width >= 1.0 && height >= 1.0 && width * height <= MAX_PIXELS;
        if !sound {
            return Err(PlotError::Size { width, height });
        }
        raster::png(scene, dpi).map_err(PlotError::Encode)
    }

    /// Writes the figure as SVG.
    pub fn write_svg(&self, path: &Path) -> Result<(), PlotError> {
        write(path, self.svg()?.as_bytes())
    }

    /// Writes the figure as PNG of the given resolution.
    pub fn write_png(&self, path: &Path, dpi: f64) -> Result<(), PlotError> {
        write(path, &self.png(dpi)?)
    }

    /// Writes `stem.svg` and `stem.png`, the latter at 300 dpi, and returns both
    /// paths.
    pub fn save(&self, stem: &Path) -> Result<[PathBuf; 2], PlotError> {
        let paths = ["svg", "png"].map(|extension| {
            let mut name = stem.as_os_str().to_owned();
            name.push(".");
            name.push(extension);
            PathBuf::from(name)
        });
        self.write_svg(&paths[0])?;
        self.write_png(&paths[1], PRINT_DPI)?;
        Ok(paths)
    }

    fn scene(&self, raster: bool) -> Result<Scene, PlotError> {
        let rows = self.panels.len().div_ceil(self.columns.max(1));
        let columns = self.columns.clamp(1, self.panels.len().max(1));
        let (width, height) = (self.width_px, self.panel_height_px * rows.max(1) as f64);
        let font = f64::from(self.font_px);
        let roomy = width / columns as f64 >= 8.0 * font && self.panel_height_px >= 6.0 * font;
        let sound = roomy && width <= MAX_SIDE && height <= MAX_SIDE && self.font_px > 0;
        if !sound {
            return Err(PlotError::Size { width, height });
        }
        let mut ink = draw::Ink { raster, ..draw::Ink::default() };
        let height = layout::draw(self, &mut ink);
        let mut scene = Scene::new(width.ceil(), height.ceil());
        scene.font_family = Some(FONTS.to_owned());
        scene.elements = Vec::with_capacity(ink.out.len() + 2);
        // Joins and ends of lines as the rasteriser draws them.
        let attributes = r#"stroke-linejoin="round" stroke-linecap="round""#;
        scene.elements.push(Primitive::GroupStart {
            transform: None,
            title: None,
            extra_attrs: Some(attributes.to_owned()),
        });
        scene.elements.append(&mut ink.out);
        scene.elements.push(Primitive::GroupEnd);
        Ok(scene)
    }
}

/// Writes a file in one go: an interrupted write leaves the former one intact.
fn write(path: &Path, bytes: &[u8]) -> Result<(), PlotError> {
    let written = || -> io::Result<()> {
        let mut file = AtomicFile::create(path)?;
        file.write_all(bytes)?;
        file.commit()
    };
    written().map_err(|source| PlotError::Write { path: path.to_owned(), source })
}
