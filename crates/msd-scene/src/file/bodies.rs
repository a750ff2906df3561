//! Particles and springs from the row of a body.

use crate::error::{FileError, plain};
use crate::file::budget::{Budget, count_lattice};
use crate::file::check::domain_of;
use crate::file::schema::{BodyRow, Kind};
use crate::file::sets::own::{Groups, OwnSets, groups};
use crate::file::substance::{caveat, check_fits, damp, made, substance};
use crate::file::tree::Source;
use crate::file::turn::{spin, turn};
use crate::materials::Made;
use crate::mesh::{self, Mesh, MeshError, MeshOptions};
use crate::precision::Precision;
use crate::shown::tame;
use glam::DVec3;
use msd_core::substance::SOLID_POISSON;
use msd_core::{
    Bending, Elasticity, Lattice, Material, Neighbours, Part, Particle, Spring, Substance, shape,
};

/// Reads the mesh that a scene names.
pub(crate) type MeshReader<'r> = dyn Fn(&str) -> Result<Mesh, MeshError> + 'r;

/// The inputs from which bodies are built.
pub(crate) struct Builder<'b> {
    pub(crate) source: &'b Source<'b>,
    pub(crate) read_mesh: &'b MeshReader<'b>,
    /// Bound of every coordinate, metres.
    pub(crate) extent: f64,
    /// Precision that the scene asks for.
    pub(crate) precision: Precision,
    pub(crate) budget: Budget,
    /// Changes made to meshes, and gaps of materials, one line each.
    pub(crate) notes: Vec<String>,
}

/// A body that has been built.
pub(crate) struct Built {
    pub(crate) part: Part,
    pub(crate) own_sets: OwnSets,
    /// Its material; none where it is given by masses and springs.
    pub(crate) made: Option<Made>,
}

impl Builder<'_> {
    /// Builds body number `row`, placed and moving.
    ///
    /// # Errors
    /// A key that its kind does not use, a value outside its domain, more than fits.
    pub(crate) fn build(&mut self, row: usize, body: &BodyRow) -> Result<Built, FileError> {
        self.source.check_kind(&format!("bodies[{row}]"))?;
        let mut built = match body.kind {
            Kind::Rope | Kind::Cloth | Kind::Block => self.lattice(row, body)?,
            Kind::Mesh => self.mesh(row, body)?,
            Kind::Explicit => self.explicit(row, body)?,
        };
        let scale = body.rest_scale.unwrap_or(1.0);
        let scale = self.source.number(format_args!("bodies[{row}].rest_scale"), scale)?;
        built.part.springs.iter_mut().for_each(|spring| spring.rest_length *= scale);
        self.place(row, body, &mut built.part)?;
        self.check_masses(row, body, &built.part)?;
        self.check_apart(row, body, &built.part)?;
        Ok(built)
    }

    fn lattice(&mut self, row: usize, body: &BodyRow) -> Result<Built, FileError> {
        let neighbours = self.neighbours(row, body)?;
        let size = self.lattice_size(row, body)?;
        let spacing = self
            .source
            .number(format_args!("bodies[{row}].spacing"), body.spacing.unwrap_or(1.0))?;
        let substance = substance(self.source, row, (body, false))?;
        let material = self.material(row, body, Material::default())?;
        let counts = count_lattice(size, neighbours);
        self.budget.add_bends(match substance.map(|substance| substance.elasticity) {
            // A line along either thread and a cell for each particle.
            Some(Elasticity::Sheet { bending, .. }) if bending != Bending::default() => {
                counts[0].saturating_mul(3)
            }
            Some(Elasticity::Rope { bending, .. }) if bending != 0.0 => counts[0],
            _ => 0,
        });
        self.budget.add_volumes(match substance.map(|substance| substance.elasticity) {
            Some(Elasticity::Solid { poisson, .. }) if poisson != SOLID_POISSON => counts[0],
            _ => 0,
        });
        self.budget.take(self.source, format_args!("bodies[{row}].size"), counts)?;
        let file = || self.source.name.to_string();
        let core = |source| FileError::Core { file: file(), source: Box::new(source) };
        let lattice = Lattice::new(size, neighbours).map_err(core)?;
        let mut part = match &substance {
            Some(substance) => shape::body(size, spacing, substance).map_err(core)?,
            None => shape::lattice(size, neighbours, spacing, material).map_err(core)?,
        };
        let made = self.finish(row, body, (substance, &mut part))?;
        Ok(Built { part, own_sets: OwnSets::Lattice(lattice), made })
    }

    /// Damps a body that is made of a substance, checks its numbers and returns its material.
    fn finish(
        &mut self,
        row: usize,
        body: &BodyRow,
        (substance, part): (Option<Substance>, &mut Part),
    ) -> Result<Option<Made>, FileError> {
        let Some(substance) = substance else { return Ok(None) };
        damp(self.source, row, body, part)?;
        check_fits(self.source, row, part)?;
        self.notes.extend(caveat(body, &substance));
        Ok(Some(made(body, &substance, part)))
    }

    fn lattice_size(&self, row: usize, body: &BodyRow) -> Result<[usize; 3], FileError> {
        let source = self.source;
        let size = body.size.as_deref().unwrap_or_default();
        for (axis, &length) in size.iter().enumerate() {
            source.count(format_args!("bodies[{row}].size[{axis}]"), length)?;
        }
        let whole = |length: u64| usize::try_from(length).unwrap_or(usize::MAX);
        match (body.kind, size) {
            (Kind::Rope, &[count]) => Ok([1, whole(count), 1]),
            (Kind::Cloth, &[rows, columns]) => Ok([whole(rows), whole(columns), 1]),
            (Kind::Block, &[rows, columns, stacks]) => Ok([rows, columns, stacks].map(whole)),
            (kind, _) => {
                let expected = match kind {
                    Kind::Rope => "one number: [count]",
                    Kind::Cloth => "two numbers: [rows, columns]",
                    _ => "three numbers: [rows, columns, stacks]",
                };
                let value = format!("a list of {}", size.len());
                let key = format_args!("bodies[{row}].size");
                Err(source.out_of_domain(key, value, expected))
            }
        }
    }

    fn neighbours(&self, row: usize, body: &BodyRow) -> Result<Neighbours, FileError> {
        match (body.kind, body.neighbours) {
            (_, None) | (Kind::Rope, Some(2)) => Ok(Neighbours::All),
            (Kind::Cloth, Some(8)) | (Kind::Block, Some(26)) => Ok(Neighbours::All),
            (Kind::Cloth, Some(4)) | (Kind::Block, Some(6)) => Ok(Neighbours::Axes),
            (kind, Some(number)) => {
                let expected = match kind {
                    Kind::Rope => "2 for a rope",
                    Kind::Cloth => "4 or 8 for a cloth",
                    _ => "6 or 26 for a block",
                };
                let key = format_args!("bodies[{row}].neighbours");
                Err(self.source.out_of_domain(key, number, expected))
            }
        }
    }

    fn material(
        &self,
        row: usize,
        body: &BodyRow,
        default: Material,
    ) -> Result<Material, FileError> {
        let source = self.source;
        let (mass, stiffness) = (body.mass.unwrap_or(default.mass), body.stiffness);
        let stiffness = stiffness.unwrap_or(default.stiffness);
        let damping = body.damping.unwrap_or(default.damping);
        Ok(Material {
            mass: source.number(format_args!("bodies[{row}].mass"), mass)?,
            stiffness: source.number(format_args!("bodies[{row}].stiffness"), stiffness)?,
            damping: source.number(format_args!("bodies[{row}].damping"), damping)?,
        })
    }

    fn mesh(&mut self, row: usize, body: &BodyRow) -> Result<Built, FileError> {
        let source = self.source;
        let file = body.file.as_deref().unwrap_or_default();
        let mesh = named_mesh(source, self.read_mesh, (&format!("bodies[{row}].file"), file))?;
        let options = self.mesh_options(row, body, &mesh)?;
        let refused = |error| {
            let key = match &error {
                MeshError::Option { quantity: "size", .. } => "length",
                MeshError::Option { quantity: "mass", .. } => "mass",
                MeshError::Option { .. } | MeshError::TooFine { .. } => "spacing",
                MeshError::Undecided { .. } => "filling",
                _ => "file",
            };
            mesh_error(source, format!("bodies[{row}].{key}"), error)
        };
        let counts = mesh::estimate(&mesh, &options).map_err(refused)?;
        if matches!(options.substance, Some(Substance { elasticity: Elasticity::Sheet { .. }, .. }))
        {
            // Of fewer edges than springs.
            self.budget.add_bends(counts[1]);
        }
        let key = if body.spacing.is_some() { "spacing" } else { "file" };
        self.budget.take(source, format_args!("bodies[{row}].{key}"), counts)?;
        let (mut part, report) = mesh::body(&mesh, &options).map_err(refused)?;
        self.notes
            .extend(mesh.report.to_string().lines().map(|line| format!("{}: {line}", mesh.name)));
        self.notes.extend(report.to_string().lines().map(|line| format!("{}: {line}", mesh.name)));
        let own_sets = OwnSets::Groups(groups(&mesh, &part.surface, 0));
        let made = self.finish(row, body, (options.substance, &mut part))?;
        Ok(Built { part, own_sets, made })
    }

    fn mesh_options(
        &self,
        row: usize,
        body: &BodyRow,
        mesh: &Mesh,
    ) -> Result<MeshOptions, FileError> {
        let source = self.source;
        let default = MeshOptions::for_mesh(mesh, body.filling.unwrap_or_default());
        let MeshOptions { mass, stiffness, damping, .. } = default;
        let Material { mass, stiffness, damping } =
            self.material(row, body, Material { mass, stiffness, damping })?;
        let length = body.length.unwrap_or(1.0);
        let bending = body.bending.unwrap_or(default.bending);
        let spacing = match body.spacing {
            Some(spacing) => Some(source.number(format_args!("bodies[{row}].spacing"), spacing)?),
            None => None,
        };
        Ok(MeshOptions {
            filling: default.filling,
            size: Some(source.number(format_args!("bodies[{row}].length"), length)?),
            bending: source.number(format_args!("bodies[{row}].bending"), bending)?,
            spacing,
            mass,
            stiffness,
            damping,
            substance: substance(source, row, (body, !mesh::is_solid(mesh, default.filling)))?,
        })
    }

    fn explicit(&mut self, row: usize, body: &BodyRow) -> Result<Built, FileError> {
        if body.particles.is_empty() {
            let reason = "is empty; an explicit body needs at least one particle";
            return Err(self.source.refuse(format_args!("bodies[{row}].particles"), reason));
        }
        let material = self.material(row, body, Material::default())?;
        let counts = [body.particles.len() as u128, body.springs.len() as u128];
        self.budget.take(self.source, format_args!("bodies[{row}].particles"), counts)?;
        let particles = self.particles(row, body, material.mass)?;
        let springs = self.springs(row, body, (&particles, material))?;
        let part = Part { particles, springs, ..Part::default() };
        Ok(Built { part, own_sets: OwnSets::Groups(Groups::new()), made: None })
    }

    fn particles(&self, row: usize, body: &BodyRow, mass: f64) -> Result<Vec<Particle>, FileError> {
        let source = self.source;
        let masses = domain_of("bodies.particles.mass");
        let particle = |(n, particle): (usize, &crate::file::schema::ParticleRow)| {
            let key = format_args!("bodies[{row}].particles[{n}]");
            let (position, velocity) = (particle.position, particle.velocity.unwrap_or_default());
            let mass = particle.mass.unwrap_or(mass);
            Ok(Particle {
                position: source.position(format_args!("{key}.position"), position, self.extent)?,
                velocity: source.vector(format_args!("{key}.velocity"), velocity)?,
                mass: source.number_in(masses, format_args!("{key}.mass"), mass)?,
            })
        };
        body.particles.iter().enumerate().map(particle).collect()
    }

    fn springs(
        &self,
        row: usize,
        body: &BodyRow,
        (particles, material): (&[Particle], Material),
    ) -> Result<Vec<Spring>, FileError> {
        let source = self.source;
        let [lengths, stiffnesses, dampings] = ["rest_length", "stiffness", "damping"]
            .map(|key| domain_of(&format!("bodies.springs.{key}")));
        let spring = |(n, spring): (usize, &crate::file::schema::SpringRow)| {
            let key = format_args!("bodies[{row}].springs[{n}]");
            let mut ends = [0; 2];
            for (side, &end) in spring.ends.iter().enumerate() {
                let key = format_args!("{key}.ends[{side}]");
                ends[side] = source.index(key, end, ("particle", particles.len()))?;
            }
            if ends[0] == ends[1] {
                let reason = format!("joins particle {} to itself; its ends must differ", ends[0]);
                return Err(source.refuse(format_args!("{key}.ends"), reason));
            }
            let across = particles[ends[1]].position - particles[ends[0]].position;
            let rest_length = spring.rest_length.unwrap_or(across.dot(across).sqrt());
            let stiffness = spring.stiffness.unwrap_or(material.stiffness);
            let damping = spring.damping.unwrap_or(material.damping);
            Ok(Spring {
                ends,
                rest_length: source.number_in(
                    lengths,
                    format_args!("{key}.rest_length"),
                    rest_length,
                )?,
                stiffness: source.number_in(
                    stiffnesses,
                    format_args!("{key}.stiffness"),
                    stiffness,
                )?,
                damping: source.number_in(dampings, format_args!("{key}.damping"), damping)?,
            })
        };
        body.springs.iter().enumerate().map(spring).collect()
    }

    /// Turns and moves a part, and sets it in motion.
    fn place(&self, row: usize, body: &BodyRow, part: &mut Part) -> Result<(), FileError> {
        let source = self.source;
        let turn = self::turn(source, &format!("bodies[{row}]"), body.rotation)?;
        let key = format_args!("bodies[{row}].position");
        let offset = source.position(key, body.position.unwrap_or_default(), self.extent)?;
        let key = format_args!("bodies[{row}].velocity");
        let velocity = source.vector(key, body.velocity.unwrap_or_default())?;
        let spin = spin(source, &format!("bodies[{row}]"), body.spin)?;
        let own: Vec<DVec3> = part.particles.iter().map(|p| turn * p.velocity).collect();
        part.place(turn, offset);
        part.set_motion(velocity, spin);
        for (particle, own) in part.particles.iter_mut().zip(own) {
            particle.velocity += own;
        }
        Ok(())
    }

    /// Refuses a mesh so light that a particle, which has a part of its mass, has none.
    fn check_masses(&self, row: usize, body: &BodyRow, part: &Part) -> Result<(), FileError> {
        let (Kind::Mesh, Some(mass)) = (body.kind, body.mass) else { return Ok(()) };
        let key = format_args!("bodies[{row}].mass");
        let lightest = part.particles.iter().map(|particle| particle.mass).fold(mass, f64::min);
        self.source.number(key, lightest).map(drop).map_err(|_| {
            let words = domain_of("bodies.mass").words();
            let count = part.particles.len();
            let expected = format!("so large that each of {count} particles has one {words}");
            self.source.out_of_domain(key, plain(mass), expected)
        })
    }

    /// Refuses a body so small, or so far out, that rounding puts neighbours on one place: the
    /// spring between them would have no direction.
    fn check_apart(&self, row: usize, body: &BodyRow, part: &Part) -> Result<(), FileError> {
        let apart = |spring: &Spring| {
            let [a, b] = spring.ends.map(|end| part.particles[end].position);
            match self.precision {
                Precision::F32 => (b.as_vec3() - a.as_vec3()).length_squared() != 0.0,
                Precision::F64 => (b - a).length_squared() != 0.0,
            }
        };
        // Two particles that a file puts on one place are meant to be there.
        let meant = |spring: &Spring| {
            let at = |end: usize| body.particles.get(spring.ends[end]).map(|row| row.position);
            body.kind == Kind::Explicit && at(0) == at(1)
        };
        let close = |spring: &Spring| !apart(spring) && !meant(spring);
        let Some(spring) = part.springs.iter().position(close) else { return Ok(()) };
        let precision = self.precision;
        let finer = match precision {
            Precision::F32 => "; precision = \"f64\" tells finer",
            Precision::F64 => "",
        };
        let (key, size) = match body.kind {
            Kind::Explicit => {
                let [a, b] = part.springs[spring].ends;
                let reason = format!(
                    "joins particles {a} and {b}, which {precision} cannot tell apart where the \
                     body stands{finer}"
                );
                let key = format_args!("bodies[{row}].springs[{spring}]");
                return Err(self.source.refuse(key, reason));
            }
            Kind::Mesh => ("length", body.length),
            _ => ("spacing", body.spacing),
        };
        let value = plain(size.unwrap_or(1.0));
        let expected = format!(
            "so large that {precision} tells neighbours apart where the body stands{finer}"
        );
        Err(self.source.out_of_domain(format_args!("bodies[{row}].{key}"), value, expected))
    }
}

/// The mesh of a name that stands at a key.
///
/// # Errors
/// A name that no line can quote; a mesh that cannot be read.
pub(crate) fn named_mesh(
    source: &Source<'_>,
    read_mesh: &MeshReader<'_>,
    (key, file): (&str, &str),
) -> Result<Mesh, FileError> {
    if file.contains(char::is_control) {
        let (key, value) = (format_args!("{key}"), tame(file));
        return Err(source.out_of_domain(key, value, "a name without control characters"));
    }
    read_mesh(file).map_err(|error| mesh_error(source, key.into(), error))
}

/// The error of a mesh, and the key that led to it.
pub(crate) fn mesh_error(source: &Source<'_>, key: String, error: MeshError) -> FileError {
    FileError::SceneMesh { place: source.place_of(&key), key, source: Box::new(error) }
}
