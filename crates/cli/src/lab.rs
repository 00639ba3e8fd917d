//! The laboratory's commands: parse flags, call the crate `lab` once, print.

pub(crate) mod calibrate;
pub(crate) mod certify;
pub(crate) mod inject;
pub(crate) mod measure;
pub(crate) mod shown;
pub(crate) mod simulate;
pub(crate) mod validate;
