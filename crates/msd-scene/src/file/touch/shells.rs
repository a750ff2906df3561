//! Surfaces and ropes that meet others at a thickness, from the key `thickness` of `touch`.

use super::{FRICTION, own, triangles};
use crate::error::{FileError, plain};
use crate::file::obstacles::short;
use crate::file::schema::TouchRow;
use crate::file::tree::Source;
use msd_core::Scene;
use msd_core::scene::Shell;

/// The largest thickness, as a part of the spacing: features that share no particle are a spacing
/// apart at rest, and each keeps its thickness.
const THICKEST: f64 = 0.4;

/// The longest spring that is an edge, as a part of the spacing: longer ones span particles.
const LONGEST: f64 = 1.5;

/// The thickness by default, as a part of the spacing.
const THICKNESS: f64 = 0.1;

/// The keys of `touch` that are for particles with a radius, and whether each is there.
fn of_radii(touch: &TouchRow) -> [(&'static str, bool); 5] {
    [
        ("radius", touch.radius.is_some()),
        ("stiffness", touch.stiffness.is_some()),
        ("damping", touch.damping.is_some()),
        ("obstacles", touch.obstacles.is_some()),
        ("with", !touch.with.is_empty()),
    ]
}

/// Whether a key says that particles have a radius.
pub(super) fn has_radius(touch: &TouchRow) -> bool {
    of_radii(touch).into_iter().any(|(_, is_there)| is_there)
}

/// The thickness of a body by default, metres; none of one without springs, which say how far apart
/// its particles are.
pub(super) fn thickness(scene: &Scene, row: usize) -> Option<f64> {
    let particles: Vec<usize> = super::outside(scene, row);
    own(scene, row, &particles).spacing.map(|spacing| THICKNESS * spacing)
}

/// The shell of a body: its surface, or the springs of one that has none.
///
/// # Errors
/// A thickness out of its domain, a key that is for particles with a radius.
pub(super) fn made(
    source: &Source<'_>,
    (row, touch): (usize, &TouchRow),
    thickness: f64,
    scene: &Scene,
) -> Result<Shell, FileError> {
    let key = format!("bodies[{row}].touch");
    if let Some((name, _)) = of_radii(touch).into_iter().find(|(_, is_there)| *is_there) {
        let reason = "is for particles with a radius, and has no place beside `thickness`, by \
                      which surfaces meet without a stiffness: leave one of them out";
        return Err(source.refuse(format_args!("{key}.{name}"), reason));
    }
    let thickness = source.number(format_args!("{key}.thickness"), thickness)?;
    let particles: Vec<usize> = super::outside(scene, row);
    let spacing = own(scene, row, &particles).spacing;
    if let Some(most) = spacing.map(|at| THICKEST * at).filter(|&most| most < thickness) {
        let expected = format!("at most {THICKEST} of the spacing, {} m", short(most));
        let key = format_args!("{key}.thickness");
        return Err(source.out_of_domain(key, plain(thickness), expected));
    }
    let body = &scene.bodies[row];
    let has_surface = !body.surface.triangles.is_empty();
    let longest = spacing.map_or(f64::INFINITY, |spacing| LONGEST * spacing);
    let springs = &scene.springs[body.springs.clone()];
    let short = springs.iter().filter(|spring| spring.rest_length <= longest);
    let friction = touch.friction.unwrap_or(FRICTION);
    Ok(Shell {
        triangles: if has_surface { triangles(source, row, scene)? } else { Vec::new() },
        edges: if has_surface { Vec::new() } else { short.map(|spring| spring.ends).collect() },
        thickness,
        friction: source.number(format_args!("{key}.friction"), friction)?,
        // A solid body seldom meets itself, and its own surface is all about.
        itself: touch.itself.unwrap_or(!has_surface || body.surface.two_sided),
        ignored: Vec::new(),
    })
}
