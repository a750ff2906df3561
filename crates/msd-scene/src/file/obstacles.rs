//! Planes and solids of the world, from their rows.

use crate::error::{FileError, plain};
use crate::file::bodies::{MeshReader, mesh_error, named_mesh};
use crate::file::keys::LENGTH;
use crate::file::schema::{PlaneRow, SolidKind, SolidRow};
use crate::file::tree::Source;
use crate::file::turn::{key_frames, spin, turn};
use crate::mesh::{self, MeshError};
use glam::DVec3;
use msd_core::scene::MOST_POINTS;
use msd_core::{Friction, KeyFrame, Plane, Shape, Solid};
use std::sync::Arc;

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

/// Restitution and friction of the surface of the obstacle at `key`.
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

/// The inputs from which solids are built.
pub(crate) struct Solids<'b> {
    pub(crate) source: &'b Source<'b>,
    pub(crate) read_mesh: &'b MeshReader<'b>,
    /// Bound of every coordinate, metres.
    pub(crate) extent: f64,
    /// The points of all grids of distances so far.
    pub(crate) points: usize,
}

impl Solids<'_> {
    /// The solid of row number `row`; `notes` are of its mesh, one line each.
    ///
    /// # Errors
    /// A key that its kind does not use, a value outside its domain, more than fits.
    pub(crate) fn build(
        &mut self,
        (row, solid): (usize, &SolidRow),
        notes: &mut Vec<String>,
    ) -> Result<Solid, FileError> {
        let (source, extent) = (self.source, self.extent);
        let key = format!("world.solids[{row}]");
        source.check_kind(&key)?;
        let position = solid.position.unwrap_or_default();
        let velocity = solid.velocity.unwrap_or_default();
        let SolidRow { restitution, friction, tangential_loss: loss, sticky, .. } = *solid;
        let (restitution, friction) = surface(source, &key, (restitution, friction, loss, sticky))?;
        let start = Solid {
            position: source.position(format_args!("{key}.position"), position, extent)?,
            axes: turn(source, &key, solid.rotation)?,
            velocity: source.vector(format_args!("{key}.velocity"), velocity)?,
            spin: spin(source, &key, solid.spin)?,
            restitution,
            friction,
            springs: solid.springs.unwrap_or(false),
            ..Solid::new(self.shape(&key, solid, notes)?)
        };
        let Some(rows) = &solid.key_frames else { return Ok(start) };
        let steady = [("velocity", solid.velocity.is_some()), ("spin", solid.spin.is_some())];
        if let Some((name, _)) = steady.into_iter().find(|&(_, is_given)| is_given) {
            let reason = "and key_frames exclude each other";
            return Err(source.refuse(format_args!("{key}.{name}"), reason));
        }
        let first = KeyFrame { time: 0.0, position: start.position, axes: start.axes };
        Ok(Solid { keys: key_frames(source, (&key, rows), first, extent)?, ..start })
    }

    fn shape(
        &mut self,
        key: &str,
        solid: &SolidRow,
        notes: &mut Vec<String>,
    ) -> Result<Shape, FileError> {
        let source = self.source;
        let number = |name: &str, value: Option<f64>| {
            source.number(format_args!("{key}.{name}"), value.unwrap_or_default())
        };
        let radius = || number("radius", solid.radius);
        let length = || number("length", solid.length);
        Ok(match solid.kind {
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
            SolidKind::Mesh => self.mesh(key, solid, notes)?,
            SolidKind::HalfSpace => Shape::HalfSpace,
        })
    }

    fn mesh(
        &mut self,
        key: &str,
        solid: &SolidRow,
        notes: &mut Vec<String>,
    ) -> Result<Shape, FileError> {
        let source = self.source;
        let file = solid.file.as_deref().unwrap_or_default();
        let mesh = named_mesh(source, self.read_mesh, (&format!("{key}.file"), file))?;
        let length = solid.length.unwrap_or(1.0);
        let length = source.number(format_args!("{key}.length"), length)?;
        let cell = match solid.cell {
            Some(cell) => Some(source.number(format_args!("{key}.cell"), cell)?),
            None => None,
        };
        let grid = mesh::distances(&mesh, length, cell).map_err(|error| {
            let is_of_cell =
                matches!(error, MeshError::TooLarge { .. } | MeshError::TooCoarse { .. });
            let name = if is_of_cell && cell.is_some() { "cell" } else { "file" };
            mesh_error(source, format!("{key}.{name}"), error)
        })?;
        self.points += grid.distances.len();
        if MOST_POINTS < self.points {
            let what = "the number of points of all grids of distances";
            let (count, limit) = (self.points as u128, MOST_POINTS as u128);
            let error = MeshError::TooLarge { file: mesh.name, what, count, limit };
            return Err(mesh_error(source, format!("{key}.cell"), error));
        }
        notes.extend(mesh.report.to_string().lines().map(|line| format!("{}: {line}", mesh.name)));
        let [x, y, z] = grid.counts;
        notes.push(format!(
            "{}: a solid by distances at {x} x {y} x {z} points, {} m apart; its surface is off by \
             at most {} m, {:.2} of that",
            mesh.name,
            told(grid.cell),
            told(grid.error),
            grid.error / grid.cell
        ));
        Ok(Shape::Mesh(Arc::new(grid)))
    }
}

/// A length that is known roughly, to two digits.
pub(crate) fn told(length: f64) -> String {
    plain(format!("{length:.1e}").parse().unwrap_or(length))
}

/// A length in three digits.
pub(crate) fn short(length: f64) -> String {
    plain(format!("{length:.2e}").parse().unwrap_or(length))
}
