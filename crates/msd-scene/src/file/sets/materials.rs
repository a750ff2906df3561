//! Materials of the springs between the particles of sets.

use super::NamedSets;
use crate::error::FileError;
use crate::file::schema::{Kind, MaterialRow, SceneFile};
use crate::file::sets::own::OwnSets;
use crate::file::tree::Source;
use crate::materials::Made;
use crate::precision::Precision;
use crate::shown::tame;
use msd_core::Scene;

/// Gives the springs of bodies that join two particles of a set the material of its row. In a body
/// that is made of a material, bends and volumes whose particles are all in the set have it too.
///
/// # Errors
/// A set without a spring between its particles, or one that has a spring of another row with
/// another material; a key that the body does not have, or a value outside its domain.
pub(crate) fn set_materials(
    source: &Source<'_>,
    (file, made): (&SceneFile, &[Option<Made>]),
    (scene, own_sets): (&mut Scene, &[OwnSets]),
) -> Result<(), FileError> {
    if file.materials.is_empty() {
        return Ok(());
    }
    let sets = NamedSets::new(source, &file.sets, (scene, own_sets))?;
    let mut owners: Vec<Option<usize>> = vec![None; scene.springs.len()];
    let (mut springs, mut bends, mut volumes) =
        (scene.springs.clone(), scene.bends.clone(), scene.volumes.clone());
    for (row, material) in file.materials.iter().enumerate() {
        let key = format!("materials[{row}]");
        let particles = sets.particles(&key, material)?;
        let body = scene.bodies.partition_point(|body| body.particles.end <= particles[0]);
        let is_mesh = file.bodies[body].kind == Kind::Mesh;
        let change = change(&sets, (&key, material), (body, made[body], is_mesh))?;
        let mut is_in = vec![false; scene.particles.len()];
        particles.into_iter().for_each(|particle| is_in[particle] = true);
        let mut found = Vec::new();
        for spring in scene.bodies[body].springs.clone() {
            let was = &scene.springs[spring];
            if was.ends.iter().all(|&end| is_in[end]) {
                let constants = change.of([was.stiffness, was.damping]);
                check_fits(source, &key, constants)?;
                [springs[spring].stiffness, springs[spring].damping] = constants;
                found.push(spring);
            }
        }
        if found.is_empty() {
            let value = format!("\"{}\"", tame(&material.set));
            let expected = "a set between whose particles there are springs";
            return Err(source.out_of_domain(format_args!("{key}.set"), value, expected));
        }
        own(source, (&file.materials, row), (&found, scene), &mut owners)?;
        if made[body].is_none() {
            continue;
        }
        for (bend, was) in bends.iter_mut().zip(&scene.bends) {
            // A particle without a weight takes no part.
            let mut ends = was.particles.iter().zip(was.weights);
            if ends.all(|(&end, weight)| weight == 0.0 || is_in[end]) {
                [bend.stiffness, bend.damping] = change.of([was.stiffness, was.damping]);
            }
        }
        for (volume, was) in volumes.iter_mut().zip(&scene.volumes) {
            if was.particles.iter().all(|&corner| is_in[corner]) {
                [volume.modulus, volume.damping] = change.of([was.modulus, was.damping]);
            }
        }
    }
    (scene.springs, scene.bends, scene.volumes) = (springs, bends, volumes);
    Ok(())
}

/// Notes whose row springs have; rows may share those to which they give the same.
fn own(
    source: &Source<'_>,
    (rows, row): (&[MaterialRow], usize),
    (found, scene): (&[usize], &Scene),
    owners: &mut [Option<usize>],
) -> Result<(), FileError> {
    for &spring in found {
        let before = owners[spring].replace(row);
        let Some(other) = before.filter(|&other| values(&rows[other]) != values(&rows[row])) else {
            continue;
        };
        let [a, b] = scene.springs[spring].ends;
        let reason = format!(
            "and materials[{other}] have the spring of particles {a} and {b} of the scene, and not \
             the same values for it"
        );
        return Err(source.refuse(format_args!("materials[{row}]"), reason));
    }
    Ok(())
}

/// The numbers of a row.
fn values(row: &MaterialRow) -> [Option<f64>; 4] {
    [row.stiffness, row.damping, row.young, row.relaxation_time]
}

/// Refuses stiffness and damping of a spring that do not fit the precision of the scene.
fn check_fits(source: &Source<'_>, key: &str, constants: [f64; 2]) -> Result<(), FileError> {
    let precision = source.precision.get();
    let fits = |value: f64| {
        value.is_finite() && (precision == Precision::F64 || (value as f32).is_finite())
    };
    if constants.into_iter().all(fits) {
        return Ok(());
    }
    let [stiffness, damping] = constants;
    let reason = format!(
        "makes a spring of {stiffness:e} N/m and {damping:e} N s/m, which do not fit {precision}"
    );
    Err(source.refuse(format_args!("{key}"), reason))
}

/// The change of stiffness and damping.
enum Change {
    /// Numbers of their own. In a mesh they are those of springs of the usual stiffness; others,
    /// which resist bending, keep their part of it.
    Springs { stiffness: Option<f64>, damping: Option<f64>, usual: Option<f64> },
    /// The factor of the modulus, and the damping over the stiffness, seconds.
    Substance { factor: f64, relaxation_time: Option<f64> },
}

impl Change {
    /// Stiffness and damping, or modulus and its damping, from their previous values.
    fn of(&self, [stiffness, damping]: [f64; 2]) -> [f64; 2] {
        match *self {
            Change::Springs { stiffness: own, damping: lost, usual } => {
                let part =
                    usual.filter(|usual| 0.0 < *usual).map_or(1.0, |usual| stiffness / usual);
                let given = |own: Option<f64>, was| own.map_or(was, |own| own * part);
                [given(own, stiffness), given(lost, damping)]
            }
            Change::Substance { factor, relaxation_time } => {
                let stiffness = stiffness * factor;
                [stiffness, relaxation_time.map_or(damping * factor, |time| stiffness * time)]
            }
        }
    }
}

/// The change of the row at `key`, checked against the material of its body.
fn change(
    sets: &NamedSets<'_>,
    (key, row): (&str, &MaterialRow),
    (body, made, is_mesh): (usize, Option<Made>, bool),
) -> Result<Change, FileError> {
    let source = sets.source;
    let plain = [("stiffness", row.stiffness), ("damping", row.damping)];
    let engineer = [("young", row.young), ("relaxation_time", row.relaxation_time)];
    let (own, other) = if made.is_some() { (engineer, plain) } else { (plain, engineer) };
    let names = own.map(|(name, _)| name).join("` and `");
    if let Some((name, _)) = other.into_iter().find(|(_, value)| value.is_some()) {
        let what = if made.is_some() { "made of a material" } else { "given by its springs" };
        let it = sets.title(body);
        let reason = format!("does not apply to {it}, which is {what}: it has `{names}`");
        return Err(source.refuse(format_args!("{key}.{name}"), reason));
    }
    if own.iter().all(|(_, value)| value.is_none()) {
        let reason = format!("needs one of the keys `{names}`");
        return Err(source.refuse(format_args!("{key}"), reason));
    }
    let number = |(name, value): (&str, Option<f64>)| {
        value.map(|value| source.number(format_args!("{key}.{name}"), value)).transpose()
    };
    let [first, second] = [number(own[0])?, number(own[1])?];
    Ok(match made {
        None => {
            // Those that resist bending come last.
            let first_spring = sets.scene.springs.get(sets.scene.bodies[body].springs.start);
            let usual = first_spring.filter(|_| is_mesh).map(|spring| spring.stiffness);
            Change::Springs { stiffness: first, damping: second, usual }
        }
        Some(made) => {
            let factor = match (first, made.young) {
                (None, _) => 1.0,
                (Some(young), Some(was)) => young / was,
                (Some(_), None) => {
                    let it = sets.title(body);
                    let reason = format!("does not apply to {it}, which is woven: it has none");
                    return Err(source.refuse(format_args!("{key}.young"), reason));
                }
            };
            Change::Substance { factor, relaxation_time: second }
        }
    })
}
