//! Planes and solids of the world, from their rows.

use crate::error::FileError;
use crate::file::domain::LENGTH;
use crate::file::schema::{PlaneRow, SolidKind, SolidRow};
use crate::file::tree::Source;
use crate::file::turn::{spin, turn};
use glam::DVec3;
use msd_core::{Friction, Plane, Shape, Solid};

/// The plane of row number `row`.
pub(crate) fn plane(
    source: &Source<'_>,
    (row, plane): (usize, &PlaneRow),
) -> Result<Plane, FileError> {
    let key = format!("world.planes[{row}]");
    let PlaneRow { restitution, friction, tangential_loss: loss, sticky, .. } = *plane;
    let (restitution, friction) = surface(source, &key, (restitution, friction, loss, sticky))?;
    let normal = plane.normal.unwrap_or([0.0, 1.0, 0.0]);
    let offset = plane.offset.unwrap_or(0.0);
    Ok(Plane {
        normal: source.direction(format_args!("{key}.normal"), normal)?,
        offset: source.number(format_args!("{key}.offset"), offset)?,
        restitution,
        friction,
    })
}

/// The keys `restitution`, `friction`, `tangential_loss` and `sticky` of a surface.
type SurfaceKeys = (Option<f64>, Option<f64>, Option<f64>, Option<bool>);

/// Restitution and friction of the surface of what stands at `key`.
fn surface(
    source: &Source<'_>,
    key: &str,
    (restitution, friction, loss, sticky): SurfaceKeys,
) -> Result<(f64, Friction), FileError> {
    let sticky = sticky.unwrap_or(false);
    if sticky && [restitution, friction, loss].iter().any(Option::is_some) {
        let reason = "says it all: leave out restitution, friction and tangential_loss";
        return Err(source.refuse(format_args!("{key}.sticky"), reason));
    }
    let friction = match (friction, loss) {
        (Some(_), Some(_)) => {
            let reason = "and tangential_loss exclude each other";
            return Err(source.refuse(format_args!("{key}.friction"), reason));
        }
        (None, Some(loss)) => {
            Friction::TangentialLoss(source.number(format_args!("{key}.tangential_loss"), loss)?)
        }
        (None, None) if sticky => Friction::TangentialLoss(1.0),
        (factor, None) => {
            let factor = factor.unwrap_or(0.5);
            Friction::Coulomb(source.number(format_args!("{key}.friction"), factor)?)
        }
    };
    let restitution = restitution.unwrap_or(0.0);
    Ok((source.number(format_args!("{key}.restitution"), restitution)?, friction))
}

/// The solid of row number `row`.
pub(crate) fn solid(
    source: &Source<'_>,
    (row, solid): (usize, &SolidRow),
    extent: f64,
) -> Result<Solid, FileError> {
    let key = format!("world.solids[{row}]");
    let position = solid.position.unwrap_or_default();
    let velocity = solid.velocity.unwrap_or_default();
    let SolidRow { restitution, friction, tangential_loss: loss, sticky, .. } = *solid;
    let (restitution, friction) = surface(source, &key, (restitution, friction, loss, sticky))?;
    Ok(Solid {
        shape: shape(source, &key, solid)?,
        position: source.position(format_args!("{key}.position"), position, extent)?,
        axes: turn(source, &key, solid.rotation)?,
        velocity: source.vector(format_args!("{key}.velocity"), velocity)?,
        spin: spin(source, &key, solid.spin)?,
        restitution,
        friction,
    })
}

fn shape(source: &Source<'_>, key: &str, solid: &SolidRow) -> Result<Shape, FileError> {
    let kind = solid.kind;
    let takes = kind.keys();
    let given = [
        ("radius", solid.radius.is_some()),
        ("length", solid.length.is_some()),
        ("size", solid.size.is_some()),
        ("tube", solid.tube.is_some()),
    ];
    for (name, is_given) in given {
        let keys = format!("a {} takes {}", kind.name(), takes.join(" and "));
        match (takes.contains(&name), is_given) {
            (true, false) => {
                let reason = format!("lacks the key `{name}`: {keys}");
                return Err(source.refuse(format_args!("{key}"), reason));
            }
            (false, true) => {
                let reason = format!("is not for its kind: {keys}");
                return Err(source.refuse(format_args!("{key}.{name}"), reason));
            }
            _ => {}
        }
    }
    let number = |name: &str, value: Option<f64>| {
        source.number(format_args!("{key}.{name}"), value.unwrap_or_default())
    };
    let radius = || number("radius", solid.radius);
    let length = || number("length", solid.length);
    Ok(match kind {
        SolidKind::Sphere => Shape::Sphere { radius: radius()? },
        SolidKind::Capsule => Shape::Capsule { radius: radius()?, length: length()? },
        SolidKind::Cylinder => Shape::Cylinder { radius: radius()?, length: length()? },
        SolidKind::Box => {
            let size = solid.size.unwrap_or_default();
            for (axis, side) in size.into_iter().enumerate() {
                let key = format_args!("{key}.size[{axis}]");
                source.number_in(LENGTH, key, side)?;
            }
            Shape::Box { size: DVec3::from_array(size) }
        }
        SolidKind::Torus => {
            let (radius, tube) = (radius()?, number("tube", solid.tube)?);
            if radius <= tube {
                let reason = format!("is {tube}; it must be smaller than the radius, {radius}");
                return Err(source.refuse(format_args!("{key}.tube"), reason));
            }
            Shape::Torus { radius, tube }
        }
    })
}

impl SolidKind {
    /// The name a user writes.
    fn name(self) -> &'static str {
        match self {
            SolidKind::Sphere => "sphere",
            SolidKind::Capsule => "capsule",
            SolidKind::Box => "box",
            SolidKind::Cylinder => "cylinder",
            SolidKind::Torus => "torus",
        }
    }

    /// The lengths that it takes.
    fn keys(self) -> &'static [&'static str] {
        match self {
            SolidKind::Sphere => &["radius"],
            SolidKind::Capsule | SolidKind::Cylinder => &["radius", "length"],
            SolidKind::Box => &["size"],
            SolidKind::Torus => &["radius", "tube"],
        }
    }
}
