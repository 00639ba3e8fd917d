//! Which files scenarios and deployments may name.

use clap::Args;
use trolley::References;

/// Which files may be named.
#[derive(Clone, Copy, Debug, Default, Args)]
pub(crate) struct ReferenceArgs {
    /// Let the files given here name policies, curves and models outside of their own folders.
    #[arg(long)]
    allow_outside: bool,
}

impl ReferenceArgs {
    pub(crate) fn references(self) -> References {
        if self.allow_outside { References::Anywhere } else { References::Inside }
    }
}
