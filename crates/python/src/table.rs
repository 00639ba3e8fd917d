//! Many rankings as an Arrow table of candidates, handed over in place.

use crate::errors::raise;
use crate::ranking::RankedScenes;
use arrow_array::builder::{
    BooleanBuilder, Float64Builder, Int32Builder, Int64Builder, StringBuilder,
};
use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::{ArrayRef, RecordBatch, RecordBatchIterator, RecordBatchReader};
use arrow_schema::ArrowError;
use pyo3::prelude::*;
use pyo3::types::PyCapsule;
use std::sync::Arc;
use trolley::Failure;

/// The columns, while they are filled.
#[derive(Default)]
struct Columns {
    scene: Int64Builder,
    scenario: StringBuilder,
    policy: StringBuilder,
    curves: StringBuilder,
    state: StringBuilder,
    place: Int32Builder,
    candidate: StringBuilder,
    is_best: BooleanBuilder,
    bounds: [Float64Builder; 4],
    is_certain: BooleanBuilder,
    why: StringBuilder,
    contacts: Int32Builder,
    first_party: StringBuilder,
    first_contact_s: Float64Builder,
}

/// The rankings as a stream of one batch, a row for each candidate in its place.
pub(crate) fn stream<'py>(
    py: Python<'py>,
    rankings: &RankedScenes,
) -> PyResult<Bound<'py, PyCapsule>> {
    let batch = py.detach(|| table(rankings));
    let batch =
        batch.map_err(|error| raise(py, &Failure::internal(format!("no table: {error}"))))?;
    let schema = batch.schema();
    let reader: Box<dyn RecordBatchReader + Send> =
        Box::new(RecordBatchIterator::new([Ok(batch)], schema));
    PyCapsule::new_with_value(py, FFI_ArrowArrayStream::new(reader), c"arrow_array_stream")
}

fn table(rankings: &RankedScenes) -> Result<RecordBatch, ArrowError> {
    let mut columns = Columns::default();
    for (number, outcome) in rankings.outcomes.iter().enumerate() {
        let Ok(outcome) = outcome else { continue };
        let scene = outcome.scene.unwrap_or(number);
        let answer = &outcome.answer;
        let best = answer.best().map(|best| best.name.as_str());
        for (place, row) in (1..).zip(&answer.ranking) {
            columns.scene.append_value(scene as i64);
            columns.scenario.append_value(&outcome.name);
            columns.policy.append_value(&answer.policy);
            columns.curves.append_value(&outcome.curves);
            columns.state.append_value(answer.state.name());
            columns.place.append_value(place);
            columns.candidate.append_value(&row.name);
            columns.is_best.append_value(best == Some(row.name.as_str()));
            let bounds = [row.work.lo(), row.work.hi(), row.range.low(), row.range.high()];
            for (column, bound) in columns.bounds.iter_mut().zip(bounds) {
                column.append_value(bound);
            }
            columns.is_certain.append_value(row.certain);
            columns.why.append_option(row.why.as_deref());
            columns.contacts.append_value(i32::try_from(row.contacts.len()).unwrap_or(i32::MAX));
            let first = row.contacts.first();
            columns.first_party.append_option(first.map(|contact| contact.party.as_str()));
            columns.first_contact_s.append_option(first.map(|contact| contact.time_s));
        }
    }
    let Columns { mut bounds, .. } = columns;
    let [lo, hi, low, high] = &mut bounds;
    RecordBatch::try_from_iter_with_nullable([
        ("scene", Arc::new(columns.scene.finish()) as ArrayRef, false),
        ("scenario", Arc::new(columns.scenario.finish()), false),
        ("policy", Arc::new(columns.policy.finish()), false),
        ("curves", Arc::new(columns.curves.finish()), false),
        ("state", Arc::new(columns.state.finish()), false),
        ("place", Arc::new(columns.place.finish()), false),
        ("candidate", Arc::new(columns.candidate.finish()), false),
        ("is_best", Arc::new(columns.is_best.finish()), false),
        ("work_lo", Arc::new(lo.finish()), false),
        ("work_hi", Arc::new(hi.finish()), false),
        ("range_low", Arc::new(low.finish()), false),
        ("range_high", Arc::new(high.finish()), false),
        ("is_certain", Arc::new(columns.is_certain.finish()), false),
        ("why", Arc::new(columns.why.finish()), true),
        ("contacts", Arc::new(columns.contacts.finish()), false),
        ("first_party", Arc::new(columns.first_party.finish()), true),
        ("first_contact_s", Arc::new(columns.first_contact_s.finish()), true),
    ])
}
