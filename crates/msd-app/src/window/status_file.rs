//! The status file: the state of each frame, a line of JSON, for tests that control the window from
//! outside.
//!
//! Positions are in pixels of the window. Keys: `frame`, `scene`, `time`, `steps`, `paused`,
//! `speed`, `real_time_factor`, `step_ms`, `frame_rate` (null before they are measured),
//! `stability` (the substep relative to the longest stable one, or null), `failed` (whether the run
//! stopped by itself), `offers` (number of recovery options), `held` (particle or null),
//! `held_solid`, `held_position`, `held_target`, `held_screen`, `selected`, `pinned` (whether the
//! selected particle is), `pins` (their number), `hovered`, `springs` (their number), `note`,
//! `error` (the last estimate of the error or null: `at`, `over`, `rms`, `worst`, `worst_error`),
//! `aim` (a visible particle: `particle`, `screen`), `stiffness`, `wind` (N on a particle), `force`
//! (the current one on each particle, N), `trade` (null while it is off or waits: number of
//! `measured` settings, cost of the `cheapest` in s/s, `now`, `done`, `failure`, measured `parts`,
//! `search`), `solver` (`integrator`, `substeps` or null until they are chosen, `automatic`,
//! `precision`), `gpu` (null, or numbers of its `steps` and of the `checked` ones, and the number
//! `left` to the processor), `refusal` (the last one, or null), `elastic` (energy, J, or null),
//! `past` (`back` and `ahead`: number of earlier and later states; `undo` and `redo`: their next
//! edits, or null), `recording` (its file or null), `twin` (null, or its root mean square distance,
//! m), `gallery` (null, or number of rendered thumbnails), `solids` (positions of their centres),
//! `findings` (sentences), `crossings` (intersecting pairs of triangles, or null), `contacts` (with
//! obstacles, since the start),
//! `full_screen`, `focus` (whether a control has the focus), `group` and `grabs` (numbers of
//! particles in the group, and grabbed), `guide` (completed steps of the tour, or null),
//! `wireframe`, `camera` (`yaw`, `pitch`, `distance`, `target`), `filming` (null, or number of
//! written frames), `pixels_per_point`, `view` and `landmarks` (rectangles: left, top, width,
//! height).

use crate::session::{Deed, ErrorNow, Search, Session};
use crate::viewer::{Guide, Viewer};
use egui::{Pos2, Rect};
use glam::Vec3;
use msd_core::Vector;
use msd_core::obstacles::Placed;
use msd_render::Camera;
use msd_run::{Finding, on};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Reports the state of a frame; `scale` is the pixels per point.
pub(crate) fn report(viewer: &Viewer, scale: f32, frame: u64) -> Value {
    let session = &viewer.session;
    let (pace, held) = (session.pace(), session.held());
    let position = |particle: usize| session.position(particle);
    let screen = |point: Vec3| viewer.viewport().project(point).map(|at| pixels(at, scale));
    let mut report = json!({
        "frame": frame,
        "scene": session.loaded().name,
        "time": session.runner().time(),
        "steps": session.runner().steps(),
        "paused": session.is_paused(),
        "speed": session.speed(),
        "real_time_factor": pace.map(|pace| pace.real_time_factor),
        "step_ms": pace.map(|pace| pace.step_ms),
        "frame_rate": pace.map(|pace| pace.frame_rate),
        "stability": session.stability().map(|(share, _)| share),
        "failed": session.failure().is_some(),
        "offers": session.offers().len(),
        "held": held,
        "held_solid": session.held_solid(),
        "held_position": held.map(|particle| position(particle).to_array()),
        "held_target": session.grab_target().map(|target| target.to_array()),
        "held_screen": held.and_then(|particle| screen(position(particle).as_vec3())),
        "selected": session.selected(),
        "pinned": session.selected().map(|particle| session.is_pinned(particle)),
        "pins": (0..session.runner().particle_count()).filter(|&at| session.is_pinned(at)).count(),
        "hovered": viewer.hand.hovered,
        "springs": session.runner().spring_count(),
        "note": viewer.note,
        "error": error(session.error()),
        "aim": aim(viewer).map(|(particle, at)| {
            json!({ "particle": particle, "screen": pixels(at, scale) })
        }),
        "stiffness": session.material().values().stiffness.map(|value| value.first),
        "wind": session.wind().strength,
        "force": on!(session.runner(), run => run.model().force().to_f64().to_array()),
        "trade": trade(session),
        "solver": solver(session),
    });
    // A single `json!` would exceed the recursion limit of macros.
    let more = report_of_view(viewer, scale);
    if let (Value::Object(report), Value::Object(more)) = (&mut report, more) {
        report.extend(more);
    }
    report
}

/// Reports the rest of the state: past, tools, view.
fn report_of_view(viewer: &Viewer, scale: f32) -> Value {
    let session = &viewer.session;
    let landmarks: BTreeMap<_, _> =
        viewer.layout.landmarks.iter().map(|(name, rect)| (name, area(*rect, scale))).collect();
    json!({
        "gpu": session.device().map(|device| {
            let tally = device.tally();
            json!({ "steps": tally.device, "checked": tally.checked, "left": tally.processor })
        }),
        "refusal": session.refusal(),
        "elastic": session.energy().map(|energy| energy.elastic),
        "past": past(session),
        "recording": session.recording(),
        "twin": session.twin().map(|twin| twin.apart().rms),
        "gallery": viewer.layout.gallery.as_ref().map(|gallery| {
            gallery.pictures.iter().filter(|picture| picture.texture.is_some()).count()
        }),
        "filming": filming(viewer),
        "solids": solids(viewer).map(|at| at.map(|at| pixels(at, scale))).collect::<Vec<_>>(),
        "findings": session.findings().iter().map(Finding::sentence).collect::<Vec<_>>(),
        "crossings": session.crossings(),
        "contacts": session.runner().contacts().count,
        "full_screen": viewer.wishes.full_screen,
        "group": session.group().len(),
        "grabs": on!(session.runner(), simulation => simulation.model().grabs().len()),
        "guide": viewer.layout.guide.as_ref().map(Guide::done),
        "wireframe": viewer.style.wireframe,
        "camera": camera(&viewer.camera),
        "pixels_per_point": scale,
        "view": area(viewer.layout.rect, scale),
        "landmarks": landmarks,
    })
}

/// Returns the positions of the centres of the solids on the screen.
fn solids(viewer: &Viewer) -> impl Iterator<Item = Option<Pos2>> + '_ {
    let runner = viewer.session.runner();
    let (solids, time) = on!(runner, run => (run.model().solids(), run.time()));
    let middles = solids.iter().map(move |solid| Placed::new(solid, time).middle.as_vec3());
    middles.map(|middle| viewer.viewport().project(middle))
}

#[cfg(not(target_arch = "wasm32"))]
fn filming(viewer: &Viewer) -> Option<usize> {
    viewer.filming.as_ref().map(|filming| filming.progress()[0])
}

/// A browser does not make films.
#[cfg(target_arch = "wasm32")]
fn filming(_: &Viewer) -> Option<usize> {
    None
}

/// Reports the trade-off, if it is open.
fn trade(session: &Session) -> Option<Value> {
    let report = session.study().filter(|_| session.trade().is_on())?;
    let parts = session.terms();
    let costs = report.found.as_ref().map(|study| study.trials.iter().map(|trial| trial.cost));
    Some(json!({
        "measured": report.found.as_ref().map_or(0, |study| study.trials.len()),
        "cheapest": costs.and_then(|costs| costs.reduce(f64::min)),
        "now": report.progress.as_ref().map(|progress| &progress.now),
        "done": report.idle,
        "failure": report.failure,
        "parts": parts.and_then(|report| report.found.as_ref().map(|rows| rows.len())),
        "search": session.searched().map(Search::words),
    }))
}

/// Reports the history and undo.
fn past(session: &Session) -> Value {
    json!({
        "back": session.steps_back(),
        "ahead": session.steps_ahead(),
        "undo": session.undoes().map(Deed::words),
        "redo": session.redoes().map(Deed::words),
    })
}

fn camera(camera: &Camera) -> Value {
    json!({
        "yaw": camera.yaw,
        "pitch": camera.pitch,
        "distance": camera.distance,
        "target": camera.target.to_array(),
    })
}

/// Reports the solver.
fn solver(session: &Session) -> Value {
    let (runner, settings) = (session.runner(), session.runner().settings());
    json!({
        "integrator": settings.integrator.name(),
        "substeps": (!runner.is_open()).then_some(settings.substeps),
        "automatic": runner.is_automatic(),
        "precision": runner.precision().name(),
    })
}

fn error(now: Option<ErrorNow<'_>>) -> Value {
    let Some(ErrorNow::Known(reading)) = now else { return Value::Null };
    let (error, (particle, worst)) = (&reading.error, reading.worst);
    json!({
        "at": error.at,
        "over": error.over,
        "rms": error.rms,
        "worst": particle,
        "worst_error": worst,
    })
}

fn pixels(at: Pos2, scale: f32) -> [f32; 2] {
    [at.x * scale, at.y * scale]
}

fn area(rect: Rect, scale: f32) -> [f32; 4] {
    [rect.left(), rect.top(), rect.width(), rect.height()].map(|side| side * scale)
}

/// Returns the particle nearest to the camera of those in front of it, and its position on the
/// screen.
fn aim(viewer: &Viewer) -> Option<(usize, Pos2)> {
    let depth = |point: Vec3| viewer.camera.depth(point);
    let viewport = viewer.viewport();
    on!(viewer.session.runner(), simulation => {
        let points = simulation.positions().map(|position| position.to_f32()).enumerate();
        let seen =
            points.filter_map(|(at, point)| Some((depth(point), at, viewport.project(point)?)));
        let nearest = seen.min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.map(|(_, particle, place)| (particle, place))
    })
}
