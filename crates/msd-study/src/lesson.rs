//! Answers to lessons: the number that a question asks for, computed from its scene.

use crate::quantity::rounded;
use core::f64::consts::TAU;
use msd_core::glam::DVec3;
use msd_core::{Error, Integrator, Plane, Scene, Settings, Simulation};
use msd_scene::schema::{Answer, LessonRow, MistakeRow};

/// The most evaluations of springs and particles that an answer may take: a tenth of a second.
const MOST_WORK: f64 = 1e7;
/// Tolerance of the run that counts as exact.
const EXACT: f64 = 1e-12;

/// A lesson with its scene and settings.
#[derive(Clone, Copy, Debug)]
pub struct Question<'a> {
    /// The lesson.
    pub lesson: &'a LessonRow,
    /// The scene at its start, with its current values.
    pub scene: &'a Scene,
    /// Its settings.
    pub settings: Settings,
}

/// The grade on an answer.
#[derive(Clone, Debug, PartialEq)]
pub enum Grade {
    /// It is right: the number of msd, with its unit.
    Right(String),
    /// It is wrong, for this reason.
    Wrong(String),
}

impl Question<'_> {
    /// Computes the right answer.
    ///
    /// # Errors
    /// A line on why the scene has no such number.
    pub fn answer(&self) -> Result<f64, String> {
        self.number(self.lesson.answer)
    }

    /// Computes the wrong answers that the lesson knows.
    ///
    /// # Errors
    /// As [`Question::answer`].
    pub fn wrong_answers(&self) -> Result<Vec<f64>, String> {
        // Each number once: it may take a run.
        let mut known: Vec<(Answer, f64)> = Vec::new();
        let mut number = |answer: Answer| match known.iter().find(|(of, _)| *of == answer) {
            Some(&(_, number)) => Ok(number),
            None => self.number(answer).inspect(|&number| known.push((answer, number))),
        };
        let wrong = |row: &MistakeRow| {
            let power = number(row.answer.unwrap_or(self.lesson.answer))?;
            let power = power.powf(row.power.unwrap_or(1.0));
            Ok(row.times.unwrap_or(1.0) * power + row.plus.unwrap_or(0.0))
        };
        self.lesson.mistakes.iter().map(wrong).collect()
    }

    /// Checks an answer.
    ///
    /// # Errors
    /// As [`Question::answer`].
    pub fn check(&self, given: f64) -> Result<Grade, String> {
        let LessonRow { tolerance, answer, .. } = *self.lesson;
        let right = self.answer()?;
        let is_near = |number: f64| {
            let size = if number == 0.0 { right } else { number };
            (given - number).abs() <= tolerance * size.abs()
        };
        if is_near(right) {
            let text = format!("{} {}", rounded(right, 3), answer.unit());
            return Ok(Grade::Right(text.trim_end().to_owned()));
        }
        let wrong = self.wrong_answers()?;
        let known =
            wrong.into_iter().zip(&self.lesson.mistakes).find(|(number, _)| is_near(*number));
        let reason = match known {
            Some((_, row)) => &row.says,
            None if is_near(-right) => "The sign is wrong.",
            None if [1e-6, 1e-3, 1e3, 1e6].iter().any(|factor| is_near(factor * right)) => {
                "A power of ten is wrong: check the units."
            }
            None if given.abs() < right.abs() => "It is too small.",
            None => "It is too large.",
        };
        Ok(Grade::Wrong(reason.to_owned()))
    }

    /// Computes a number of the scene.
    fn number(&self, answer: Answer) -> Result<f64, String> {
        let start = || self.simulation(self.settings);
        let found = match answer {
            Answer::Frequency => self.slowest()?.0 / TAU,
            Answer::DampingRatio => self.slowest()?.1,
            Answer::StableSubstep => start()?.stable_substep(),
            Answer::EnergyGrowth => {
                let energy = |simulation: &Simulation<f64>| simulation.energy().mechanical();
                energy(&self.run(self.settings)?) / energy(&start()?)
            }
            Answer::Error => self.error(self.settings)?,
            Answer::ErrorRatio => {
                let substeps = self.settings.substeps.saturating_mul(2);
                self.error(self.settings)? / self.error(Settings { substeps, ..self.settings })?
            }
            Answer::Order => self.number(Answer::ErrorRatio)?.log2(),
            Answer::Sag => self.sags()?.last().copied().unwrap_or_default(),
            Answer::SagLimit => match self.sags()?[..] {
                // With a difference that shrinks by a constant factor.
                [.., a, b, c] => c - (c - b) * (c - b) / ((c - b) - (b - a)),
                _ => return Err("this lesson needs three bodies".into()),
            },
            Answer::CriticalFriction => self.slope()?.tan(),
            Answer::SlopeSine => self.slope()?.sin(),
            Answer::Slope => self.slope()?,
        };
        let is_known = found.is_finite();
        is_known.then_some(found).ok_or_else(|| "this scene has no such number".into())
    }

    fn simulation(&self, settings: Settings) -> Result<Simulation<f64>, String> {
        Simulation::new(self.scene, settings).map_err(words)
    }

    /// The angular frequency of the slowest motion that something resists, radians per second, and
    /// its damping ratio.
    fn slowest(&self) -> Result<(f64, f64), String> {
        let modes = self.simulation(self.settings)?.slowest_modes(1);
        let mode = modes.first().ok_or("nothing in this scene oscillates")?;
        let frequency = mode.stiffness.sqrt();
        Ok((frequency, 0.5 * mode.damping / frequency))
    }

    /// The scene at the end of a run.
    fn run(&self, settings: Settings) -> Result<Simulation<f64>, String> {
        let mut simulation = self.simulation(settings)?;
        let steps = (self.lesson.time.unwrap_or(1.0) / settings.step).round();
        let work = steps * (self.scene.particles.len() + self.scene.springs.len()) as f64;
        if MOST_WORK < work * f64::from(settings.substeps) {
            return Err("the run of this lesson takes too long".into());
        }
        simulation.set_most_evaluations((MOST_WORK / work) as u64);
        for _ in 0..steps as u64 {
            simulation.step().map_err(words)?;
        }
        Ok(simulation)
    }

    /// The largest distance of a particle from its exact place at the end of a run, metres.
    fn error(&self, settings: Settings) -> Result<f64, String> {
        let integrator = Integrator::DormandPrince;
        let exact = Settings { integrator, tolerance: EXACT, substeps: 1, ..settings };
        let (run, exact) = (self.run(settings)?, self.run(exact)?);
        let distances = run.positions().zip(exact.positions()).map(|(a, b)| (a - b).length());
        Ok(distances.fold(0.0, f64::max))
    }

    /// The distance by which the lowest point of each body sinks in a run, metres.
    fn sags(&self) -> Result<Vec<f64>, String> {
        let start: Vec<DVec3> = self.scene.particles.iter().map(|row| row.position).collect();
        let end: Vec<DVec3> = self.run(self.settings)?.positions().collect();
        let lowest = |all: &[DVec3]| all.iter().map(|at| at.y).fold(f64::INFINITY, f64::min);
        let bodies = self.scene.bodies.iter().map(|body| body.particles.clone());
        Ok(bodies.map(|rows| lowest(&start[rows.clone()]) - lowest(&end[rows])).collect())
    }

    /// The slope of the first plane, radians.
    fn slope(&self) -> Result<f64, String> {
        let &Plane { normal, .. } = self.scene.planes.first().ok_or("this scene has no plane")?;
        Ok(normal.angle_between(-self.scene.world.gravity))
    }
}

fn words(error: Error) -> String {
    format!("the run of this lesson fails: {error}")
}

/// Reads a number that a person typed, with or without the unit, with a point or a comma.
///
/// # Errors
/// A line on what to type.
pub fn read_number(text: &str, unit: &str) -> Result<f64, String> {
    let text = text.trim();
    let text = text.strip_suffix(unit).unwrap_or(text).trim_end().replace(',', ".");
    let number = text.parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| format!("Type a number, such as 1.5 {unit}").trim_end().to_owned())
}
