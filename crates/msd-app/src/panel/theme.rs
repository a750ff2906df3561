//! Colours, sizes and fonts of the window, dark or light.

use egui::epaint::{Shape, shape_transform::adjust_colors};
use egui::{Color32, Context, CornerRadius, FontFamily, FontId, Stroke, TextStyle, Theme, vec2};

/// Background of the panels.
pub(crate) const PANEL: Color32 = Color32::from_rgb(27, 30, 37);
/// Background of fields and buttons.
pub(crate) const FIELD: Color32 = Color32::from_rgb(43, 48, 58);
/// Lines between parts.
pub const LINE: Color32 = Color32::from_rgb(55, 61, 73);
/// Ordinary text.
pub const TEXT: Color32 = Color32::from_rgb(205, 211, 222);
/// Secondary text.
pub(crate) const FAINT: Color32 = Color32::from_rgb(138, 147, 163);
/// Selection.
pub(crate) const ACCENT: Color32 = Color32::from_rgb(64, 132, 214);
/// Selection in light panels, below dark text.
const PALE: Color32 = Color32::from_rgb(146, 190, 244);
/// A value within its limits.
pub(crate) const GOOD: Color32 = Color32::from_rgb(110, 196, 132);
/// A value that needs attention.
pub(crate) const WARN: Color32 = Color32::from_rgb(240, 180, 80);
/// An error.
pub(crate) const BAD: Color32 = Color32::from_rgb(240, 110, 100);

/// Height of a control that a pointer presses, points.
const POINTER: f32 = 20.0;
/// Height of a control that a finger presses, points.
pub(crate) const FINGER: f32 = 44.0;

/// Placeholder for a number that is being computed.
pub(crate) const VOID: &str = "…";

/// Background of the box over a diverged run.
pub(crate) const ALARM: Color32 = Color32::from_rgb(66, 30, 32);

/// The colours above, and their counterparts in light panels.
const LIGHT: [(Color32, Color32); 9] = [
    (PANEL, Color32::from_rgb(244, 245, 247)),
    (FIELD, Color32::from_rgb(224, 227, 232)),
    (LINE, Color32::from_rgb(203, 208, 216)),
    (TEXT, Color32::from_rgb(38, 43, 52)),
    (FAINT, Color32::from_rgb(98, 107, 122)),
    (GOOD, Color32::from_rgb(24, 122, 54)),
    (WARN, Color32::from_rgb(158, 96, 0)),
    (BAD, Color32::from_rgb(190, 40, 32)),
    (ALARM, Color32::from_rgb(253, 228, 226)),
];

/// Returns the counterpart of a dark colour in light panels.
fn light(colour: Color32) -> Color32 {
    LIGHT.iter().find(|(dark, _)| *dark == colour).map_or(colour, |&(_, light)| light)
}

/// Converts a shape with the colours above to light panels.
///
/// Panels use dark colours, and only this function knows of others. Overlays of the scene are white
/// on a dark background in both themes.
pub(crate) fn lighten(shape: &mut Shape) {
    adjust_colors(shape, |colour| *colour = light(*colour));
}

/// Sets colours, sizes and fonts; initially dark.
pub fn apply(ctx: &Context) {
    choose(ctx, false);
    ctx.all_styles_mut(|style| {
        style.spacing.item_spacing = vec2(6.0, 5.0);
        style.spacing.button_padding = vec2(8.0, 3.0);
        style.spacing.interact_size.y = POINTER;
        style.spacing.combo_width = 150.0;
        style.spacing.slider_width = 96.0;
        // The scroll bar is visible without the pointer over it.
        style.spacing.scroll.dormant_handle_opacity = 0.5;
        let font = |size| FontId::new(size, FontFamily::Proportional);
        style.text_styles.insert(TextStyle::Body, font(13.0));
        style.text_styles.insert(TextStyle::Button, font(13.0));
        style.text_styles.insert(TextStyle::Small, font(11.0));
        style.text_styles.insert(TextStyle::Heading, font(17.0));
        style.interaction.selectable_labels = false;
    });
    for theme in [Theme::Dark, Theme::Light] {
        let own: fn(Color32) -> Color32 = if theme == Theme::Dark { |dark| dark } else { light };
        ctx.style_mut_of(theme, |style| colour(&mut style.visuals, own));
    }
}

/// Sets the height of controls for touch or pointer input.
pub fn fit(ctx: &Context, by_touch: bool) {
    let (height, icon) = if by_touch { (FINGER, 24.0) } else { (POINTER, 14.0) };
    if ctx.global_style().spacing.interact_size.y != height {
        ctx.all_styles_mut(|style| {
            (style.spacing.interact_size.y, style.spacing.icon_width) = (height, icon);
            style.spacing.icon_width_inner = icon * 4.0 / 7.0;
        });
    }
}

/// Sets dark or light panels, independently of the system: the scene is designed for dark ones.
pub fn choose(ctx: &Context, light: bool) {
    ctx.set_theme(if light { Theme::Light } else { Theme::Dark });
}

fn colour(visuals: &mut egui::Visuals, own: fn(Color32) -> Color32) {
    visuals.panel_fill = own(PANEL);
    visuals.window_fill = own(PANEL);
    if visuals.dark_mode {
        visuals.extreme_bg_color = Color32::from_rgb(18, 20, 25);
    }
    visuals.window_stroke = Stroke::new(1.0, own(LINE));
    // The frame of a focused text field has the selection colour.
    let (chosen, on_chosen) =
        if visuals.dark_mode { (ACCENT, Color32::WHITE) } else { (PALE, own(TEXT)) };
    visuals.selection.bg_fill = chosen;
    visuals.selection.stroke = Stroke::new(1.0, on_chosen);
    visuals.slider_trailing_fill = true;
    let widgets = &mut visuals.widgets;
    for widget in [
        &mut widgets.noninteractive,
        &mut widgets.inactive,
        &mut widgets.hovered,
        &mut widgets.active,
        &mut widgets.open,
    ] {
        widget.corner_radius = CornerRadius::same(4);
    }
    widgets.noninteractive.fg_stroke.color = own(TEXT);
    widgets.noninteractive.bg_stroke.color = own(LINE);
    widgets.inactive.fg_stroke.color = own(TEXT);
    widgets.inactive.bg_fill = own(FIELD);
    widgets.inactive.weak_bg_fill = own(FIELD);
    // The focused control has a frame, even if it is selected.
    widgets.active.bg_stroke = Stroke::new(2.0, on_chosen);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the contrast of two opaque colours by WCAG 2.1.
    fn contrast(a: Color32, b: Color32) -> f32 {
        let luminance = |colour: Color32| {
            let [red, green, blue, _] = egui::Rgba::from(colour).to_array();
            0.2126 * red + 0.7152 * green + 0.0722 * blue
        };
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    #[test]
    fn every_word_can_be_read_in_both_themes() {
        for own in [|dark| dark, light] {
            for word in [TEXT, FAINT, GOOD, WARN, BAD] {
                // Level AA for text of ordinary size.
                let found = contrast(own(word), own(PANEL));
                assert!(4.5 <= found, "{word:?}: {found}");
            }
            assert!(4.5 <= contrast(own(TEXT), own(ALARM)));
        }
    }

    #[test]
    fn shapes_turn_light_and_other_colours_stay() {
        let rect = egui::Rect::from_min_size(egui::Pos2::ZERO, vec2(1.0, 1.0));
        let fill = |colour| {
            let mut shape = Shape::rect_filled(rect, 0.0, colour);
            lighten(&mut shape);
            shape
        };
        assert_eq!(fill(PANEL), Shape::rect_filled(rect, 0.0, light(PANEL)));
        assert_eq!(fill(Color32::WHITE), Shape::rect_filled(rect, 0.0, Color32::WHITE));
    }
}
