//! Trajectories as Parquet: a row per particle and moment.

use super::Follow;
use super::skin::{positions, velocities};
use crate::runner::Runner;
use msd_scene::{FileError, Output, one_line};
use parquet::basic::{Repetition, Type as Physical};
use parquet::data_type::{DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::{Type, TypePtr};
use std::io;
use std::sync::Arc;

/// Rows that are written at once.
const GROUP: usize = 100_000;

/// The columns of numbers, beside the particle.
const NUMBERS: [&str; 7] = ["time", "x", "y", "z", "vx", "vy", "vz"];

/// A table that is being written.
pub struct ParquetTable {
    writer: SerializedFileWriter<Output>,
    name: String,
    particles: Vec<i64>,
    numbers: [Vec<f64>; NUMBERS.len()],
}

impl ParquetTable {
    /// Begins one.
    ///
    /// # Errors
    /// Those of the operating system.
    pub fn new(output: Output) -> io::Result<Self> {
        let name = output.name().to_owned();
        let writer = SerializedFileWriter::new(output, schema()?, Arc::default())?;
        Ok(ParquetTable { writer, name, particles: Vec::new(), numbers: Default::default() })
    }

    fn write_group(&mut self) -> Result<(), ParquetError> {
        if self.particles.is_empty() {
            return Ok(());
        }
        let mut group = self.writer.next_row_group()?;
        add::<Int64Type>(&mut group, &self.particles)?;
        for column in &self.numbers {
            add::<DoubleType>(&mut group, column)?;
        }
        group.close()?;
        self.particles.clear();
        self.numbers.iter_mut().for_each(Vec::clear);
        Ok(())
    }
}

fn schema() -> Result<TypePtr, ParquetError> {
    let field = |name: &str, physical| {
        let builder = Type::primitive_type_builder(name, physical);
        builder.with_repetition(Repetition::REQUIRED).build().map(Arc::new)
    };
    let mut fields = vec![field("particle", Physical::INT64)?];
    for name in NUMBERS {
        fields.push(field(name, Physical::DOUBLE)?);
    }
    Type::group_type_builder("run").with_fields(fields).build().map(Arc::new)
}

fn add<T: DataType>(
    group: &mut SerializedRowGroupWriter<'_, Output>,
    values: &[T::T],
) -> Result<(), ParquetError> {
    let more = || ParquetError::General("more columns than the schema has".into());
    let mut column = group.next_column()?.ok_or_else(more)?;
    column.typed::<T>().write_batch(values, None, None)?;
    column.close()
}

impl Follow for ParquetTable {
    fn add(&mut self, runner: &Runner) -> io::Result<()> {
        let all = positions(runner).into_iter().zip(velocities(runner));
        for (particle, ([x, y, z], [vx, vy, vz])) in all.enumerate() {
            self.particles.push(particle as i64);
            let row = [runner.time(), x, y, z, vx, vy, vz];
            self.numbers.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
        }
        if GROUP <= self.particles.len() {
            self.write_group()?;
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<(), FileError> {
        let written = self.write_group();
        let ParquetTable { writer, name, .. } = *self;
        let refused =
            |error: ParquetError| FileError::Unwritable { file: name, reason: one_line(error) };
        written.and_then(|()| writer.into_inner()).map_err(refused)?.finish()
    }
}
