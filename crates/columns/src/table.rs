//! The table, and how it is written.

use diagnostic::Failure;
use parquet::basic::Compression;
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;
use std::fmt::Write as _;
use std::sync::Arc;

/// A value; what a row does not have is `Empty`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value<'r> {
    /// None.
    Empty,
    /// A text.
    Text(&'r str),
    /// A whole number.
    Whole(i64),
    /// A truth value; in CSV `true` or `false`.
    Flag(bool),
    /// A number, and its decimals in CSV.
    Real(f64, usize),
}

impl<'r> Value<'r> {
    /// A text, if there is one.
    #[must_use]
    pub fn text(text: Option<&'r str>) -> Self {
        text.map_or(Self::Empty, Self::Text)
    }

    /// A whole number, if there is one.
    #[must_use]
    pub fn whole(number: Option<impl Into<i64>>) -> Self {
        number.map_or(Self::Empty, |number| Self::Whole(number.into()))
    }

    /// A number, if there is one.
    #[must_use]
    pub fn real(number: Option<f64>) -> Self {
        number.map_or(Self::Empty, |number| Self::Real(number, 6))
    }
}

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Texts.
    Text,
    /// Whole numbers, of 64 bits.
    Whole,
    /// Real numbers, of 64 bits.
    Real,
    /// Truth values.
    Flag,
}

/// A table: its columns in order, and its rows.
#[derive(Clone, Debug)]
pub struct Table<'r, const N: usize> {
    columns: [(&'static str, Form); N],
    rows: Vec<[Value<'r>; N]>,
}

impl<'r, const N: usize> Table<'r, N> {
    /// A table without rows.
    #[must_use]
    pub fn new(columns: [(&'static str, Form); N]) -> Self {
        Self { columns, rows: Vec::new() }
    }

    /// Adds a row.
    pub fn push(&mut self, row: [Value<'r>; N]) {
        self.rows.push(row);
    }

    /// Its rows, in order.
    #[must_use]
    pub fn rows(&self) -> &[[Value<'r>; N]] {
        &self.rows
    }

    /// The table as CSV. Texts are written as they are: for words without commas.
    #[must_use]
    pub fn csv(&self) -> String {
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
                    Value::Flag(is_so) => write!(text, "{separator}{is_so}"),
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
    pub fn parquet(&self) -> Result<Vec<u8>, Failure> {
        let mut writer = TableWriter::new(self.columns)?;
        writer.append(self)?;
        writer.finish()
    }
}

/// A Parquet file that is written piece by piece, so that no more than a piece is in memory beside
/// the file's bytes.
pub struct TableWriter<const N: usize> {
    columns: [(&'static str, Form); N],
    file: SerializedFileWriter<Vec<u8>>,
}

impl<const N: usize> TableWriter<N> {
    /// A file without rows.
    ///
    /// # Errors
    ///
    /// If the library fails.
    pub fn new(columns: [(&'static str, Form); N]) -> Result<Self, Failure> {
        let schema: Vec<String> = columns
            .iter()
            .map(|(name, form)| match form {
                Form::Text => format!("optional binary {name} (UTF8);"),
                Form::Whole => format!("optional int64 {name};"),
                Form::Real => format!("optional double {name};"),
                Form::Flag => format!("optional boolean {name};"),
            })
            .collect();
        let schema = parse_message_type(&format!("message table {{ {} }}", schema.join(" ")));
        let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
        let file = schema.and_then(|schema| {
            SerializedFileWriter::new(Vec::new(), Arc::new(schema), Arc::new(properties))
        });
        Ok(Self { columns, file: file.map_err(failed)? })
    }

    /// Adds the rows of a table of the same columns.
    ///
    /// # Errors
    ///
    /// As [`Table::parquet`].
    pub fn append(&mut self, table: &Table<'_, N>) -> Result<(), Failure> {
        self.appended(table).map_err(failed)
    }

    /// The bytes of the file.
    ///
    /// # Errors
    ///
    /// If the library fails.
    pub fn finish(self) -> Result<Vec<u8>, Failure> {
        self.file.into_inner().map_err(failed)
    }

    fn appended(&mut self, table: &Table<'_, N>) -> Result<(), ParquetError> {
        for rows in table.rows.chunks(ROWS) {
            let mut group = self.file.next_row_group()?;
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
                    Form::Flag => {
                        let flags = filled.map(|value| match value {
                            Value::Flag(is_so) => Ok(is_so),
                            _ => Err(wrong()),
                        });
                        let flags = flags.collect::<Result<Vec<_>, _>>()?;
                        column.typed::<BoolType>().write_batch(&flags, Some(&levels), None)?;
                    }
                }
                column.close()?;
            }
            group.close()?;
        }
        Ok(())
    }
}

fn failed(error: ParquetError) -> Failure {
    Failure::internal(format!("Parquet: {error}"))
}

/// Rows of a row group.
pub(crate) const ROWS: usize = 100_000;

#[cfg(test)]
mod tests {
    //! CSV has the same rows, and what does not fit its column is refused.

    use super::*;

    #[test]
    fn csv_has_the_same_rows() {
        let mut table = Table::new([("name", Form::Text), ("share", Form::Real)]);
        table.push([Value::Text("a"), Value::Real(0.25, 1)]);
        table.push([Value::Empty, Value::Empty]);
        assert_eq!(table.csv(), "name,share\na,0.2\n,\n");
    }

    #[test]
    fn a_value_of_another_form_is_refused() {
        for form in [Form::Text, Form::Whole, Form::Flag] {
            let mut wrong = Table::new([("x", form)]);
            wrong.push([Value::Real(1.0, 0)]);
            assert!(wrong.parquet().is_err(), "{form:?}");
        }
    }
}
