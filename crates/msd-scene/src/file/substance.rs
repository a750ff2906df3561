//! The substance of a body, from the keys of its row.

use crate::error::{FileError, nearest, plain};
use crate::file::check::domain_of;
use crate::file::keys::Domain;
use crate::file::schema::{BodyRow, Kind};
use crate::file::tree::Source;
use crate::materials::{MATERIALS, Made, Numbers, named};
use msd_core::glam::DVec3;
use msd_core::substance::{MOST_POISSON, SHEET_POISSON, SOLID_POISSON, round_section};
use msd_core::{Bending, Body, Elasticity, Part, Scene, Settings, Simulation, Substance};

/// The tolerance of a Poisson's ratio given for a sheet, about that of springs: 0.33 means 1/3.
const POISSON_WITHIN: f64 = 0.005;

/// The most particles of a body whose slowest motion is sought: it takes seconds.
const MOST_SOUGHT: usize = 4000;

/// The strain of a column at its foot under its own weight, by Hooke's law, above which it is said.
const MOST_STRAIN: f64 = 0.5;

/// The keys of a substance in a row, each with its value.
fn given(body: &BodyRow) -> [(&'static str, Option<f64>); 15] {
    [
        ("young", body.young),
        ("poisson", body.poisson),
        ("density", body.density),
        ("relaxation_time", body.relaxation_time),
        ("damping_ratio", body.damping_ratio),
        ("thickness", body.thickness),
        ("area_density", body.area_density),
        ("young_warp", body.young_warp),
        ("young_weft", body.young_weft),
        ("shear", body.shear),
        ("diameter", body.diameter),
        ("bending", body.bending),
        ("bending_warp", body.bending_warp),
        ("bending_weft", body.bending_weft),
        ("bending_bias", body.bending_bias),
    ]
}

/// The first key of a row that names the material of the body.
pub(super) fn first_key(body: &BodyRow) -> Option<&'static str> {
    // That of a mesh is a part of the stiffness of its other springs.
    let means_else = |key| body.kind == Kind::Mesh && key == "bending";
    let mut numbers = given(body).into_iter().filter(|(_, value)| value.is_some());
    let number = numbers.find(|(key, _)| !means_else(*key)).map(|(key, _)| key);
    body.material.as_ref().map(|_| "material").or(number)
}

/// The keys of body number `row`, over the numbers of the material that it names.
struct Keys<'k> {
    source: &'k Source<'k>,
    row: usize,
    body: &'k BodyRow,
    /// Whether it is a shell of a mesh.
    is_shell: bool,
    material: Option<Numbers>,
}

/// Reads the material of body number `row`, which may be a shell of a mesh; `None` where it is
/// given by masses and springs.
///
/// # Errors
/// A number outside its domain, a key that is missing, keys that exclude each other.
pub(super) fn substance(
    source: &Source<'_>,
    row: usize,
    (body, is_shell): (&BodyRow, bool),
) -> Result<Option<Substance>, FileError> {
    let Some(first) = first_key(body) else { return Ok(None) };
    let plain_keys = [
        ("mass", body.mass.is_some()),
        ("stiffness", body.stiffness.is_some()),
        ("damping", body.damping.is_some()),
        ("neighbours", body.neighbours.is_some()),
        ("bending", body.kind == Kind::Mesh && !is_shell && body.bending.is_some()),
    ];
    if let Some((other, _)) = plain_keys.into_iter().find(|(_, is_given)| *is_given) {
        let reason = format!("and bodies[{row}].{other} exclude each other");
        return Err(source.refuse(format_args!("bodies[{row}].{first}"), reason));
    }
    for (axis, &length) in body.size.iter().flatten().enumerate() {
        if length < 2 {
            let key = format_args!("bodies[{row}].size[{axis}]");
            let expected = format!("at least 2 in a body that has the key `{first}`");
            return Err(source.out_of_domain(key, length, expected));
        }
    }
    let material = match &body.material {
        Some(name) => Some(known(source, &format!("bodies[{row}].material"), name)?),
        None => None,
    };
    Keys { source, row, body, is_shell, material }.substance().map(Some)
}

/// The numbers of a material by its name, which a key gives.
pub(crate) fn known(source: &Source<'_>, key: &str, name: &str) -> Result<Numbers, FileError> {
    if let Some(material) = named(name) {
        return Ok(material.numbers);
    }
    let names = || MATERIALS.iter().map(|material| material.name);
    // The middle one of a family: "gelatine" is not a misspelling.
    let written = name.to_lowercase();
    let family: Vec<&str> = names().filter(|known| known.starts_with(&written)).collect();
    let of_family = family.get(family.len() / 2).copied().filter(|_| !written.is_empty());
    let expected = match nearest(name, names()).or(of_family) {
        Some(near) => format!("the name of a material; did you mean `{near}`?"),
        None => format!("one of {}", names().collect::<Vec<_>>().join(", ")),
    };
    let value = format!("\"{}\"", crate::shown::tame(name));
    Err(source.out_of_domain(format_args!("{key}"), value, expected))
}

impl Keys<'_> {
    fn substance(&self) -> Result<Substance, FileError> {
        let relaxation_time = match self.body.damping_ratio {
            Some(_) if self.body.relaxation_time.is_some() => {
                let row = self.row;
                let reason = format!("and bodies[{row}].relaxation_time exclude each other");
                return Err(self
                    .source
                    .refuse(format_args!("bodies[{row}].damping_ratio"), reason));
            }
            Some(_) => 0.0,
            None => self.number("relaxation_time")?.unwrap_or(0.0),
        };
        let (elasticity, density) = match self.body.kind {
            Kind::Rope | Kind::Block | Kind::Mesh if self.is_woven() => {
                return Err(self.no_fabric());
            }
            Kind::Rope => self.rope()?,
            Kind::Cloth => self.sheet()?,
            Kind::Mesh if self.is_shell => self.sheet()?,
            _ => {
                self.check_is_no_sheet()?;
                let (young, poisson) = (self.needed("young")?, self.solid_poisson()?);
                (Elasticity::Solid { young, poisson }, self.needed("density")?)
            }
        };
        Ok(Substance { elasticity, density, relaxation_time })
    }

    /// Whether the material is a fabric, which has no Young's modulus.
    fn is_woven(&self) -> bool {
        matches!(self.material, Some(Numbers::Fabric { .. }))
    }

    fn no_fabric(&self) -> FileError {
        let name = self.body.material.as_deref().unwrap_or_default();
        let key = format_args!("bodies[{}].material", self.row);
        let expected = "that of a solid in a rope, a block or a mesh: a fabric makes a cloth";
        self.source.out_of_domain(key, format!("\"{}\"", crate::shown::tame(name)), expected)
    }

    /// Refuses the keys of a shell in a solid.
    fn check_is_no_sheet(&self) -> Result<(), FileError> {
        let keys = ["thickness", "area_density"];
        let Some(key) = keys.into_iter().find(|key| self.of_row(key).is_some()) else {
            return Ok(());
        };
        let reason = "does not apply to a solid, which this mesh becomes; `filling = \"shell\"` \
                      asks for a shell";
        Err(self.source.refuse(format_args!("bodies[{}].{key}", self.row), reason))
    }

    fn rope(&self) -> Result<(Elasticity, f64), FileError> {
        let diameter = self.needed("diameter")?;
        let mut elasticity = Elasticity::rope(self.needed("young")?, diameter);
        if let (Elasticity::Rope { bending, .. }, Some(given)) =
            (&mut elasticity, self.number("bending")?)
        {
            *bending = given;
        }
        Ok((elasticity, self.needed("density")? * round_section(diameter)))
    }

    fn sheet(&self) -> Result<(Elasticity, f64), FileError> {
        let (source, row) = (self.source, self.row);
        let density = match (self.body.area_density, self.body.density) {
            (Some(_), Some(_)) => {
                let reason = format!("and bodies[{row}].density exclude each other");
                return Err(source.refuse(format_args!("bodies[{row}].area_density"), reason));
            }
            (None, Some(_)) => None,
            _ => self.number("area_density")?,
        };
        let density = match density {
            Some(density) => density,
            None => self.needed("density")? * self.needed("thickness")?,
        };
        let woven = ["young_warp", "young_weft", "shear"];
        let [warp, weft, shear] = woven;
        let is_woven = woven.iter().any(|key| self.value(key).is_some());
        if !is_woven {
            self.check_sheet_poisson()?;
            let mut elasticity =
                Elasticity::sheet(self.needed("young")?, self.needed("thickness")?);
            if let (Elasticity::Sheet { bending, .. }, Some(given)) =
                (&mut elasticity, self.bending()?)
            {
                *bending = given;
            }
            return Ok((elasticity, density));
        }
        if let Some(key) = ["young", "poisson"].into_iter().find(|key| self.value(key).is_some()) {
            let reason = format!(
                "and the moduli of a woven cloth, {warp}, {weft} and {shear}, \
                                  exclude each other"
            );
            return Err(source.refuse(format_args!("bodies[{row}].{key}"), reason));
        }
        let [warp, weft, shear] = [self.needed(warp)?, self.needed(weft)?, self.needed(shear)?];
        let most = warp * weft / (warp - weft).abs();
        if most < shear {
            let key = format_args!("bodies[{row}].shear");
            let limit = "young_warp young_weft / |young_warp - young_weft|";
            let expected = format!("at most {}, {limit}: springs give no more", plain(most));
            return Err(source.out_of_domain(key, plain(shear), expected));
        }
        let bending = self.bending()?.unwrap_or_default();
        Ok((Elasticity::Sheet { warp, weft, shear, bending }, density))
    }

    /// The bending resistance of a sheet, if that is given.
    fn bending(&self) -> Result<Option<Bending>, FileError> {
        let (source, row) = (self.source, self.row);
        let woven = ["bending_warp", "bending_weft", "bending_bias"];
        let all = self.number("bending")?;
        let of_row = woven.into_iter().find(|key| self.of_row(key).is_some());
        let is_woven = woven.into_iter().any(|key| self.value(key).is_some());
        // One number beside a material replaces its three.
        if !is_woven || (all.is_some() && of_row.is_none()) {
            return Ok(all.map(Bending::uniform));
        }
        if let (Some(_), Some(first)) = (all, of_row) {
            let reason = format!("and bodies[{row}].{first} exclude each other");
            return Err(source.refuse(format_args!("bodies[{row}].bending"), reason));
        }
        let [warp, weft, bias] = woven.map(|key| self.needed(key));
        let (warp, weft, bias) = (warp?, weft?, bias?);
        let least = 0.25 * (warp + weft);
        if bias < least {
            let limit = "(bending_warp + bending_weft)/4";
            // The others may be those of a material: the message names a key that was written.
            let is_own = self.of_row("bending_bias").is_some();
            let written = of_row.filter(|_| !is_own).unwrap_or("bending_bias");
            let expected = match is_own {
                true => format!("at least {}, {limit}", plain(least)),
                false => format!(
                    "such that {limit} is at most bending_bias, {} of the material",
                    plain(bias)
                ),
            };
            let key = format_args!("bodies[{row}].{written}");
            let value = self.of_row(written).unwrap_or(bias);
            return Err(source.out_of_domain(key, plain(value), expected));
        }
        Ok(Some(Bending { warp, weft, bias }))
    }

    /// The Poisson's ratio of a block: that of springs, or another, which costs more. A mesh has
    /// that of springs: there are no cells between its lattice and its surface.
    fn solid_poisson(&self) -> Result<f64, FileError> {
        let Some(poisson) = self.number_of_row("poisson")? else { return Ok(SOLID_POISSON) };
        let key = format_args!("bodies[{}].poisson", self.row);
        if self.body.kind == Kind::Mesh && poisson != SOLID_POISSON {
            let expected = "0.25 in a solid of a mesh, the only one that its springs give; a block \
                            may have another";
            return Err(self.source.out_of_domain(key, plain(poisson), expected));
        }
        if (0.0..=MOST_POISSON).contains(&poisson) {
            return Ok(poisson);
        }
        let why = if poisson < 0.0 {
            "its springs give no less"
        } else {
            "towards 0.5 the stable step goes to 0"
        };
        let expected = format!("between 0 and {MOST_POISSON} in a block: {why}");
        Err(self.source.out_of_domain(key, plain(poisson), expected))
    }

    /// Refuses a Poisson's ratio of a sheet that springs do not give.
    fn check_sheet_poisson(&self) -> Result<(), FileError> {
        match self.number_of_row("poisson")? {
            Some(poisson) if POISSON_WITHIN < (poisson - SHEET_POISSON).abs() => {
                let key = format_args!("bodies[{}].poisson", self.row);
                let sheet = if self.is_shell { "shell" } else { "cloth" };
                let expected =
                    format!("0.3333 (1/3) in a {sheet}, the only one that its springs give");
                Err(self.source.out_of_domain(key, plain(poisson), expected))
            }
            _ => Ok(()),
        }
    }

    /// The value of a key in the row, or by the material.
    fn value(&self, key: &str) -> Option<f64> {
        self.of_row(key).or_else(|| self.of_material(key))
    }

    fn of_row(&self, key: &str) -> Option<f64> {
        given(self.body).into_iter().find(|(known, _)| *known == key).and_then(|(_, value)| value)
    }

    fn of_material(&self, key: &str) -> Option<f64> {
        match (self.material?, key) {
            (Numbers::Uniform { young, .. }, "young") => Some(young),
            (Numbers::Uniform { density, .. }, "density") => Some(density),
            (Numbers::Uniform { relaxation_time, .. }, "relaxation_time") => Some(relaxation_time),
            (Numbers::Fabric { young_warp, .. }, "young_warp") => Some(young_warp),
            (Numbers::Fabric { young_weft, .. }, "young_weft") => Some(young_weft),
            (Numbers::Fabric { shear, .. }, "shear") => Some(shear),
            (Numbers::Fabric { area_density, .. }, "area_density") => Some(area_density),
            (Numbers::Fabric { bending: [warp, ..], .. }, "bending_warp") => Some(warp),
            (Numbers::Fabric { bending: [_, weft, _], .. }, "bending_weft") => Some(weft),
            (Numbers::Fabric { bending: [.., bias], .. }, "bending_bias") => Some(bias),
            _ => None,
        }
    }

    /// A number that may be left out, in its domain.
    fn number(&self, key: &str) -> Result<Option<f64>, FileError> {
        let row = self.number_of_row(key)?;
        Ok(row.or_else(|| self.of_material(key)))
    }

    fn number_of_row(&self, key: &str) -> Result<Option<f64>, FileError> {
        let number = |value| self.source.number(format_args!("bodies[{}].{key}", self.row), value);
        self.of_row(key).map(number).transpose()
    }

    /// A number that must be given, in its domain.
    fn needed(&self, key: &str) -> Result<f64, FileError> {
        if let Some(value) = self.number(key)? {
            return Ok(value);
        }
        let domain = domain_of(&format!("bodies.{key}")).words();
        let beside = first_key(self.body).unwrap_or("material");
        let kind = if self.is_shell { "shell of a mesh" } else { self.body.kind.name() };
        let reason = format!("lacks the key `{key}`, {domain}: a {kind} with `{beside}` needs it");
        Err(self.source.refuse(format_args!("bodies[{}]", self.row), reason))
    }
}

/// Damps a part by the ratio ζ of its row, if it has one. The relaxation time is 2 ζ/w, w being the
/// angular frequency of the slowest motion of the body on its own.
///
/// # Errors
/// A number outside its domain; a body that is too large, or has motions that nothing resists.
pub(super) fn damp(
    source: &Source<'_>,
    row: usize,
    body: &BodyRow,
    part: &mut Part,
) -> Result<(), FileError> {
    let Some(ratio) = body.damping_ratio else { return Ok(()) };
    let ratio = source.number(format_args!("bodies[{row}].damping_ratio"), ratio)?;
    let refuse = |reason: String| {
        let reason = format!("{reason}; give `relaxation_time` instead");
        source.refuse(format_args!("bodies[{row}].damping_ratio"), reason)
    };
    let count = part.particles.len();
    if MOST_SOUGHT < count {
        return Err(refuse(format!(
            "asks for the slowest motion of {count} particles, and of more than {MOST_SOUGHT} that \
             is not sought"
        )));
    }
    let core = |error| FileError::Core { file: source.name.to_string(), source: Box::new(error) };
    let alone = Simulation::<f64>::new(&Scene::of("body", part.clone()), Settings::default());
    let slowest = alone.map_err(core)?.slowest_modes(1);
    let Some(mode) = slowest.first() else {
        return Err(refuse("asks for the slowest motion, and nothing resists many of them".into()));
    };
    let time = 2.0 * ratio / mode.stiffness.sqrt();
    part.springs.iter_mut().for_each(|spring| spring.damping = spring.stiffness * time);
    part.bends.iter_mut().for_each(|bend| bend.damping = bend.stiffness * time);
    part.volumes.iter_mut().for_each(|volume| volume.damping = volume.modulus * time);
    Ok(())
}

/// The material of a body, as an engineer would say it.
pub(super) fn made(body: &BodyRow, substance: &Substance, part: &Part) -> Made {
    let (young, poisson, section) = match substance.elasticity {
        Elasticity::Solid { young, poisson } => (Some(young), Some(poisson), 1.0),
        Elasticity::Rope { stretch, .. } => {
            let section = round_section(body.diameter.unwrap_or(1.0));
            (Some(stretch / section), None, section)
        }
        Elasticity::Sheet { warp, weft, .. } => match body.thickness {
            // A woven sheet may have a thickness too, by which its density is given.
            Some(thickness) if warp == weft && body.young_warp.is_none() => {
                (Some(warp / thickness), Some(SHEET_POISSON), thickness)
            }
            _ => (None, None, 1.0),
        },
    };
    let damped = part.springs.iter().find(|spring| 0.0 < spring.stiffness);
    Made {
        material: body.material.as_deref().and_then(named).map(|material| material.name),
        young,
        poisson,
        density: substance.density / section,
        relaxation_time: damped.map_or(0.0, |spring| spring.damping / spring.stiffness),
        thickness: body.thickness.filter(|_| young.is_some()),
    }
}

/// The properties that a body lacks of the material that it names; none of a rope.
pub(super) fn caveat(body: &BodyRow, substance: &Substance) -> Option<String> {
    let name = body.material.as_deref().filter(|_| body.poisson.is_none())?;
    let Numbers::Uniform { poisson, .. } = named(name)?.numbers else { return None };
    let springs = match substance.elasticity {
        Elasticity::Solid { .. } => "1/4",
        Elasticity::Sheet { .. } => "1/3",
        Elasticity::Rope { .. } => return None,
    };
    let ratio = format!("Poisson's ratio is {springs}, that of springs, instead of {poisson}");
    let hint = match body.kind {
        Kind::Block => format!("; `poisson = {}` costs more", poisson.min(MOST_POISSON)),
        _ => String::new(),
    };
    Some(format!("{name}: {ratio}{hint}"))
}

/// A note for each solid of a material that its own weight squeezes by more than half at its foot.
pub(super) fn overburdened(scene: &Scene, made: &[Option<Made>]) -> Vec<String> {
    let notes = scene.bodies.iter().zip(made).enumerate().filter_map(|(row, (body, made))| {
        let made = made.filter(|made| made.poisson.is_some() && made.thickness.is_none())?;
        let pressure = made.density * drop(scene, body);
        let young = made.young?;
        if pressure <= MOST_STRAIN * young {
            return None;
        }
        Some(format!(
            "bodies[{row}] ({}) cannot carry its own weight: where it stands its foot bears \
             density * gravity * height = {pressure:.3e} Pa, {:.0} % of its Young's modulus; with \
             a `young` of {:.1e} Pa its foot is squeezed by a tenth",
            body.name,
            100.0 * pressure / young,
            10.0 * pressure
        ))
    });
    notes.collect()
}

/// The gravity times the extent of a body along it, square metres per second squared.
fn drop(scene: &Scene, body: &Body) -> f64 {
    let gravity: DVec3 = scene.world.gravity;
    let depths =
        scene.particles[body.particles.clone()].iter().map(|row| gravity.dot(row.position));
    let [least, most] = depths.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], depth| {
        [least.min(depth), most.max(depth)]
    });
    (most - least).max(0.0)
}

/// Refuses a substance whose masses or springs do not fit the precision of the scene.
pub(super) fn check_fits(source: &Source<'_>, row: usize, part: &Part) -> Result<(), FileError> {
    let precision = source.precision.get();
    let masses = part.particles.iter().map(|particle| particle.mass);
    let lightest = masses.fold(f64::INFINITY, f64::min);
    let springs = part.springs.iter().flat_map(|spring| [spring.stiffness, spring.damping]);
    let bends = part.bends.iter().flat_map(|bend| [bend.stiffness, bend.damping]);
    let volumes = part.volumes.iter().flat_map(|row| [row.modulus.abs(), row.damping.abs()]);
    let largest = springs.chain(bends).chain(volumes).fold(0.0, f64::max);
    let fits = Domain::Mass.holds(lightest, precision)
        && Domain::NotNegative.holds(largest, precision)
        && (precision == crate::Precision::F64 || (largest as f32).is_finite());
    if fits {
        return Ok(());
    }
    let reason = format!(
        "is made of particles down to {lightest:e} kg and springs up to {largest:e} N/m, which do \
         not fit {precision}"
    );
    Err(source.refuse(format_args!("bodies[{row}]"), reason))
}
