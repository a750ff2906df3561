//! The running simulation: one step on a page, its queue, and the guard that keeps it in the world.
//!
//! `interaction.rs` holds user input between two steps, `material.rs` changes of the material of a
//! body, and `topology.rs` additions and removals. `progress.rs` holds the checkpoint from which a
//! run resumes to the bit, `guard.rs` the stop of a run that diverges, and `guided.rs` the motion
//! of guided pins. `readings.rs` holds the measurements, `witness.rs` the drift detector, and
//! `compiled.rs` the functions that a debug build of a caller runs optimised.

mod compiled;
mod guard;
mod guided;
mod material;
pub(crate) mod interaction;
mod progress;
mod readings;
mod rise;
mod topology;
mod witness;

pub use interaction::{Effects, Interaction, Select};
pub use material::MaterialNumber;
pub use progress::{Held, Progress};
pub use witness::Witness;

use crate::columns::threads;
use crate::contact::shells::{RowImpulse, ShellRows};
use crate::elements::grabs::Grab;
use crate::elements::{Element, Own};
use crate::energy::Ledger;
use crate::error::Error;
use crate::methods::{Done, Method, OwnMethod, Scratch, Settings, StepContext};
use crate::number::{Instructions, Real};
use crate::obstacles::{Obstacle, Obstacles, OwnObstacle};
use crate::scene::check::check_steps;
use crate::scene::{Scene, Solid};
use crate::stability::Region;
use crate::system::{Columns, Model, State};
use alloc::borrow::Cow;
use alloc::boxed::Box;
use alloc::vec::Vec;
use compiled::Compiled;
use fearless_simd::Level;

/// A system that runs.
#[derive(Clone, Debug)]
pub struct Simulation<R: Real = f32> {
    pub(crate) model: Model<R>,
    pub(crate) state: Columns<R>,
    settings: Settings,
    /// The most evaluations of a step of an adaptive method.
    most_evaluations: u64,
    /// A user-defined method, in place of that of the settings.
    own_method: Option<OwnMethod>,
    level: Level,
    scratch: Scratch<R>,
    /// The rows of shells; their impulses are a part of the state.
    rows: ShellRows<R>,
    good_impulses: Vec<RowImpulse>,
    /// The state at the start of the step, to fall back on.
    good: Columns<R>,
    /// The grabs at the start of the step, before the queue was applied.
    good_grabs: Vec<Grab<R>>,
    queue: Vec<Interaction>,
    /// Whether anything touched an obstacle in the last step.
    touched: bool,
    ledger: Ledger,
    steps: u64,
    /// Steps and time at which the length of a step changed last.
    epoch: (u64, f64),
    /// The handle of the next user-defined element or obstacle.
    next_handle: usize,
}

/// The previous part of the model that the queue may change.
enum Kept<R: Real> {
    /// All of it.
    Model(Box<Model<R>>),
    /// The grabs, which stand in `good_grabs`, the number of pushes, and the solids if one is
    /// moved.
    Hands { pushes: usize, solids: Vec<Solid> },
}

impl<R: Real> Simulation<R> {
    /// Checks a scene and makes it ready to run.
    ///
    /// # Errors
    /// The first row or setting that is out of its domain.
    pub fn new(scene: &Scene, settings: Settings) -> Result<Self, Error> {
        (Compiled::of_precision().start)(Cow::Borrowed(scene), settings)
    }

    /// The same, which frees the rows of the scene on the way: less memory at once.
    ///
    /// # Errors
    /// See [`Simulation::new`].
    pub fn from_scene(scene: Scene, settings: Settings) -> Result<Self, Error> {
        (Compiled::of_precision().start)(Cow::Owned(scene), settings)
    }

    /// The body of [`Simulation::new`].
    fn start(scene: Cow<'_, Scene>, settings: Settings) -> Result<Self, Error> {
        let (model, state) = Model::new(scene)?;
        let mut simulation = Simulation::from_parts(model, state, settings)?;
        simulation.follow_guides();
        // A scene may start inside an obstacle; it never runs there.
        simulation.leave_obstacles();
        let inside = "inside the world once the obstacles have pushed the particle out";
        simulation.check_state(inside)?;
        simulation.start_shells();
        Ok(simulation)
    }

    fn from_parts(mut model: Model<R>, state: State<R>, settings: Settings) -> Result<Self, Error> {
        settings.check::<R>()?;
        settings.integrator.check_shells(model.shells())?;
        model.prepare_bounces();
        let columns = Method::<R>::columns(&settings.integrator);
        let start = Columns::of(&model.slots, &state, 0);
        drop(state);
        Ok(Simulation {
            scratch: Scratch::new(&model, columns),
            good: Columns::new(&model.slots, 2),
            good_grabs: Vec::new(),
            state: start,
            rows: ShellRows::default(),
            good_impulses: Vec::new(),
            model,
            settings,
            most_evaluations: u64::MAX,
            own_method: None,
            level: Instructions::best().level(),
            queue: Vec::new(),
            touched: false,
            ledger: Ledger::default(),
            steps: 0,
            epoch: (0, 0.0),
            next_handle: 0,
        })
    }

    /// Advances by one step of `settings.step` seconds.
    ///
    /// # Errors
    /// [`Error::Diverged`] if a particle left the world, would cross all of it in a substep, or
    /// the force on it or the energy taken is not finite,
    /// [`Error::Unreachable`] if an adaptive method cannot keep its tolerance,
    /// [`Error::TooManyEvaluations`] if it would take longer than it may, [`Error::Unsolved`] if an
    /// implicit one cannot solve for the step, [`Error::OutOfDomain`] for one step too many to be
    /// counted exactly. State, queue and everything that the queue changes are then as they
    /// were before the step: a shorter step may follow, or [`Simulation::clear_queue`].
    pub fn step(&mut self) -> Result<(), Error> {
        (Compiled::of_precision().step)(self, true).map(drop)
    }

    /// Advances by one step unless shells may cross in it, see [`Ledger::passes`]. Nor does it
    /// advance if a surface turns in a substep by more than a tenth of a radian on the way of a
    /// particle that meets it, or moves by half of its thickness. Friction that does not settle
    /// refuses a step too, as does energy that nothing supplied, a tenth of that in motion. Returns
    /// whether it did. If not, everything is restored.
    ///
    /// # Errors
    /// See [`Simulation::step`].
    pub fn step_unless_passing(&mut self) -> Result<bool, Error> {
        (Compiled::of_precision().step)(self, false)
    }

    /// The body of [`Simulation::step`] and [`Simulation::step_unless_passing`].
    fn step_or_refuse(&mut self, may_pass: bool) -> Result<bool, Error> {
        check_steps("number", ("step", 0), self.steps + 1)?;
        self.good.copy_from(&self.state);
        self.rows.keep(&mut self.good_impulses);
        let kept = self.keep_model();
        self.apply_queue();
        self.model.prepare_bounces();
        let method: &dyn Method<R> = match &self.own_method {
            Some(own) => own.of::<R>(),
            None => &self.settings.integrator,
        };
        let mut step = StepContext {
            start: step_start(self.epoch, self.steps, self.settings.step),
            model: &self.model,
            settings: &self.settings,
            most_evaluations: self.most_evaluations,
            level: self.level,
            finished: 0,
            state: &mut self.state,
            scratch: &mut self.scratch,
            rows: &mut self.rows,
            done: Default::default(),
        };
        let is_refused = |done: Done| !may_pass && (0 < done.passes || done.turned);
        if !is_refused(step.done) {
            threads::enter(self.model.springs.is_shared(), || method.advance(&mut step));
        }
        let mut done = step.done;
        let [before, after] =
            [&self.good, &self.state].map(|state| self.model.energy_of_pins(&state.velocities));
        done.drive(after - before);
        if is_refused(done) || !may_pass && self.has_risen(&done) {
            self.go_back();
            self.put_model_back(kept);
            return Ok(false);
        }
        self.touched = done.touched;
        if let Err(error) = self.guard_or_go_back(&done) {
            self.put_model_back(kept);
            return Err(error);
        }
        self.model.pushes.0.clear();
        self.queue.clear();
        self.ledger.book(done.counted, done.given, done.contacts);
        self.ledger.note_passes(done.passes + done.crossed, self.rows.take_passages());
        self.steps += 1;
        self.follow_guides();
        Ok(true)
    }

    /// Keeps the model before the queue is applied: all of it, or only the part that grabs and
    /// pushes change, as these are frequent.
    fn keep_model(&mut self) -> Kept<R> {
        use Interaction::{Grab, Impulse, MoveSolid, Push, Release, Spin};
        let pushes = self.model.pushes.0.len();
        if self.queue.is_empty() {
            return Kept::Hands { pushes, solids: Vec::new() };
        }
        let is_hand = |interaction: &Interaction| {
            matches!(
                interaction,
                Grab { .. }
                    | Release { .. }
                    | Push { .. }
                    | Impulse { .. }
                    | Spin { .. }
                    | MoveSolid { .. }
            )
        };
        if !self.queue.iter().all(is_hand) {
            return Kept::Model(self.model.clone().into());
        }
        // Room for those that are queued too: the next step allocates nothing.
        self.good_grabs.clear();
        self.good_grabs.reserve(self.model.grabs.0.len() + self.queue.len());
        self.good_grabs.extend_from_slice(&self.model.grabs.0);
        let is_moved = |interaction: &Interaction| matches!(interaction, MoveSolid { .. });
        let moves = self.queue.iter().any(is_moved);
        let solids = if moves { self.model.solids().to_vec() } else { Vec::new() };
        Kept::Hands { pushes, solids }
    }

    /// Undoes the changes of the queue to the model.
    fn put_model_back(&mut self, kept: Kept<R>) {
        match kept {
            Kept::Model(model) => self.model = *model,
            Kept::Hands { pushes, solids } => {
                if !solids.is_empty() {
                    self.model.obstacles.solids = solids;
                }
                self.model.pushes.0.truncate(pushes);
                if !self.queue.is_empty() {
                    self.model.grabs.0.clone_from(&self.good_grabs);
                }
            }
        }
    }

    /// Goes back to the last good state where the current one is refused.
    fn guard_or_go_back(&mut self, done: &Done) -> Result<(), Error> {
        self.guard(done).inspect_err(|_| self.go_back())
    }

    /// Goes back to the last good state.
    fn go_back(&mut self) {
        self.state.copy_from(&self.good);
        self.rows.set_impulses(&self.good_impulses);
        // The scratch of an evaluation may hold NaN.
        let adaptive = self.scratch.dormand_prince.take();
        self.renew_scratch();
        self.scratch.dormand_prince = adaptive;
    }

    fn apply_queue(&mut self) {
        if !self.model.pushes.0.is_empty() || !self.queue.is_empty() {
            self.scratch.warm = false;
        }
        if self.queue.is_empty() {
            return;
        }
        let now = (self.settings.substep(), self.time());
        let mut changed = Effects::default();
        for &interaction in &self.queue {
            interaction::apply(&mut self.model, &mut self.state, now, interaction);
            // A cut has taken its spring out of the rows already.
            if !matches!(interaction, Interaction::Cut { .. }) {
                changed = changed.or(interaction.effects());
            }
        }
        self.model.tear(self.queue.iter().filter_map(|interaction| match interaction {
            Interaction::Cut { spring } => Some(*spring),
            _ => None,
        }));
        self.renew(changed);
    }

    /// Updates the columns that a step reads after a change.
    fn renew(&mut self, changed: Effects) {
        if changed.springs {
            self.model.springs.renew();
        }
        if changed.masses || changed.energy {
            self.model.renew_masses();
        }
        self.scratch.warm = false;
    }

    /// Queues an interaction for the start of the next step.
    ///
    /// # Errors
    /// An index out of range or a number out of its domain; nothing is queued then.
    pub fn queue(&mut self, interaction: Interaction) -> Result<(), Error> {
        interaction::check_interaction(&self.model, &interaction)?;
        self.queue.push(interaction);
        Ok(())
    }

    /// The interactions queued for the start of the next step.
    pub fn queued(&self) -> &[Interaction] {
        &self.queue
    }

    /// Empties the queue.
    pub fn clear_queue(&mut self) {
        self.queue.clear();
    }

    /// Applies the queue without stepping: for a paused window.
    ///
    /// # Errors
    /// [`Error::Diverged`] for a velocity that overflows; the state is then the one before, but for
    /// the velocities of pins.
    pub fn apply_queued(&mut self) -> Result<(), Error> {
        let changes_state = self.queue.iter().any(|interaction| interaction.effects().state);
        if !changes_state {
            self.apply_queue();
            self.queue.clear();
            return Ok(());
        }
        self.good.copy_from(&self.state);
        self.rows.keep(&mut self.good_impulses);
        self.apply_queue();
        for interaction in self.queue.drain(..) {
            // A pinned particle stays pinned, and keeps its velocity.
            if let Interaction::Pin { particle, .. } = interaction {
                let at = self.model.slots.at(particle);
                let (_, velocity) = self.state.get(at);
                let (position, _) = self.good.get(at);
                self.good.put(at, (position, velocity));
            }
        }
        self.guard_or_go_back(&Done::default())
    }

    /// Replaces the state, for instance with that of a state file or of an earlier step.
    ///
    /// # Errors
    /// [`Error::WrongLength`] for another number of particles; [`Error::OutOfDomain`] for a
    /// position outside the world, a velocity that is not finite or 2^53 steps or more.
    pub fn set_state(&mut self, state: &State<R>, steps: u64) -> Result<(), Error> {
        let expected = self.model.particle_count();
        for (what, count) in
            [("positions", state.positions.len()), ("velocities", state.velocities.len())]
        {
            if count != expected {
                return Err(Error::WrongLength { what, count, expected });
            }
        }
        state.check(self.model.extent, "finite and inside the world")?;
        check_steps("number", ("step", 0), steps)?;
        self.put_state(state);
        self.steps = steps;
        if steps < self.epoch.0 {
            self.epoch = (0, 0.0);
        }
        self.follow_guides();
        Ok(())
    }

    /// Replaces the state. A particle that is pinned now keeps its velocity, which belongs to the
    /// pin: an older state may be from before it was pinned.
    fn put_state(&mut self, state: &State<R>) {
        let rows = state.positions.iter().zip(&state.velocities);
        for (particle, (at, (&position, &velocity))) in
            self.model.slots.places().zip(rows).enumerate()
        {
            let (_, now) = self.state.get(at);
            let pinned = self.model.is_pinned(particle);
            self.state.put(at, (position, if pinned && now != velocity { now } else { velocity }));
        }
        // Impulses of shells belong to the state that was.
        self.rows.set_impulses(&[]);
        self.scratch.warm = false;
    }

    /// The impulses from which shells start the next substep, to be put back with the state.
    pub fn impulses(&self) -> Vec<RowImpulse> {
        self.rows.impulses()
    }

    /// Puts back the impulses that belong to a state that was put back, in the order of their keys.
    pub fn set_impulses(&mut self, impulses: &[RowImpulse]) {
        self.rows.set_impulses(impulses);
    }

    /// The ledger of the energy dissipated, to be put back with the state.
    pub fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    /// Puts back the ledger that belongs to a state that was put back.
    pub fn set_ledger(&mut self, ledger: Ledger) {
        self.ledger = ledger;
    }

    /// Changes how the system is stepped from the next step on.
    ///
    /// # Errors
    /// A step or a number of substeps out of its domain; nothing changes then.
    pub fn set_settings(&mut self, settings: Settings) -> Result<(), Error> {
        settings.check::<R>()?;
        settings.integrator.check_shells(self.model.shells())?;
        self.rows.scale(settings.substep() / self.settings.substep());
        if settings.step != self.settings.step {
            self.epoch = (self.steps, self.time());
        }
        let is_other = settings.integrator != self.settings.integrator;
        interaction::cap_grabs(&mut self.model, settings.substep());
        self.settings = settings;
        self.scratch.warm = false;
        if is_other && self.own_method.is_none() {
            self.renew_scratch();
        }
        Ok(())
    }

    /// Bounds the evaluations of all forces that a step of an adaptive method may take, so that a
    /// window is never kept waiting. A step that needs more fails. No bound by default, and none is
    /// kept in a saved run.
    pub fn set_most_evaluations(&mut self, most: u64) {
        self.most_evaluations = most;
    }

    /// Steps by a user-defined method from the next step on, in place of the integrator of the
    /// settings. Their step, substeps and tolerance hold for it too.
    pub fn set_method(&mut self, method: impl Method<f32> + Method<f64> + 'static) {
        self.own_method = Some(OwnMethod::new(method));
        self.renew_scratch();
    }

    /// Goes back to the integrator of the settings.
    pub fn clear_method(&mut self) {
        self.own_method = None;
        self.renew_scratch();
    }

    /// Whether a user-defined method steps it.
    pub fn has_own_method(&self) -> bool {
        self.own_method.is_some()
    }

    /// Makes the work columns of the current method.
    fn renew_scratch(&mut self) {
        let columns = match &self.own_method {
            Some(own) => own.of::<R>().columns(),
            None => Method::<R>::columns(&self.settings.integrator),
        };
        self.scratch = Scratch::new(&self.model, columns);
    }

    /// The stability region of the current method.
    fn region(&self) -> Region {
        match &self.own_method {
            Some(own) => own.of::<R>().region(),
            None => Method::<R>::region(&self.settings.integrator),
        }
    }

    /// Chooses the instructions of the steps to come, for measurements. All of them give the same
    /// bits, and the best that this machine has are chosen at the start.
    pub fn set_instructions(&mut self, instructions: Instructions) {
        self.level = instructions.level();
    }

    /// Adds a user-defined element; returns its handle.
    pub fn add_element(&mut self, element: impl Element<f32> + Element<f64> + 'static) -> usize {
        self.scratch.warm = false;
        let handle = self.new_handle();
        self.model.own.0.push((handle, Own::new(element)));
        handle
    }

    /// Removes a user-defined element; returns whether there was one of that handle.
    pub fn remove_element(&mut self, handle: usize) -> bool {
        self.scratch.warm = false;
        let before = self.model.own.0.len();
        self.model.own.0.retain(|&(other, _)| other != handle);
        self.model.own.0.len() < before
    }

    /// Adds a user-defined obstacle and moves out the particles inside it; returns its handle.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for a particle that it pushes out of the world; nothing is added
    /// then.
    pub fn add_obstacle(
        &mut self,
        obstacle: impl Obstacle<f32> + Obstacle<f64> + 'static,
    ) -> Result<usize, Error> {
        let handle = self.new_handle();
        let own = (handle, OwnObstacle::new(obstacle));
        self.add_to_obstacles(|obstacles| obstacles.own.push(own))?;
        Ok(handle)
    }

    /// Adds an obstacle and moves out the particles inside it; adds nothing where that pushes one
    /// out of the world.
    fn add_to_obstacles(&mut self, add: impl FnOnce(&mut Obstacles<R>)) -> Result<(), Error> {
        let before = (self.model.obstacles.clone(), self.state.clone());
        add(&mut self.model.obstacles);
        (Compiled::of_precision().leave_obstacles)(self);
        self.scratch.warm = false;
        let inside = "inside the world once the obstacle has pushed the particle out";
        let checked = self.check_state(inside);
        if checked.is_err() {
            (self.model.obstacles, self.state) = before;
        }
        checked
    }

    /// Removes a user-defined obstacle; returns whether there was one of that handle.
    pub fn remove_obstacle(&mut self, handle: usize) -> bool {
        let before = self.model.obstacles.own.len();
        self.model.obstacles.own.retain(|&(other, _)| other != handle);
        self.model.obstacles.own.len() < before
    }

    fn new_handle(&mut self) -> usize {
        self.next_handle += 1;
        self.next_handle - 1
    }

    /// The same simulation in another precision, each number rounded once.
    ///
    /// # Errors
    /// The first number that the other precision cannot hold.
    pub fn convert<S: Real>(&self) -> Result<Simulation<S>, Error> {
        let (scene, progress) = self.progress();
        let mut other = Simulation::<S>::resume(&scene, &progress)?;
        other.model.own = self.model.own.clone();
        other.model.obstacles.own = self.model.obstacles.own.clone();
        other.own_method = self.own_method.clone();
        other.most_evaluations = self.most_evaluations;
        other.renew_scratch();
        (other.next_handle, other.level) = (self.next_handle, self.level);
        Ok(other)
    }

    /// The model: everything that a step reads.
    pub fn model(&self) -> &Model<R> {
        &self.model
    }

    /// A copy of the state, in the order of the scene.
    pub fn state(&self) -> State<R> {
        self.state.state(&self.model.slots)
    }

    /// The settings by which the system is stepped.
    pub fn settings(&self) -> Settings {
        self.settings
    }

    /// Whether anything touched an obstacle in the last step.
    pub fn touched(&self) -> bool {
        self.touched
    }

    /// Steps taken.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Simulated time, seconds: steps times the step, never a running sum.
    pub fn time(&self) -> f64 {
        step_start(self.epoch, self.steps, self.settings.step)
    }
}

/// Time at the start of a step, seconds.
fn step_start((steps, time): (u64, f64), taken: u64, step: f64) -> f64 {
    time + (taken - steps) as f64 * step
}
