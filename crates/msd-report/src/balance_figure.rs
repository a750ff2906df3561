//! The figure of the balance: the errors of space, time and precision as bars.

use crate::figure::relative;
use crate::pen::{Axis, Drawn, Pen, Type, WIDTH};
use crate::{ink, units};
use msd_study::Study;
use msd_study::space::ErrorBalance;
use plotters::prelude::DrawingBackend;

/// Height of the figure, pixels of a page [`WIDTH`] wide.
pub const HEIGHT: f64 = 190.0;
/// Left, top, right and bottom of the ground, pixels.
const GROUND: [f64; 4] = [90.0, 12.0, WIDTH - 150.0, HEIGHT - 44.0];
/// Decades below the largest error that are shown: smaller errors are negligible beside it.
const DECADES: f64 = 9.0;

/// Draws the errors as parts of the size of the scene, on a log scale; a mark is where the remedy
/// brings them.
///
/// # Errors
/// The error of the surface.
pub fn errors_side_by_side<DB: DrawingBackend>(
    study: &Study,
    balance: &ErrorBalance,
    surface: DB,
) -> Drawn<DB> {
    let pen = Pen::new(surface, ink::PAPER.light)?;
    let [left, top, right, bottom] = GROUND;
    let shares = balance.shares();
    let part = |error: f64| relative(study, error);
    let errors = shares.iter().filter_map(|(_, share)| *share).map(|share| part(share.error));
    let largest = errors.filter(|error| error.is_finite()).fold(1e-15, f64::max);
    let most = 10f64.powf(largest.log10().ceil());
    let axis =
        Axis { values: (most / 10f64.powf(DECADES), most), pixels: (left, right), log: true };
    for tick in axis.decades(6) {
        let x = axis.at(tick.value());
        pen.line(&[(x, top), (x, bottom)], ink::GRID.light, 1.0)?;
        let style = Type::new(12.0, ink::MUTED.light).centred();
        pen.words(&tick.percent(), (x, bottom + 14.0), style)?;
    }
    let stride = (bottom - top) / shares.len() as f64;
    for (row, (name, share)) in shares.into_iter().enumerate() {
        let middle = top + (row as f64 + 0.5) * stride;
        pen.words(name, (left - 10.0, middle), Type::new(13.0, ink::TEXT.light).ending())?;
        let style = Type::new(12.5, ink::TEXT.light);
        let Some(share) = share else {
            pen.words("not known", (left + 8.0, middle), style)?;
            continue;
        };
        let (end, half) = (axis.at(part(share.error)), 0.3 * stride);
        pen.block((left, middle - half), (end, middle + half), ink::GUIDE.light)?;
        if !share.remedy.is_empty() && share.left.is_finite() {
            let x = axis.at(part(share.left));
            pen.line(&[(x, middle - half), (x, middle + half)], ink::TEXT.light, 2.0)?;
        }
        let below = if share.is_bound { "below " } else { "" };
        let said = format!("{below}{}", units::quantity(share.error, "m"));
        pen.words(&said, (end + 8.0, middle), style)?;
    }
    let title = Type::new(13.0, ink::TEXT.light).centred();
    pen.words("Error, of the size of the scene", (0.5 * (left + right), bottom + 33.0), title)?;
    pen.finish()
}
