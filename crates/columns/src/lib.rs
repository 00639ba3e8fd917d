//! Tables of plain columns: written as Parquet, and as CSV where they are short, from the same
//! values; columns of such a file read again.
//!
//! A column holds texts, whole numbers, real numbers or truth values, and any of its values may be
//! missing. Pure: bytes come out, and what is read is an open file.
//!
//! # Invariants
//!
//! - What is written is read back, value by value; what does not fit its column is refused:
//!   `table.rs`, `read.rs`.
//!
//! ```
//! use trolley_columns::{Form, Table, Value};
//!
//! let mut table = Table::new([("scheme", Form::Text), ("share", Form::Real)]);
//! table.push([Value::Text("best-match"), Value::Real(0.25, 2)]);
//! assert_eq!(table.csv(), "scheme,share\nbest-match,0.25\n");
//! assert!(table.parquet().is_ok_and(|bytes| bytes.starts_with(b"PAR1")));
//! ```

mod read;
mod table;

pub use read::{ReadColumn, read};
pub use table::{Form, Table, TableWriter, Value};
