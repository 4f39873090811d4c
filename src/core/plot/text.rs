//! Indices and exponents: the library only knows the few letters that exist raised or lowered.

use kuva::render::render::{Primitive, Scene};

/// Private letters that begin and end an index and an exponent, and their markup. What follows an index is moved back
/// by a letter without width.
const MARKUP: [(char, &str); 4] = [
    ('\u{E000}', r#"<tspan dy="0.28em" font-size="72%">"#),
    ('\u{E001}', "</tspan><tspan dy=\"-0.2em\">\u{200B}</tspan>"),
    ('\u{E002}', r#"<tspan dy="-0.53em" font-size="72%">"#),
    ('\u{E003}', "</tspan><tspan dy=\"0.38em\">\u{200B}</tspan>"),
];

/// Marks what is between dollars after `_` or `^`, a letter or letters in braces.
pub(super) fn mark(scene: &mut Scene) {
    for element in &mut scene.elements {
        let Primitive::Text { content, .. } = element else { continue };
        let mut marked = String::new();
        let clean = content.replace(|c: char| c.is_control() || ('\u{E000}'..='\u{F8FF}').contains(&c), "");
        for (i, part) in clean.split('$').enumerate() {
            let mut letters = part.chars();
            while let Some(c) = letters.next() {
                let level = match c {
                    '_' if i % 2 == 1 => 0,
                    '^' if i % 2 == 1 => 2,
                    _ => {
                        marked.push(c);
                        continue;
                    }
                };
                marked.push(MARKUP[level].0);
                match letters.next() {
                    Some('{') => marked.extend(letters.by_ref().take_while(|c| *c != '}')),
                    letter => marked.extend(letter),
                }
                marked.push(MARKUP[level + 1].0);
            }
        }
        *content = marked;
    }
}

/// Replaces the marks in a drawing, and cuts what floating point leaves behind the hundredths of its lengths.
pub(super) fn finish(svg: &str) -> String {
    let mut short = String::with_capacity(svg.len());
    for (i, part) in svg.split('.').enumerate() {
        let decimals = part.bytes().take_while(u8::is_ascii_digit).count();
        short.push_str(if i > 0 { "." } else { "" });
        short.push_str(if i > 0 && decimals > 12 { &part[..2] } else { &part[..decimals] });
        short.push_str(&part[decimals..]);
    }
    MARKUP.iter().fold(short, |svg, (mark, markup)| svg.replace(*mark, markup))
}
