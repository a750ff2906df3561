//! Looks of bodies, and the viewpoint, from their rows.

use crate::error::FileError;
use crate::file::schema::{BodyRow, CameraRow, Finish, Kind, LookRow};
use crate::file::tree::{Node, Source, Value};
use crate::shown::tame;
use crate::viewpoint::Viewpoint;
use msd_core::Look;
use std::fmt::Arguments;

/// The appearance of body number `row`.
///
/// # Errors
/// A value outside its domain, or the other side of a body that is not a sheet.
pub(crate) fn look(
    source: &Source<'_>,
    (row, body): (usize, &BodyRow),
    is_sheet: bool,
) -> Result<Look, FileError> {
    let default = LookRow::default();
    let given = body.look.as_ref().unwrap_or(&default);
    let key = format!("bodies[{row}].look");
    let mut look = given.finish.unwrap_or_else(|| usual(body.kind, is_sheet)).look();
    let number = |name: &str, value: Option<f64>, otherwise: f32| {
        let checked = value.map(|value| source.number(format_args!("{key}.{name}"), value));
        Ok::<f32, FileError>(checked.transpose()?.map_or(otherwise, |value| value as f32))
    };
    look.roughness = number("roughness", given.roughness, look.roughness)?;
    look.translucency = number("translucency", given.translucency, look.translucency)?;
    look.pattern_size = number("pattern_size", given.pattern_size, look.pattern_size)?;
    look.pattern = given.pattern.unwrap_or(look.pattern);
    if let Some(text) = &given.colour {
        look.colour = Some(colour(source, format_args!("{key}.colour"), text)?);
    }
    if let Some(text) = &given.back {
        if !is_sheet {
            let reason = "does not apply to a body that is not a sheet: it is the colour of \
                          the other side of one";
            return Err(source.refuse(format_args!("{key}.back"), reason));
        }
        look.back = Some(colour(source, format_args!("{key}.back"), text)?);
    }
    Ok(look)
}

/// The look of a row on its own, of a sheet or not.
///
/// # Errors
/// A value outside its domain.
pub fn look_of(row: LookRow, is_sheet: bool) -> Result<Look, FileError> {
    let source = Source::of(Node { value: Value::Nothing, offset: None }, "look");
    look(&source, (0, &BodyRow { look: Some(row), ..BodyRow::default() }), is_sheet)
}

/// A look as a row: a finish, and the differences from it.
pub fn look_row(look: &Look) -> LookRow {
    let finish = Finish::of(look);
    let usual = finish.look();
    let number = |now: f32, usual: f32| (now != usual).then(|| shortest(now));
    LookRow {
        finish: Some(finish),
        colour: look.colour.filter(|_| look.colour != usual.colour).map(hex),
        back: look.back.map(hex),
        roughness: number(look.roughness, usual.roughness),
        translucency: number(look.translucency, usual.translucency),
        pattern: (look.pattern != usual.pattern).then_some(look.pattern),
        pattern_size: number(look.pattern_size, 0.0),
    }
}

/// The written form of a colour.
fn hex(colour: [f32; 3]) -> String {
    let [red, green, blue] = colour.map(|part| (part * 255.0).round() as u8);
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// The number of fewest digits that is the same in single precision.
fn shortest(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(value.into())
}

/// The finish that a body of a kind has by default.
fn usual(kind: Kind, is_sheet: bool) -> Finish {
    match (kind, is_sheet) {
        (Kind::Mesh, true) | (Kind::Explicit, _) => Finish::Plastic,
        (_, true) | (Kind::Rope | Kind::Cloth, _) => Finish::Cloth,
        (Kind::Block, _) => Finish::Jelly,
        (Kind::Mesh, _) => Finish::Clay,
    }
}

/// The components of a colour that is written `#rrggbb`.
fn colour(source: &Source<'_>, key: Arguments<'_>, text: &str) -> Result<[f32; 3], FileError> {
    let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6);
    let digits = digits.filter(|digits| digits.bytes().all(|digit| digit.is_ascii_hexdigit()));
    let Some(number) = digits.and_then(|digits| u32::from_str_radix(digits, 16).ok()) else {
        let value = format!("\"{}\"", tame(text));
        return Err(source.out_of_domain(key, value, "a colour such as \"#3d7fb5\""));
    };
    let [_, red, green, blue] = number.to_be_bytes();
    Ok([red, green, blue].map(|part| f32::from(part) / 255.0))
}

/// From where a scene is looked at.
///
/// # Errors
/// A value outside its domain.
pub(crate) fn viewpoint(
    source: &Source<'_>,
    CameraRow { yaw_deg, pitch_deg, target, distance }: CameraRow,
    extent: f64,
) -> Result<Viewpoint, FileError> {
    for (key, value) in [
        ("camera.yaw_deg", yaw_deg),
        ("camera.pitch_deg", pitch_deg),
        ("camera.distance", distance),
    ] {
        value.map(|value| source.number(format_args!("{key}"), value)).transpose()?;
    }
    target.map(|at| source.position(format_args!("camera.target"), at, extent)).transpose()?;
    Ok(Viewpoint { yaw_deg, pitch_deg, target, distance })
}
