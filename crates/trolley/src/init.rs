//! A scenario to begin with: commented, and ranked at once.

/// `config/examples/crash.toml`.
const TEXT: &str = include_str!("../config/examples/crash.toml");

/// The ego's body in [`TEXT`], and the comment that says how to have another.
const GENERATED: &str = "generate = { shape = \"sedan\", triangles = 5000 }\n\
    # file = \"car.trolley\"            # your own body instead: `trolley model import`\n";

/// Returns the text of a scenario whose ego has a generated body, or that of a model file, named
/// relative to the scenario's folder.
///
/// ```
/// let text = trolley::init::scenario(None);
/// let scenario = trolley::Scenario::parse("crash.toml", &text)?;
/// assert_eq!(scenario.parsed().candidates.len(), 4);
///
/// let own = trolley::init::scenario(Some("car.trolley"));
/// assert!(own.contains("file = \"car.trolley\""));
/// assert!(trolley::Scenario::parse("crash.toml", &own).is_ok());
/// # Ok::<(), trolley::Failure>(())
/// ```
#[must_use]
pub fn scenario(body: Option<&str>) -> String {
    match body {
        None => TEXT.to_owned(),
        Some(path) => TEXT.replacen(GENERATED, &format!("file = {path:?}\n"), 1),
    }
}
