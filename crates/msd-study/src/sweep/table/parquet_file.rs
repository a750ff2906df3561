//! Tables as Parquet files.

use crate::sweep::table::{Column, Datum, Kind, Table};
use msd_scene::{FileError, Output, one_line};
use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::record::Field;
use parquet::schema::types::{Type, TypePtr};
use std::path::Path;
use std::sync::Arc;

/// Writes a table as one row group; every column may miss values.
pub(super) fn write(table: &Table, mut output: Output) -> Result<(), FileError> {
    write_to(table, &mut output).map_err(|error| FileError::Unwritable {
        file: output.name().to_owned(),
        reason: one_line(error),
    })?;
    output.finish()
}

fn write_to(table: &Table, output: &mut Output) -> Result<(), ParquetError> {
    let mut writer = SerializedFileWriter::new(output, schema(&table.columns)?, Arc::default())?;
    let mut group = writer.next_row_group()?;
    for (place, column) in table.columns.iter().enumerate() {
        let values = table.rows.iter().map(|row| &row[place]);
        match column.kind {
            Kind::Flag => add::<BoolType>(&mut group, values.map(flag)),
            Kind::Whole => add::<Int64Type>(&mut group, values.map(whole)),
            Kind::Number => add::<DoubleType>(&mut group, values.map(Datum::as_number)),
            Kind::Text => add::<ByteArrayType>(&mut group, values.map(text)),
        }?;
    }
    group.close()?;
    writer.close()?;
    Ok(())
}

fn schema(columns: &[Column]) -> Result<TypePtr, ParquetError> {
    let field = |column: &Column| {
        let (physical, logical) = match column.kind {
            Kind::Flag => (Physical::BOOLEAN, None),
            Kind::Whole => (Physical::INT64, None),
            Kind::Number => (Physical::DOUBLE, None),
            Kind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        };
        let builder = Type::primitive_type_builder(&column.name, physical);
        let builder = builder.with_repetition(Repetition::OPTIONAL).with_logical_type(logical);
        builder.build().map(Arc::new)
    };
    let fields: Result<Vec<_>, _> = columns.iter().map(field).collect();
    Type::group_type_builder("sweep").with_fields(fields?).build().map(Arc::new)
}

/// Adds a column: the values that are there, and for each row whether there is one.
fn add<T: DataType>(
    group: &mut SerializedRowGroupWriter<'_, &mut Output>,
    values: impl Iterator<Item = Option<T::T>>,
) -> Result<(), ParquetError> {
    let values: Vec<Option<T::T>> = values.collect();
    let levels: Vec<i16> = values.iter().map(|value| i16::from(value.is_some())).collect();
    let there: Vec<T::T> = values.into_iter().flatten().collect();
    let more = || ParquetError::General("more columns than the schema has".into());
    let mut column = group.next_column()?.ok_or_else(more)?;
    column.typed::<T>().write_batch(&there, Some(&levels), None)?;
    column.close()
}

fn flag(value: &Datum) -> Option<bool> {
    if let Datum::Flag(flag) = value { Some(*flag) } else { None }
}

fn whole(value: &Datum) -> Option<i64> {
    if let Datum::Whole(number) = value { Some(*number) } else { None }
}

fn text(value: &Datum) -> Option<ByteArray> {
    if let Datum::Text(text) = value { Some(text.as_str().into()) } else { None }
}

/// Reads a table.
pub(super) fn read(path: &Path) -> Result<Table, String> {
    let reader = SerializedFileReader::try_from(path).map_err(one_line)?;
    let fields = reader.metadata().file_metadata().schema().get_fields().to_vec();
    let column = |field: &TypePtr| {
        let kind = match field.is_primitive().then(|| field.get_physical_type()) {
            Some(Physical::BOOLEAN) => Kind::Flag,
            Some(Physical::INT64) => Kind::Whole,
            Some(Physical::DOUBLE) => Kind::Number,
            Some(Physical::BYTE_ARRAY) => Kind::Text,
            _ => return Err(format!("column {} is of another type", field.name())),
        };
        Ok(Column { name: field.name().into(), kind })
    };
    let columns: Result<Vec<_>, String> = fields.iter().map(column).collect();
    let mut table = Table { columns: columns?, rows: Vec::new() };
    for row in reader.get_row_iter(None).map_err(one_line)? {
        let fields = row.map_err(one_line)?.into_columns();
        let row: Result<_, String> = fields.into_iter().map(|field| datum(field.1)).collect();
        table.rows.push(row?);
    }
    Ok(table)
}

fn datum(field: Field) -> Result<Datum, String> {
    match field {
        Field::Null => Ok(Datum::Nothing),
        Field::Bool(flag) => Ok(Datum::Flag(flag)),
        Field::Long(number) => Ok(Datum::Whole(number)),
        Field::Double(number) => Ok(Datum::Number(number)),
        Field::Str(text) => Ok(Datum::Text(text)),
        other => Err(format!("there is a value of another type: {other}")),
    }
}
