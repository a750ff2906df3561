//! Colours, sizes and fonts of the window.

use egui::{Color32, Context, CornerRadius, FontFamily, FontId, Stroke, TextStyle, Theme, vec2};

/// Behind the panels.
pub const PANEL: Color32 = Color32::from_rgb(27, 30, 37);
/// Behind fields and buttons.
pub const FIELD: Color32 = Color32::from_rgb(43, 48, 58);
/// Lines between parts.
pub const LINE: Color32 = Color32::from_rgb(55, 61, 73);
/// Ordinary text.
pub const TEXT: Color32 = Color32::from_rgb(205, 211, 222);
/// Text of less weight.
pub const FAINT: Color32 = Color32::from_rgb(138, 147, 163);
/// What is chosen.
pub const ACCENT: Color32 = Color32::from_rgb(64, 132, 214);
/// What goes well.
pub const GOOD: Color32 = Color32::from_rgb(110, 196, 132);
/// What needs attention.
pub const WARN: Color32 = Color32::from_rgb(240, 180, 80);
/// What went wrong.
pub const BAD: Color32 = Color32::from_rgb(240, 110, 100);

/// What stands in place of a number that is being worked out.
pub const VOID: &str = "…";

/// Sets colours, sizes and fonts: dark, whatever the system prefers, as the scene is drawn for it.
pub fn apply(ctx: &Context) {
    ctx.set_theme(Theme::Dark);
    ctx.style_mut_of(Theme::Dark, |style| {
        style.spacing.item_spacing = vec2(6.0, 5.0);
        style.spacing.button_padding = vec2(8.0, 3.0);
        style.spacing.interact_size.y = 20.0;
        style.spacing.combo_width = 150.0;
        let font = |size| FontId::new(size, FontFamily::Proportional);
        style.text_styles.insert(TextStyle::Body, font(13.0));
        style.text_styles.insert(TextStyle::Button, font(13.0));
        style.text_styles.insert(TextStyle::Small, font(11.0));
        style.text_styles.insert(TextStyle::Heading, font(17.0));
        style.interaction.selectable_labels = false;
        let visuals = &mut style.visuals;
        visuals.panel_fill = PANEL;
        visuals.window_fill = PANEL;
        visuals.extreme_bg_color = Color32::from_rgb(18, 20, 25);
        visuals.window_stroke = Stroke::new(1.0, LINE);
        visuals.selection.bg_fill = ACCENT;
        visuals.selection.stroke = Stroke::new(1.0, Color32::WHITE);
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
        widgets.noninteractive.fg_stroke.color = TEXT;
        widgets.noninteractive.bg_stroke.color = LINE;
        widgets.inactive.fg_stroke.color = TEXT;
        widgets.inactive.bg_fill = FIELD;
        widgets.inactive.weak_bg_fill = FIELD;
    });
}
