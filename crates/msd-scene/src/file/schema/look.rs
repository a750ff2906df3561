//! Rows of looks and of the camera.

use crate::file::keys::{Domain, LENGTH, rows};
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

rows! {
    /// How a body looks.
    LookRow {
        /// Apparent material. `clay`: dull; `plastic`: smooth; `jelly`: glossy and translucent;
        /// `cloth`: woven; `metal`: mirrors in its own colour; `wood`: grained.
        finish: Option<Finish> = "block `jelly`, cloth and rope `cloth`, solid mesh `clay`, others \
                                  `plastic`",
        /// Colour, sRGB.
        colour: Option<String> = "by the number of the body; `metal` grey, `wood` brown"
            { domain: Domain::Words("text, `\"#rrggbb\"`") },
        /// Colour of the other side of a cloth or a shell, sRGB.
        back: Option<String> = "a lighter shade" { domain: Domain::Words("text, `\"#rrggbb\"`") },
        /// 0 mirrors, 1 is dull.
        roughness: Option<f64> = "that of the finish" { domain: Domain::Fraction },
        /// Share of light that passes thin parts.
        translucency: Option<f64> = "that of the finish" { domain: Domain::Fraction },
        /// Pattern along the surface.
        pattern: Option<Pattern> = "that of the finish",
        /// Side of a square, width of a stripe or a thread, distance between lines of a grain;
        /// rounded so that a whole number fits.
        pattern_size: Option<f64> = "a part of the body" { unit: "m", domain: LENGTH },
    }

    /// From where a scene is looked at, unless the user says otherwise.
    CameraRow: Copy {
        /// Azimuth about the vertical; at 0 the camera is on the +z side, at 90 on the +x side.
        yaw_deg: Option<f64> = "34" { unit: "°", domain: Domain::Finite },
        /// Elevation above the horizon. The camera always stays above a level plane.
        pitch_deg: Option<f64> = "20" { unit: "°", domain: Domain::Elevation },
        /// Point in the middle of the picture.
        target: Option<[f64; 3]> = "the middle of the bodies" { unit: "m", domain: Domain::Place },
        /// Distance of the camera from the target.
        distance: Option<f64> = "the shortest that shows all bodies"
            { unit: "m", domain: LENGTH },
    }
}
