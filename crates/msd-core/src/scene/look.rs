//! Looks of bodies. Nothing of them is physics: a step never reads them.

use crate::scene::surface::Surface;

/// Colours of bodies, sRGB: apart in hue, and in lightness from neighbour to neighbour.
pub const PALETTE: [[f32; 3]; 8] = [
    [0.14, 0.55, 0.71],
    [0.89, 0.37, 0.25],
    [0.95, 0.72, 0.24],
    [0.33, 0.42, 0.73],
    [0.45, 0.69, 0.36],
    [0.80, 0.66, 0.46],
    [0.84, 0.42, 0.57],
    [0.53, 0.39, 0.65],
];
/// Where the palette begins for sheets, and for ropes and other bodies without a surface.
const FIRST_SHEET: usize = 1;
const FIRST_ROPE: usize = 5;

/// A pattern that is repeated along the surface of a body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Pattern {
    /// One colour.
    #[default]
    None,
    /// A chequerboard; the size is the side of a square.
    Checks,
    /// Stripes; the size is the width of one.
    Stripes,
    /// Threads over and under each other; the size is the width of one.
    Weave,
    /// Wavy lines as in wood; the size is the distance of two.
    Grain,
}

impl Pattern {
    /// All of them.
    pub const ALL: [Pattern; 5] =
        [Pattern::None, Pattern::Checks, Pattern::Stripes, Pattern::Weave, Pattern::Grain];

    /// The name, as in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Pattern::None => "none",
            Pattern::Checks => "checks",
            Pattern::Stripes => "stripes",
            Pattern::Weave => "weave",
            Pattern::Grain => "grain",
        }
    }
}

/// The appearance of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Look {
    /// Colour, sRGB, each component from 0 to 1. Default by the place of the body among the
    /// others.
    pub colour: Option<[f32; 3]>,
    /// Colour of the other side of a sheet, sRGB, each component from 0 to 1. Default a lighter
    /// shade of `colour`.
    pub back: Option<[f32; 3]>,
    /// From 0, which mirrors, to 1, which is dull. Default 0.5.
    pub roughness: f32,
    /// Whether it mirrors in its own colour, as metals do. Default false.
    pub metal: bool,
    /// The share of light that passes thin parts, from 0 to 1. Default 0.
    pub translucency: f32,
    /// Pattern that is repeated along its surface. Default none.
    pub pattern: Pattern,
    /// Size of the pattern, metres; 0 for a part of the body that suits the pattern. Default 0.
    pub pattern_size: f32,
}

impl Default for Look {
    fn default() -> Self {
        Self {
            colour: None,
            back: None,
            roughness: 0.5,
            metal: false,
            translucency: 0.0,
            pattern: Pattern::None,
            pattern_size: 0.0,
        }
    }
}

impl Look {
    /// The colour of a body of this look, sRGB from 0 to 1. It is its own, or one of eight by the
    /// kind of its surface and by its place among the bodies.
    pub fn colour_at(&self, number: usize, surface: &Surface) -> [f32; 3] {
        let first = match surface {
            surface if surface.triangles.is_empty() => FIRST_ROPE,
            surface if surface.two_sided => FIRST_SHEET,
            _ => 0,
        };
        self.colour.unwrap_or(PALETTE[(first + number) % PALETTE.len()])
    }

    /// The look of a body with this surface of which no more is known: a sheet is woven.
    pub fn of(surface: &Surface) -> Self {
        match surface.two_sided {
            true => Self { roughness: 0.9, pattern: Pattern::Weave, ..Self::default() },
            false => Self::default(),
        }
    }
}
