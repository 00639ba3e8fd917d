//! Opening model files: every error names the file and says what to do.
//!
//! ```
//! # use trolley::model::{self, Generate, Shape};
//! # let folder = std::env::temp_dir().join(format!("trolley-open-{}", std::process::id()));
//! # std::fs::create_dir_all(&folder).ok();
//! # let out = folder.join("pole.trolley");
//! # let tree = model::tree(model::Build::Paper, 4);
//! # let (shape, triangles, seed) = (Shape::Pole, 600, 0);
//! # let pole = Generate { shape, triangles, seed, tree, out: out.clone() };
//! # let generated = pole.run(&|_, _| {})?;
//! use trolley::files::InputKind;
//! use trolley::model::open;
//!
//! let map = open::bytes(&out, InputKind::Model)?;
//! let (meta, body) = open::view(&out, map.bytes())?;
//! assert_eq!((meta.name.as_str(), body.corners.len()), ("pole", 600));
//! # std::fs::remove_dir_all(&folder).ok();
//! # Ok::<(), trolley::Failure>(())
//! ```

use body::{BodyView, Meta, file};
use diagnostic::Failure;
use runtime::{InputKind, input};
use std::path::Path;

/// Reads a file of this kind into memory of its own, which begins with a page.
///
/// ```
/// # use trolley::model::{self, Generate, Shape};
/// # let folder = std::env::temp_dir().join(format!("trolley-open-bytes-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let out = folder.join("pole.trolley");
/// # let tree = model::tree(model::Build::Paper, 4);
/// # let (shape, triangles, seed) = (Shape::Pole, 600, 0);
/// # let pole = Generate { shape, triangles, seed, tree, out: out.clone() };
/// # let generated = pole.run(&|_, _| {})?;
/// use trolley::files::InputKind;
///
/// let map = model::open::bytes(&out, InputKind::Model)?;
/// assert_eq!(map.bytes().len(), generated.body.bytes);
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use mesh::reader::open::bytes;

/// Allocates memory for a model file.
///
/// ```
/// let mut buffer = trolley::model::open::zeroed_buffer(1024);
/// buffer.bytes_mut().fill(1);
/// assert_eq!(buffer.bytes().len(), 1024);
/// ```
pub use mesh::reader::open::zeroed_buffer;

/// Reads a model file into memory: a mapped file could change after it was verified.
///
/// ```
/// # use trolley::model::{self, Generate, Shape};
/// # let folder = std::env::temp_dir().join(format!("trolley-copy-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let out = folder.join("pole.trolley");
/// # let tree = model::tree(model::Build::Paper, 4);
/// # let (shape, triangles, seed) = (Shape::Pole, 600, 0);
/// # let pole = Generate { shape, triangles, seed, tree, out: out.clone() };
/// # let generated = pole.run(&|_, _| {})?;
/// let copy = model::open::copy(&out)?;
/// assert_eq!(copy.bytes().len(), generated.body.bytes);
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
///
/// # Errors
///
/// If the file does not exist or cannot be read.
pub fn copy(path: &Path) -> Result<file::Aligned, Failure> {
    let map = bytes(path, InputKind::Model)?;
    let mut copy = zeroed_buffer(map.bytes().len());
    copy.bytes_mut().copy_from_slice(map.bytes());
    Ok(copy)
}

/// Verifies the bytes of a model file, and returns a view of them; `path` is for messages.
///
/// ```
/// # use trolley::model::{self, Generate, Shape};
/// # let folder = std::env::temp_dir().join(format!("trolley-view-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let out = folder.join("pole.trolley");
/// # let tree = model::tree(model::Build::Paper, 4);
/// # let (shape, triangles, seed) = (Shape::Pole, 600, 0);
/// # let pole = Generate { shape, triangles, seed, tree, out: out.clone() };
/// # let generated = pole.run(&|_, _| {})?;
/// use trolley::model::open;
///
/// let copy = open::copy(&out)?;
/// let (meta, body) = open::view(&out, copy.bytes())?;
/// assert_eq!(body.corners.len(), 600);
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
///
/// # Errors
///
/// If the bytes are not a valid model file.
pub fn view<'a>(path: &Path, bytes: &'a [u8]) -> Result<(Meta, BodyView<'a>), Failure> {
    file::view(bytes).map_err(|error| Failure::from(error).at(path.display()))
}

/// Returns whether a file is a model file, by its ending or its first bytes.
///
/// ```
/// use trolley::model::open::is_model;
///
/// assert!(is_model("car.trolley".as_ref()));
/// assert!(!is_model("examples/data/pole.stl".as_ref()));
/// ```
#[must_use]
pub fn is_model(path: &Path) -> bool {
    let is_named = path.extension().is_some_and(|end| end == "trolley");
    is_named || begins_like_a_model(path)
}

fn begins_like_a_model(path: &Path) -> bool {
    let mut start = [0; file::MAGIC.len()];
    input::start(path, &mut start) == start.len() && start == file::MAGIC
}
