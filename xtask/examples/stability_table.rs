//! A plot, stability_table.svg: the greatest stiffness of a cloth by steps per frame, for Euler and
//! Runge-Kutta, undamped and damped. Beside it are the values that the report of 2014 found for its
//! own cloth.

use msd_core::Integrator;
use plotters::prelude::*;
use xtask::stability_table::{Scheme, euler_steps, stability_table};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = std::env::args().nth(1).unwrap_or_else(|| "stability_table.svg".into());
    let scene = msd_scene::open("cloth")?.scene;
    let table = stability_table(&scene, euler_steps(&scene)?)?;
    print!("{}", table.text());

    let figure = SVGBackend::new(&file, (900, 560)).into_drawing_area();
    figure.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&figure)
        .caption("Stiffness borne, over that of undamped Euler at 4 steps", ("sans-serif", 22))
        .margin(12)
        .x_label_area_size(40)
        .y_label_area_size(60)
        .build_cartesian_2d((3.0..60.0).log_scale(), (0.3..600.0).log_scale())?;
    chart.configure_mesh().x_desc("steps per frame of 1/60 s").y_desc("stiffness").draw()?;

    let euler = Scheme::Ours(Integrator::SymplecticEuler);
    let schemes = [
        (euler, BLUE, "symplectic Euler", 1.0),
        (Scheme::Ours(Integrator::Rk4), RED, "RK4", 2.0),
        (Scheme::Rk1331, MAGENTA, "Runge-Kutta weighed 1, 3, 3, 1", 1.75),
    ];
    let unit = table.undamped(euler, 4).and_then(|row| row.observed).ok_or("no limit found")?;
    for (scheme, colour, name, height) in schemes {
        let theory = [3.0, 60.0].map(|steps: f64| (steps, height * (steps / 4.0).powi(2)));
        let line = chart.draw_series(LineSeries::new(theory, colour.mix(0.5)))?;
        line.label(format!("{name}, theory"))
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], colour));
        for row in table.rows.iter().filter(|row| row.method == scheme) {
            let Some(observed) = row.observed else { continue };
            let at = (f64::from(row.steps), observed / unit);
            let style = if row.damping == 0.0 { colour.filled() } else { colour.stroke_width(1) };
            chart.draw_series([Circle::new(at, 5, style)])?;
        }
    }
    let report = table.rows.iter().filter_map(|row| Some((row.steps, row.report?)));
    let crosses = report.map(|(steps, found)| {
        // In units of the stiffness that the report's own Euler bore at 4 steps.
        Cross::new((f64::from(steps), found / 5550.0), 6, BLACK.stroke_width(2))
    });
    chart
        .draw_series(crosses)?
        .label("the source report (ours: discs undamped, circles damped)")
        .legend(|(x, y)| Cross::new((x + 8, y), 5, BLACK.stroke_width(2)));
    chart.configure_series_labels().position(SeriesLabelPosition::LowerRight).draw()?;
    figure.present()?;
    println!("wrote {file}");
    Ok(())
}
