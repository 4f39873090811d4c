//! Text with indices and exponents, and its width.

use kuva::render::render::{Primitive, TextAnchor};

/// Size of an index or exponent relative to its line.
const SMALL: f64 = 0.72;

/// Ellipsis of labels too long for the place they have.
const CUT: char = '…';

/// Height of a run of text above or below the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Level {
    Base,
    Index,
    Exponent,
}

impl Level {
    const ALL: [Self; 3] = [Self::Base, Self::Index, Self::Exponent];

    fn scale(self) -> f64 {
        if self == Self::Base { 1.0 } else { SMALL }
    }

    /// Downward shift in units of the full size.
    fn shift(self) -> f64 {
        match self {
            Self::Base => 0.0,
            Self::Index => 0.2,
            Self::Exponent => -0.38,
        }
    }
}

/// A line of text at a place of the figure.
#[derive(Clone, Debug)]
pub(super) struct Text<'a> {
    pub(super) content: &'a str,
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) size: u32,
    pub(super) anchor: TextAnchor,
    /// Set to read upwards.
    pub(super) upright: bool,
}

impl Text<'_> {
    /// Drawing of the text for the rasteriser, which has one run per primitive.
    pub(super) fn raster(&self, out: &mut Vec<Primitive>) {
        let size = f64::from(self.size);
        let mut pen = match self.anchor {
            TextAnchor::Start => 0.0,
            TextAnchor::Middle => -width(self.content, size) / 2.0,
            TextAnchor::End => -width(self.content, size),
        };
        for (level, run) in runs(self.content) {
            let (along, down) = (pen, level.shift() * size);
            let (dx, dy) = if self.upright { (down, -along) } else { (along, down) };
            pen += run_width(&run, size * level.scale());
            let size = (size * level.scale()).round() as u32;
            out.push(self.primitive(self.x + dx, self.y + dy, run, size, TextAnchor::Start));
        }
    }

    /// Drawing of the text for SVG: one primitive, whose changes of level are
    /// private characters until [`finish_svg`] turns them into markup. The viewer
    /// may have another font, so only it can place the runs after one another.
    pub(super) fn vector(&self, out: &mut Vec<Primitive>) {
        let mut content = String::new();
        let mut previous = Level::Base;
        for (level, run) in runs(self.content) {
            if level != previous {
                content.push(change(previous, level));
            }
            content.push_str(&run);
            previous = level;
        }
        out.push(self.primitive(self.x, self.y, content, self.size, self.anchor));
    }

    fn primitive(&self, x: f64, y: f64, text: String, size: u32, anchor: TextAnchor) -> Primitive {
        Primitive::Text {
            x,
            y,
            content: text,
            size: size.max(1),
            anchor,
            rotate: self.upright.then_some(-90.0),
            bold: false,
            color: None,
        }
    }
}

/// Private character standing for a change of level.
fn change(from: Level, to: Level) -> char {
    char::from_u32(0xE000 + 3 * from as u32 + to as u32).unwrap_or(' ')
}

/// Replaces the private characters left by [`Text::vector`] with markup.
pub(super) fn finish_svg(svg: &str) -> String {
    let mut out = String::with_capacity(svg.len() + 1024);
    let mut open = false;
    let mut chars = svg.chars().peekable();
    while let Some(c) = chars.next() {
        let pairs = Level::ALL.iter().flat_map(|a| Level::ALL.map(|b| (*a, b)));
        if !('\u{E000}'..='\u{E008}').contains(&c) {
            // A run inside a text ends with the text.
            if c == '<' && std::mem::take(&mut open) {
                out.push_str("</tspan>");
            }
            out.push(c);
        } else if let Some((from, to)) = pairs.into_iter().find(|(a, b)| change(*a, *b) == c) {
            if open {
                out.push_str("</tspan>");
            }
            let rise = (to.shift() - from.shift()) / to.scale();
            let size = to.scale() * 100.0;
            // Viewers drop a space at the start of a run.
            let space = chars.next_if_eq(&' ').map_or("", |_| r#" dx="0.318em""#);
            let markup = format!(r#"<tspan{space} dy="{rise:.3}em" font-size="{size:.0}%">"#);
            out.push_str(&markup);
            open = true;
        }
    }
    out
}

/// Splits a label into runs; indices and exponents are only read between dollars.
fn runs(label: &str) -> Vec<(Level, String)> {
    let mut out: Vec<(Level, String)> = Vec::new();
    let mut put = |level: Level, c: char| match out.last_mut() {
        Some((last, run)) if *last == level => run.push(c),
        _ => out.push((level, c.to_string())),
    };
    let clean = |c: &char| !c.is_control() && !('\u{E000}'..='\u{F8FF}').contains(c);
    let mut chars = label.chars().filter(clean).peekable();
    let paired = label.matches('$').count() >= 2;
    let mut math = false;
    while let Some(c) = chars.next() {
        let level = match c {
            '$' if paired => {
                math = !math;
                continue;
            }
            // A lone dollar must not reach the library, which reads markup too.
            '$' | '\\' => continue,
            '_' if math => Level::Index,
            '^' if math => Level::Exponent,
            _ => {
                put(Level::Base, c);
                continue;
            }
        };
        if chars.next_if_eq(&'{').is_some() {
            for c in chars.by_ref().take_while(|c| *c != '}') {
                put(level, c);
            }
        } else if let Some(c) = chars.next() {
            put(level, c);
        }
    }
    out
}

/// Width of a label at `size`, exact for the bundled font (DejaVu Sans) and
/// an upper bound for the fonts viewers are likely to substitute.
pub(super) fn width(label: &str, size: f64) -> f64 {
    let run = |(level, run): &(Level, String)| run_width(run, size * level.scale());
    runs(label).iter().map(run).sum()
}

fn run_width(run: &str, size: f64) -> f64 {
    run.chars().map(advance).sum::<f64>() * size / 1000.0
}

/// The largest size ≤ `size` at which the label is at most `room` wide, with the
/// label, shortened if no legible size will do.
pub(super) fn fit(label: &str, size: u32, room: f64) -> (u32, String) {
    let least = size.min(7);
    for size in (least..=size).rev() {
        if width(label, f64::from(size)) <= room {
            return (size, label.to_owned());
        }
    }
    let plain: String = runs(label).into_iter().map(|r| r.1).collect();
    let mut kept = String::new();
    let mut used = advance(CUT);
    for c in plain.chars() {
        used += advance(c);
        if used * f64::from(least) / 1000.0 > room {
            break;
        }
        kept.push(c);
    }
    kept.push(CUT);
    (least, kept)
}

/// Advance of a character of DejaVu Sans in thousandths of the size.
fn advance(c: char) -> f64 {
    #[rustfmt::skip]
    const ASCII: [u16; 95] = [
        318, 401, 460, 838, 636, 950, 780, 275, 390, 390, 500, 838, 318, 361, 318, 337,
        636, 636, 636, 636, 636, 636, 636, 636, 636, 636, 337, 337, 838, 838, 838, 531,
        1000, 684, 686, 698, 770, 632, 575, 775, 752, 295, 295, 656, 557, 863, 748, 787,
        603, 787, 695, 635, 611, 732, 684, 989, 685, 611, 685, 390, 337, 390, 838, 500,
        500, 613, 635, 550, 635, 615, 352, 635, 634, 278, 278, 579, 278, 974, 634, 612,
        635, 635, 411, 521, 392, 634, 592, 818, 592, 592, 525, 636, 337, 636, 838,
    ];
    let ascii = (c as usize).checked_sub(32).and_then(|i| ASCII.get(i));
    match (ascii, c) {
        (Some(&advance), _) => f64::from(advance),
        (None, '−' | '×' | '±' | '≤' | '≥' | '∞' | 'ω') => 838.0,
        (None, '·' | '′') => 318.0,
        (None, '–' | '°') => 500.0,
        (None, 'α'..='ψ' | 'à'..='ÿ') => 640.0,
        (None, 'Α'..='Ω') => 770.0,
        (None, _) => 1000.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_are_read_between_dollars_only() {
        let run = |level, text: &str| (level, text.to_owned());
        assert_eq!(
            runs("$u_N$ (m s$^{-1}$)"),
            [
                run(Level::Base, "u"),
                run(Level::Index, "N"),
                run(Level::Base, " (m s"),
                run(Level::Exponent, "-1"),
                run(Level::Base, ")"),
            ]
        );
        assert_eq!(runs("a_b $5"), [run(Level::Base, "a_b 5")]);
        for odd in ["$_", "$^$", "$a_{$", "$$", "\u{0}\u{E003}\n", "$a_{b"] {
            assert!(width(odd, 10.0).is_finite());
        }
    }

    #[test]
    fn svg_runs_are_closed() {
        let text = Text {
            content: "$u_N^2$ b",
            x: 0.0,
            y: 0.0,
            size: 10,
            anchor: TextAnchor::Start,
            upright: false,
        };
        let mut out = Vec::new();
        text.vector(&mut out);
        let Some(Primitive::Text { content, .. }) = out.first() else {
            panic!("no text");
        };
        let svg = finish_svg(&format!("<text>{content}</text>"));
        assert_eq!(svg.matches("<tspan").count(), 3);
        assert_eq!(svg.matches("</tspan>").count(), 3);
        assert_eq!(svg.matches("dx=").count(), 1);
        assert!(svg.ends_with(">b</tspan></text>"), "{svg}");
    }

    #[test]
    fn long_labels_shrink_then_are_cut() {
        assert_eq!(fit("abc", 11, 100.0), (11, "abc".to_owned()));
        let (size, label) = fit("a rather long label", 11, 90.0);
        assert!(size < 11 && label.ends_with("label"));
        let (_, label) = fit("a rather long label", 11, 30.0);
        assert!(label.ends_with(CUT) && width(&label, 7.0) <= 30.0);
        assert_eq!(fit("abc", 11, f64::NAN).1, "abc…");
    }
}
