//! Values of an accessor: positions and indices, with stride, sparse or not, every range checked.

use super::super::MeshDefect;
use ::gltf::json;
use json::accessor::{ComponentType, Type};
use json::validation::Checked;

/// Maximum number of elements of one accessor.
const COUNT_MAX: u64 = 1 << 26;

/// A parsed file with its buffers.
pub(super) struct Source<'a> {
    pub(super) root: &'a json::Root,
    pub(super) buffers: &'a [Vec<u8>],
}

/// Elements `stride` bytes apart.
#[derive(Clone, Copy)]
struct Run<'a> {
    bytes: &'a [u8],
    stride: usize,
}

impl<'a> Run<'a> {
    fn element(&self, at: usize, length: usize) -> Option<&'a [u8]> {
        let start = at.checked_mul(self.stride)?;
        self.bytes.get(start..start.checked_add(length)?)
    }
}

fn no_such(what: &str, index: usize, count: usize) -> MeshDefect {
    MeshDefect::Index { index: index as i64, range: format!("the file has {count} {what}") }
}

fn short(what: &str) -> MeshDefect {
    MeshDefect::Truncated(format!("{what} reaches past the end of its buffer"))
}

impl<'a> Source<'a> {
    /// Positions: three f32 each.
    pub(super) fn positions(&self, number: usize) -> Result<Vec<[f32; 3]>, MeshDefect> {
        let accessor = self.accessor(number)?;
        let component = component(accessor)?;
        if accessor.type_ != Checked::Valid(Type::Vec3) || component != ComponentType::F32 {
            return Err(MeshDefect::Feature(format!(
                "accessor {number}: positions other than f32 × 3"
            )));
        }
        let read = |bytes: &[u8]| {
            let (words, _) = bytes.as_chunks::<4>();
            [0, 1, 2].map(|i| f32::from_le_bytes(words[i]))
        };
        self.values(accessor, 12, [0.0; 3], read)
    }

    /// Indices: u8, u16 or u32 each.
    pub(super) fn indices(&self, number: usize) -> Result<Vec<u32>, MeshDefect> {
        let accessor = self.accessor(number)?;
        let component = component(accessor)?;
        if accessor.type_ != Checked::Valid(Type::Scalar) {
            return Err(MeshDefect::Syntax(format!("accessor {number}: indices are not scalars")));
        }
        let length = match component {
            ComponentType::U8 | ComponentType::U16 | ComponentType::U32 => component.size(),
            _ => {
                return Err(MeshDefect::Syntax(format!(
                    "accessor {number}: indices are not unsigned"
                )));
            }
        };
        self.values(accessor, length, 0, little_endian)
    }

    fn accessor(&self, number: usize) -> Result<&'a json::Accessor, MeshDefect> {
        let accessors = &self.root.accessors;
        let accessor =
            accessors.get(number).ok_or_else(|| no_such("accessors", number, accessors.len()))?;
        if accessor.count.0 > COUNT_MAX {
            let (count, max) = (accessor.count.0, COUNT_MAX);
            return Err(MeshDefect::TooMany { what: "elements of an accessor", count, max });
        }
        Ok(accessor)
    }

    /// The elements of an accessor; `empty` if it has no view.
    fn values<T: Copy>(
        &self,
        accessor: &json::Accessor,
        length: usize,
        empty: T,
        read: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, MeshDefect> {
        let count = accessor.count.0 as usize;
        let mut values = match accessor.buffer_view {
            Some(view) => {
                let offset = accessor.byte_offset.unwrap_or_default().0;
                let run = self.run(view.value(), offset, length)?;
                // The last element first: if it exists, all do, and nothing is allocated before.
                if count > 0 {
                    run.element(count - 1, length).ok_or_else(|| short("an accessor"))?;
                }
                (0..count).map_while(|at| run.element(at, length).map(&read)).collect()
            }
            // Zeros are an allocation bomb: 20 bytes of JSON request gigabytes.
            None if accessor.sparse.is_none() => {
                return Err(MeshDefect::Feature("an accessor without a buffer view".to_owned()));
            }
            None if count as u64 > self.bytes() => {
                return Err(MeshDefect::Truncated(
                    "a sparse accessor claims more than there is".into(),
                ));
            }
            None => vec![empty; count],
        };
        if let Some(sparse) = &accessor.sparse {
            self.overlay(sparse, length, read, &mut values)?;
        }
        Ok(values)
    }

    fn bytes(&self) -> u64 {
        self.buffers.iter().map(|buffer| buffer.len() as u64).sum()
    }

    fn overlay<T: Copy>(
        &self,
        sparse: &json::accessor::sparse::Sparse,
        length: usize,
        read: impl Fn(&[u8]) -> T,
        values: &mut [T],
    ) -> Result<(), MeshDefect> {
        let Checked::Valid(kind) = sparse.indices.component_type else {
            return Err(MeshDefect::Syntax("sparse indices of unknown type".to_owned()));
        };
        let width = kind.0.size();
        let places =
            self.run(sparse.indices.buffer_view.value(), sparse.indices.byte_offset.0, width)?;
        let news =
            self.run(sparse.values.buffer_view.value(), sparse.values.byte_offset.0, length)?;
        for at in 0..usize::try_from(sparse.count.0).unwrap_or(usize::MAX) {
            let (place, new) = places
                .element(at, width)
                .zip(news.element(at, length))
                .ok_or_else(|| short("a sparse accessor"))?;
            let place = little_endian(place) as usize;
            let count = values.len();
            let value =
                values.get_mut(place).ok_or_else(|| no_such("such elements", place, count))?;
            *value = read(new);
        }
        Ok(())
    }

    /// The bytes of a view from an offset on, and the distance of its elements.
    fn run(&self, number: usize, offset: u64, length: usize) -> Result<Run<'a>, MeshDefect> {
        let views = &self.root.buffer_views;
        let view = views.get(number).ok_or_else(|| no_such("buffer views", number, views.len()))?;
        let buffer = view.buffer.value();
        let bytes = self
            .buffers
            .get(buffer)
            .ok_or_else(|| no_such("buffers", buffer, self.buffers.len()))?;
        let start = view.byte_offset.unwrap_or_default().0;
        let range = |start: u64, length: u64| {
            let start = usize::try_from(start).ok()?;
            Some(start..start.checked_add(usize::try_from(length).ok()?)?)
        };
        let own = range(start, view.byte_length.0).and_then(|range| bytes.get(range));
        let own = own.ok_or_else(|| short("a buffer view"))?;
        let from = usize::try_from(offset).ok().and_then(|offset| own.get(offset..));
        let from = from.ok_or_else(|| short("an accessor"))?;
        let stride = view.byte_stride.map_or(length, |stride| stride.0);
        if stride < length {
            return Err(MeshDefect::Syntax(format!(
                "stride {stride} for elements of {length} bytes"
            )));
        }
        Ok(Run { bytes: from, stride })
    }
}

fn component(accessor: &json::Accessor) -> Result<ComponentType, MeshDefect> {
    match accessor.component_type {
        Checked::Valid(kind) => Ok(kind.0),
        Checked::Invalid => Err(MeshDefect::Syntax("an accessor of unknown type".to_owned())),
    }
}

/// An unsigned number of 1, 2 or 4 bytes.
fn little_endian(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |sum, byte| sum << 8 | u32::from(*byte))
}
