//! The two bodies: meshes, read in a child process, or model files; each with its tree.

use crate::Failure;
use crate::files::InputKind;
use crate::model::open;
use body::{BodyView, Build, Meta, file};
use bvh::BuildOptions;
use diagnostic::chain;
use mesh::reader::{OnProgress, ReadLimits, ReadMesh, ReadRequest};
use runtime::clock::now_ns;
use std::path::Path;

/// A body, and the time to build its tree.
pub(super) struct Body {
    pub(super) meta: Meta,
    held: Held,
    /// 0 if a model file had the tree already.
    pub(super) build_ns: u64,
}

enum Held {
    /// A model file that was verified.
    File(file::Aligned),
    Built(Box<body::Body>),
}

/// How both trees are built where that was left open: as in the first model file, else by surface
/// area, which is the quickest to build and to walk.
pub(super) fn options(
    files: [&Path; 2],
    build: Option<Build>,
    leaf_size: Option<u32>,
    threads: usize,
) -> Result<BuildOptions, Failure> {
    let mut options = BuildOptions { build: Build::Sah, threads, ..BuildOptions::default() };
    if let Some(path) = files.into_iter().find(|path| open::is_model(path)) {
        let map = open::bytes(path, InputKind::Model)?;
        let (meta, _) = open::view(path, map.bytes())?;
        (options.build, options.leaf_size) = (meta.build, meta.leaf_size);
    }
    options.build = build.unwrap_or(options.build);
    options.leaf_size = leaf_size.unwrap_or(options.leaf_size);
    Ok(options)
}

impl Body {
    /// Reads and verifies a body, and rebuilds its tree if another one is asked for.
    pub(super) fn load(
        path: &Path,
        options: &BuildOptions,
        limits: ReadLimits,
        progress: OnProgress<'_>,
    ) -> Result<Self, Failure> {
        let (bytes, build_ns) = if open::is_model(path) {
            (open::copy(path)?, 0)
        } else {
            let ReadMesh { bytes, build_ns, .. } =
                ReadRequest::as_it_stands(path, options, limits)?.run(progress)?;
            (bytes, build_ns)
        };
        let (meta, view) = open::view(path, bytes.bytes())?;
        if (meta.build, meta.leaf_size) == (options.build, options.leaf_size) {
            return Ok(Self { meta, held: Held::File(bytes), build_ns });
        }
        let begun_ns = now_ns();
        let body = bvh::rebuild(view, &meta, options, &|_| {})
            .map_err(|error| Failure::input(format!("{}: {error}", path.display())))?;
        let build_ns = now_ns() - begun_ns;
        Ok(Self { meta: body.meta.clone(), held: Held::Built(Box::new(body)), build_ns })
    }

    pub(super) fn view(&self) -> Result<BodyView<'_>, Failure> {
        match &self.held {
            Held::File(bytes) => file::quick_view(bytes.bytes())
                .map(|(_, view)| view)
                .map_err(|error| Failure::internal(chain(&error))),
            Held::Built(body) => Ok(body.view()),
        }
    }
}
