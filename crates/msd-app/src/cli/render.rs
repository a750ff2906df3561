//! `msd render`: a scene becomes a picture without a display.

use super::arguments::RenderArguments;
use super::failure::{Failure, say};
use super::places::Places;
use super::run::explain_divergence;
use super::run::prepare::{Prepared, prepare};
use msd_app::drivers::quietly;
use msd_app::viewer::shows_springs;
use msd_render::{Gpu, Image, Offscreen, RenderError, Style, View, bounds};
use msd_run::on;
use msd_scene::{Output, shown_path};
use msd_study::quantity::quantity;
use std::path::PathBuf;

/// Runs a scene for a while and draws it.
pub fn render(arguments: &RenderArguments) -> Result<(), Failure> {
    let RenderArguments { scene, solver, time, .. } = arguments;
    let mut prepared = prepare((scene, &arguments.set), solver, ("--time", *time))?;
    let path = arguments.out.clone();
    let path = path.unwrap_or_else(|| PathBuf::from(format!("{}.png", prepared.name)));
    if !path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png")) {
        let path = shown_path(&path);
        return Err(Failure::input(format!(
            "{path}: pictures are written as PNG; end the name in .png"
        )));
    }
    let mut places = Places::default();
    prepared.files.iter().for_each(|file| places.read("SCENE", file));
    solver.from.iter().for_each(|state| places.read("--from", state));
    places.write("--out", &path)?;
    let mut output = Output::create(&path).map_err(Failure::input)?;
    // Asked for before the run: without a driver, or for a picture that is too large for it, the
    // steps would be in vain.
    let gpu = quietly(|| pollster::block_on(Gpu::headless())).map_err(Failure::input)?;
    let [width, height] = arguments.size;
    let mut screen = Offscreen::new(&gpu, width, height).map_err(Failure::input)?;
    for _ in 0..prepared.steps {
        let stepped = prepared.runner.step();
        let advice = prepared.is_advised.then_some("");
        stepped.map_err(|error| explain_divergence(&prepared.name, error, advice))?;
    }
    let image = draw(&mut screen, &prepared, arguments).map_err(Failure::input)?;
    let Image { width, height, rgba } = image;
    write_png(&mut output, [width, height], &rgba)
        .map_err(|error| Failure::input(format!("{}: {error}", shown_path(&path))))?;
    output.finish().map_err(Failure::input)?;
    let (name, time) = (&prepared.name, quantity(prepared.runner.time(), "s"));
    let path = shown_path(&path);
    say(&format!("{path}: {name} after {time}, {width}x{height} pixels"))
}

/// Writes rows of pixels, red, green, blue and opacity.
fn write_png(
    output: &mut Output,
    [width, height]: [u32; 2],
    rgba: &[u8],
) -> Result<(), png::EncodingError> {
    let mut encoder = png::Encoder::new(output, width, height);
    encoder.set_color(png::ColorType::Rgba);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(rgba)?;
    writer.finish()
}

fn draw(
    screen: &mut Offscreen,
    prepared: &Prepared,
    arguments: &RenderArguments,
) -> Result<Image, RenderError> {
    let [width, height] = arguments.size;
    let mut view = View {
        style: Style {
            surfaces: !arguments.no_surfaces,
            wireframe: arguments.wireframe,
            springs: arguments.springs || shows_springs(&prepared.name),
            particles: arguments.particles,
            ..Style::default()
        },
        ..View::default()
    };
    let radians = |degrees: f64| degrees.to_radians() as f32;
    view.camera.yaw = arguments.yaw_deg.map_or(view.camera.yaw, radians);
    view.camera.pitch = arguments.pitch_deg.map_or(view.camera.pitch, radians);
    on!(&prepared.runner, simulation => {
        let snapshot = simulation.snapshot();
        if let Some(bounds) = bounds(&snapshot) {
            view.camera.frame(bounds, width as f32 / height as f32);
        }
        screen.render(&snapshot, &view)
    })
}
