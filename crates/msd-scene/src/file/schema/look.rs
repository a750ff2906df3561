//! Rows of looks and of the camera.

use msd_core::{Look, Pattern};
use serde::{Deserialize, Serialize};

/// Brown, of wood, and grey, of metal, sRGB.
const WOOD: [f32; 3] = [0.72, 0.49, 0.28];
const STEEL: [f32; 3] = [0.74, 0.76, 0.79];

/// What a body seems to be made of: the rest of its look where that is not given.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Finish {
    /// Dull and even.
    Clay,
    /// Smooth with soft highlights.
    Plastic,
    /// Glossy, and light passes through thin parts.
    Jelly,
    /// Dull threads.
    Cloth,
    /// Mirrors in its own colour.
    Metal,
    /// Grained.
    Wood,
}

impl Finish {
    /// All of them.
    pub const ALL: [Finish; 6] =
        [Finish::Clay, Finish::Plastic, Finish::Jelly, Finish::Cloth, Finish::Metal, Finish::Wood];

    /// The name, as in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Finish::Clay => "clay",
            Finish::Plastic => "plastic",
            Finish::Jelly => "jelly",
            Finish::Cloth => "cloth",
            Finish::Metal => "metal",
            Finish::Wood => "wood",
        }
    }

    /// The look of a body of which no more is said.
    pub fn look(self) -> Look {
        let plain = Look::default();
        match self {
            Finish::Clay => Look { roughness: 0.8, ..plain },
            Finish::Plastic => Look { roughness: 0.3, ..plain },
            Finish::Jelly => Look { roughness: 0.06, translucency: 0.6, ..plain },
            Finish::Cloth => {
                Look { roughness: 0.95, pattern: Pattern::Weave, translucency: 0.15, ..plain }
            }
            Finish::Metal => Look { colour: Some(STEEL), roughness: 0.25, metal: true, ..plain },
            Finish::Wood => {
                Look { colour: Some(WOOD), roughness: 0.6, pattern: Pattern::Grain, ..plain }
            }
        }
    }

    /// The finish of a look: that from which it differs in the fewest numbers. What mirrors in its
    /// own colour is metal, and what has no colour of its own has a finish without one.
    pub fn of(look: &Look) -> Finish {
        let differences = |finish: &Finish| {
            let own = finish.look();
            let colour = own.colour.is_some() && own.colour != look.colour;
            let is_coloured = own.colour.is_some() && look.colour.is_none();
            let numbers = [
                own.roughness != look.roughness,
                own.translucency != look.translucency,
                own.pattern != look.pattern,
                colour,
            ];
            let count = numbers.into_iter().filter(|differs| *differs).count();
            (own.metal != look.metal, is_coloured, count)
        };
        Finish::ALL.into_iter().min_by_key(differences).unwrap_or(Finish::Clay)
    }
}

/// How a body looks.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LookRow {
    /// What it seems to be made of. Default by the kind of the body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub finish: Option<Finish>,
    /// Colour, `"#rrggbb"`. Default by the place of the body among the others; of wood brown, of
    /// metal grey.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub colour: Option<String>,
    /// Colour of the other side of a sheet, `"#rrggbb"`. Default a lighter shade.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub back: Option<String>,
    /// From 0, which mirrors, to 1, which is dull. Default that of the finish.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub roughness: Option<f64>,
    /// The share of light that passes thin parts, 0 to 1. Default that of the finish.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub translucency: Option<f64>,
    /// What is repeated along the surface. Default that of the finish.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pattern: Option<Pattern>,
    /// Size of the pattern, metres. Default a part of the body that suits the pattern.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pattern_size: Option<f64>,
}

/// From where a scene is looked at, unless the user says otherwise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraRow {
    /// Azimuth about the vertical, degrees; at 0 the camera is on the +z side.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub yaw_deg: Option<f64>,
    /// Elevation above the horizon, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pitch_deg: Option<f64>,
    /// What is in the middle of the picture, metres. Default the middle of the bodies.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<[f64; 3]>,
    /// Distance from there, metres. Default as near as all bodies are in the picture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance: Option<f64>,
}
