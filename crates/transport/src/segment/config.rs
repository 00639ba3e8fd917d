//! Where a segment lies: folder, prefix, type, name and suffix make its path.

use super::Segment;
use core::fmt::Debug;
use core::marker::PhantomData;
use iceoryx2::prelude::{FileName, Path as IceoryxPath, SemanticString};
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;
use iceoryx2_cal::dynamic_storage::DynamicStorage;
use iceoryx2_cal::dynamic_storage::dynamic_storage_configuration::DynamicStorageConfiguration;
use iceoryx2_cal::named_concept::{FilePath, NamedConceptConfiguration, NamedConceptMgmt};
use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt as _;
use std::path::{Path, PathBuf};

/// The folder of segments of a type, and what their names begin and end with.
#[derive(Debug)]
pub(crate) struct SegmentConfig<T> {
    prefix: FileName,
    suffix: FileName,
    folder: IceoryxPath,
    type_name: String,
    of: PhantomData<fn() -> T>,
}

impl<T> SegmentConfig<T> {
    pub(super) fn folder(&self) -> &Path {
        Path::new(OsStr::from_bytes(self.folder.as_bytes()))
    }

    pub(super) fn set_type_name(&mut self, name: &str) {
        name.clone_into(&mut self.type_name);
    }
}

impl<T: Debug + Send + Sync + ZeroCopySend> SegmentConfig<T> {
    pub(super) fn file(&self, name: &FileName) -> PathBuf {
        PathBuf::from(OsStr::from_bytes(self.path_for(name).as_bytes()))
    }
}

impl<T> Clone for SegmentConfig<T> {
    fn clone(&self) -> Self {
        let Self { prefix, suffix, folder, ref type_name, of } = *self;
        Self { prefix, suffix, folder, type_name: type_name.clone(), of }
    }
}

impl<T: Debug + Send + Sync + ZeroCopySend> Default for SegmentConfig<T> {
    fn default() -> Self {
        Self {
            prefix: Segment::<T>::default_prefix(),
            suffix: <Segment<T> as DynamicStorage<T>>::default_suffix(),
            folder: Segment::<T>::default_path_hint(),
            type_name: core::any::type_name::<T>().to_owned(),
            of: PhantomData,
        }
    }
}

impl<T: Debug + Send + Sync + ZeroCopySend> DynamicStorageConfiguration for SegmentConfig<T> {
    fn type_name(&self) -> &str {
        &self.type_name
    }
}

impl<T: Debug + Send + Sync + ZeroCopySend> NamedConceptConfiguration for SegmentConfig<T> {
    fn prefix(mut self, value: &FileName) -> Self {
        self.prefix = *value;
        self
    }

    fn get_prefix(&self) -> &FileName {
        &self.prefix
    }

    fn suffix(mut self, value: &FileName) -> Self {
        self.suffix = *value;
        self
    }

    fn get_suffix(&self) -> &FileName {
        &self.suffix
    }

    fn path_hint(mut self, value: &IceoryxPath) -> Self {
        self.folder = *value;
        self
    }

    fn get_path_hint(&self) -> &IceoryxPath {
        &self.folder
    }

    fn path_for(&self, name: &FileName) -> FilePath {
        self.path_for_with_type(name)
    }

    fn extract_name_from_file(&self, file: &FileName) -> Option<FileName> {
        self.extract_name_from_file_with_type(file)
    }
}
