//! Chunks of bodies sent to a worker that copies: the payload of [`crate::MessageKind::Section`].
//!
//! A piece is a run of elements of one array of one body, with its position: a worker stores it at
//! the same place as in the store, so numbers of nodes and triangles stay the same.
//!
//! ```text
//! words of a piece:  [model | array << 32] [first | count << 32] [bytes, filled up with zeros]
//! ```

/// An array of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Array {
    /// Nodes of the tree.
    Nodes = 1,
    /// Nodes of the wide tree.
    Wide = 2,
    /// Per node of the tree, its wide node.
    WideOf = 3,
    /// Triangles.
    Corners = 4,
    /// Their source ids.
    SourceIds = 5,
    /// Their zones.
    Zones = 6,
}

impl Array {
    const ALL: [Self; 6] =
        [Self::Nodes, Self::Wide, Self::WideOf, Self::Corners, Self::SourceIds, Self::Zones];

    /// Bytes per element.
    #[must_use]
    pub const fn bytes(self) -> usize {
        match self {
            Self::Nodes => 32,
            Self::Wide => 256,
            Self::WideOf | Self::SourceIds => 4,
            Self::Corners => 36,
            Self::Zones => 2,
        }
    }
}

/// A run of elements of one array of one body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Piece<'p> {
    /// Number of the body in the model store.
    pub model: u32,
    /// The array.
    pub array: Array,
    /// Number of the first element.
    pub first: u32,
    /// The elements.
    pub bytes: &'p [u8],
}

/// Words before the bytes of a piece.
const HEAD: usize = 2;

/// Appends as much of a piece as fits; returns the number of elements appended.
///
/// # Panics
///
/// The bytes are not whole elements.
pub fn write_piece(words: &mut Vec<u64>, room: usize, piece: &Piece<'_>) -> usize {
    let size = piece.array.bytes();
    assert!(piece.bytes.len().is_multiple_of(size), "elements are whole");
    let free = room.saturating_sub(words.len() + HEAD) * 8 / size;
    let count = free.min(piece.bytes.len() / size);
    if count == 0 {
        return 0;
    }
    words.push(u64::from(piece.model) | (piece.array as u64) << 32);
    words.push(u64::from(piece.first) | (count as u64) << 32);
    for bytes in piece.bytes[..count * size].chunks(8) {
        let mut word = [0; 8];
        word[..bytes.len()].copy_from_slice(bytes);
        words.push(u64::from_ne_bytes(word));
    }
    count
}

/// Splits the first piece off a message; `None` if its header does not match the words.
#[must_use]
pub fn read_piece(words: &[u64]) -> Option<(Piece<'_>, &[u64])> {
    let (head, rest) = words.split_at_checked(HEAD)?;
    let model = (head[0] & 0xffff_ffff) as u32;
    let array = Array::ALL.into_iter().find(|array| *array as u64 == head[0] >> 32)?;
    let (first, count) = ((head[1] & 0xffff_ffff) as u32, (head[1] >> 32) as usize);
    let bytes = count.checked_mul(array.bytes())?;
    let (body, rest) = rest.split_at_checked(bytes.div_ceil(8))?;
    let bytes = bytemuck::cast_slice::<u64, u8>(body).get(..bytes)?;
    Some((Piece { model, array, first, bytes }, rest))
}

#[cfg(test)]
mod tests {
    //! Pieces survive a round trip, in any number of messages; malformed ones are rejected.
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn pieces_come_back_however_they_are_cut(
            (model, first, which) in (0_u32..9, 0_u32..1000, 0_usize..6),
            bytes in prop::collection::vec(any::<u8>(), 0..3000),
            room in 40_usize..200,
        ) {
            let array = Array::ALL[which];
            let whole = &bytes[..bytes.len() / array.bytes() * array.bytes()];
            let (mut done, mut back) = (0, Vec::new());
            while done * array.bytes() < whole.len() {
                let (at, mut words) = (first + done as u32, Vec::new());
                let rest = &whole[done * array.bytes()..];
                let piece = Piece { model, array, first: at, bytes: rest };
                let count = write_piece(&mut words, room, &piece);
                prop_assert!(count > 0 && words.len() <= room);
                let (read, left) = read_piece(&words).unwrap();
                prop_assert!(left.is_empty());
                prop_assert_eq!((read.model, read.array, read.first), (model, array, at));
                back.extend_from_slice(read.bytes);
                done += count;
            }
            prop_assert_eq!(back.as_slice(), whole);
        }

        #[test]
        fn nonsense_is_refused_or_fits_its_words(
            words in prop::collection::vec(0_u64..1 << 36, 0..9),
        ) {
            if let Some((piece, rest)) = read_piece(&words) {
                prop_assert_eq!(piece.bytes.len() % piece.array.bytes(), 0);
                prop_assert!(rest.len() + HEAD <= words.len());
            }
        }
    }
}
