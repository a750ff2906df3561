//! How does the row of a body become particles and springs?

use crate::error::LabError;
use crate::mesh::{self, Filling, Mesh, MeshError, MeshOptions};
use crate::node::Source;
use crate::schema::{BodyRow, Kind, Spin};
use crate::turn::{random_axis, rotation};
use glam::{DMat3, DVec3};
use msd_core::lattice::FAMILIES;
use msd_core::{Lattice, Material, Neighbours, Part, Particle, Spring, shape};

/// Reads the mesh that a scene names.
pub(crate) type MeshReader<'r> = dyn Fn(&str) -> Result<Mesh, MeshError> + 'r;

/// What bodies are built from.
pub(crate) struct Builder<'b> {
    pub(crate) source: &'b Source<'b>,
    pub(crate) read_mesh: &'b MeshReader<'b>,
    /// Bound of every coordinate, metres.
    pub(crate) extent: f64,
    pub(crate) budget: Budget,
    /// What was done to meshes, one line each.
    pub(crate) notes: Vec<String>,
}

/// A body that has been built.
pub(crate) struct Built {
    pub(crate) part: Part,
    pub(crate) lattice: Option<Lattice>,
}

/// What the bodies so far ask for.
#[derive(Default)]
pub(crate) struct Budget {
    particles: u128,
    springs: u128,
}

/// The most memory a scene may take, bytes: beyond it a small machine starts to swap.
const MEMORY: u128 = 4_000_000_000;
/// Rows, columns in double precision and work space of a particle and of a spring, bytes.
const PARTICLE_BYTES: u128 = 400;
const SPRING_BYTES: u128 = 100;

impl Builder<'_> {
    /// Builds body number `row`, placed and moving.
    ///
    /// # Errors
    /// A key that its kind does not use, a value outside its domain, more than fits.
    pub(crate) fn build(&mut self, row: usize, body: &BodyRow) -> Result<Built, LabError> {
        check_keys(self.source, row, body)?;
        let mut built = match body.kind {
            Kind::Rope | Kind::Cloth | Kind::Block => self.lattice(row, body)?,
            Kind::Mesh => self.mesh(row, body)?,
            Kind::Explicit => self.explicit(row, body)?,
        };
        self.place(row, body, &mut built.part)?;
        Ok(built)
    }

    fn lattice(&mut self, row: usize, body: &BodyRow) -> Result<Built, LabError> {
        let neighbours = self.neighbours(row, body)?;
        let size = self.lattice_size(row, body)?;
        let spacing = self
            .source
            .positive(format_args!("bodies[{row}].spacing"), body.spacing.unwrap_or(1.0))?;
        let material = self.material(row, body, Material::default())?;
        let counts = count_lattice(size, neighbours);
        self.budget.take(self.source, format_args!("bodies[{row}].size"), counts)?;
        let core = |source| LabError::Core { file: self.source.name.into(), source };
        let lattice = Lattice::new(size, neighbours).map_err(core)?;
        let part = shape::lattice(size, neighbours, spacing, material).map_err(core)?;
        Ok(Built { part, lattice: Some(lattice) })
    }

    fn lattice_size(&self, row: usize, body: &BodyRow) -> Result<[usize; 3], LabError> {
        let source = self.source;
        let Some(size) = &body.size else {
            return Err(source.missing(format_args!("bodies[{row}]"), "size"));
        };
        for (axis, &length) in size.iter().enumerate() {
            if length == 0 {
                let key = format_args!("bodies[{row}].size[{axis}]");
                return Err(source.out_of_domain(key, length, "at least 1"));
            }
        }
        let whole = |length: u64| usize::try_from(length).unwrap_or(usize::MAX);
        match (body.kind, size.as_slice()) {
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

    fn neighbours(&self, row: usize, body: &BodyRow) -> Result<Neighbours, LabError> {
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
    ) -> Result<Material, LabError> {
        let source = self.source;
        let (mass, stiffness) = (body.mass.unwrap_or(default.mass), body.stiffness);
        let stiffness = stiffness.unwrap_or(default.stiffness);
        let damping = body.damping.unwrap_or(default.damping);
        Ok(Material {
            mass: source.positive(format_args!("bodies[{row}].mass"), mass)?,
            stiffness: source.not_negative(format_args!("bodies[{row}].stiffness"), stiffness)?,
            damping: source.not_negative(format_args!("bodies[{row}].damping"), damping)?,
        })
    }

    fn mesh(&mut self, row: usize, body: &BodyRow) -> Result<Built, LabError> {
        let source = self.source;
        let Some(file) = &body.file else {
            return Err(source.missing(format_args!("bodies[{row}]"), "file"));
        };
        let default = MeshOptions::default();
        let Material { mass, stiffness, damping } = self.material(
            row,
            body,
            Material { mass: default.mass, stiffness: default.stiffness, damping: default.damping },
        )?;
        let length = body.length.unwrap_or(1.0);
        let bending = body.bending.unwrap_or(default.bending);
        let spacing = match body.spacing {
            Some(spacing) => Some(source.positive(format_args!("bodies[{row}].spacing"), spacing)?),
            None => None,
        };
        let options = MeshOptions {
            filling: body.filling.unwrap_or(Filling::Auto),
            size: Some(source.positive(format_args!("bodies[{row}].length"), length)?),
            bending: source.not_negative(format_args!("bodies[{row}].bending"), bending)?,
            spacing,
            mass,
            stiffness,
            damping,
        };
        let mesh = (self.read_mesh)(file)?;
        let (part, report) = mesh::body(&mesh, &options)?;
        let counts = [part.particles.len() as u128, part.springs.len() as u128];
        self.budget.take(source, format_args!("bodies[{row}].file"), counts)?;
        self.notes
            .extend(mesh.report.to_string().lines().map(|line| format!("{}: {line}", mesh.name)));
        self.notes.extend(report.to_string().lines().map(|line| format!("{}: {line}", mesh.name)));
        Ok(Built { part, lattice: None })
    }

    fn explicit(&mut self, row: usize, body: &BodyRow) -> Result<Built, LabError> {
        if body.particles.is_empty() {
            return Err(self.source.missing(format_args!("bodies[{row}]"), "particles"));
        }
        let material = self.material(row, body, Material::default())?;
        let counts = [body.particles.len() as u128, body.springs.len() as u128];
        self.budget.take(self.source, format_args!("bodies[{row}].particles"), counts)?;
        let particles = self.particles(row, body, material.mass)?;
        let springs = self.springs(row, body, (&particles, material))?;
        Ok(Built { part: Part { particles, springs, ..Part::default() }, lattice: None })
    }

    fn particles(&self, row: usize, body: &BodyRow, mass: f64) -> Result<Vec<Particle>, LabError> {
        let source = self.source;
        let particle = |(n, particle): (usize, &crate::schema::ParticleRow)| {
            let key = format_args!("bodies[{row}].particles[{n}]");
            let (position, velocity) = (particle.position, particle.velocity.unwrap_or_default());
            let mass = particle.mass.unwrap_or(mass);
            Ok(Particle {
                position: source.position(format_args!("{key}.position"), position, self.extent)?,
                velocity: source.vector(format_args!("{key}.velocity"), velocity)?,
                mass: source.positive(format_args!("{key}.mass"), mass)?,
            })
        };
        body.particles.iter().enumerate().map(particle).collect()
    }

    fn springs(
        &self,
        row: usize,
        body: &BodyRow,
        (particles, material): (&[Particle], Material),
    ) -> Result<Vec<Spring>, LabError> {
        let source = self.source;
        let spring = |(n, spring): (usize, &crate::schema::SpringRow)| {
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
                rest_length: source.not_negative(format_args!("{key}.rest_length"), rest_length)?,
                stiffness: source.not_negative(format_args!("{key}.stiffness"), stiffness)?,
                damping: source.not_negative(format_args!("{key}.damping"), damping)?,
            })
        };
        body.springs.iter().enumerate().map(spring).collect()
    }

    /// Turns and moves a part, and sets it in motion.
    fn place(&self, row: usize, body: &BodyRow, part: &mut Part) -> Result<(), LabError> {
        let source = self.source;
        let turn = match body.rotation {
            Some(turn) => {
                let key = format_args!("bodies[{row}].rotation.axis");
                let axis = source.direction(key, turn.axis)?;
                let key = format_args!("bodies[{row}].rotation.angle_deg");
                rotation(axis, source.finite(key, turn.angle_deg)?.to_radians())
            }
            None => DMat3::IDENTITY,
        };
        let key = format_args!("bodies[{row}].position");
        let offset = source.position(key, body.position.unwrap_or_default(), self.extent)?;
        let key = format_args!("bodies[{row}].velocity");
        let velocity = source.vector(key, body.velocity.unwrap_or_default())?;
        let spin = self.spin(row, body)?;
        let own: Vec<DVec3> = part.particles.iter().map(|p| turn * p.velocity).collect();
        part.place(turn, offset);
        part.set_motion(velocity, spin);
        for (particle, own) in part.particles.iter_mut().zip(own) {
            particle.velocity += own;
        }
        Ok(())
    }

    fn spin(&self, row: usize, body: &BodyRow) -> Result<DVec3, LabError> {
        let source = self.source;
        let about = match body.spin {
            None => return Ok(DVec3::ZERO),
            Some(Spin::Vector(spin)) => {
                return source.vector(format_args!("bodies[{row}].spin"), spin);
            }
            Some(Spin::About(about)) => about,
        };
        let speed = source.finite(format_args!("bodies[{row}].spin.speed"), about.speed)?;
        let axis = match (about.axis, about.random_axis_seed) {
            (Some(axis), None) => {
                source.direction(format_args!("bodies[{row}].spin.axis"), axis)?
            }
            (None, Some(seed)) => random_axis(seed),
            _ => {
                let reason = "needs one of the keys `axis` and `random_axis_seed`";
                return Err(source.refuse(format_args!("bodies[{row}].spin"), reason));
            }
        };
        Ok(axis * speed)
    }
}

impl Budget {
    /// Counts what a body asks for, before anything is allocated.
    fn take(
        &mut self,
        source: &Source<'_>,
        key: std::fmt::Arguments<'_>,
        [particles, springs]: [u128; 2],
    ) -> Result<(), LabError> {
        self.particles = self.particles.saturating_add(particles);
        self.springs = self.springs.saturating_add(springs);
        let bytes = self.particles.saturating_mul(PARTICLE_BYTES);
        let bytes = bytes.saturating_add(self.springs.saturating_mul(SPRING_BYTES));
        if bytes <= MEMORY {
            return Ok(());
        }
        let (particles, springs) = (self.particles, self.springs);
        Err(LabError::TooLarge {
            place: source.place_of(&key.to_string()),
            key: key.to_string(),
            counts: format!("{particles} particles and {springs} springs"),
            gigabytes: bytes as f64 * 1e-9,
            limit: MEMORY as f64 * 1e-9,
        })
    }
}

/// Particles and springs of a lattice that need not fit.
fn count_lattice(size: [usize; 3], neighbours: Neighbours) -> [u128; 2] {
    let families = if neighbours == Neighbours::All { FAMILIES.len() } else { 3 };
    let product = |lengths: [u128; 3]| lengths.into_iter().fold(1, u128::saturating_mul);
    let springs = FAMILIES[..families].iter().map(|step| {
        product(
            [0, 1, 2].map(|axis| (size[axis] - step[axis].unsigned_abs().min(size[axis])) as u128),
        )
    });
    [product(size.map(|length| length as u128)), springs.fold(0, u128::saturating_add)]
}

/// Refuses keys that the kind of a body does not use: they would have no effect silently.
fn check_keys(source: &Source<'_>, row: usize, body: &BodyRow) -> Result<(), LabError> {
    const LATTICES: &[Kind] = &[Kind::Rope, Kind::Cloth, Kind::Block];
    const SPACED: &[Kind] = &[Kind::Rope, Kind::Cloth, Kind::Block, Kind::Mesh];
    let keys = [
        ("size", body.size.is_some(), LATTICES),
        ("neighbours", body.neighbours.is_some(), LATTICES),
        ("spacing", body.spacing.is_some(), SPACED),
        ("file", body.file.is_some(), &[Kind::Mesh]),
        ("filling", body.filling.is_some(), &[Kind::Mesh]),
        ("length", body.length.is_some(), &[Kind::Mesh]),
        ("bending", body.bending.is_some(), &[Kind::Mesh]),
        ("particles", !body.particles.is_empty(), &[Kind::Explicit]),
        ("springs", !body.springs.is_empty(), &[Kind::Explicit]),
    ];
    for (key, given, kinds) in keys {
        if given && !kinds.contains(&body.kind) {
            let kinds: Vec<&str> = kinds.iter().map(|kind| kind.name()).collect();
            let (kind, kinds) = (body.kind.name(), kinds.join(", "));
            let reason = format!("means nothing to a {kind}; it belongs to kind {kinds}");
            return Err(source.refuse(format_args!("bodies[{row}].{key}"), reason));
        }
    }
    Ok(())
}
