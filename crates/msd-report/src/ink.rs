//! The colour and the mark of each method, the same in every figure; grey for a method without a
//! colour.

use msd_core::Integrator;
use plotters::style::RGBColor;

/// A colour on white paper and on a dark screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ink {
    /// On white, and in the file.
    pub light: RGBColor,
    /// On a dark screen.
    pub dark: RGBColor,
}

const fn ink(light: (u8, u8, u8), dark: (u8, u8, u8)) -> Ink {
    Ink { light: RGBColor(light.0, light.1, light.2), dark: RGBColor(dark.0, dark.1, dark.2) }
}

/// The ground.
pub const PAPER: Ink = ink((255, 255, 255), (24, 27, 31));
/// Titles, and the reference.
pub const TEXT: Ink = ink((33, 37, 41), (233, 236, 239));
/// Axes and the words beside them.
pub const MUTED: Ink = ink((96, 103, 110), (160, 168, 176));
/// The grid.
pub const GRID: Ink = ink((233, 235, 237), (44, 49, 55));
/// Ground that no measurement reaches.
pub const SHADE: Ink = ink((243, 244, 245), (33, 37, 42));
/// Guides: the wanted error, real time.
pub const GUIDE: Ink = ink((143, 150, 157), (118, 126, 134));
/// The Pareto front.
pub const FRONT: Ink = ink((206, 199, 184), (92, 87, 76));

/// Every ink that is not a method's.
pub const COMMON: [Ink; 7] = [PAPER, TEXT, MUTED, GRID, SHADE, GUIDE, FRONT];

/// The ink of a method: Okabe and Ito's colours (2008), which the colour-blind can distinguish, but
/// with grey for black and olive for yellow, which white paper swallows.
pub fn line(integrator: Integrator) -> Ink {
    match integrator {
        Integrator::ExplicitEuler => ink((128, 128, 129), (150, 150, 151)),
        Integrator::SymplecticEuler => ink((230, 159, 0), (240, 173, 30)),
        Integrator::VelocityVerlet => ink((0, 114, 178), (60, 155, 215)),
        Integrator::Rk4 => ink((213, 94, 0), (235, 120, 40)),
        Integrator::DormandPrince => ink((204, 121, 167), (220, 140, 184)),
        Integrator::BackwardEuler => ink((86, 180, 233), (110, 195, 242)),
        Integrator::ImplicitMidpoint => ink((0, 158, 115), (30, 180, 138)),
        Integrator::Xpbd => ink((142, 132, 24), (184, 172, 60)),
        _ => MUTED,
    }
}

/// The ink of a method's name: its colour, dark enough to be read on white (4.5 : 1).
pub fn name(integrator: Integrator) -> Ink {
    match integrator {
        Integrator::ExplicitEuler => ink((104, 104, 105), (170, 170, 171)),
        Integrator::SymplecticEuler => ink((150, 98, 0), (245, 190, 75)),
        Integrator::VelocityVerlet => ink((0, 100, 160), (105, 180, 230)),
        Integrator::Rk4 => ink((178, 72, 0), (242, 150, 85)),
        Integrator::DormandPrince => ink((165, 68, 122), (230, 165, 200)),
        Integrator::BackwardEuler => ink((20, 112, 165), (140, 208, 246)),
        Integrator::ImplicitMidpoint => ink((0, 116, 84), (80, 200, 162)),
        Integrator::Xpbd => ink((112, 103, 12), (205, 195, 100)),
        _ => MUTED,
    }
}

/// The outline of a method's mark about the origin, of radius about 1; y points down.
pub fn mark(integrator: Integrator) -> Vec<(f64, f64)> {
    match integrator {
        Integrator::ExplicitEuler => star(4, 0.0, 1.25, 0.5),
        Integrator::SymplecticEuler => star(3, 0.5, 1.2, 0.6),
        Integrator::VelocityVerlet => star(12, 0.0, 0.95, 0.95),
        Integrator::Rk4 => star(2, 0.25, 1.15, 1.15),
        Integrator::DormandPrince => star(2, 0.0, 1.2, 1.2),
        Integrator::BackwardEuler => star(3, 0.0, 1.2, 0.6),
        Integrator::ImplicitMidpoint => star(5, 0.0, 1.2, 0.97),
        Integrator::Xpbd => star(5, 0.0, 1.3, 0.62),
        _ => star(6, 0.0, 1.2, 0.6),
    }
}

/// A star of so many points, turned by a fraction of a turn, point and notch at these radii.
fn star(points: usize, turn: f64, outer: f64, inner: f64) -> Vec<(f64, f64)> {
    let corner = |corner: usize| {
        let angle = std::f64::consts::TAU * (turn * 0.5 + corner as f64 / (2 * points) as f64);
        let radius = if corner.is_multiple_of(2) { outer } else { inner };
        (radius * libm::sin(angle), -radius * libm::cos(angle))
    };
    (0..2 * points).map(corner).collect()
}

/// A colour as a drawing writes it: `#0072B2`.
pub fn hex(colour: RGBColor) -> String {
    format!("#{:02X}{:02X}{:02X}", colour.0, colour.1, colour.2)
}
