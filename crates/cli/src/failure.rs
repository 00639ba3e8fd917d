//! What went wrong, for the person at the terminal and for the shell.

use runtime::error::chain;
use std::fmt;
use std::process::ExitCode;

/// Exit codes, after sysexits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Code {
    /// A check that this command made has failed.
    GateFailed = 1,
    /// The answer is degraded: bounds, not figures.
    Degraded = 3,
    /// No answer can be given to this request.
    Refused = 4,
    /// A mesh, model, scenario, policy or curve file is at fault.
    Input = 65,
    /// Memory, shared memory, descriptors or workers ran out.
    Resources = 69,
    /// A mistake of ours.
    Internal = 70,
    /// The operating system refused.
    System = 71,
    /// Somebody else is in the way: try again.
    TryAgain = 75,
    /// Two versions of this program met.
    Skew = 76,
    /// Real time was required, and is not to be had.
    NoRealtime = 77,
    /// A setting is at fault.
    Configuration = 78,
    /// SIGINT or SIGTERM.
    Interrupted = 130,
}

impl From<Code> for ExitCode {
    fn from(code: Code) -> Self {
        Self::from(code as u8)
    }
}

/// A failure: file, place, fault; then the remedy.
#[derive(Debug)]
pub(crate) struct Failure {
    pub(crate) code: Code,
    pub(crate) fault: String,
    pub(crate) help: Option<String>,
}

impl Failure {
    pub(crate) fn new(code: Code, fault: impl Into<String>) -> Self {
        Self { code, fault: fault.into(), help: None }
    }

    pub(crate) fn input(fault: impl Into<String>) -> Self {
        Self::new(Code::Input, fault)
    }

    pub(crate) fn help(self, help: impl Into<String>) -> Self {
        Self { help: Some(help.into()), ..self }
    }

    /// Stdout could not be written.
    pub(crate) fn output(error: std::io::Error) -> Self {
        Self::new(Code::System, format!("cannot write the output: {error}"))
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.fault)?;
        match &self.help {
            Some(help) => write!(f, "\n  help: {help}"),
            None => Ok(()),
        }
    }
}

impl From<scenario::ScenarioError> for Failure {
    fn from(error: scenario::ScenarioError) -> Self {
        Self::input(error.to_string())
    }
}

impl From<runtime::OsError> for Failure {
    fn from(error: runtime::OsError) -> Self {
        Self::new(Code::System, chain(&error))
    }
}

impl From<geometry::simd::Unavailable> for Failure {
    fn from(error: geometry::simd::Unavailable) -> Self {
        Self::new(Code::Configuration, error.to_string())
    }
}

impl From<worker::WorkerError> for Failure {
    fn from(error: worker::WorkerError) -> Self {
        let code = match &error {
            worker::WorkerError::Launch => Code::Configuration,
            worker::WorkerError::Open(open) if open.is_skew() => Code::Skew,
            worker::WorkerError::Open(_) => Code::Resources,
            worker::WorkerError::System(_) => Code::System,
            worker::WorkerError::Use(_)
            | worker::WorkerError::Batch(_)
            | worker::WorkerError::Store(_) => Code::Internal,
        };
        Self::new(code, chain(&error))
    }
}

impl From<coordinator::RequestError> for Failure {
    fn from(error: coordinator::RequestError) -> Self {
        Self::new(Code::Refused, chain(&error)).help("correct the candidate, or leave it out")
    }
}

impl From<coordinator::CrewError> for Failure {
    fn from(error: coordinator::CrewError) -> Self {
        use coordinator::CrewError;
        if let CrewError::Lack(lack) = error {
            return Self::new(Code::Resources, lack.what).help(lack.remedy);
        }
        let (code, help) = match &error {
            CrewError::System(_) => (Code::System, None),
            CrewError::Open(open) if open.is_skew() => (Code::Skew, None),
            _ if error.is_setting() => (Code::Configuration, None),
            CrewError::Open(_) => (
                Code::Resources,
                Some("shared memory must be writable and large enough: df -h /dev/shm"),
            ),
            CrewError::StillBorn { .. } | CrewError::Mute { .. } => (Code::Resources, None),
            CrewError::Thrashed(_) => (
                Code::Resources,
                Some("more --depth makes sections smaller, --memory-budget gives more room"),
            ),
            CrewError::NobodyLeft { .. } | CrewError::Lack(_) => (Code::Resources, None),
            CrewError::Interrupted => (Code::Interrupted, None),
        };
        Self { code, fault: chain(&error), help: help.map(str::to_owned) }
    }
}

/// A channel that cannot be opened.
pub(crate) fn unopened(error: &transport::OpenError) -> Failure {
    use transport::OpenError;
    let (code, help) = match error {
        OpenError::Skew { .. } => (Code::Skew, "start both from the same program"),
        OpenError::Name { .. } | OpenError::Text { .. } | OpenError::RootTooLong { .. } => {
            (Code::Configuration, "correct `instance` and `folder` in the deployment file")
        }
        OpenError::Taken { .. } => {
            (Code::TryAgain, "stop the other one, or choose another instance")
        }
        OpenError::NoService { .. } => (Code::TryAgain, "start it: trolley serve DEPLOYMENT.toml"),
        OpenError::Failed { .. } => {
            (Code::Resources, "/dev/shm and the folder must be writable and large enough")
        }
    };
    Failure::new(code, chain(error)).help(help)
}

impl From<service::DeploymentError> for Failure {
    fn from(error: service::DeploymentError) -> Self {
        Self::new(Code::Configuration, error.to_string())
    }
}

impl From<service::ServiceError> for Failure {
    fn from(error: service::ServiceError) -> Self {
        use service::ServiceError;
        match error {
            ServiceError::Open(error) => unopened(&error),
            ServiceError::Crew(error) => error.into(),
            ServiceError::System(error) => error.into(),
            ServiceError::Files { .. } => Self::new(Code::System, chain(&error))
                .help("`decisions` needs a folder that may be written to"),
            ServiceError::NoRealtime(_) => Self::new(Code::NoRealtime, error.to_string()).help(
                "raise LimitRTPRIO and LimitMEMLOCK (see tools/systemd), or start without \
                 --require-rt",
            ),
            ServiceError::Memory => Self::new(Code::Resources, error.to_string()),
        }
    }
}
