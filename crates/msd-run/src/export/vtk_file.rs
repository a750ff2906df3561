//! Files of VTK, as ParaView reads them: a moment is an unstructured grid (VTU), many are a
//! collection (PVD) of these.

use super::Follow;
use super::skin::{Form, Skin, positions, velocities};
use crate::on;
use crate::runner::Runner;
use msd_core::Real;
use msd_scene::{FileError, Output, write_file};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Value of a cell of a surface where springs have a number.
const NO_SPRING: f64 = f64::NAN;
/// Kinds of cells of VTK.
const LINE: u8 = 3;
const TRIANGLE: u8 = 5;

/// An array of numbers in the raw bytes at the end of a file.
struct Column {
    name: &'static str,
    kind: &'static str,
    components: usize,
    bytes: Vec<u8>,
}

impl Column {
    fn numbers(name: &'static str, components: usize, values: impl Iterator<Item = f64>) -> Self {
        let bytes = values.flat_map(f64::to_le_bytes).collect();
        Column { name, kind: "Float64", components, bytes }
    }

    fn whole(name: &'static str, values: impl Iterator<Item = i64>) -> Self {
        let bytes = values.flat_map(i64::to_le_bytes).collect();
        Column { name, kind: "Int64", components: 1, bytes }
    }

    fn kinds(name: &'static str, values: impl Iterator<Item = u8>) -> Self {
        Column { name, kind: "UInt8", components: 1, bytes: values.collect() }
    }
}

/// Writes the moment as VTU: all particles with their velocities and masses; springs as lines with
/// their strain and force; the triangles of surfaces.
pub fn write_vtu(runner: &Runner, skin: &Skin, output: &mut impl Write) -> io::Result<()> {
    let triangles: Vec<(i64, [i64; 3])> = triangles(skin);
    let (springs, strains, forces, masses, bodies) = on!(runner, simulation => {
        let model = simulation.model();
        let there = (0..model.spring_count()).filter(|&spring| !model.is_cut(spring));
        let there: Vec<usize> = there.collect();
        let body_of = |spring: &usize| {
            let body = model.bodies().iter().position(|body| body.springs.contains(spring));
            body.map_or(-1, |body| body as i64)
        };
        (
            there.iter().map(|&row| model.ends()[row].map(i64::from)).collect::<Vec<_>>(),
            there.iter().map(|&row| simulation.strain(row)).collect::<Vec<_>>(),
            there.iter().map(|&row| simulation.tension(row)).collect::<Vec<_>>(),
            model.masses().iter().map(|mass| mass.to_f64()).collect::<Vec<_>>(),
            there.iter().map(body_of).collect::<Vec<_>>(),
        )
    });
    let none = || triangles.iter().map(|_| NO_SPRING);
    let corners = springs.iter().flatten().chain(triangles.iter().flat_map(|(_, three)| three));
    let sizes = springs.iter().map(|_| 2).chain(triangles.iter().map(|_| 3));
    let offsets = sizes.scan(0, |sum, size| {
        *sum += size;
        Some(*sum)
    });
    let (lines, surfaces) = (springs.iter().map(|_| LINE), triangles.iter().map(|_| TRIANGLE));
    let bodies = bodies.into_iter().chain(triangles.iter().map(|(body, _)| *body));
    let vectors = |rows: Vec<[f64; 3]>| rows.into_iter().flatten();
    let sections = [
        ("Points", vec![Column::numbers("position", 3, vectors(positions(runner)))]),
        (
            "Cells",
            vec![
                Column::whole("connectivity", corners.copied()),
                Column::whole("offsets", offsets),
                Column::kinds("types", lines.chain(surfaces)),
            ],
        ),
        (
            "PointData",
            vec![
                Column::numbers("velocity", 3, vectors(velocities(runner))),
                Column::numbers("mass", 1, masses.into_iter()),
            ],
        ),
        (
            "CellData",
            vec![
                Column::numbers("strain", 1, strains.into_iter().chain(none())),
                Column::numbers("force", 1, forces.into_iter().chain(none())),
                Column::whole("body", bodies),
            ],
        ),
    ];
    let (particles, cells) = (runner.particle_count(), springs.len() + triangles.len());
    write_sections(runner.time(), [particles, cells], &sections, output)
}

/// The triangles of all surfaces, each with its body.
fn triangles(skin: &Skin) -> Vec<(i64, [i64; 3])> {
    let mut found = Vec::new();
    for (body, part) in skin.parts.iter().enumerate() {
        let Form::Surface(surface) = &part.form else { continue };
        found.extend(surface.particles().map(|three| (body as i64, three.map(i64::from))));
    }
    found
}

fn write_sections(
    time: f64,
    [particles, cells]: [usize; 2],
    sections: &[(&str, Vec<Column>)],
    output: &mut impl Write,
) -> io::Result<()> {
    writeln!(
        output,
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" \
         byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<UnstructuredGrid>\n<FieldData>\n\
         <DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">\n\
         {time}\n</DataArray>\n</FieldData>\n\
         <Piece NumberOfPoints=\"{particles}\" NumberOfCells=\"{cells}\">"
    )?;
    let mut at = 0;
    for (section, columns) in sections {
        writeln!(output, "<{section}>")?;
        for Column { name, kind, components, bytes } in columns {
            writeln!(
                output,
                "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" \
                 format=\"appended\" offset=\"{at}\"/>"
            )?;
            at += size_of::<u64>() + bytes.len();
        }
        writeln!(output, "</{section}>")?;
    }
    write!(output, "</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_")?;
    for Column { bytes, .. } in sections.iter().flat_map(|(_, columns)| columns) {
        output.write_all(&(bytes.len() as u64).to_le_bytes())?;
        output.write_all(bytes)?;
    }
    writeln!(output, "\n</AppendedData>\n</VTKFile>")
}

/// A collection that is being written: a VTU file for each moment, and the list of them.
#[derive(Debug)]
pub struct Collection {
    output: Output,
    path: PathBuf,
    skin: Skin,
    /// Times and names of the moments so far.
    moments: Vec<(f64, String)>,
}

impl Collection {
    /// Begins one; moments go into files beside it.
    pub fn new(output: Output, path: &Path, skin: Skin) -> Self {
        Collection { output, path: path.into(), skin, moments: Vec::new() }
    }
}

/// The file of a moment of a collection, by its number.
fn moment_path(path: &Path, moment: usize) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}_{moment:05}.vtu"))
}

impl Follow for Collection {
    fn add(&mut self, runner: &Runner) -> io::Result<()> {
        let path = moment_path(&self.path, self.moments.len());
        let mut bytes = Vec::new();
        write_vtu(runner, &self.skin, &mut bytes)?;
        write_file(&path, &bytes).map_err(io::Error::other)?;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let name = name.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
        self.moments.push((runner.time(), name));
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), FileError> {
        let Collection { mut output, moments, .. } = *self;
        let mut text = String::from(
            "<?xml version=\"1.0\"?>\n\
             <VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n\
             <Collection>\n",
        );
        for (time, name) in moments {
            text.push_str(&format!("<DataSet timestep=\"{time}\" part=\"0\" file=\"{name}\"/>\n"));
        }
        text.push_str("</Collection>\n</VTKFile>\n");
        output.write_all(text.as_bytes()).map_err(|error| output.refused(&error))?;
        output.finish()
    }
}
