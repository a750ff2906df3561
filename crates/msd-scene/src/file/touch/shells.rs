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
    let others = [
        ("radius", touch.radius.is_some()),
        ("stiffness", touch.stiffness.is_some()),
        ("damping", touch.damping.is_some()),
        ("triangles", touch.triangles.is_some()),
        ("obstacles", touch.obstacles.is_some()),
        ("with", !touch.with.is_empty()),
    ];
    if let Some((name, _)) = others.into_iter().find(|(_, is_there)| *is_there) {
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
    let springs = &scene.springs[body.springs.clone()];
    let longest = spacing.map_or(f64::INFINITY, |spacing| LONGEST * spacing);
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
