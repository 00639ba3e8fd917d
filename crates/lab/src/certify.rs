//! What bounds, deadlines and budgets are worth, measured on requests of chance.
//!
//! What must hold is checked on the way: a violation of a bound is counted and told, any other is
//! an error.

mod bounds;
mod budget;
mod deadline;
mod figures;
mod requests;
mod share;

pub use bounds::{BoundsOptions, BoundsReport, bounds};
pub use budget::{BudgetOptions, BudgetReport, budget};
pub use coordinator::BoundFlaw;
pub use deadline::{DeadlineOptions, DeadlineReport, deadline};
pub use share::{ShareOptions, ShareReport, share};

/// Most tests of a job, where nothing else is said.
pub const BUDGET: u64 = coordinator::RequestLimits::BUDGET;
