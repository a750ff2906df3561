//! Bits of the visible parts of a scene, for links.

use msd_render::{Quantity, Style};

/// Returns the parts that the window can show or hide, with their bits.
fn shown(style: &mut Style) -> [(u16, &mut bool); 6] {
    let Style { surfaces, pattern, wireframe, particles, shadows, grid, .. } = style;
    [(0, surfaces), (1, pattern), (2, wireframe), (4, particles), (5, shadows), (6, grid)]
}

/// The bit for coloured quantities, and the first of three bits for the quantity.
const COLOURED: [u16; 2] = [3, 7];

/// Encodes the visible parts of a style.
pub(super) fn shown_bits(mut style: Style) -> u16 {
    let [coloured, which] = COLOURED;
    let place = |quantity| Quantity::ALL.iter().position(|&other| other == quantity).unwrap_or(0);
    let colours = style.colour_by.map_or(0, |quantity| 1 << coloured | (place(quantity) << which));
    let bits = shown(&mut style).map(|(bit, is_shown)| u16::from(*is_shown) << bit);
    bits.iter().sum::<u16>() | colours as u16
}

/// Applies encoded bits to a style.
pub(super) fn show_bits(style: &mut Style, bits: u16) {
    for (bit, is_shown) in shown(style) {
        *is_shown = bits >> bit & 1 == 1;
    }
    let [coloured, which] = COLOURED;
    // An unknown quantity of another version becomes the first, the strain.
    let quantity = Quantity::ALL.get(usize::from(bits >> which & 7)).unwrap_or(&Quantity::ALL[0]);
    style.colour_by = (bits >> coloured & 1 == 1).then_some(*quantity);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_shown_and_what_colours_stand_for_come_back_from_the_bits() {
        for colour_by in Quantity::ALL.map(Some).into_iter().chain([None]) {
            for all in [false, true] {
                let mut style = Style { colour_by, ..Style::default() };
                shown(&mut style).into_iter().for_each(|(_, is_shown)| *is_shown = all);
                let mut read = Style { colour_by: Some(Quantity::Force), ..Style::default() };
                show_bits(&mut read, shown_bits(style));
                assert_eq!(read, style);
            }
        }
        // Links of the version with strain only.
        let mut style = Style::default();
        show_bits(&mut style, 0b000_1000);
        assert_eq!((style.colour_by, style.surfaces), (Some(Quantity::Strain), false));
    }
}
