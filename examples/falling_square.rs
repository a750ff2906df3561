//! A picture, falling_square.svg: five moments of the 4x4 square, springs green to red by strain.

use msd::core::Vector;
use msd::run::{Runner, on};
use msd::scene::open;
use msd_render::strain_colour;
use plotters::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = std::env::args().nth(1).unwrap_or_else(|| "falling_square.svg".into());
    let square = open("square")?;
    let mut runner = Runner::open(&square)?;
    let figure = SVGBackend::new(&file, (1250, 420)).into_drawing_area();
    figure.fill(&WHITE)?;
    for (moment, panel) in figure.split_evenly((1, 5)).iter().enumerate() {
        let time = 0.4 * moment as f64;
        while runner.time() < time {
            runner.step()?;
        }
        let mut chart = ChartBuilder::on(panel)
            .caption(format!("{time:.1} s"), ("sans-serif", 18))
            .margin(8)
            .build_cartesian_2d(-3.5..3.5, -6.0..6.0)?;
        let floor = square.scene.planes[0].offset;
        chart.draw_series(LineSeries::new([(-3.5, floor), (3.5, floor)], BLACK))?;
        for (ends, strain) in on!(&runner, simulation => springs(simulation)) {
            let [r, g, b] = strain_colour(strain as f32, 0.2).map(|c| (c * 255.0) as u8);
            chart.draw_series(LineSeries::new(ends, RGBColor(r, g, b).stroke_width(3)))?;
        }
    }
    figure.present()?;
    println!("wrote {file}");
    Ok(())
}

/// The two ends of each spring in the plane of the picture, and its strain.
fn springs<R: msd::core::Real>(
    simulation: &msd::core::Simulation<R>,
) -> Vec<([(f64, f64); 2], f64)> {
    let place = |end: u32| {
        let position = simulation.position(end as usize).to_f64();
        (position.x, position.y)
    };
    let ends = simulation.model().ends().iter().enumerate();
    ends.map(|(spring, ends)| (ends.map(place), simulation.strain(spring))).collect()
}
