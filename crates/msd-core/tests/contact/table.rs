//! The tables, the measures of a scenario, and the check of a method.

use crate::{
    blocks, corners, cubes, curved, endurance, impacts, moving, rods, slopes, thick, turning,
};
use msd_core::Integrator::{
    BackwardEuler, DormandPrince, ExplicitEuler, ExplicitEuler as Explicit, Rk4, SymplecticEuler,
    VelocityVerlet, Xpbd,
};
use msd_core::{Error, Integrator, Real, Scene, Settings, Simulation};
use std::fmt::Write;

/// Gravity of the default world, metres per second squared.
pub const G: f64 = 9.82;
/// A substep of the default settings, seconds.
pub const H: f64 = 1.0 / 480.0;

/// A scenario: its description, its runs in single and in double precision, and its known errors.
pub struct Scenario {
    name: &'static str,
    runs: [fn(Integrator) -> Measures; 2],
    /// Quantities that a method gets wrong by its nature: they are asserted to exceed their bounds.
    wrong: &'static [(Integrator, &'static str)],
}

macro_rules! scenario {
    ($module:ident::$run:ident, $name:literal $(, wrong: $wrong:expr)?) => {
        Scenario {
            name: $name,
            runs: [$module::$run::<f32>, $module::$run::<f64>],
            wrong: scenario!(@ $($wrong)?),
        }
    };
    (@) => { &[] };
    (@ $wrong:expr) => { $wrong };
}

/// Explicit Euler moves by the velocity before the kick: a resting particle falls by g h² in every
/// other substep, is put back, and pays for it.
const FALLS: &[(Integrator, &str)] = &[(Explicit, "dissipated, J")];
/// The same where it comes to rest.
const NEVER_RESTS: &[(Integrator, &str)] = &[(Explicit, "speed, m/s"), (Explicit, "gain, J")];
/// The same of a body, to whose vibrations explicit Euler adds energy.
const VIBRATES: &[(Integrator, &str)] = &[(Explicit, "height varies, m"), (Explicit, "gain, J")];

/// The surface takes that, too.
const FALLS_ON_A_BELT: &[(Integrator, &str)] = &[(Explicit, "off its loss, J")];
/// It never lies still for the same reason.
const MOVES: &[(Integrator, &str)] = &[(Explicit, "moved, m")];

/// Faults that are known and not mended: scenario, method, precision and quantity. They are
/// asserted to exceed their bounds still, so that one which is mended is taken off.
///
/// A particle dropped into a groove without friction comes to rest in ever shorter slides through
/// its foot. Dormand-Prince neglects hops up to its tolerance there; velocity Verlet and RK4 locate
/// an impact to the first order. Backward Euler holds a rope by friction that does not settle.
///
/// The ledger of contact points counts too much where many of them touch at the end of a substep.
/// That of XPBD misses work of a wall that presses, 0.8 of 2 J where h w is 0.8 for the spring; RK4
/// books the work of the stages of a substep behind the wall, 6 J. Both vanish with shorter
/// substeps.
const KNOWN: &[(&str, Integrator, &str, &str)] = &[
    ("a soft block lands on a rough rod", SymplecticEuler, "f32", "imbalance, J"),
    ("a soft block lands on a rough rod", SymplecticEuler, "f64", "imbalance, J"),
    ("a soft block lands on a rough rod", BackwardEuler, "f32", "imbalance, J"),
    ("a soft block lands on a rough rod", BackwardEuler, "f64", "imbalance, J"),
    ("a soft block lands on a rough rod", Xpbd, "f32", "imbalance, J"),
    ("a soft block lands on a rough rod", Xpbd, "f64", "imbalance, J"),
    ("a wall presses a spring by key frames", Xpbd, "f32", "off its work, J"),
    ("a wall presses a spring by key frames", Xpbd, "f64", "off its work, J"),
    ("a wall presses a spring by key frames", Rk4, "f32", "lost, J"),
    ("a wall presses a spring by key frames", Rk4, "f64", "lost, J"),
    ("a wall presses a spring by key frames", Rk4, "f64", "off its work, J"),
    ("a block carried by a rough solid that turns", ExplicitEuler, "f64", "height varies, m"),
    ("a large soft cube falls into a valley", Rk4, "f32", "imbalance, J"),
    ("a large soft cube falls into a valley", Rk4, "f64", "imbalance, J"),
    ("a particle dropped between round solids", SymplecticEuler, "f64", "from the foot, m"),
    ("a particle dropped between round solids", VelocityVerlet, "f32", "added, J"),
    ("a particle dropped between round solids", VelocityVerlet, "f32", "speed, m/s"),
    ("a particle dropped between round solids", VelocityVerlet, "f64", "added, J"),
    ("a particle dropped between round solids", VelocityVerlet, "f64", "from the foot, m"),
    ("a particle dropped between round solids", VelocityVerlet, "f64", "speed, m/s"),
    ("a particle dropped between round solids", Rk4, "f64", "from the foot, m"),
    ("a particle dropped between round solids", DormandPrince, "f32", "added, J"),
    ("a particle dropped between round solids", DormandPrince, "f32", "from the foot, m"),
    ("a particle dropped between round solids", DormandPrince, "f32", "speed, m/s"),
    ("a particle dropped between round solids", DormandPrince, "f64", "from the foot, m"),
    ("a particle dropped between round solids", DormandPrince, "f64", "speed, m/s"),
    ("a particle dropped between round solids", Xpbd, "f64", "from the foot, m"),
    ("a particle dropped into a corner", VelocityVerlet, "f32", "from the foot, m"),
    ("a particle dropped into a corner", VelocityVerlet, "f32", "speed, m/s"),
    ("a particle dropped into a corner", VelocityVerlet, "f64", "added, J"),
    ("a particle dropped into a corner", VelocityVerlet, "f64", "speed, m/s"),
    ("a particle dropped into a corner", DormandPrince, "f32", "added, J"),
    ("a particle dropped into a corner", DormandPrince, "f32", "from the foot, m"),
    ("a particle dropped into a corner", DormandPrince, "f32", "speed, m/s"),
    ("a particle dropped into a corner", DormandPrince, "f64", "from the foot, m"),
    ("a particle dropped into a corner", DormandPrince, "f64", "speed, m/s"),
    ("a particle dropped into a groove", VelocityVerlet, "f32", "added, J"),
    ("a particle dropped into a groove", VelocityVerlet, "f32", "from the foot, m"),
    ("a particle dropped into a groove", VelocityVerlet, "f32", "speed, m/s"),
    ("a particle dropped into a groove", VelocityVerlet, "f64", "from the foot, m"),
    ("a particle dropped into a groove", VelocityVerlet, "f64", "speed, m/s"),
    ("a particle dropped into a groove", Rk4, "f64", "from the foot, m"),
    ("a particle dropped into a groove", Rk4, "f64", "speed, m/s"),
    ("a particle dropped into a groove", DormandPrince, "f32", "added, J"),
    ("a particle dropped into a groove", DormandPrince, "f32", "from the foot, m"),
    ("a particle dropped into a groove", DormandPrince, "f32", "speed, m/s"),
    ("a particle dropped into a groove", DormandPrince, "f64", "from the foot, m"),
    ("a particle dropped into a groove", DormandPrince, "f64", "speed, m/s"),
    ("a rope slips over a drum", BackwardEuler, "f64", "off its acceleration, m/s²"),
    ("a soft cube comes to rest between surfaces", Rk4, "f32", "imbalance, J"),
    ("a soft cube comes to rest between surfaces", Rk4, "f32", "speed, m/s"),
    ("a soft cube comes to rest between surfaces", Rk4, "f64", "imbalance, J"),
    ("a soft cube comes to rest between surfaces", Rk4, "f64", "speed, m/s"),
    ("a particle dropped into a groove", ExplicitEuler, "f64", "from the foot, m"),
    ("a particle dropped into a corner", ExplicitEuler, "f64", "from the foot, m"),
    ("a particle dropped between round solids", ExplicitEuler, "f64", "from the foot, m"),
];

/// Scenarios that a few seconds show.
pub const TABLE: &[Scenario] = &[
    scenario!(corners::grooves_hold, "a particle at rest in a groove", wrong: FALLS),
    scenario!(corners::grooves_stop, "a particle dropped into a groove", wrong: NEVER_RESTS),
    scenario!(corners::corners_hold, "a particle at rest in a corner", wrong: FALLS),
    scenario!(corners::corners_stop, "a particle dropped into a corner", wrong: NEVER_RESTS),
    scenario!(corners::valleys_hold, "a particle at rest between round solids", wrong: FALLS),
    scenario!(corners::valleys_stop, "a particle dropped between round solids", wrong: NEVER_RESTS),
    scenario!(slopes::slopes_slide, "a particle on a slope below the critical friction"),
    scenario!(slopes::slopes_hold, "a particle on a slope above the critical friction"),
    scenario!(
        slopes::ramps_end,
        "a particle slides down a ramp onto a floor",
        wrong: &[(Explicit, "speed, m/s")]
    ),
    scenario!(
        turning::smooth_turntables,
        "a particle on a smooth solid that turns below it",
        wrong: &[(Explicit, "speed, m/s"), (Explicit, "gain, J")]
    ),
    scenario!(
        turning::rough_turntables,
        "a particle carried by a rough solid that turns",
        wrong: &[(Explicit, "gain, J")]
    ),
    scenario!(
        turning::blocks_on_smooth,
        "a block on a smooth solid that turns below it",
        wrong: VIBRATES
    ),
    scenario!(
        turning::blocks_on_rough,
        "a block carried by a rough solid that turns",
        wrong: &[(Explicit, "gain, J")]
    ),
    scenario!(moving::rises, "a particle on a half space that rises"),
    scenario!(moving::comes, "a wall that comes drives what it hits"),
    scenario!(moving::tilts, "a particle slides on a half space that tilts"),
    scenario!(moving::lifts, "a half space lifts a particle by key frames"),
    scenario!(moving::belt, "a belt speeds up a particle", wrong: FALLS_ON_A_BELT),
    scenario!(moving::platform, "a platform lifts and shifts a particle"),
    scenario!(moving::lifts_and_turns, "a plate lifts and turns a particle"),
    scenario!(moving::keyed_wall, "a wall that comes by key frames drives what it hits"),
    scenario!(
        moving::pressing_wall,
        "a wall presses a spring by key frames",
        wrong: &[(Explicit, "off its work, J"), (Explicit, "lost, J")]
    ),
    scenario!(moving::turntable_flings, "a turntable holds a particle or flings it off"),
    scenario!(curved::particles_slide_off, "a particle slides off a round solid"),
    scenario!(curved::bodies_slide_off, "a body slides off a ball, by substeps"),
    scenario!(curved::ropes_slip, "a rope slips over a drum"),
    scenario!(curved::ropes_are_drawn, "a rope is drawn over a capsule"),
    scenario!(curved::leave_smooth_balls, "a particle leaves a smooth ball"),
    scenario!(curved::slide_on_grids, "a particle slides on a ball made of distances"),
    scenario!(
        curved::cloths_are_taken_along,
        "a fast ball takes a cloth along",
        wrong: &[(Explicit, "error"), (Explicit, "behind, m")]
    ),
    scenario!(blocks::slide, "a block slides down slopes"),
    scenario!(blocks::lie, "a block lies on slopes", wrong: MOVES),
    scenario!(impacts::thin_plates, "a thin plate is a wall"),
    scenario!(impacts::small_balls, "a small fast ball hits what is in its way"),
    scenario!(impacts::ways_through_boxes, "a way through a box in a substep"),
    scenario!(impacts::times_of_impacts, "the time of an impact"),
    scenario!(impacts::lands_on_rough_balls, "a particle lands on a rough ball"),
    scenario!(impacts::rooms, "a particle that has no room"),
    scenario!(
        rods::sparse_cloths_hang,
        "a sparse cloth hangs over a thin rod",
        wrong: &[(Explicit, "imbalance, J"), (DormandPrince, "imbalance, J")]
    ),
    scenario!(rods::impulses_are_shared, "a rod shares its impulse to the ends of a spring"),
    scenario!(thick::rest, "a particle of a radius comes to rest"),
    scenario!(thick::further_out, "radii are surfaces further out"),
    scenario!(thick::half_spaces, "a half space at rest is a plane"),
    scenario!(thick::fall_far_away, "a particle falls far from the origin"),
    scenario!(
        cubes::cubes_rest,
        "a soft cube comes to rest between surfaces",
        wrong: &[(Explicit, "speed, m/s"), (Explicit, "imbalance, J")]
    ),
    scenario!(
        cubes::large_cube_settles,
        "a large soft cube falls into a valley",
        wrong: &[(Explicit, "error")]
    ),
    scenario!(
        cubes::lands_on_a_ball,
        "a soft block lands on a rough ball",
        wrong: &[(Explicit, "error")]
    ),
    scenario!(
        cubes::lands_on_a_rod,
        "a soft block lands on a rough rod",
        wrong: &[(Explicit, "error"), (DormandPrince, "imbalance, J")]
    ),
];

/// Scenarios that take minutes to show, in simulated time.
pub const ENDURANCE: &[Scenario] = &[
    scenario!(endurance::a_particle_sticks, "a particle sticks on slopes"),
    scenario!(endurance::a_particle_slides, "a particle slides down slopes"),
    scenario!(endurance::apexes_last, "apexes of 60 s of bounces, e = 1"),
    scenario!(endurance::apexes_shrink, "apexes of bounces, e = 0.7"),
    scenario!(endurance::a_corner_holds, "a particle comes to rest in a corner"),
    scenario!(endurance::a_block_rests, "a block rests on slopes for 600 s", wrong: MOVES),
    scenario!(
        endurance::blocks_hold,
        "blocks hold up to 0.9 of the critical slope at 0.9 of the stable substep",
        wrong: MOVES
    ),
    scenario!(endurance::a_column_stands, "a column stands on slopes for 120 s", wrong: MOVES),
    scenario!(endurance::a_force_presses, "a force holds a particle to a wall"),
];

/// The tolerance of each of these, in the words of docs/measured/trade.md.
const ALLOWED: [&str; 9] = [
    "8 roundings of its place in 20 s",
    "a h t; rounding for order 2 and above",
    "g h²",
    "2 g h²",
    "16 roundings in 20 s",
    "1e-5 of its size",
    "1e-5 of their size in 60 s",
    "1e-5 of its size",
    "8 roundings in 20 s",
];

/// Measurements of a run beside their bounds, the worst of each quantity.
#[derive(Default)]
pub struct Measures(Vec<Measure>);

struct Measure {
    quantity: &'static str,
    measured: f64,
    bound: f64,
    /// The case in which it was the worst.
    case: String,
    /// Number of cases that exceed the bound, and of all.
    over: [usize; 2],
}

impl Measure {
    fn exceeds(&self) -> bool {
        1.0 < self.fraction()
    }

    /// As a fraction of the bound; infinite for a NaN, and for a bound of zero or less.
    fn fraction(&self) -> f64 {
        let fraction = self.measured / self.bound;
        if 0.0 < self.bound && !fraction.is_nan() { fraction } else { f64::INFINITY }
    }
}

impl Measures {
    /// Keeps the worst, by fraction of the bound, of a quantity: its name ends with its unit.
    pub fn see(&mut self, quantity: &'static str, (measured, bound): (f64, f64), case: &str) {
        let mut new = Measure { quantity, measured, bound, case: case.to_owned(), over: [0, 1] };
        new.over[0] = usize::from(new.exceeds());
        let Some(old) = self.0.iter_mut().find(|old| old.quantity == quantity) else {
            self.0.push(new);
            return;
        };
        let over = [0, 1].map(|at| old.over[at] + new.over[at]);
        if old.fraction() < new.fraction() {
            *old = new;
        }
        old.over = over;
    }

    /// The largest fraction of a bound.
    fn worst(&self) -> f64 {
        self.0.iter().map(Measure::fraction).fold(0.0, f64::max)
    }

    /// Keeps that a run ended in an error.
    pub fn fail(&mut self, error: &Error, case: &str) {
        self.see("error", (f64::INFINITY, 0.0), &format!("{case}: {error}"));
    }
}

/// Runs a table under a method; panics with the rows that exceed their bounds.
pub fn check(table: &[Scenario], integrator: Integrator) {
    let mut failures = String::new();
    for Scenario { name, runs, wrong } in table {
        for (precision, run) in ["f32", "f64"].into_iter().zip(runs) {
            for row in run(integrator).0 {
                let is_wrong = wrong.contains(&(integrator, row.quantity))
                    || KNOWN.contains(&(name, integrator, precision, row.quantity));
                if row.exceeds() != is_wrong {
                    let Measure { quantity, measured, bound, case, over: [over, all] } = row;
                    let note = if is_wrong { "is wrong no more" } else { "" };
                    writeln!(
                        failures,
                        "{name} | {integrator} | {precision} | {quantity} | {measured:.2e} | \
                         {bound:.2e} | {over} of {all}: {case} {note}"
                    )
                    .expect("memory");
                }
            }
        }
    }
    let head = "scenario | method | precision | quantity | measured | bound | cases, and the worst";
    assert!(failures.is_empty(), "{head}\n{failures}");
}

/// The table of docs/measured/trade.md: the worst of each method in f32 and f64, as a fraction of
/// its bound.
pub fn page() -> String {
    let mut page = String::from("| what | allowed |");
    Integrator::ALL.iter().for_each(|integrator| write!(page, " {integrator} |").expect("memory"));
    write!(page, "\n|---|---|{}", "---|".repeat(Integrator::ALL.len())).expect("memory");
    for (scenario, allowed) in ENDURANCE.iter().zip(ALLOWED) {
        write!(page, "\n| {} | {allowed} |", scenario.name).expect("memory");
        for integrator in Integrator::ALL {
            let [single, double] = scenario.runs.map(|run| short(run(integrator).worst()));
            write!(page, " {single}, {double} |").expect("memory");
        }
    }
    page + "\n"
}

/// Two digits of a fraction.
fn short(value: f64) -> String {
    match value {
        value if value < 0.005 => "0".into(),
        value if value < 10.0 => format!("{value:.2}"),
        value => format!("{value:.0}"),
    }
}

/// Whether the precision is double.
pub fn is_double<R: Real>() -> bool {
    R::EPSILON.to_f64() < 1e-9
}

/// A simulation of a scene with the default settings otherwise.
pub fn start<R: Real>(scene: &Scene, integrator: Integrator) -> Simulation<R> {
    Simulation::new(scene, Settings { integrator, ..Settings::default() }).expect("a valid scene")
}

/// Takes the steps of so many seconds, and looks at the simulation after each.
pub fn run<R: Real>(
    simulation: &mut Simulation<R>,
    seconds: f64,
    mut look: impl FnMut(&Simulation<R>),
) -> Result<(), Error> {
    let steps = (seconds / simulation.settings().step).round() as usize;
    (0..steps).try_for_each(|_| {
        simulation.step()?;
        look(simulation);
        Ok(())
    })
}

/// Runs a scene for so many steps of 1/60 s.
pub fn after<R: Real>(
    scene: &Scene,
    (integrator, substeps): (Integrator, u32),
    steps: u32,
    (measures, name): (&mut Measures, &str),
) -> Simulation<R> {
    let settings = Settings { integrator, substeps, ..Settings::default() };
    let mut simulation = Simulation::<R>::new(scene, settings).expect("a valid scene");
    let ended = run(&mut simulation, f64::from(steps) / 60.0, |_| {});
    ended.unwrap_or_else(|error| measures.fail(&error, name));
    simulation
}
