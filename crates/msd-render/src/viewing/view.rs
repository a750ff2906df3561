//! View settings: the parts of a snapshot that are shown, and their looks.

use crate::viewing::camera::Camera;
use crate::viewing::quantity::Quantity;
use glam::Vec3;

/// A camera and a style: all that a picture needs besides the snapshot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct View {
    /// From where the scene is seen.
    pub camera: Camera,
    /// The parts that are shown.
    pub style: Style,
}

/// The parts of a snapshot that are shown.
///
/// A body without a surface, such as a rope, is shown by its springs and particles as long as
/// `surfaces` is on, in the colour of the body. So are particles of no body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Style {
    /// Whether bodies show their surfaces. Default true.
    pub surfaces: bool,
    /// Whether surfaces carry the patterns of their looks. Default true.
    pub pattern: bool,
    /// Whether the edges of surface triangles are drawn. Default false.
    pub wireframe: bool,
    /// The quantity of the colours; none where bodies have their own. For a quantity of springs
    /// every spring is drawn, on surfaces that are grey then; for one of particles all that shows
    /// particles has its colours. Default none.
    pub colour_by: Option<Quantity>,
    /// The end of the scale of that quantity, in its unit; positive. None takes that of
    /// [`Quantity::full_scale`], by the contents of the picture. Default none.
    pub full_scale: Option<f32>,
    /// Whether every particle is drawn. Default false.
    pub particles: bool,
    /// Whether pinned particles are marked. Default true.
    pub pins: bool,
    /// Whether the grabs, such as the mouse spring, are drawn. Default true.
    pub grabs: bool,
    /// Whether planes are drawn. Default true.
    pub planes: bool,
    /// Whether planes carry a grid of 1 m, 10 m and 100 m. Default true.
    pub grid: bool,
    /// Whether the sky is drawn. Without it a picture is transparent where nothing else is drawn.
    /// Default true.
    pub sky: bool,
    /// Whether bodies cast shadows. Default true.
    pub shadows: bool,
    /// Whether a legend is drawn where colours stand for a quantity. Default true.
    pub legend: bool,
    /// Radius of a particle, metres; 0 chooses by the rest lengths. Default 0.
    pub particle_radius: f32,
    /// Width of a line, points; not negative, drawn at least 1.5 pixels wide. Default 1.6.
    pub line_width: f32,
    /// Pixels per point of the display, 1; positive. Default 1.
    pub pixels_per_point: f32,
    /// Direction to the light, of any length but zero. Default (−0.45, 0.85, 0.45).
    pub light: Vec3,
}

impl Default for Style {
    fn default() -> Self {
        Self {
            surfaces: true,
            pattern: true,
            wireframe: false,
            colour_by: None,
            full_scale: None,
            particles: false,
            pins: true,
            grabs: true,
            planes: true,
            grid: true,
            sky: true,
            shadows: true,
            legend: true,
            particle_radius: 0.0,
            line_width: 1.6,
            pixels_per_point: 1.0,
            light: Vec3::new(-0.45, 0.85, 0.45),
        }
    }
}

impl Style {
    /// The pixels per point, or 1 if the field is out of its domain.
    pub(crate) fn scale(&self) -> f32 {
        let scale = self.pixels_per_point;
        if scale.is_finite() && 0.0 < scale { scale.clamp(0.25, 8.0) } else { 1.0 }
    }

    /// The width of a line, pixels; at least 1.5.
    pub(crate) fn line_pixels(&self) -> f32 {
        // `max` drops a NaN, so a broken width becomes the thinnest line.
        (self.line_width * self.scale()).clamp(f32::MIN, 100.0).max(1.5)
    }
}
