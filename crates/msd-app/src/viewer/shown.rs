//! Bits of what is drawn of a scene, as links have them.

use msd_render::Style;

/// What a link says of a style: what the window can show and hide, in the order of bits.
fn shown(style: &mut Style) -> [&mut bool; 7] {
    let Style { surfaces, pattern, wireframe, springs, particles, shadows, grid, .. } = style;
    [surfaces, pattern, wireframe, springs, particles, shadows, grid]
}

/// The bits of what a style shows.
pub(super) fn shown_bits(mut style: Style) -> u16 {
    let bits = shown(&mut style).map(|is_shown| u16::from(*is_shown));
    bits.iter().enumerate().map(|(place, bit)| bit << place).sum()
}

/// Shows what the bits say.
pub(super) fn show_bits(style: &mut Style, bits: u16) {
    for (place, is_shown) in shown(style).into_iter().enumerate() {
        *is_shown = bits >> place & 1 == 1;
    }
}
