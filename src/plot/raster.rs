//! Rasterisation of a scene, smoother than the library's own.
//!
//! The library smooths edges in one direction only and blurs rotated text. The
//! scene is therefore drawn larger than asked and averaged, and upright text is
//! drawn lying down on a page of its own, then turned with the pixels.

use std::io::Cursor;

use kuva::backend::raster::RasterBackend;
use kuva::render::render::{Primitive, Scene};

use super::BASE_DPI;

/// Resolution of the drawing before it is averaged.
const FINE_DPI: f64 = 1200.0;

/// Largest drawing before it is averaged.
const FINE_PIXELS: f64 = 1.5e8;

/// A grid of opaque RGB pixels.
struct Image {
    width: usize,
    height: usize,
    rgb: Vec<u8>,
}

/// The scene as a PNG image of the given resolution, on a white ground.
pub(super) fn png(mut scene: Scene, dpi: f64) -> Result<Vec<u8>, String> {
    let scale = dpi / BASE_DPI;
    let pixels = scene.width * scale * scene.height * scale;
    let wanted = (FINE_DPI / dpi).round().clamp(2.0, 4.0);
    let fine = wanted.min((FINE_PIXELS / pixels).sqrt().floor()).max(1.0);
    let upright = lay_down(&mut scene);
    let mut image = draw(&scene, scale, fine)?;
    if let Some(page) = upright {
        // Text is smooth as it comes.
        image.darken_turned(&draw(&page, scale, 1.0)?);
    }
    encode(&image, dpi)
}

/// Moves upright text to a page turned clockwise, where it lies down.
fn lay_down(scene: &mut Scene) -> Option<Scene> {
    let height = scene.height;
    let mut page = Scene::new(height, scene.width);
    scene.elements.retain(|element| match element {
        Primitive::Text { x, y, rotate: Some(_), .. } => {
            let mut lying = element.clone();
            if let Primitive::Text { x: across, y: down, rotate, .. } = &mut lying {
                (*across, *down, *rotate) = (height - y, *x, None);
            }
            page.elements.push(lying);
            false
        }
        _ => true,
    });
    (!page.elements.is_empty()).then_some(page)
}

fn draw(scene: &Scene, scale: f64, fine: f64) -> Result<Image, String> {
    let backend = RasterBackend::new().with_scale((scale * fine) as f32);
    Ok(decode(&backend.render_scene(scene)?)?.averaged(fine as usize))
}

fn decode(bytes: &[u8]) -> Result<Image, String> {
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().map_err(|e| e.to_string())?;
    let size = reader.output_buffer_size().ok_or("image too large")?;
    let mut pixels = vec![0; size];
    let info = reader.next_frame(&mut pixels).map_err(|e| e.to_string())?;
    let samples = info.color_type.samples();
    if samples < 3 || info.bit_depth != png::BitDepth::Eight {
        return Err("unexpected pixel format".to_owned());
    }
    let rgb = pixels.chunks_exact(samples).flat_map(|p| [p[0], p[1], p[2]]);
    Ok(Image { width: info.width as usize, height: info.height as usize, rgb: rgb.collect() })
}

impl Image {
    /// Averages squares of `side` pixels; those cut by the edge are dropped.
    fn averaged(self, side: usize) -> Self {
        if side <= 1 {
            return self;
        }
        let (width, height) = (self.width / side, self.height / side);
        let mut rgb = Vec::with_capacity(3 * width * height);
        let mut sums = vec![0_u32; 3 * width];
        let count = (side * side) as u32;
        for row in 0..height {
            sums.fill(0);
            let lines = self.rgb.chunks_exact(3 * self.width);
            for line in lines.skip(row * side).take(side) {
                for (sums, square) in sums.chunks_exact_mut(3).zip(line.chunks_exact(3 * side)) {
                    for pixel in square.chunks_exact(3) {
                        for (sum, value) in sums.iter_mut().zip(pixel) {
                            *sum += u32::from(*value);
                        }
                    }
                }
            }
            rgb.extend(sums.iter().map(|sum| ((sum + count / 2) / count) as u8));
        }
        Self { width, height, rgb }
    }

    /// Lays an image turned clockwise over this one, keeping the darker pixels.
    fn darken_turned(&mut self, page: &Self) {
        for y in 0..self.height.min(page.width) {
            let column = page.width - 1 - y;
            for x in 0..self.width.min(page.height) {
                let over = 3 * (x * page.width + column);
                let under = 3 * (y * self.width + x);
                for channel in 0..3 {
                    let value = page.rgb[over + channel];
                    let pixel = &mut self.rgb[under + channel];
                    *pixel = value.min(*pixel);
                }
            }
        }
    }
}

fn encode(image: &Image, dpi: f64) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, image.width as u32, image.height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let per_metre = (dpi / 0.0254).round() as u32;
    encoder.set_pixel_dims(Some(png::PixelDimensions {
        xppu: per_metre,
        yppu: per_metre,
        unit: png::Unit::Meter,
    }));
    let mut writer = encoder.write_header().map_err(|e| e.to_string())?;
    writer.write_image_data(&image.rgb).and_then(|()| writer.finish()).map_err(|e| e.to_string())?;
    Ok(bytes)
}
