//! From a text to checked values, with the place of whatever is wrong.
//!
//! Each fault carries the path of keys to what is wrong; [`Document`] turns it into line and
//! column.

use crate::document::{Document, Objection, Path};
use crate::error::{Misfit, ScenarioError};
use crate::explain::explain;
use crate::names::quoted;
use serde::de::DeserializeOwned;
use toml::de::DeValue;

/// A broken rule and the path to what breaks it.
pub(crate) struct Fault {
    pub(crate) path: Path,
    pub(crate) misfit: Misfit,
}

/// Adds the position of a misfit.
pub(crate) trait At<T> {
    fn at(self, path: &Path) -> Result<T, Fault>;
}

impl<T> At<T> for Result<T, Misfit> {
    fn at(self, path: &Path) -> Result<T, Fault> {
        self.map_err(|misfit| Fault { path: path.clone(), misfit })
    }
}

/// Reads a text of this form, the value of its key `schema`, and checks what it says.
pub(crate) fn read<R: DeserializeOwned, T>(
    file: &str,
    text: &str,
    schema: &str,
    check: impl FnOnce(R, &Document<'_>) -> Result<T, Fault>,
) -> Result<T, ScenarioError> {
    let objected = |objection: Objection| {
        let (fault, help) = explain(&objection);
        ScenarioError::new(file, objection.place, fault, help)
    };
    let document = Document::parse(text).map_err(objected)?;
    let broken = |Fault { path, misfit }| {
        ScenarioError::new(file, document.place(&path), misfit.what, misfit.remedy)
    };
    // The version comes first: another form may have keys that this one does not know.
    version(&document, schema).map_err(broken)?;
    let raw = document.read::<R>().map_err(objected)?;
    check(raw, &document).map_err(broken)
}

/// The form of early versions: pairs of bodies at a predicted impact.
const FORMER: &str = "trolley.scenario/1";

/// Whether the text declares this schema version.
fn version(document: &Document<'_>, schema: &str) -> Result<(), Fault> {
    let path = Path::default().key("schema");
    let fault = match document.value(&path).map(DeValue::as_str) {
        Some(Some(known)) if known == schema => return Ok(()),
        Some(Some(other)) => format!("schema {} is not known", quoted(other)),
        Some(None) => "schema is not text".to_owned(),
        None => "schema is missing".to_owned(),
    };
    let help = if document.value(&path).and_then(DeValue::as_str) == Some(FORMER) {
        format!(
            "write schema = {schema:?}: give every party a place, a state or paths, and every \
             candidate the ego's way; contacts are found (`trolley schema` prints every key)"
        )
    } else {
        format!("this version reads schema = {schema:?}")
    };
    Err(Misfit::new("schema", fault, help)).at(&path)
}
