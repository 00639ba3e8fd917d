//! What candidates are assessed and ranked by: policy, curves and parameters together.

use crate::fault::DataFileError;
use crate::injury::Curves;
use crate::parameters::Parameters;
use crate::policy::Policy;
use std::sync::Arc;

/// A policy, the injury curves and the parameters of contact and dynamics that it is applied with.
#[derive(Clone, Debug)]
pub struct Criteria {
    /// How candidates are compared.
    pub policy: Arc<Policy>,
    /// Whose risk follows which curve.
    pub curves: Arc<Curves>,
    /// Contact and dynamics.
    pub parameters: Arc<Parameters>,
}

impl Criteria {
    /// A policy with the curves and parameters that ship with the program.
    ///
    /// # Errors
    ///
    /// Never for the files as shipped: tests read them.
    pub fn with_policy(policy: Policy) -> Result<Self, DataFileError> {
        Ok(Self {
            policy: Arc::new(policy),
            curves: Arc::new(Curves::shipped()?),
            parameters: Arc::new(Parameters::shipped()?),
        })
    }
}
