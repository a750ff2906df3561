//! Meshes of one moment: OBJ and PLY.

use super::skin::{Form, Skin, positions, velocities};
use crate::runner::Runner;
use msd_core::Surface;
use std::io::{self, Write};

/// Writes the moment as OBJ: a group per body, with its texture coordinates; ropes and links are
/// lines. A surface in one piece is smooth; a block, whose sides have corners of their own, is not.
pub fn write_obj(runner: &Runner, skin: &Skin, output: &mut impl Write) -> io::Result<()> {
    writeln!(output, "# msd, t = {} s", runner.time())?;
    let all = positions(runner);
    for &particle in &skin.particles {
        // In its own precision: the shortest digits that read back the same.
        let [x, y, z] = all[particle];
        match runner {
            Runner::F32(..) => writeln!(output, "v {} {} {}", x as f32, y as f32, z as f32)?,
            Runner::F64(..) => writeln!(output, "v {x} {y} {z}")?,
        }
    }
    let places = skin.places();
    // Counted from 1.
    let place = |particle: u32| places[particle as usize] + 1;
    let mut textured = 0;
    for part in &skin.parts {
        // A name with spaces would be several.
        let name = part.name.replace(|letter: char| letter.is_whitespace(), "_");
        writeln!(output, "g {name}")?;
        match &part.form {
            Form::Surface(surface) => {
                for corner in &surface.corners {
                    writeln!(output, "vt {} {}", corner.uv[0], corner.uv[1])?;
                }
                writeln!(output, "s {}", if is_one_piece(surface) { "1" } else { "off" })?;
                for triangle in &surface.triangles {
                    let [a, b, c] = triangle.map(|corner| {
                        let particle = surface.corners[corner as usize].particle;
                        format!("{}/{}", place(particle), textured + corner + 1)
                    });
                    writeln!(output, "f {a} {b} {c}")?;
                }
                textured += surface.corners.len() as u32;
            }
            Form::Lines(lines) => {
                for line in lines {
                    let [a, b] = line.map(place);
                    writeln!(output, "l {a} {b}")?;
                }
            }
            Form::Points(points) => {
                for &point in points {
                    writeln!(output, "p {}", place(point))?;
                }
            }
        }
    }
    Ok(())
}

/// Whether no two corners are of one particle.
fn is_one_piece(surface: &Surface) -> bool {
    let mut particles: Vec<u32> = surface.corners.iter().map(|corner| corner.particle).collect();
    particles.sort_unstable();
    particles.is_sorted_by(|a, b| a < b)
}

/// Writes the moment as binary PLY: vertices with their velocities, triangles, and edges where a
/// body has no surface.
pub fn write_ply(runner: &Runner, skin: &Skin, output: &mut impl Write) -> io::Result<()> {
    let places = skin.places();
    let place = |particle: u32| places[particle as usize];
    let (mut triangles, mut edges) = (Vec::new(), Vec::new());
    for part in &skin.parts {
        match &part.form {
            Form::Surface(surface) => {
                triangles.extend(surface.particles().map(|three| three.map(place)));
            }
            Form::Lines(lines) => edges.extend(lines.iter().map(|line| line.map(place))),
            Form::Points(_) => {}
        }
    }
    let number = match runner {
        Runner::F32(..) => "float",
        Runner::F64(..) => "double",
    };
    writeln!(output, "ply\nformat binary_little_endian 1.0\ncomment msd, t = {} s", runner.time())?;
    writeln!(output, "element vertex {}", skin.particles.len())?;
    for name in ["x", "y", "z", "vx", "vy", "vz"] {
        writeln!(output, "property {number} {name}")?;
    }
    writeln!(output, "element face {}", triangles.len())?;
    writeln!(output, "property list uchar uint vertex_indices")?;
    writeln!(output, "element edge {}", edges.len())?;
    writeln!(output, "property uint vertex1\nproperty uint vertex2\nend_header")?;
    let (positions, velocities) = (positions(runner), velocities(runner));
    for &particle in &skin.particles {
        for component in positions[particle].into_iter().chain(velocities[particle]) {
            match runner {
                Runner::F32(..) => output.write_all(&(component as f32).to_le_bytes())?,
                Runner::F64(..) => output.write_all(&component.to_le_bytes())?,
            }
        }
    }
    for triangle in triangles {
        output.write_all(&[3])?;
        triangle.iter().try_for_each(|corner| output.write_all(&corner.to_le_bytes()))?;
    }
    for end in edges.into_iter().flatten() {
        output.write_all(&end.to_le_bytes())?;
    }
    Ok(())
}
