//! Checks bounds, deadlines, budgets and members on random requests.
//!
//! Violations of a bound are counted and reported; any other violation is an error.

mod bounds;
mod budget;
mod deadline;
mod figures;
mod members;
mod requests;
mod share;

pub use bounds::{BoundsOptions, BoundsReport, bounds};
pub use budget::{BudgetOptions, BudgetReport, budget};
pub use coordinator::CourseFlaw;
pub use deadline::{DeadlineOptions, DeadlineReport, deadline};
pub use members::{CountRow, FamilyRow, MembersOptions, MembersReport, WrongPairs, members};
pub use share::{ShareOptions, ShareReport, share};

/// Default maximum number of tests per job.
pub const BUDGET: u64 = coordinator::RequestLimits::BUDGET;
