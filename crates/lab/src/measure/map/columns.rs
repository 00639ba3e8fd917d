//! Tables of a map as Parquet, and as CSV where they are short: both from the same columns.

use parquet::basic::Compression;
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;
use std::fmt::Write as _;
use std::sync::Arc;
use trolley::Failure;

/// A value; what a row does not have is `Empty`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Value {
    Empty,
    Text(&'static str),
    Whole(i64),
    /// A number, and its decimals in CSV.
    Real(f64, usize),
}

impl Value {
    pub(crate) fn text(text: Option<&'static str>) -> Self {
        text.map_or(Self::Empty, Self::Text)
    }

    pub(crate) fn whole(number: Option<impl Into<i64>>) -> Self {
        number.map_or(Self::Empty, |number| Self::Whole(number.into()))
    }
}

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Form {
    Text,
    Whole,
    Real,
}

/// A table: its columns in order, and its rows.
#[derive(Clone, Debug)]
pub(crate) struct Table<const N: usize> {
    columns: [(&'static str, Form); N],
    rows: Vec<[Value; N]>,
}

impl<const N: usize> Table<N> {
    pub(crate) fn new(columns: [(&'static str, Form); N]) -> Self {
        Self { columns, rows: Vec::new() }
    }

    pub(crate) fn push(&mut self, row: [Value; N]) {
        self.rows.push(row);
    }

    pub(crate) fn csv(&self) -> String {
        let mut text = self.columns.map(|(name, _)| name).join(",");
        text.push('\n');
        for row in &self.rows {
            for (number, value) in row.iter().enumerate() {
                let separator = if number == 0 { "" } else { "," };
                // Writing to a String cannot fail.
                let _written = match value {
                    Value::Empty => write!(text, "{separator}"),
                    Value::Text(word) => write!(text, "{separator}{word}"),
                    Value::Whole(number) => write!(text, "{separator}{number}"),
                    Value::Real(number, decimals) => {
                        write!(text, "{separator}{number:.decimals$}")
                    }
                };
            }
            text.push('\n');
        }
        text
    }

    /// The table as the bytes of a Parquet file (format 2, Snappy).
    ///
    /// # Errors
    ///
    /// If a value does not have its column's form, or the library fails.
    pub(crate) fn parquet(&self) -> Result<Vec<u8>, Failure> {
        self.written().map_err(|error| Failure::internal(format!("Parquet: {error}")))
    }

    fn written(&self) -> Result<Vec<u8>, ParquetError> {
        let columns: Vec<String> = self
            .columns
            .iter()
            .map(|(name, form)| match form {
                Form::Text => format!("optional binary {name} (UTF8);"),
                Form::Whole => format!("optional int64 {name};"),
                Form::Real => format!("optional double {name};"),
            })
            .collect();
        let schema = parse_message_type(&format!("message map {{ {} }}", columns.join(" ")))?;
        let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
        let mut bytes = Vec::new();
        let mut writer =
            SerializedFileWriter::new(&mut bytes, Arc::new(schema), Arc::new(properties))?;
        for rows in self.rows.chunks(ROWS) {
            let mut group = writer.next_row_group()?;
            for (number, (name, form)) in self.columns.iter().enumerate() {
                let wrong = || ParquetError::General(format!("a value of {name} is no {form:?}"));
                let values = rows.iter().map(|row| row[number]);
                let filled = values.clone().filter(|value| *value != Value::Empty);
                let levels: Vec<i16> =
                    values.map(|value| i16::from(value != Value::Empty)).collect();
                let Some(mut column) = group.next_column()? else { break };
                match form {
                    Form::Text => {
                        let text = filled.map(|value| match value {
                            Value::Text(word) => Ok(ByteArray::from(word)),
                            _ => Err(wrong()),
                        });
                        let text = text.collect::<Result<Vec<_>, _>>()?;
                        column.typed::<ByteArrayType>().write_batch(&text, Some(&levels), None)?;
                    }
                    Form::Whole => {
                        let whole = filled.map(|value| match value {
                            Value::Whole(number) => Ok(number),
                            _ => Err(wrong()),
                        });
                        let whole = whole.collect::<Result<Vec<_>, _>>()?;
                        column.typed::<Int64Type>().write_batch(&whole, Some(&levels), None)?;
                    }
                    Form::Real => {
                        let real = filled.map(|value| match value {
                            Value::Real(number, _) => Ok(number),
                            _ => Err(wrong()),
                        });
                        let real = real.collect::<Result<Vec<_>, _>>()?;
                        column.typed::<DoubleType>().write_batch(&real, Some(&levels), None)?;
                    }
                }
                column.close()?;
            }
            group.close()?;
        }
        writer.close()?;
        Ok(bytes)
    }
}

/// Rows of a row group.
const ROWS: usize = 100_000;

#[cfg(test)]
mod tests {
    //! What is written is read back, value by value; what does not fit its column is refused.

    use super::*;
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;
    use std::io::Write as _;

    #[test]
    fn a_table_is_read_back_with_its_gaps() {
        let columns = [("name", Form::Text), ("count", Form::Whole), ("share", Form::Real)];
        let mut table = Table::new(columns);
        // More than one row group.
        for row in 0..ROWS as i64 + 7 {
            let is_there = row % 3 != 1;
            table.push([
                Value::text(is_there.then_some("a")),
                Value::whole(is_there.then_some(row)),
                if is_there { Value::Real(row as f64 / 3.0, 4) } else { Value::Empty },
            ]);
        }
        let mut file = tempfile::tempfile().expect("a file");
        file.write_all(&table.parquet().expect("it is written")).expect("room");
        let reader = SerializedFileReader::new(file).expect("it is Parquet");
        assert_eq!(reader.num_row_groups(), 2);
        let mut count = 0;
        for (row, written) in reader.into_iter().zip(&table.rows) {
            let row = row.expect("a row");
            for ((_, field), value) in row.get_column_iter().zip(written) {
                let is_same = match (field, value) {
                    (Field::Null, Value::Empty) => true,
                    (Field::Str(read), Value::Text(word)) => read == word,
                    (Field::Long(read), Value::Whole(number)) => read == number,
                    (Field::Double(read), Value::Real(number, _)) => read == number,
                    _ => false,
                };
                assert!(is_same, "{field:?} {value:?}");
            }
            count += 1;
        }
        assert_eq!(count, table.rows.len());
        let mut wrong = Table::new(columns);
        wrong.push([Value::Empty, Value::Real(1.0, 0), Value::Empty]);
        assert!(wrong.parquet().is_err(), "a real number is no whole one");
    }

    #[test]
    fn csv_has_the_same_rows() {
        let mut table = Table::new([("name", Form::Text), ("share", Form::Real)]);
        table.push([Value::Text("a"), Value::Real(0.25, 1)]);
        table.push([Value::Empty, Value::Empty]);
        assert_eq!(table.csv(), "name,share\na,0.2\n,\n");
    }
}
