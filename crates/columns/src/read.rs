//! Columns of a Parquet file that a [`Table`](crate::Table) wrote.

use diagnostic::Failure;
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use std::fs::File;

/// The values of a column, in the order of the rows.
#[derive(Clone, Debug, PartialEq)]
pub enum ReadColumn {
    /// Texts.
    Text(Vec<Option<String>>),
    /// Whole numbers.
    Whole(Vec<Option<i64>>),
    /// Real numbers.
    Real(Vec<Option<f64>>),
    /// Truth values.
    Flag(Vec<Option<bool>>),
}

impl ReadColumn {
    /// The text of a row; `None` if there is none, or the column has other values.
    #[must_use]
    pub fn text(&self, row: usize) -> Option<&str> {
        let Self::Text(values) = self else { return None };
        values.get(row)?.as_deref()
    }

    /// The whole number of a row, as [`text`](Self::text).
    #[must_use]
    pub fn whole(&self, row: usize) -> Option<i64> {
        let Self::Whole(values) = self else { return None };
        *values.get(row)?
    }

    /// The real number of a row, as [`text`](Self::text).
    #[must_use]
    pub fn real(&self, row: usize) -> Option<f64> {
        let Self::Real(values) = self else { return None };
        *values.get(row)?
    }

    /// The truth value of a row, as [`text`](Self::text).
    #[must_use]
    pub fn flag(&self, row: usize) -> Option<bool> {
        let Self::Flag(values) = self else { return None };
        *values.get(row)?
    }

    /// The number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        match self {
            Self::Text(values) => values.len(),
            Self::Whole(values) => values.len(),
            Self::Real(values) => values.len(),
            Self::Flag(values) => values.len(),
        }
    }
}

/// Reads these columns, in this order.
///
/// # Errors
///
/// If the file is no Parquet, lacks a column, or has one of another form than a table writes.
pub fn read<const N: usize>(file: File, names: [&str; N]) -> Result<[ReadColumn; N], Failure> {
    let failed = |error: ParquetError| Failure::input(format!("it is no table: {error}"));
    let reader = SerializedFileReader::new(file).map_err(failed)?;
    let schema = reader.metadata().file_metadata().schema_descr_ptr();
    let mut read: [Option<ReadColumn>; N] = [const { None }; N];
    for (name, column) in names.iter().zip(&mut read) {
        let found = schema.columns().iter().position(|column| column.name() == *name);
        let number = found.ok_or_else(|| Failure::input(format!("it has no column \"{name}\"")))?;
        for group in 0..reader.num_row_groups() {
            let group = reader.get_row_group(group).map_err(failed)?;
            let rows = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
            let part = group.get_column_reader(number).map_err(failed)?;
            append(column, part, rows).map_err(failed)?;
        }
    }
    let empty = |column: Option<ReadColumn>| column.unwrap_or(ReadColumn::Text(Vec::new()));
    Ok(read.map(empty))
}

/// Adds the rows of a row group to a column.
fn append(
    column: &mut Option<ReadColumn>,
    reader: ColumnReader,
    rows: usize,
) -> Result<(), ParquetError> {
    let mixed = || ParquetError::General("a column has values of several forms".to_owned());
    match reader {
        ColumnReader::ByteArrayColumnReader(reader) => {
            let ReadColumn::Text(all) = column.get_or_insert(ReadColumn::Text(Vec::new())) else {
                return Err(mixed());
            };
            for value in values(reader, rows)? {
                let text = value.map(|bytes| bytes.as_utf8().map(str::to_owned)).transpose()?;
                all.push(text);
            }
        }
        ColumnReader::Int64ColumnReader(reader) => {
            let ReadColumn::Whole(all) = column.get_or_insert(ReadColumn::Whole(Vec::new())) else {
                return Err(mixed());
            };
            all.extend(values(reader, rows)?);
        }
        ColumnReader::DoubleColumnReader(reader) => {
            let ReadColumn::Real(all) = column.get_or_insert(ReadColumn::Real(Vec::new())) else {
                return Err(mixed());
            };
            all.extend(values(reader, rows)?);
        }
        ColumnReader::BoolColumnReader(reader) => {
            let ReadColumn::Flag(all) = column.get_or_insert(ReadColumn::Flag(Vec::new())) else {
                return Err(mixed());
            };
            all.extend(values(reader, rows)?);
        }
        _ => return Err(ParquetError::General("a column of a form unknown here".to_owned())),
    }
    Ok(())
}

/// The values of a row group, and where there is none.
fn values<T: DataType>(
    mut reader: ColumnReaderImpl<T>,
    rows: usize,
) -> Result<Vec<Option<T::T>>, ParquetError> {
    let (mut filled, mut levels) = (Vec::new(), Vec::new());
    let mut left = rows;
    while left > 0 {
        let (records, ..) = reader.read_records(left, Some(&mut levels), None, &mut filled)?;
        if records == 0 {
            return Err(ParquetError::General("a column ends early".to_owned()));
        }
        left -= records;
    }
    let mut filled = filled.into_iter();
    Ok(levels.into_iter().map(|level| if level == 0 { None } else { filled.next() }).collect())
}

#[cfg(test)]
mod tests {
    //! What is written is read back, value by value, over several row groups.

    use super::*;
    use crate::table::ROWS;
    use crate::{Form, Table, Value};
    use std::io::Write as _;

    #[test]
    fn a_table_is_read_back_with_its_gaps() {
        let forms = [
            ("name", Form::Text),
            ("count", Form::Whole),
            ("share", Form::Real),
            ("is_odd", Form::Flag),
        ];
        let names: Vec<String> = (0..7).map(|number| format!("name {number}")).collect();
        let mut table = Table::new(forms);
        for row in 0..ROWS as i64 + 7 {
            let is_there = row % 3 != 1;
            table.push([
                Value::text(is_there.then(|| names[row as usize % 7].as_str())),
                Value::whole(is_there.then_some(row)),
                Value::real(is_there.then_some(row as f64 / 3.0)),
                if is_there { Value::Flag(row % 2 == 1) } else { Value::Empty },
            ]);
        }
        let mut file = tempfile::tempfile().expect("a file");
        file.write_all(&table.parquet().expect("it is written")).expect("room");
        let copy = file.try_clone().expect("a copy");
        let [share, name, is_odd, count] =
            read(file, ["share", "name", "is_odd", "count"]).expect("it is read");
        assert_eq!(count.rows(), ROWS + 7);
        for row in 0..count.rows() {
            let is_there = row % 3 != 1;
            let whole = row as i64;
            assert_eq!(count.whole(row), is_there.then_some(whole));
            assert_eq!(name.text(row), is_there.then(|| names[row % 7].as_str()));
            assert_eq!(share.real(row), is_there.then_some(row as f64 / 3.0));
            assert_eq!(is_odd.flag(row), is_there.then_some(row % 2 == 1));
        }
        assert!(read(copy, ["nothing"]).is_err(), "there is no such column");
    }

    #[test]
    fn what_is_no_table_is_refused() {
        let mut file = tempfile::tempfile().expect("a file");
        file.write_all(b"PAR1 and nothing else").expect("room");
        assert!(read(file, ["name"]).is_err());
    }
}
