//! Rows of how bodies meet.

use super::{BodyKey, MATERIAL_NAMES};
use crate::file::keys::{Domain, LENGTH, Scale, rows};

rows! {
    /// How a body meets itself and others.
    TouchRow {
        /// Distance that the surface, a rope or a particle keeps on each side, at most 0.4 of the
        /// spacing.
        thickness: Option<f64> = "a tenth of the spacing, which is the median over particles of \
                                  their shortest spring"
            { unit: "m", domain: LENGTH, scale: Scale::LENGTH, instead_of: &["radius"] },
        /// Coulomb's coefficient of friction; of two bodies the root of the product.
        friction: Option<f64> = "0.5" { domain: Domain::Factor },
        /// Coefficient of restitution; of two bodies the larger. A soft body bounces by its own
        /// springs and needs none.
        restitution: Option<f64> = "0" { domain: Domain::Fraction },
        /// Whether the body collides with itself.
        itself: Option<bool> = "`true`, but `false` of a block or a solid mesh",
        /// Whether it keeps its thickness from obstacles too. Otherwise they meet its particles as
        /// points.
        obstacles: Option<bool> = "`false`",
        /// Bodies that it passes through, by name or number.
        ignore: Vec<BodyKey> = "none" { domain: Domain::Words("list of names or numbers") },
        /// Values for single other bodies, or those of a material: see [`with`](#with-of-touch).
        with: Vec<WithRow> = "none",
        /// Of older files: read as `thickness`, at most 0.4 of the spacing, with a note.
        radius: Option<f64> = "none" { unit: "m", domain: LENGTH, scale: Scale::LENGTH },
        /// Of older files: no effect, with a note.
        stiffness: Option<f64> = "none" { domain: Domain::Words("any number") },
        /// Of older files: no effect, with a note.
        damping: Option<f64> = "none" { domain: Domain::Words("any number") },
        /// Of older files: no effect, with a note.
        triangles: Option<bool> = "none",
    }

    /// How a body meets another, or all others of a material.
    WithRow {
        /// Name or number of the other body, which has a table `touch` as well.
        body: Option<BodyKey> = "none: `material` says which" { domain: Domain::Words("a body") },
        /// Name of a material: all other bodies of it that have a table `touch` as well, but those
        /// that an entry of the pair names.
        material: Option<String> = "none: `body` says which"
            { domain: Domain::Words(MATERIAL_NAMES) },
        /// Coulomb's coefficient of friction of the two.
        friction: Option<f64> = "the root of the product" { domain: Domain::Factor },
        /// Coefficient of restitution of the two.
        restitution: Option<f64> = "the larger one" { domain: Domain::Fraction },
        /// Of older files: no effect, with a note.
        stiffness: Option<f64> = "none" { domain: Domain::Words("any number") },
        /// Of older files: no effect, with a note.
        damping: Option<f64> = "none" { domain: Domain::Words("any number") },
    }
}
