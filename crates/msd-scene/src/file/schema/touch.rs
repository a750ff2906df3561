//! Rows of how bodies meet.

use super::{BodyKey, MATERIAL_NAMES};
use crate::file::keys::{Domain, LENGTH, Scale, rows};

rows! {
    /// How a body meets itself and others.
    TouchRow {
        /// Thickness on each side of the surface, or around a rope or a particle, at most 0.4 of
        /// the spacing.
        thickness: Option<f64> = "a tenth of the spacing: here, the median length of each \
                                  particle's shortest spring"
            { unit: "m", domain: LENGTH, scale: Scale::LENGTH, instead_of: &["radius"] },
        /// Coulomb's coefficient of friction; for a pair, the root of the product.
        friction: Option<f64> = "0.5" { domain: Domain::Factor },
        /// Coefficient of restitution; for a pair, the larger one. A soft body bounces by its own
        /// springs and needs none.
        restitution: Option<f64> = "0" { domain: Domain::Fraction },
        /// Whether the body collides with itself.
        itself: Option<bool> = "`true`, but `false` for a block or a solid mesh",
        /// Whether the thickness also applies to obstacles. Otherwise they stop its particles as
        /// points.
        obstacles: Option<bool> = "`false`",
        /// Bodies that it passes through, by name or number.
        ignore: Vec<BodyKey> = "none" { domain: Domain::Words("list of names or numbers") },
        /// Values for contact with certain bodies or materials: see [`with`](#with-of-touch).
        with: Vec<WithRow> = "none",
        /// Obsolete: read as `thickness`, at most 0.4 of the spacing, with a note.
        radius: Option<f64> = "none" { unit: "m", domain: LENGTH, scale: Scale::LENGTH },
        /// Obsolete: ignored, with a note.
        stiffness: Option<f64> = "none" { domain: Domain::Words("any number") },
        /// Obsolete: ignored, with a note.
        damping: Option<f64> = "none" { domain: Domain::Words("any number") },
        /// Obsolete: ignored, with a note.
        triangles: Option<bool> = "none",
    }

    /// How a body meets another, or all others of a material.
    WithRow {
        /// Name or number of the other body, which must have `touch` too.
        body: Option<BodyKey> = "none: `material` selects it" { domain: Domain::Words("a body") },
        /// Name of a material: all other bodies of this material that have `touch`, unless an entry
        /// of either body names the other.
        material: Option<String> = "none: `body` selects it"
            { domain: Domain::Words(MATERIAL_NAMES) },
        /// Coulomb's coefficient of friction of the two.
        friction: Option<f64> = "the root of the product" { domain: Domain::Factor },
        /// Coefficient of restitution of the two.
        restitution: Option<f64> = "the larger one" { domain: Domain::Fraction },
        /// Obsolete: ignored, with a note.
        stiffness: Option<f64> = "none" { domain: Domain::Words("any number") },
        /// Obsolete: ignored, with a note.
        damping: Option<f64> = "none" { domain: Domain::Words("any number") },
    }
}
