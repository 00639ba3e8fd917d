//! The commands of the laboratory: flags, one call of the crate `lab`, print.

pub(crate) mod calibrate;
pub(crate) mod certify;
pub(crate) mod inject;
pub(crate) mod measure;
pub(crate) mod shown;
pub(crate) mod simulate;
