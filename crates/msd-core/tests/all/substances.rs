//! Lattices of a substance, against the elasticity of continua.

use msd_core::glam::{DMat3, DVec3};
use msd_core::substance::{SHEET_POISSON, SOLID_POISSON};
use msd_core::{
    Bending, Elasticity, Error, Integrator, Interaction, MaterialNumber, Moduli, Part, Scene,
    Select, Settings, Simulation, Substance, World, shape,
};

const SPACING: f64 = 0.01;
const YOUNG: f64 = 12_500.0;
const SOLID: Substance = Substance {
    elasticity: Elasticity::Solid { young: YOUNG, poisson: SOLID_POISSON },
    density: 1050.0,
    relaxation_time: 0.0,
};
const WARP: f64 = 900.0;
const WEFT: f64 = 400.0;
const SHEAR: f64 = 60.0;
const LIMP: Bending = Bending { warp: 0.0, weft: 0.0, bias: 0.0 };
const WOVEN: Substance = Substance {
    elasticity: Elasticity::Sheet { warp: WARP, weft: WEFT, shear: SHEAR, bending: LIMP },
    density: 0.12,
    relaxation_time: 0.0,
};

/// The forces of the springs and volumes of a part for a small displacement, linearised.
fn linear_forces(part: &Part, displacement: impl Fn(DVec3) -> DVec3) -> Vec<DVec3> {
    let mut forces = vec![DVec3::ZERO; part.particles.len()];
    for spring in &part.springs {
        let [a, b] = spring.ends.map(|end| part.particles[end].position);
        let way = (b - a).normalize();
        let pull = way * (spring.stiffness * way.dot(displacement(b) - displacement(a)));
        forces[spring.ends[0]] += pull;
        forces[spring.ends[1]] -= pull;
    }
    // A cube at rest: the gradient of its volume is a quarter of three faces at each corner.
    for volume in &part.volumes {
        let at = volume.particles.map(|particle| part.particles[particle].position);
        let middle = (at[0] + at[7]) * 0.5;
        let side = at[1].x - at[0].x;
        let gradient = at.map(|x| (x - middle).signum() * (0.25 * side * side));
        let swells: f64 = gradient.iter().zip(at).map(|(g, x)| g.dot(displacement(x))).sum();
        let tension = volume.modulus * swells / volume.rest_volume;
        for (particle, gradient) in volume.particles.into_iter().zip(gradient) {
            forces[particle] -= gradient * tension;
        }
    }
    forces
}

/// Asserts that a uniform strain of a lattice meets, at every particle, the force of a uniform
/// stress on the share of the particle in the surface of the body: none inside.
///
/// Under shear a corner of a block has a force along the third axis too, as one space diagonal ends
/// there and no other balances it. Those of the eight corners balance one another.
fn passes_the_patch_test(part: &Part, size: [usize; 3], strain: DMat3, stress: DMat3) {
    let [rows, columns, stacks] = size;
    let half = DVec3::new(columns as f64 - 1.0, rows as f64 - 1.0, stacks as f64 - 1.0) * 0.5;
    let forces = linear_forces(part, |x| strain * x);
    let largest = forces.iter().map(|force| force.length()).fold(0.0, f64::max);
    let (mut corners, mut virial) = (DVec3::ZERO, DMat3::ZERO);
    for (particle, force) in part.particles.iter().zip(forces) {
        virial -= outer(force, particle.position);
        let place = particle.position / SPACING;
        let at_end = |axis: usize| 1e-6 > half[axis] - place[axis].abs();
        let mut expected = DVec3::ZERO;
        for axis in (0..3).filter(|&axis| 0.0 < half[axis] && at_end(axis)) {
            // Half of each of the squares, or lengths, that the particle does not own whole.
            let others = (0..3).filter(|&other| other != axis && 0.0 < half[other]);
            let area: f64 = others.map(|o| SPACING * if at_end(o) { 0.5 } else { 1.0 }).product();
            let normal = DVec3::AXES[axis] * place[axis].signum();
            expected -= stress * normal * area;
        }
        let is_corner = (0..3).all(|axis| 0.0 < half[axis] && at_end(axis));
        let along_third = if is_corner && strain.x_axis.x + strain.y_axis.y + strain.z_axis.z == 0.0
        {
            let third = DVec3::AXES[(0..3).find(|&axis| strain.col(axis) == DVec3::ZERO).unwrap()];
            corners += third * third.dot(force);
            third
        } else {
            DVec3::ZERO
        };
        let error = force - expected;
        let error = (error - along_third * along_third.dot(error)).length();
        assert!(error <= 1e-12 * largest, "at {place}: {force} is not {expected}");
    }
    assert!(corners.length() <= 1e-12 * largest, "{corners}");
    // The mean stress of the body: the work of the forces on its surface.
    let volume: f64 = (0..3)
        .map(|axis| half[axis])
        .filter(|&half| 0.0 < half)
        .map(|half| 2.0 * half * SPACING)
        .product();
    let scale = stress.to_cols_array().into_iter().map(f64::abs).fold(0.0, f64::max);
    let error = (virial * (1.0 / volume) - stress).to_cols_array();
    assert!(error.into_iter().all(|error| error.abs() <= 1e-12 * scale), "{virial}");
}

/// a bᵀ.
fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// Strains of every kind, one by one.
fn strains(axes: &[[usize; 2]]) -> Vec<DMat3> {
    let strain = |&[a, b]: &[usize; 2]| {
        let mut strain = DMat3::ZERO;
        strain.col_mut(a)[b] = 0.5;
        strain.col_mut(b)[a] += 0.5;
        strain
    };
    axes.iter().map(strain).collect()
}

#[test]
fn a_uniform_strain_of_a_solid_has_the_stress_of_hooke_at_faces_edges_and_corners() {
    for poisson in [0.0, 0.1, SOLID_POISSON, 0.3, 0.4, 0.45] {
        // Lamé's constants.
        let mu = YOUNG / (2.0 * (1.0 + poisson));
        let lambda = 2.0 * mu * poisson / (1.0 - 2.0 * poisson);
        let elasticity = Elasticity::Solid { young: YOUNG, poisson };
        for size in [[4, 3, 5], [2, 2, 2], [2, 12, 2]] {
            let part = shape::body(size, SPACING, &Substance { elasticity, ..SOLID }).unwrap();
            for strain in strains(&[[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [2, 0]]) {
                let trace = strain.x_axis.x + strain.y_axis.y + strain.z_axis.z;
                let stress = strain * (2.0 * mu) + DMat3::IDENTITY * (lambda * trace);
                passes_the_patch_test(&part, size, strain, stress);
            }
        }
    }
}

#[test]
fn a_uniform_strain_of_an_isotropic_sheet_has_its_stress_at_edges_and_corners() {
    let (thickness, nu) = (0.002, SHEET_POISSON);
    let elasticity = Elasticity::sheet(YOUNG, thickness);
    let size = [4, 6, 1];
    let part = shape::body(size, SPACING, &Substance { elasticity, ..WOVEN }).unwrap();
    for strain in strains(&[[0, 0], [1, 1], [0, 1]]) {
        let plane = YOUNG * thickness / (1.0 - nu * nu);
        let trace = strain.x_axis.x + strain.y_axis.y;
        let in_plane = DMat3::from_diagonal(DVec3::new(1.0, 1.0, 0.0));
        let stress = (strain * (1.0 - nu) + in_plane * (nu * trace)) * plane;
        passes_the_patch_test(&part, size, strain, stress);
    }
}

#[test]
fn a_rope_pulls_by_its_stretch_times_its_strain() {
    let (elasticity, size) = (Elasticity::Rope { stretch: 70.0, bending: 0.0 }, [1, 9, 1]);
    let rope = Substance { elasticity, density: 0.02, relaxation_time: 0.0 };
    let part = shape::body(size, SPACING, &rope).unwrap();
    let strain = strains(&[[0, 0]])[0];
    passes_the_patch_test(&part, size, strain, strain * 70.0);
}

#[test]
fn the_masses_of_a_body_are_those_of_its_cells() {
    let mass = |part: &Part| part.particles.iter().map(|row| row.mass).sum::<f64>();
    let solid = shape::body([4, 3, 5], SPACING, &SOLID).unwrap();
    let volume = f64::from(3 * 2 * 4) * SPACING.powi(3);
    assert!((mass(&solid) / (1050.0 * volume) - 1.0).abs() < 1e-14);
    let cell = 1050.0 * SPACING.powi(3);
    let of = |share: f64| {
        solid.particles.iter().filter(|row| (row.mass / cell - share).abs() < 1e-14).count()
    };
    // Corners, edges, faces and the inside of 4 x 3 x 5 particles.
    assert_eq!([0.125, 0.25, 0.5, 1.0].map(of), [8, 4 * (2 + 1 + 3), 2 * (2 + 3 + 6), 6]);
    let sheet = shape::body([4, 6, 1], SPACING, &WOVEN).unwrap();
    assert!((mass(&sheet) / (0.12 * 15.0 * SPACING * SPACING) - 1.0).abs() < 1e-14);
}

/// The 26 directions to the neighbours of a particle of a lattice.
fn directions() -> impl Iterator<Item = DVec3> {
    let steps = [-1.0, 0.0, 1.0];
    let all = steps
        .into_iter()
        .flat_map(move |x| steps.into_iter().flat_map(move |y| steps.map(|z| DVec3::new(x, y, z))));
    all.filter(|way| *way != DVec3::ZERO).map(DVec3::normalize)
}

fn moduli(part: &Part, volume: f64) -> Moduli {
    let spring = |spring: &msd_core::Spring| {
        let [a, b] = spring.ends.map(|end| part.particles[end].position);
        (spring.stiffness, b - a)
    };
    Moduli::of(part.springs.iter().map(spring), &part.volumes, volume)
}

#[test]
fn a_solid_is_as_stiff_in_all_26_directions_and_alike_springs_are_not() {
    let size = [4, 3, 5];
    let volume = f64::from(3 * 2 * 4) * SPACING.powi(3);
    assert_eq!(directions().count(), 26);
    for poisson in [0.0, SOLID_POISSON, 0.45] {
        let elasticity = Elasticity::Solid { young: YOUNG, poisson };
        let part = shape::body(size, SPACING, &Substance { elasticity, ..SOLID }).unwrap();
        let solid = moduli(&part, volume);
        for way in directions() {
            assert!((solid.young(way) / YOUNG - 1.0).abs() < 1e-12, "{way}: {}", solid.young(way));
            let transverse = way.any_orthonormal_vector();
            assert!((solid.poisson(way, transverse) - poisson).abs() < 1e-12);
        }
    }
    // Alike springs inside a body, where each counts in full: C11 = 3 + 4/3 and C12 = C44 = 1 +
    // 4/3, so that E along an axis is C11 − 2 C12²/(C11 + C12), and along a space diagonal
    // 1/E = (1/(C11 + 2 C12) + 1/C44)/3.
    let cell = msd_core::lattice::FAMILIES.map(|step| {
        let [y, x, z] = step.map(|length| length as f64 * SPACING);
        (1000.0, DVec3::new(x, y, z))
    });
    let alike = Moduli::of(cell.into_iter(), &[], SPACING.powi(3));
    let (c11, c12) = (13.0 / 3.0, 7.0 / 3.0);
    let axis = c11 - 2.0 * c12 * c12 / (c11 + c12);
    let diagonal = 3.0 / (1.0 / (c11 + 2.0 * c12) + 1.0 / c12);
    for (way, expected) in [(DVec3::X, axis), (DVec3::ONE.normalize(), diagonal)] {
        let expected = expected * 1000.0 / SPACING;
        assert!((alike.young(way) / expected - 1.0).abs() < 1e-12);
    }
    assert!((diagonal / axis - 2.06).abs() < 0.005, "{}", diagonal / axis);
}

#[test]
fn a_woven_sheet_has_the_moduli_that_were_measured() {
    let sheet = moduli(&shape::body([4, 6, 1], SPACING, &WOVEN).unwrap(), 15.0 * SPACING * SPACING);
    assert!((sheet.young(DVec3::Y) / WARP - 1.0).abs() < 1e-12);
    assert!((sheet.young(DVec3::X) / WEFT - 1.0).abs() < 1e-12);
    assert_eq!(sheet.young(DVec3::Z), 0.0);
    // On the bias: 4/E = 1/E1 + 1/E2 + 1/G − 2 ν1/E1, where ν1/E1 = C12/(C11 C22 − C12²).
    let c11 = 0.5 * (WARP + (WARP * WARP + 4.0 * SHEAR * SHEAR * WARP / WEFT).sqrt());
    let coupling = SHEAR / (c11 * c11 * WEFT / WARP - SHEAR * SHEAR);
    let bias = 4.0 / (1.0 / WARP + 1.0 / WEFT + 1.0 / SHEAR - 2.0 * coupling);
    let way = DVec3::new(1.0, 1.0, 0.0).normalize();
    assert!((sheet.young(way) / bias - 1.0).abs() < 1e-12);
    let isotropic = Substance { elasticity: Elasticity::sheet(YOUNG, 0.002), ..WOVEN };
    let isotropic = shape::body([4, 6, 1], SPACING, &isotropic).unwrap();
    let sheet = moduli(&isotropic, 15.0 * SPACING * SPACING);
    for way in directions().filter(|way| way.z == 0.0) {
        assert!((sheet.young(way) / (YOUNG * 0.002) - 1.0).abs() < 1e-12);
        let transverse = DVec3::Z.cross(way);
        assert!((sheet.poisson(way, transverse) - SHEET_POISSON).abs() < 1e-12);
    }
}

fn scene(part: Part) -> Scene {
    let world = World { gravity: DVec3::ZERO, ..World::default() };
    Scene { world, ..Scene::of("body", part) }
}

#[test]
fn the_stable_substep_of_a_block_follows_from_the_speed_of_sound() {
    let part = shape::body([10, 10, 10], SPACING, &SOLID).unwrap();
    let simulation = Simulation::<f64>::new(&scene(part), Settings::default()).unwrap();
    let limit = simulation.stable_substep_of(Integrator::SymplecticEuler, 1);
    let per_cell = limit / (SPACING * (1050.0f64 / YOUNG).sqrt());
    // Inside, w² is largest where neighbours along one axis move against each other: springs along
    // it count 4 k1, the four face diagonals and four space diagonals that cross it 4 k (n·x)², so
    // w² = 4 (8/15 + 4·4/15·1/2 + 4·1/10·1/3) E/(ρ a²) = 4.8 E/(ρ a²) and 2/w = 0.913. At a corner
    // particles lose more mass than springs, which leaves 0.88.
    assert!((per_cell - 0.88).abs() < 0.01, "{per_cell}");
}

#[test]
fn a_pulled_bar_relaxes_with_the_time_constant_of_its_substance() {
    // Kelvin and Voigt: σ = E (ε + τ ε'), so that a bar which is let go slowly, all masses being
    // small, shrinks as exp(−t/τ). The inertia of a bar whose lowest period is 2π/w adds about
    // 1/(w τ)², here 1e-4.
    for poisson in [0.0, SOLID_POISSON, 0.45] {
        let left = left_of_a_pull(poisson);
        assert!((left / (-1.0f64).exp() - 1.0).abs() < 0.01, "{poisson}: {left}");
    }
}

/// The part of the strain of a bar that is left after its relaxation time.
fn left_of_a_pull(poisson: f64) -> f64 {
    let tau = 0.5;
    let elasticity = Elasticity::Solid { young: YOUNG, poisson };
    let light = Substance { elasticity, density: 1e-3, relaxation_time: tau };
    let (size, strain) = ([3, 9, 3], 1e-4);
    let mut part = shape::body(size, SPACING, &light).unwrap();
    let stretched = DVec3::new(strain, -poisson * strain, -poisson * strain);
    let rest: Vec<DVec3> = part.particles.iter().map(|row| row.position).collect();
    part.particles.iter_mut().for_each(|row| row.position += row.position * stretched);
    let integrator = Integrator::ImplicitMidpoint;
    let settings = Settings { integrator, step: 1e-3 * tau, substeps: 1, ..Settings::default() };
    let mut simulation = Simulation::<f64>::new(&scene(part), settings).unwrap();
    (0..1000).for_each(|_| simulation.step().unwrap());
    let last = rest.len() - 1;
    let now = simulation.position(last).x - simulation.position(0).x;
    (now / (rest[last].x - rest[0].x) - 1.0) / strain
}

#[test]
fn a_number_of_a_material_that_is_multiplied_makes_the_body_of_that_material() {
    let solid = |young, density, time| Substance {
        elasticity: Elasticity::Solid { young, poisson: 0.4 },
        density,
        relaxation_time: time,
    };
    let sheet = |thickness, density| Substance {
        elasticity: Elasticity::sheet(YOUNG, thickness),
        density,
        relaxation_time: 0.25,
    };
    let bodies = Select::Body(1);
    let scale = |number, factor| Interaction::ScaleMaterial { bodies, number, factor };
    for (size, from, to, acts) in [
        (
            [3, 4, 5],
            solid(1e4, 900.0, 0.0),
            solid(3e4, 1800.0, 0.5),
            vec![
                scale(MaterialNumber::Young, 3.0),
                scale(MaterialNumber::Density, 2.0),
                Interaction::SetRelaxationTime { bodies, value: 0.5 },
            ],
        ),
        (
            [4, 4, 1],
            sheet(1e-3, 1.0),
            sheet(2e-3, 2.0),
            vec![scale(MaterialNumber::Thickness, 2.0)],
        ),
    ] {
        let of = |substance| {
            let part = shape::body(size, SPACING, substance).expect("a body");
            let mut scene = scene(shape::body(size, SPACING, &from).expect("a body"));
            scene.add("other", part);
            scene
        };
        let settings = Settings::default();
        let mut simulation = Simulation::<f64>::new(&of(&from), settings).expect("a scene");
        acts.into_iter().for_each(|act| simulation.queue(act).expect("a valid act"));
        simulation.apply_queued().expect("a state");
        let wanted = Simulation::<f64>::new(&of(&to), settings).expect("a scene");
        // Products of a few factors: the last digits.
        let near = |a: f64, b: f64| assert!((a - b).abs() <= 1e-14 * b.abs(), "{a} is not {b}");
        let (made, wanted) = (simulation.progress().0, wanted.progress().0);
        for (a, b) in made.springs.iter().zip(&wanted.springs) {
            near(a.stiffness, b.stiffness);
            near(a.damping, b.damping);
        }
        for (a, b) in made.bends.iter().zip(&wanted.bends) {
            assert_eq!(a.particles, b.particles);
            near(a.stiffness, b.stiffness);
            near(a.damping, b.damping);
        }
        for (a, b) in made.volumes.iter().zip(&wanted.volumes) {
            assert_eq!(a.particles, b.particles);
            near(a.modulus, b.modulus);
            near(a.damping, b.damping);
        }
        let masses = made.particles.iter().zip(&wanted.particles);
        masses.for_each(|(a, b)| near(a.mass, b.mass));
    }
}

#[test]
fn a_substance_outside_its_domain_or_of_other_dimensions_is_refused() {
    let refused = |size, substance: Substance| {
        let error = shape::body(size, SPACING, &substance).unwrap_err();
        assert!(matches!(error, Error::OutOfDomain { .. }), "{error:?}");
        error.to_string()
    };
    let with = |elasticity| Substance { elasticity, ..WOVEN };
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(refused([3, 3, 3], Substance { density: bad, ..SOLID }).contains("density"));
        let young = with(Elasticity::Solid { young: bad, poisson: SOLID_POISSON });
        assert!(refused([3, 3, 3], young).contains("Young's modulus"));
        let stretch = with(Elasticity::Rope { stretch: bad, bending: 0.0 });
        assert!(refused([1, 3, 1], stretch).contains("stretch"));
        let sheet = with(Elasticity::Sheet { warp: bad, weft: 1.0, shear: 0.1, bending: LIMP });
        assert!(refused([3, 3, 1], sheet).contains("warp"));
    }
    let slow = Substance { relaxation_time: -1.0, ..SOLID };
    assert!(refused([3, 3, 3], slow).contains("relaxation time"));
    // Three springs cannot be stiffer in shear than this: 2·1/(2 − 1).
    let stiff = |shear| with(Elasticity::Sheet { warp: 2.0, weft: 1.0, shear, bending: LIMP });
    assert!(refused([3, 3, 1], stiff(2.01)).contains("at most warp weft"));
    assert!(shape::body([3, 3, 1], SPACING, &stiff(1.99)).is_ok());
    assert!(refused([3, 3, 1], SOLID).contains("for a solid"));
    assert!(refused([3, 3, 3], WOVEN).contains("for a sheet"));
    let rope = with(Elasticity::Rope { stretch: 1.0, bending: 0.0 });
    assert!(refused([1, 1, 1], rope).contains("for a rope"));
}
