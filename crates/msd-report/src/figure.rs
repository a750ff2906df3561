//! The work-precision diagram of a study: error against processor time.

use crate::ink::{self, Ink};
use crate::labels::{self, Name, Obstacles};
use crate::pen::{Axis, Drawn, Pen, Point, Type, WIDTH};
use crate::{raster, units};
use msd_core::Integrator;
use msd_scene::Precision;
use msd_study::Study;
use msd_study::choice::{Choice, FRAME, Fineness};
use msd_study::trial::Trial;
use plotters::prelude::DrawingBackend;

/// Height of the work-precision diagram, pixels of a page [`WIDTH`] wide.
pub const HEIGHT: f64 = 612.0;
/// Left, top, right and bottom of the ground of the diagram, pixels.
const GROUND: [f64; 4] = [70.0, 104.0, WIDTH - 66.0, HEIGHT - 48.0];
/// Height of the band above the ground for trials that left the world, pixels.
const BAND: f64 = 24.0;
/// The greatest error shown, sizes of the object: a worse result is useless.
const WORST: f64 = 10.0;
/// The least error shown, sizes of the object: double precision rounds there.
const LEAST: f64 = 1e-17;

/// Ratio of the uncertainty of the reference to the lowest error of the diagram.
const DEEP: f64 = 30.0;

/// Place of a trial in a diagram.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// Its row in the study.
    pub row: usize,
    /// Its place, pixels of a page [`WIDTH`] wide.
    pub at: Point,
    /// Whether it is in the band of those that left the world or are off the scale.
    pub lost: bool,
}

struct Diagram<'a> {
    study: &'a Study,
    cost: Axis,
    error: Axis,
    spots: Vec<Spot>,
}

/// Draws error against processor time per simulated second and returns the places of the trials.
///
/// # Errors
/// The error of the surface.
pub fn work_precision<DB: DrawingBackend>(study: &Study, surface: DB) -> Drawn<DB, Vec<Spot>> {
    let pen = Pen::new(surface, ink::PAPER.light)?;
    let diagram = Diagram::new(study);
    diagram.draw_ground(&pen)?;
    diagram.draw_axes(&pen)?;
    pen.line(&diagram.steps(), ink::FRONT.light, 5.0)?;
    diagram.draw_guides(&pen)?;
    for integrator in Integrator::ALL {
        diagram.draw_method(&pen, integrator)?;
    }
    diagram.draw_lost(&pen)?;
    diagram.draw_names(&pen)?;
    diagram.draw_head(&pen)?;
    pen.finish()?;
    Ok(diagram.spots)
}

/// An error as a fraction of the size of the scene, or in metres where the scene has none.
pub fn relative(study: &Study, error: f64) -> f64 {
    if 0.0 < study.size && study.size.is_finite() { error / study.size } else { error }
}

/// Fineness of a choice, coarse first.
pub fn fineness(choice: &Choice) -> f64 {
    match choice.fineness {
        Fineness::Substeps(substeps) => f64::from(substeps),
        Fineness::Tolerance(tolerance) => -tolerance,
    }
}

/// Least and greatest of the positive finite values.
fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let sound = values.filter(|value| 0.0 < *value && value.is_finite());
    sound.fold(None, |range, value| {
        let (least, greatest) = range.unwrap_or((value, value));
        Some((value.min(least), value.max(greatest)))
    })
}

impl<'a> Diagram<'a> {
    fn new(study: &'a Study) -> Self {
        let [left, top, right, bottom] = GROUND;
        let sound = || study.trials.iter().filter(|trial| trial.errors.is_some());
        let error = |trial: &Trial| relative(study, trial.error());
        let costs = range(sound().map(|trial| trial.cost));
        let (mut least, mut greatest) = costs.unwrap_or((1e-3, 1.0));
        // Real time is shown where it is not far away, and named at the edge where it is.
        if 0.1 <= greatest && least <= 10.0 {
            (least, greatest) = (least.min(0.8), greatest.max(1.25));
        }
        let values = (least / 1.8, (greatest * 2.0).max(20.0 * least));
        let cost = Axis { values, pixels: (left, right), log: true };
        let shown = sound().map(error).filter(|&error| error <= WORST);
        let (mut least, mut greatest) = range(shown).unwrap_or((1e-6, 1e-1));
        // Far below its uncertainty the reference resolves nothing.
        let floor = relative(study, study.reference.uncertainty) / DEEP;
        least = least.max(floor.min(greatest));
        let wanted = relative(study, study.wanted);
        if least / 100.0 <= wanted && wanted <= greatest * 100.0 {
            (least, greatest) = (least.min(wanted), greatest.max(wanted));
        }
        let values = ((least / 3.0).max(LEAST), (greatest * 2.0).max(30.0 * least).max(1e-15));
        let error_axis = Axis { values, pixels: (bottom, top), log: true };
        let spot = |(row, trial): (usize, &Trial)| {
            let lost = trial.errors.is_none() || error(trial).is_nan() || values.1 < error(trial);
            let y = if lost { top - 0.5 * BAND } else { error_axis.at(error(trial)) };
            Spot { row, at: (cost.at(trial.cost), y), lost }
        };
        let spots = study.trials.iter().enumerate().map(spot).collect();
        Diagram { study, cost, error: error_axis, spots }
    }

    fn any_lost(&self) -> bool {
        self.spots.iter().any(|spot| spot.lost)
    }

    /// The places of the trials of one method in one precision, coarse first.
    fn line(&self, integrator: Integrator, precision: Precision) -> Vec<Spot> {
        let choice = |spot: &Spot| self.study.trials[spot.row].choice;
        let ours = |spot: &&Spot| {
            let choice = choice(spot);
            !spot.lost && choice.integrator == integrator && choice.precision == precision
        };
        let mut line: Vec<Spot> = self.spots.iter().filter(ours).copied().collect();
        line.sort_by(|a, b| fineness(&choice(a)).total_cmp(&fineness(&choice(b))));
        line
    }

    fn draw_ground<DB: DrawingBackend>(&self, pen: &Pen<DB>) -> Drawn<DB> {
        let [left, top, right, bottom] = GROUND;
        let floor = relative(self.study, self.study.reference.uncertainty);
        if self.error.values.0 < floor {
            let y = self.error.at(floor);
            pen.block((left, y), (right, bottom), ink::SHADE.light)?;
            let said = format!(
                "below {} the reference itself is uncertain",
                units::quantity(self.study.reference.uncertainty, "m")
            );
            let at = (left + 8.0, (y + 11.0).min(bottom - 9.0));
            pen.words(&said, at, Type::new(11.5, ink::MUTED.light))?;
        }
        let below = |trial: &Trial| relative(self.study, trial.error()) < self.error.values.0;
        if self.study.trials.iter().any(below) {
            let at = (right - 8.0, bottom - 9.0);
            let style = Type::new(11.5, ink::MUTED.light);
            pen.words("on the lower edge: too accurate to tell", at, style.ending())?;
        }
        if self.any_lost() {
            pen.block((left, top - BAND), (right, top), ink::SHADE.light)?;
            let at = (left - 8.0, top - 0.5 * BAND);
            pen.words("diverged", at, Type::new(12.0, ink::MUTED.light).ending())?;
        }
        Ok(())
    }

    fn draw_axes<DB: DrawingBackend>(&self, pen: &Pen<DB>) -> Drawn<DB> {
        let [left, top, right, bottom] = GROUND;
        let (grid, style) = (ink::GRID.light, Type::new(12.0, ink::MUTED.light));
        for tick in self.error.decades(9) {
            let y = self.error.at(tick.value());
            pen.line(&[(left, y), (right, y)], grid, 1.0)?;
            pen.words(&tick.percent(), (left - 8.0, y), style.ending())?;
        }
        let metres = self.second(&self.error, relative(self.study, 1.0));
        for tick in metres.decades(9) {
            let y = metres.at(tick.value());
            pen.line(&[(right, y), (right + 4.0, y)], ink::GUIDE.light, 1.0)?;
            pen.words(&tick.with_unit("m"), (right + 8.0, y), style)?;
        }
        for tick in self.cost.decades(9) {
            let x = self.cost.at(tick.value());
            pen.line(&[(x, top), (x, bottom)], grid, 1.0)?;
            pen.words(&tick.with_unit("s"), (x, bottom + 14.0), style.centred())?;
        }
        let high = if self.any_lost() { top - BAND } else { top };
        let frames = self.second(&self.cost, 1.0 / FRAME);
        for tick in frames.decades(9) {
            let x = frames.at(tick.value());
            pen.line(&[(x, high - 4.0), (x, high)], ink::GUIDE.light, 1.0)?;
            pen.words(&tick.with_unit("s"), (x, high - 12.0), style.centred())?;
        }
        pen.line(&[(left, bottom), (right, bottom)], ink::GUIDE.light, 1.0)?;
        let title = Type::new(13.0, ink::TEXT.light);
        let said = "Processor time per simulated second";
        pen.words(said, (0.5 * (left + right), bottom + 36.0), title.centred())
    }

    /// The same axis read in another unit.
    fn second(&self, axis: &Axis, unit: f64) -> Axis {
        Axis { values: (axis.values.0 / unit, axis.values.1 / unit), ..*axis }
    }

    /// The steps of the Pareto front: no trial is both left of them and below them.
    fn steps(&self) -> Vec<Point> {
        let [_, top, right, _] = GROUND;
        let front = self.study.front();
        let on = front.iter().filter_map(|&row| self.spots.get(row)).filter(|spot| !spot.lost);
        let mut steps: Vec<Point> = Vec::new();
        for spot in on {
            let y = steps.last().map_or(top, |&(_, y)| y);
            steps.extend([(spot.at.0, y), spot.at]);
        }
        if let Some(&(_, y)) = steps.last() {
            steps.push((right, y));
        }
        steps
    }

    fn draw_guides<DB: DrawingBackend>(&self, pen: &Pen<DB>) -> Drawn<DB> {
        for guide in self.guides() {
            pen.dashes(guide, (5.0, 4.0), ink::GUIDE.light)?;
        }
        if self.cost.holds(1.0) {
            return Ok(());
        }
        // Real time is far away: it is said how far, and where.
        let [left, top, right, _] = GROUND;
        let style = Type::new(12.0, ink::MUTED.light);
        if self.cost.values.1 < 1.0 {
            let factor = units::number(1.0 / self.cost.values.1);
            let said = format!("real time is {factor}× further →");
            pen.words(&said, (right - 8.0, top + 12.0), style.ending())
        } else {
            let factor = units::number(self.cost.values.0);
            let said = format!("← real time is {factor}× further");
            pen.words(&said, (left + 8.0, top + 12.0), style)
        }
    }

    /// The lines of the wanted error and of real time, where they are on the ground.
    fn guides(&self) -> Vec<[Point; 2]> {
        let [left, top, right, bottom] = GROUND;
        let wanted = relative(self.study, self.study.wanted);
        let (x, y) = (self.cost.at(1.0), self.error.at(wanted));
        let across = self.error.holds(wanted).then_some([(left, y), (right, y)]);
        let upright = self.cost.holds(1.0).then_some([(x, top), (x, bottom)]);
        across.into_iter().chain(upright).collect()
    }

    /// Names of the guides, and the places where they may stand.
    fn guide_names(&self) -> Vec<(String, Type, Name)> {
        let style = Type::new(12.0, ink::MUTED.light);
        let named = |[from, to]: [Point; 2]| {
            let across = from.1 == to.1;
            let said = if across {
                format!("wanted: {}", units::quantity(self.study.wanted, "m"))
            } else {
                "real time".into()
            };
            let width = 1.2 * raster::width(&said, style.size);
            let at = |step: i32| {
                let part = f64::from(step) / 12.0;
                (from.0 + part * (to.0 - from.0), from.1 + part * (to.1 - from.1))
            };
            let name = Name { width, beside: (0..=12).map(at).collect() };
            (said, style, name)
        };
        self.guides().into_iter().map(named).collect()
    }

    fn draw_method<DB: DrawingBackend>(&self, pen: &Pen<DB>, integrator: Integrator) -> Drawn<DB> {
        let Ink { light: colour, .. } = ink::line(integrator);
        let front = self.study.front();
        for (precision, width) in [(Precision::F32, 1.0), (Precision::F64, 2.0)] {
            let line = self.line(integrator, precision);
            let points: Vec<Point> = line.iter().map(|spot| spot.at).collect();
            pen.line(&points, colour, width)?;
            let inside = if precision == Precision::F32 { ink::PAPER.light } else { colour };
            for spot in line {
                let radius = if front.contains(&spot.row) { 6.5 } else { 4.6 };
                pen.shape(&mark(integrator, spot.at, radius), colour, inside)?;
                if front.contains(&spot.row) {
                    pen.line(&ring(spot.at), ink::TEXT.light, 1.4)?;
                }
            }
        }
        Ok(())
    }

    /// Crosses out the trials that left the world or are off the scale.
    fn draw_lost<DB: DrawingBackend>(&self, pen: &Pen<DB>) -> Drawn<DB> {
        for spot in self.spots.iter().filter(|spot| spot.lost) {
            let integrator = self.study.trials[spot.row].choice.integrator;
            pen.cross(spot.at, ink::line(integrator).light)?;
        }
        Ok(())
    }

    /// Names the guides, and every method once, beside its line.
    fn draw_names<DB: DrawingBackend>(&self, pen: &Pen<DB>) -> Drawn<DB> {
        let [left, top, right, bottom] = GROUND;
        let mut obstacles = Obstacles { lines: self.guides(), marks: Vec::new() };
        obstacles.lines.extend(self.steps().windows(2).map(|ends| [ends[0], ends[1]]));
        let mut named = self.guide_names();
        for integrator in Integrator::ALL {
            let mut beside = Vec::new();
            for precision in [Precision::F64, Precision::F32] {
                let line = self.line(integrator, precision);
                let points: Vec<Point> = line.iter().map(|spot| spot.at).collect();
                obstacles.lines.extend(points.windows(2).map(|ends| [ends[0], ends[1]]));
                obstacles.marks.extend(&points);
                beside.extend(labels::ends_first(points));
            }
            if !beside.is_empty() {
                let said = integrator.name().to_owned();
                let style = Type::new(13.0, ink::name(integrator).light);
                // Letters of the reader's machine may be wider than ours.
                let width = 1.25 * raster::width(&said, style.size);
                named.push((said, Type { bold: true, ..style }, Name { width, beside }));
            }
        }
        let page = ((left + 4.0, top + 3.0), (right - 4.0, bottom - 3.0));
        let names: Vec<&Name> = named.iter().map(|(.., name)| name).collect();
        let places = labels::place(&names, &obstacles, page);
        for ((said, style, _), place) in named.iter().zip(places) {
            if let Some(at) = place {
                pen.words(said, at, *style)?;
            }
        }
        Ok(())
    }

    /// The title, the title of the upright axis, and the meanings of the marks.
    fn draw_head<DB: DrawingBackend>(&self, pen: &Pen<DB>) -> Drawn<DB> {
        let (title, text) = (Type::new(16.0, ink::TEXT.light), Type::new(13.0, ink::TEXT.light));
        let scene = raster::fitted(&self.study.scene, 16.0, 180.0);
        let said = format!("{scene}: what accuracy costs");
        pen.words(&said, (8.0, 16.0), Type { bold: true, ..title })?;
        let size = units::quantity(self.study.size, "m");
        let said = format!("Position error (RMS) as a fraction of the object’s size, {size}");
        pen.words(&said, (8.0, 44.0), text)?;
        let note = Type::new(12.0, ink::MUTED.light);
        let muted = ink::MUTED.light;
        let (x, y) = (WIDTH - 474.0, 16.0);
        let circle = |x: f64| mark(Integrator::VelocityVerlet, (x, y), 4.6);
        pen.shape(&circle(x), muted, ink::PAPER.light)?;
        pen.words("single precision", (x + 9.0, y), note)?;
        pen.shape(&circle(x + 118.0), muted, muted)?;
        pen.words("double precision", (x + 127.0, y), note)?;
        pen.line(&[(x + 240.0, y), (x + 272.0, y)], ink::FRONT.light, 5.0)?;
        pen.shape(&circle(x + 256.0), muted, muted)?;
        pen.line(&ring((x + 256.0, y)), ink::TEXT.light, 1.4)?;
        pen.words("Pareto front: the best trade-offs", (x + 280.0, y), note)?;
        let said = "Processor time per frame of 1/60 s";
        pen.words(said, (WIDTH - 8.0, 44.0), note.ending())
    }
}

/// The outline of a method's mark at a place.
fn mark(integrator: Integrator, (x, y): Point, radius: f64) -> Vec<Point> {
    let corners = ink::mark(integrator);
    corners.into_iter().map(|(dx, dy)| (x + radius * dx, y + radius * dy)).collect()
}

/// A closed circle about a mark of the front.
fn ring((x, y): Point) -> Vec<Point> {
    let angle = |corner: i32| std::f64::consts::TAU * f64::from(corner) / 32.0;
    let at = |corner| (x + 10.0 * libm::cos(angle(corner)), y + 10.0 * libm::sin(angle(corner)));
    (0..=32).map(at).collect()
}
