//! A plot, chain.svg: five particles on a line, one pulled out by 1.4, and the wave it sends.

use msd::run::Runner;
use msd::scene::open;
use plotters::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = std::env::args().nth(1).unwrap_or_else(|| "chain.svg".into());
    let chain = open("chain")?;
    let mut runner = Runner::new(&chain.scene, chain.settings, chain.precision)?;
    let mut rows: Vec<(f64, Vec<f64>)> = Vec::new();
    while runner.time() <= 25.0 {
        rows.push((runner.time(), along(&runner)));
        runner.step()?;
    }

    let figure = SVGBackend::new(&file, (900, 500)).into_drawing_area();
    figure.fill(&WHITE)?;
    let lowest = rows.iter().flat_map(|(_, x)| x).copied().fold(f64::MAX, f64::min);
    let highest = rows.iter().flat_map(|(_, x)| x).copied().fold(f64::MIN, f64::max);
    let mut chart = ChartBuilder::on(&figure)
        .caption("A wave runs through a damped chain", ("sans-serif", 22))
        .margin(12)
        .x_label_area_size(40)
        .y_label_area_size(50)
        .build_cartesian_2d(0.0..25.0, lowest - 0.3..highest + 0.3)?;
    chart.configure_mesh().x_desc("time, s").y_desc("position, m").draw()?;
    for particle in 0..runner.particle_count() {
        let colour = Palette99::pick(particle).stroke_width(2);
        let line = rows.iter().map(|(time, x)| (*time, x[particle]));
        chart.draw_series(LineSeries::new(line, colour))?;
    }
    figure.present()?;
    println!("wrote {file}");
    Ok(())
}

/// Positions along the chain, metres.
fn along(runner: &Runner) -> Vec<f64> {
    use msd::core::Vector;
    msd::run::on!(runner, simulation => {
        simulation.positions().map(|position| position.to_f64().x).collect()
    })
}
