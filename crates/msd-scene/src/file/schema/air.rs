//! Rows of the air that acts on surfaces.

use crate::file::keys::{Domain, LENGTH, rows};

rows! {
    /// The air that acts on surfaces.
    AirRow {
        /// Density of the air.
        density: Option<f64> = "1.2" { unit: "kg/m³", domain: Domain::NotNegative },
        /// Velocity of the mean wind.
        velocity: Option<[f64; 3]> = "`[0, 0, 0]`" { unit: "m/s", domain: Domain::Vector },
        /// Drag coefficient C_d of a sheet that faces the wind.
        drag: Option<f64> = "1.2, that of a square plate" { domain: Domain::NotNegative },
        /// Lift coefficient C_l, at most `drag`. A sheet edge-on to the wind has the drag
        /// coefficient C_d − C_l.
        lift: Option<f64> = "0.98 times `drag`" { domain: Domain::NotNegative },
        /// Gusts in addition to the mean wind.
        gust: Option<GustRow> = "none",
    }

    /// Gusts: a random velocity of the air, smooth in space and time.
    GustRow {
        /// Root mean square of the velocity of the gusts.
        strength: Option<f64> = "1" { unit: "m/s", domain: Domain::NotNegative },
        /// Length of a gust.
        length: Option<f64> = "1" { unit: "m", domain: LENGTH },
        /// Time scale of the gusts.
        time: Option<f64> = "1" { unit: "s", domain: LENGTH },
        /// Seed of the gusts.
        seed: Option<u32> = "0" { domain: Domain::Words("whole, from 0 to 4294967295") },
    }
}
