//! One body as the model store takes it: opened, generated, or made by the caller.

use super::{generate, with_tree};
use crate::Failure;
use body::{BodyKind, BodyView, Fit, Meta, Shape, defaults, file};
use bvh::BuildOptions;
use runtime::{FileMap, InputError, InputKind};
use std::path::Path;

/// A body on its way into the model store.
///
/// ```
/// # use trolley::bodies::{Bodies, ModelFile};
/// # use trolley::model::{BuildOptions, Shape};
/// let pole = ModelFile::generate(Shape::Pole, 600, 0, &BuildOptions::default())?;
/// println!("a {}, {} bytes", pole.kind(), pole.bytes().len());
/// # assert_eq!(pole.kind(), trolley::model::BodyKind::Pole);
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Debug)]
pub struct ModelFile {
    kind: BodyKind,
    bytes: file::Aligned,
    pub(super) source_hash: Option<String>,
}

impl ModelFile {
    /// Opens a model file. Its tree is rebuilt if `options` ask for another one; with a `size` (m),
    /// the body is stretched to it.
    ///
    /// ```
    /// # use trolley::bodies::ModelFile;
    /// # use trolley::model::{BuildOptions, Shape};
    /// # let pole = ModelFile::generate(Shape::Pole, 600, 0, &BuildOptions::default())?;
    /// # let folder = std::env::temp_dir().join(format!("trolley-open-{}", std::process::id()));
    /// # std::fs::create_dir_all(&folder).ok();
    /// # let path = folder.join("pole.trolley");
    /// # trolley::files::replace(&path, pole.bytes())?;
    /// let options = BuildOptions { leaf_size: 8, ..BuildOptions::default() };
    /// let pole = ModelFile::open(&path, None, &options)?;
    /// assert!(pole.source_hash().is_some());
    /// # std::fs::remove_dir_all(&folder).ok();
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If the file cannot be read or is no sound model file.
    pub fn open(path: &Path, size: Option<Fit>, options: &BuildOptions) -> Result<Self, Failure> {
        let map = FileMap::open(path, InputKind::Model).map_err(|error| match error {
            InputError::Missing { .. } => Failure::from(error)
                .with_remedy("paths are relative to the folder of the file that names them"),
            other => other.into(),
        })?;
        let bad = |error: file::FileError| Failure::from(error).at(path.display());
        let (meta, view) = file::view(map.bytes()).map_err(bad)?;
        let source_hash = Some(file::content_hash(map.bytes()).map_err(bad)?);
        if let Some(size) = size {
            let body = stretched(&meta, &view, size, options)?;
            return Ok(Self { source_hash, ..Self::of(&body)? });
        }
        if meta.build == options.build && meta.leaf_size == options.leaf_size {
            let bytes = file::Aligned::copy_of(map.bytes());
            return Ok(Self { kind: meta.kind, bytes, source_hash });
        }
        let body = bvh::rebuild(view, &meta, options, &|_| {})
            .map_err(|error| Failure::from(error).at(path.display()))?;
        Ok(Self { source_hash, ..Self::of(&body)? })
    }

    /// Opens a model file, and keeps its tree.
    ///
    /// ```
    /// # use trolley::bodies::ModelFile;
    /// # use trolley::model::{BuildOptions, Shape};
    /// # let pole = ModelFile::generate(Shape::Pole, 600, 0, &BuildOptions::default())?;
    /// # let folder = std::env::temp_dir();
    /// # let folder = folder.join(format!("trolley-as-it-is-{}", std::process::id()));
    /// # std::fs::create_dir_all(&folder).ok();
    /// # let path = folder.join("pole.trolley");
    /// # trolley::files::replace(&path, pole.bytes())?;
    /// let same = ModelFile::as_it_is(&path)?;
    /// assert_eq!(same.bytes(), pole.bytes());
    /// # std::fs::remove_dir_all(&folder).ok();
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If the file cannot be read or is no sound model file.
    pub fn as_it_is(path: &Path) -> Result<Self, Failure> {
        let map = FileMap::open(path, InputKind::Model)?;
        // The copy is checked: a file may change while it is mapped.
        let bytes = file::Aligned::copy_of(map.bytes());
        let bad = |error: file::FileError| Failure::from(error).at(path.display());
        let (meta, _) = file::view(bytes.bytes()).map_err(bad)?;
        let source_hash = Some(file::content_hash(bytes.bytes()).map_err(bad)?);
        Ok(Self { kind: meta.kind, bytes, source_hash })
    }

    /// Generates a body and builds its tree.
    ///
    /// ```
    /// # use trolley::bodies::ModelFile;
    /// # use trolley::model::{BuildOptions, Shape};
    /// let suv = ModelFile::generate(Shape::Suv, 1500, 0, &BuildOptions::default())?;
    /// let another = ModelFile::generate(Shape::Suv, 1500, 1, &BuildOptions::default())?;
    /// assert_ne!(suv.bytes(), another.bytes());
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If `triangles` is out of range for the shape.
    pub fn generate(
        shape: Shape,
        triangles: u32,
        seed: u64,
        options: &BuildOptions,
    ) -> Result<Self, Failure> {
        Self::of(&generate(shape, triangles, seed, options, &|_| {})?)
    }

    /// Encodes a body as a model file in memory.
    ///
    /// ```
    /// # use trolley::bodies::ModelFile;
    /// # use trolley::model::{BuildOptions, Shape};
    /// let options = BuildOptions::default();
    /// let body = trolley::bodies::generate(Shape::Pole, 600, 0, &options, &|_| {})?;
    /// let file = ModelFile::of(&body)?;
    /// assert_eq!(file.kind(), body.meta.kind);
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If its names are too long for a model file.
    pub fn of(body: &body::Body) -> Result<Self, Failure> {
        let bytes = file::encode(body)?;
        let bytes = file::Aligned::copy_of(&bytes);
        Ok(Self { kind: body.meta.kind, bytes, source_hash: None })
    }

    /// Returns the kind of the body.
    ///
    /// ```
    /// # use trolley::bodies::{Bodies, ModelFile};
    /// # use trolley::model::{BuildOptions, Shape};
    /// # let pole = ModelFile::generate(Shape::Pole, 600, 0, &BuildOptions::default())?;
    /// assert_eq!(pole.kind(), trolley::model::BodyKind::Pole);
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn kind(&self) -> BodyKind {
        self.kind
    }

    /// Returns the bytes of the model file.
    ///
    /// ```
    /// # use trolley::bodies::ModelFile;
    /// # use trolley::model::{BuildOptions, Shape};
    /// # let pole = ModelFile::generate(Shape::Pole, 600, 0, &BuildOptions::default())?;
    /// # let folder = std::env::temp_dir().join(format!("trolley-bytes-{}", std::process::id()));
    /// # std::fs::create_dir_all(&folder).ok();
    /// # let path = folder.join("pole.trolley");
    /// # trolley::files::replace(&path, pole.bytes())?;
    /// trolley::files::replace(&path, pole.bytes())?;
    /// assert!(trolley::model::open::is_model(&path));
    /// # std::fs::remove_dir_all(&folder).ok();
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.bytes.bytes()
    }

    /// Returns the content hash of the file that was opened; `None` if the body was generated.
    ///
    /// ```
    /// # use trolley::bodies::{Bodies, ModelFile};
    /// # use trolley::model::{BuildOptions, Shape};
    /// # let pole = ModelFile::generate(Shape::Pole, 600, 0, &BuildOptions::default())?;
    /// assert!(pole.source_hash().is_none(), "it was generated");
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn source_hash(&self) -> Option<&str> {
        self.source_hash.as_deref()
    }
}

/// A body stretched to a size. What depends on the size is computed again; a stated mass stays.
pub(super) fn stretched(
    meta: &Meta,
    view: &BodyView<'_>,
    size: Fit,
    options: &BuildOptions,
) -> Result<body::Body, Failure> {
    let mesh = body::fit::fitted(body::fit::mesh_of(meta, view), size);
    let origin = defaults::Origin {
        name: &meta.name,
        kind: meta.kind,
        origin: &format!("{}, stretched", meta.origin),
        hash: &meta.origin_hash,
    };
    bvh::in_threads(options.threads, mesh.corners.len(), || {
        let mut new = defaults::assemble(origin, &mesh);
        if !meta.mass_source.starts_with("default") {
            new.mass_kg = meta.mass_kg;
            new.mass_source.clone_from(&meta.mass_source);
        }
        new.occupants.clone_from(&meta.occupants);
        with_tree(mesh, new, options, &|_| {})
    })
}
