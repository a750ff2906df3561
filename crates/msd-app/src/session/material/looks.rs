//! Looks of bodies: edited like a material, without effect on the run.

use super::MixedValue;
use crate::session::{Deed, Session};
use msd_core::{Body, Interaction, Look, Pattern, Select};
use msd_run::on;
use msd_scene::keys::Live;
use msd_scene::schema::Finish;
use msd_scene::{Assignment, look_row};

/// An edit of the look of the selected bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LookEdit {
    /// Finish, which sets everything but a chosen colour.
    Finish(Finish),
    /// Colour, sRGB, each component from 0 to 1.
    Colour([f32; 3]),
    /// Colour of the other side of sheets, sRGB, each component from 0 to 1.
    Back([f32; 3]),
    /// Roughness, from 0, a mirror, to 1, dull.
    Roughness(f64),
    /// The share of light that passes thin parts, from 0 to 1.
    Translucency(f64),
    /// Pattern along the surface.
    Pattern(Pattern),
    /// Size of the pattern, metres; 0 for a size relative to the body.
    PatternSize(f64),
}

impl LookEdit {
    /// Returns the edited property in a word or two.
    pub fn words(self) -> &'static str {
        match self {
            LookEdit::Finish(_) => "look",
            LookEdit::Colour(_) => "colour",
            LookEdit::Back(_) => "colour of the other side",
            LookEdit::Roughness(_) => "roughness",
            LookEdit::Translucency(_) => "translucency",
            LookEdit::Pattern(_) => "pattern",
            LookEdit::PatternSize(_) => "size of the pattern",
        }
    }

    /// Returns the look of a body after the edit.
    fn apply(self, body: &Body) -> Look {
        let mut look = body.look;
        match self {
            LookEdit::Finish(finish) => {
                let fresh = finish.look();
                let usual = Finish::of(&look).look().colour;
                let chosen = look.colour.filter(|colour| Some(*colour) != usual);
                look = Look { colour: chosen.or(fresh.colour), back: look.back, ..fresh };
            }
            LookEdit::Colour(colour) => look.colour = Some(colour),
            LookEdit::Back(colour) if body.surface.two_sided => look.back = Some(colour),
            LookEdit::Back(_) => {}
            LookEdit::Roughness(roughness) => look.roughness = roughness as f32,
            LookEdit::Translucency(share) => look.translucency = share as f32,
            LookEdit::Pattern(pattern) => {
                // The size of the previous pattern does not apply.
                (look.pattern, look.pattern_size) = (pattern, 0.0);
            }
            LookEdit::PatternSize(size) => look.pattern_size = size as f32,
        }
        look
    }
}

/// Look of the selected bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LookValues {
    /// The first of these bodies.
    pub body: usize,
    /// Their finish; `None` if it is custom, or if they differ.
    pub finish: Option<Finish>,
    /// Roughness, from 0, a mirror, to 1, dull.
    pub roughness: MixedValue,
    /// The share of light that passes thin parts, from 0 to 1.
    pub translucency: MixedValue,
    /// Pattern along their surfaces; `None` if they differ.
    pub pattern: Option<Pattern>,
    /// Size of the pattern, metres; 0 for one that suits the body.
    pub pattern_size: MixedValue,
    /// Whether any of them has a surface; without one, only the colour applies.
    pub has_surface: bool,
    /// Whether any is a sheet, which has another side.
    pub is_sheet: bool,
}

impl LookValues {
    fn of(bodies: &[(usize, &Body)]) -> Option<Self> {
        let looks = || bodies.iter().map(|(_, body)| body.look);
        let number =
            |number: fn(Look) -> f32| MixedValue::of(looks().map(|look| f64::from(number(look))));
        let (body, first) = *bodies.first()?;
        let finish = Finish::of(&first.look);
        let is_usual = |look: Look| {
            let Look { colour, back, .. } = look;
            look == Look { colour, back, ..finish.look() }
        };
        let pattern = first.look.pattern;
        let has_surface = |body: &Body| !body.surface.triangles.is_empty();
        Some(LookValues {
            body,
            finish: looks().all(is_usual).then_some(finish),
            roughness: number(|look| look.roughness)?,
            translucency: number(|look| look.translucency)?,
            pattern: looks().all(|look| look.pattern == pattern).then_some(pattern),
            pattern_size: number(|look| look.pattern_size)?,
            has_surface: bodies.iter().any(|(_, body)| has_surface(body)),
            is_sheet: bodies.iter().any(|(_, body)| body.surface.two_sided),
        })
    }
}

/// Returns whether an interaction only edits a look, and so does not affect the run.
pub(in crate::session) fn is_look(edit: &Interaction) -> bool {
    matches!(edit, Interaction::SetLook { .. })
}

/// Returns the same for a key.
pub(in crate::session) fn is_of_looks(edit: &Assignment) -> bool {
    edit.live() == Live::Look
}

/// Edits of looks.
impl Session {
    /// Edits the look of the selected bodies.
    pub fn edit_look(&mut self, edit: LookEdit) {
        let begins = self.remember(Deed::Edit(edit.words()));
        let keys = self.selected_bodies(|bodies| {
            let look = |&(body, row): &(usize, &Body)| {
                Assignment::new(&format!("bodies[{body}].look"), look_row(&edit.apply(row)))
            };
            bodies.iter().map(look).collect()
        });
        if !self.set(keys) && begins {
            self.undo.withdraw();
        }
    }

    /// Returns the look of the selected bodies; `None` without bodies.
    pub fn look_values(&self) -> Option<LookValues> {
        self.selected_bodies(LookValues::of)
    }

    /// Applies `read` to the selected bodies, with their indices.
    fn selected_bodies<T>(&self, read: impl FnOnce(&[(usize, &Body)]) -> T) -> T {
        let select = self.material.values().select;
        let is_of = |body: usize| select == Select::All || select == Select::Body(body);
        on!(self.runner(), simulation => {
            let bodies = simulation.model().bodies().iter().enumerate();
            read(&bodies.filter(|(body, _)| is_of(*body)).collect::<Vec<_>>())
        })
    }
}
