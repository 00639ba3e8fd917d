//! The Python package `trolley_av`: exact intersection of meshes, and the ranking of manoeuvres.
//!
//! ```text
//! numpy arrays --arrays--> MeshBody --queries--> numpy arrays      meshes of anybody
//! ScenarioText --session--> an engine's thread --> RankedScene     scenarios, ranked
//!                              '--> SearchedScene --searched--> RankedScene: one for each policy
//! ```
//!
//! Functions copy what they are given, release Python's lock for the work, and return new arrays.
//! What is refused is raised with its place and a remedy. `python/trolley_av` has the Python part,
//! the signatures and the documentation of every name.

mod arrays;
mod batch;
mod errors;
mod mesh_body;
mod queries;
mod ranking;
mod scenario;
mod scene;
mod searched;
mod session;
mod study;
#[cfg(feature = "arrow")]
mod table;

use pyo3::prelude::*;

/// The compiled part of `trolley_av`.
#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<mesh_body::MeshBody>()?;
    module.add_class::<scene::MeshScene>()?;
    module.add_class::<scenario::ScenarioText>()?;
    module.add_class::<session::RankingSession>()?;
    module.add_class::<ranking::RankedScene>()?;
    module.add_class::<ranking::RankedScenes>()?;
    module.add_class::<searched::SearchedScene>()?;
    module.add_function(wrap_pyfunction!(queries::touches, module)?)?;
    module.add_function(wrap_pyfunction!(queries::pairs, module)?)?;
    module.add_function(wrap_pyfunction!(queries::hits, module)?)?;
    module.add_function(wrap_pyfunction!(queries::first_contact, module)?)?;
    module.add_function(wrap_pyfunction!(queries::segments, module)?)?;
    module.add_function(wrap_pyfunction!(queries::self_pairs, module)?)?;
    module.add_function(wrap_pyfunction!(searched::assess_many, module)?)?;
    module.add_function(wrap_pyfunction!(scenario::policy_names, module)?)?;
    module.add_function(wrap_pyfunction!(scenario::check_policies, module)?)?;
    module.add_function(wrap_pyfunction!(study::study_plan, module)?)?;
    module.add_function(wrap_pyfunction!(study::study_run_shard, module)?)?;
    module.add_function(wrap_pyfunction!(study::study_status, module)?)?;
    module.add_function(wrap_pyfunction!(study::study_check, module)?)?;
    module.add("BUILD", trolley::BUILD)?;
    Ok(())
}
