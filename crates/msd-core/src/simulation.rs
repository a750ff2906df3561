//! What is one step? Queued interactions, substeps of integrate and collide, and a guard.

use crate::check::check_steps;
use crate::collision;
use crate::dormand_prince::Work;
use crate::energy;
use crate::engine::Engine;
use crate::error::Error;
use crate::guard;
use crate::interaction::{self, Interaction};
use crate::kernel::{Instructions, Substeps};
use crate::ledger::Ledger;
use crate::real::{Real, Vector};
use crate::scene::Scene;
use crate::settings::Settings;
use crate::stability::Estimator;
use crate::system::{Model, Motion, State};
use alloc::vec;
use alloc::vec::Vec;

/// A system that runs.
#[derive(Clone, Debug)]
pub struct Simulation<R: Real = f32> {
    pub(crate) model: Model<R>,
    pub(crate) state: State<R>,
    pub(crate) settings: Settings,
    engine: Engine<R>,
    /// The state at the start of the step, to fall back on.
    good: State<R>,
    pub(crate) queue: Vec<Interaction>,
    /// How many of them cut a spring.
    cuts: usize,
    /// Whether anything touched a plane in the last step.
    pub(crate) touched: bool,
    pub(crate) ledger: Ledger,
    pub(crate) steps: u64,
    /// Steps and time at which the length of a step changed last.
    pub(crate) epoch: (u64, f64),
}

impl<R: Real> Simulation<R> {
    /// Checks a scene and makes it ready to run.
    ///
    /// # Errors
    /// The first row or setting that is out of its domain.
    pub fn new(scene: &Scene, settings: Settings) -> Result<Self, Error> {
        let (model, state) = Model::new(scene)?;
        let mut simulation = Simulation::from_parts(model, state, settings)?;
        // A scene may start inside a plane; it never runs there.
        let Simulation { model, state, .. } = &mut simulation;
        let nothing = vec![R::Vec3::ZERO; model.particle_count()];
        collision::resolve(model, R::of(settings.substep()), &nothing, state);
        let inside = "inside the world once the planes have pushed the particle out";
        simulation.state.check(simulation.model.extent, inside)?;
        Ok(simulation)
    }

    pub(crate) fn from_parts(
        model: Model<R>,
        state: State<R>,
        settings: Settings,
    ) -> Result<Self, Error> {
        settings.check::<R>()?;
        Ok(Simulation {
            engine: Engine::new(settings.integrator, &model),
            good: state.clone(),
            model,
            state,
            settings,
            queue: Vec::new(),
            cuts: 0,
            touched: false,
            ledger: Ledger::default(),
            steps: 0,
            epoch: (0, 0.0),
        })
    }

    /// Advances by one step of `settings.step` seconds.
    ///
    /// # Errors
    /// [`Error::Diverged`] if a particle left the world, [`Error::Unreachable`] if an adaptive
    /// method cannot keep its tolerance; the state is then the one before the step.
    pub fn step(&mut self) -> Result<(), Error> {
        self.run_step(None::<&mut fn(Motion<'_, R>, &mut [R::Vec3])>)
    }

    /// Advances by one step with a force of the caller's, which adds to its last argument, newtons.
    ///
    /// # Errors
    /// See [`Simulation::step`].
    pub fn step_with(
        &mut self,
        mut own_force: impl FnMut(Motion<'_, R>, &mut [R::Vec3]),
    ) -> Result<(), Error> {
        self.run_step(Some(&mut own_force))
    }

    fn run_step(
        &mut self,
        own_force: Option<&mut impl FnMut(Motion<'_, R>, &mut [R::Vec3])>,
    ) -> Result<(), Error> {
        self.keep_good();
        let handled = own_force.is_some() || !self.queue.is_empty();
        self.apply_queue();
        let Simulation { engine, model, settings, state, .. } = self;
        let Substeps { counted, touched, inside, stuck, .. } =
            engine.advance((model, settings), state, own_force);
        self.touched = touched;
        let contact_alone = touched && !handled && !self.is_handled();
        self.model.pushes.clear();
        if !inside {
            self.guard_or_go_back(stuck)?;
        }
        let Simulation { ledger, model, good, .. } = self;
        ledger.book(counted, contact_alone, || energy::energy(model, good, 0.0).total());
        self.steps += 1;
        Ok(())
    }

    /// Remembers the present state.
    fn keep_good(&mut self) {
        self.good.positions.copy_from_slice(&self.state.positions);
        self.good.velocities.copy_from_slice(&self.state.velocities);
    }

    /// Goes back to the state remembered where the present one cannot be. A velocity that a pin has
    /// been given since then was remembered too: that of now may be no number.
    fn guard_or_go_back(&mut self, stuck: Option<usize>) -> Result<(), Error> {
        self.guard(stuck).inspect_err(|_| {
            self.state.positions.copy_from_slice(&self.good.positions);
            self.state.velocities.copy_from_slice(&self.good.velocities);
            self.engine.forget_state();
        })
    }

    fn apply_queue(&mut self) {
        let h = self.settings.substep();
        if !self.model.pushes.is_empty() || !self.queue.is_empty() {
            self.engine.forget_forces();
        }
        if !self.queue.is_empty() {
            self.close_ledger();
        }
        let hands_alone = self.only_hands_queued();
        if !hands_alone {
            self.engine.forget_state();
        }
        self.cuts = 0;
        for interaction in self.queue.drain(..) {
            interaction::apply(&mut self.model, &mut self.state, h, interaction);
            if interaction.effects().springs {
                self.engine.forget_springs();
            }
            if let Interaction::Pin { particle, .. } = interaction {
                self.good.velocities[particle] = self.state.velocities[particle];
            }
        }
        if !hands_alone {
            self.engine.renew(&self.model);
        }
    }

    /// Whether what is queued, if anything, changes hands alone.
    fn only_hands_queued(&self) -> bool {
        self.queue.iter().all(interaction::changes_hands_alone)
    }

    /// Whether a hand does work: by a grab, a push or a pin that moves.
    pub fn is_handled(&self) -> bool {
        let moves = |(&w, &v): (&R, &R::Vec3)| w == R::ZERO && v != R::Vec3::ZERO;
        let mut rows = self.model.inverse_masses.iter().zip(&self.state.velocities);
        !self.model.grabs.is_empty() || !self.model.pushes.is_empty() || rows.any(moves)
    }

    /// Counts what a contact took before something else than a step changes the energy.
    fn close_ledger(&mut self) {
        let Simulation { ledger, model, state, .. } = self;
        ledger.close(|| energy::energy(model, state, 0.0).total());
    }

    /// Refuses a step that was given up and a state outside the world.
    fn guard(&self, stuck: Option<usize>) -> Result<(), Error> {
        let (model, step, time) = (&self.model, self.steps + 1, self.time());
        if let Some(particle) = stuck {
            let tolerance = self.settings.tolerance;
            return Err(Error::Unreachable { tolerance, particle, step, time });
        }
        let Some(particle) = guard::first_outside(model, &self.state) else { return Ok(()) };
        let at = (particle, step, time);
        Err(guard::divergence(model, (&self.good, &self.settings), at).into())
    }

    pub(crate) fn largest_step_from(&self, state: &State<R>, estimator: &mut Estimator) -> f64 {
        guard::largest_step(&self.model, (state, &self.settings), estimator)
    }

    /// Queues an interaction for the start of the next step.
    ///
    /// # Errors
    /// An index that names nothing or a number out of its domain; nothing is queued then.
    pub fn queue(&mut self, interaction: Interaction) -> Result<(), Error> {
        interaction::check_interaction(&self.model, self.cuts, &interaction)?;
        self.cuts += usize::from(matches!(interaction, Interaction::Cut { .. }));
        self.queue.push(interaction);
        Ok(())
    }

    /// Chooses the instructions of the steps to come, for measurements: all of them give the same
    /// bits, and the best that this machine has are chosen at the start.
    pub fn set_instructions(&mut self, instructions: Instructions) {
        self.engine.set_instructions(instructions);
    }

    /// What is queued for the start of the next step.
    pub fn queued(&self) -> &[Interaction] {
        &self.queue
    }

    /// Applies what is queued without stepping: for a paused window.
    ///
    /// # Errors
    /// [`Error::Diverged`] for a velocity that overflows; the state is then the one before.
    pub fn apply_queued(&mut self) -> Result<(), Error> {
        if self.only_hands_queued() {
            self.apply_queue();
            return Ok(());
        }
        self.keep_good();
        self.apply_queue();
        self.guard_or_go_back(None)
    }

    /// Replaces the state, as when a state file is loaded or a step taken back.
    ///
    /// # Errors
    /// [`Error::WrongLength`] for another number of particles; [`Error::OutOfDomain`] for a
    /// position outside the world, a velocity that is not finite or more than 2^53 steps.
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
        self.close_ledger();
        self.put_state(state);
        self.steps = steps;
        if steps < self.epoch.0 {
            self.epoch = (0, 0.0);
        }
        Ok(())
    }

    /// What was booked of the energy taken away, to be put back with the state.
    pub fn ledger(&self) -> Ledger {
        self.ledger
    }

    /// Puts back what was booked at a state that was returned to. If something that the energy
    /// depends on was changed since, the ledger must have been closed before that.
    pub fn set_ledger(&mut self, ledger: Ledger) {
        self.ledger = ledger;
    }

    /// Replaces the state. What is pinned now keeps its velocity, which belongs to the pin: an
    /// older state may be from before it was pinned.
    fn put_state(&mut self, state: &State<R>) {
        let pinned = self.model.inverse_masses.iter().map(|&w| w == R::ZERO);
        let velocities = self.state.velocities.iter_mut().zip(&state.velocities);
        for (pinned, (now, &velocity)) in pinned.zip(velocities) {
            *now = if pinned { *now } else { velocity };
        }
        self.state.positions.copy_from_slice(&state.positions);
        self.engine.forget_state();
    }

    /// Changes how the system is stepped from the next step on.
    ///
    /// # Errors
    /// A step or a number of substeps out of its domain; nothing changes then.
    pub fn set_settings(&mut self, settings: Settings) -> Result<(), Error> {
        settings.check::<R>()?;
        if settings.integrator != self.settings.integrator {
            self.engine.set_method(settings.integrator, &self.model);
        }
        if settings.step != self.settings.step {
            self.epoch = (self.steps, self.time());
        }
        interaction::cap_grabs(&mut self.model, settings.substep());
        self.settings = settings;
        self.engine.forget_forces();
        Ok(())
    }

    /// The same simulation in another precision, each number rounded once.
    ///
    /// # Errors
    /// The first number that the other precision cannot hold.
    pub fn convert<S: Real>(&self) -> Result<Simulation<S>, Error> {
        let (model, state) = (self.model.convert::<S>()?, self.state.convert());
        let mut other = Simulation::from_parts(model, state, self.settings)?;
        other.state.check(other.model.extent, "finite and inside the world")?;
        self.queue.iter().try_for_each(|&interaction| other.queue(interaction))?;
        other.ledger = Ledger::of(self.dissipated());
        (other.steps, other.epoch) = (self.steps, self.epoch);
        Ok(other)
    }

    /// What a step reads.
    pub fn model(&self) -> &Model<R> {
        &self.model
    }

    /// A copy of what a step advances, in the order of the scene. To read some of it see
    /// [`Simulation::positions`] and [`Simulation::position`].
    pub fn state(&self) -> State<R> {
        self.state.clone()
    }

    /// How the system is stepped.
    pub fn settings(&self) -> Settings {
        self.settings
    }

    /// Whether anything touched a plane in the last step.
    pub fn touched(&self) -> bool {
        self.touched
    }

    /// Steps taken.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Simulated time, seconds: steps times the step, never a running sum.
    pub fn time(&self) -> f64 {
        let (steps, time) = self.epoch;
        time + (self.steps - steps) as f64 * self.settings.step
    }

    /// What the steps of an adaptive method have taken since it was chosen; `None` of another.
    pub fn work(&self) -> Option<Work> {
        self.engine.work()
    }
}
