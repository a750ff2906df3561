//! WGSL sources of the programs that run on the device, each complete but for the switches that
//! [`source`] puts before it.

use crate::device::quality::Quality;

macro_rules! with_common {
    ($file:literal) => {
        concat!(include_str!("shaders/common.wgsl"), include_str!($file))
    };
}
macro_rules! with_light {
    ($file:literal) => {
        concat!(
            include_str!("shaders/common.wgsl"),
            include_str!("shaders/light.wgsl"),
            include_str!($file)
        )
    };
}

/// The sky behind everything.
pub const SKY: &str = with_common!("shaders/sky.wgsl");
/// Lit surfaces.
pub const SURFACE: &str = with_light!("shaders/surface.wgsl");
/// Planes with their grid.
pub const GROUND: &str = with_light!("shaders/ground.wgsl");
/// Lines of constant width in pixels, and round rods.
pub const LINE: &str = with_light!("shaders/line.wgsl");
/// Round points.
pub const POINT: &str = with_light!("shaders/point.wgsl");
/// The shader of shadow casters, seen from the light.
pub const SHADOW: &str = with_common!("shaders/shadow.wgsl");
/// Rectangles over the picture.
pub const OVERLAY: &str = with_common!("shaders/overlay.wgsl");

/// Every source with its name, for checks.
pub const ALL: [(&str, &str); 7] = [
    ("sky", SKY),
    ("surface", SURFACE),
    ("ground", GROUND),
    ("line", LINE),
    ("point", POINT),
    ("shadow", SHADOW),
    ("overlay", OVERLAY),
];

/// A source for a quality, complete in itself.
pub fn source(text: &str, quality: Quality) -> String {
    let fine = quality == Quality::Full;
    format!("const FINE: bool = {fine};\n{text}")
}
