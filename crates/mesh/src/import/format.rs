//! The format of a file: determined by its name, checked against its content.

use super::{FilePosition, ImportError, MeshDefect};
use core::fmt;

/// A mesh format that can be imported.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Wavefront OBJ.
    Obj,
    /// STL, binary or ASCII.
    Stl,
    /// PLY, ASCII or binary.
    Ply,
    /// glTF 2.0 as JSON with side files.
    Gltf,
    /// glTF 2.0 as one binary file.
    Glb,
    /// COLLADA.
    Collada,
    /// LS-DYNA keyword deck.
    LsDyna,
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl Format {
    /// Every format.
    pub const ALL: [Self; 7] =
        [Self::Obj, Self::Stl, Self::Ply, Self::Gltf, Self::Glb, Self::Collada, Self::LsDyna];

    /// Human-readable name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Obj => "OBJ",
            Self::Stl => "STL",
            Self::Ply => "PLY",
            Self::Gltf => "glTF",
            Self::Glb => "GLB",
            Self::Collada => "COLLADA",
            Self::LsDyna => "LS-DYNA",
        }
    }

    /// The usual extension, lower case, without the dot.
    #[must_use]
    pub fn extension(self) -> &'static str {
        match self {
            Self::Obj => "obj",
            Self::Stl => "stl",
            Self::Ply => "ply",
            Self::Gltf => "gltf",
            Self::Glb => "glb",
            Self::Collada => "dae",
            Self::LsDyna => "k",
        }
    }

    /// Whether files of this format may have this extension.
    fn ends(self, extension: &str) -> bool {
        extension == self.extension()
            || (self == Self::LsDyna && ["key", "dyn", "dyna"].contains(&extension))
    }

    /// The format given by a file's name, unless its content contradicts it.
    ///
    /// # Errors
    ///
    /// The extension is unknown, or the content is clearly something else.
    pub fn detect(file: &str, bytes: &[u8]) -> Result<Self, ImportError> {
        let refuse = |fault| Err(ImportError::new(file, FilePosition::Whole, fault));
        let looks = look(bytes);
        let extension = file.rsplit_once('.').map_or("", |(_, end)| end).to_ascii_lowercase();
        let Some(named) = Self::ALL.into_iter().find(|format| format.ends(&extension)) else {
            let named = match extension.as_str() {
                "" => "a file without extension".to_owned(),
                extension => format!("a file named .{extension}"),
            };
            let what = match looks {
                Some(looks) => format!("{named} that looks like {looks}"),
                None => named,
            };
            return refuse(MeshDefect::Unsupported { what });
        };
        match looks {
            Some(looks) if looks != named.name() => {
                refuse(MeshDefect::Misnamed { named, looks: looks.to_owned() })
            }
            _ => Ok(named),
        }
    }
}

impl Format {
    /// Whether a text of this format ends its lines with CR alone, as programs for the classic Mac
    /// wrote them: readers take it for a single line.
    pub(super) fn has_cr_line_ends(self, bytes: &[u8]) -> bool {
        let start = &bytes[..bytes.len().min(LOOK_MAX)];
        match self {
            // A binary one has a text for a head.
            Self::Ply => start.starts_with(b"ply\r") && start.get(4) != Some(&b'\n'),
            Self::Stl if is_binary_stl(bytes) => false,
            Self::Obj | Self::Stl | Self::LsDyna => {
                let has = |byte: u8| start.contains(&byte);
                has(b'\r') && !has(b'\n') && !has(0)
            }
            // Line ends mean nothing to JSON and XML.
            Self::Gltf | Self::Glb | Self::Collada => false,
        }
    }
}

/// Number of bytes of a text that are examined.
const LOOK_MAX: usize = 64 << 10;

/// What the content is, if that is certain: the name of a format, or a description.
fn look(bytes: &[u8]) -> Option<&'static str> {
    const SIGNS: [(&[u8], &str); 10] = [
        (b"version https://git-lfs.github.com/spec/", "a pointer of Git LFS"),
        (b"glTF", "GLB"),
        (b"ply\n", "PLY"),
        (b"ply\r", "PLY"),
        (b"\xFE\xFF", "UTF-16 text"),
        (b"\xFF\xFE", "UTF-16 text"),
        (b"TROLLEY\n", "a model file, which needs no import"),
        (b"PK\x03\x04", "a ZIP archive"),
        (b"\x1F\x8B", "a gzip archive"),
        (b"Kaydara FBX Binary", "FBX"),
    ];
    if let Some((_, name)) = SIGNS.iter().find(|(sign, _)| bytes.starts_with(sign)) {
        return Some(name);
    }
    if is_binary_stl(bytes) {
        return Some("STL");
    }
    let start = &bytes[..bytes.len().min(LOOK_MAX)];
    if start.contains(&0) {
        return None;
    }
    let text = String::from_utf8_lossy(start);
    let text = text.trim_start_matches('\u{feff}').trim_start();
    let has_line =
        |begins: &dyn Fn(&str) -> bool| text.lines().any(|line| begins(line.trim_start()));
    if text.starts_with("<?xml") || text.starts_with('<') {
        return Some(if text.contains("<COLLADA") { "COLLADA" } else { "XML" });
    }
    if text.starts_with('{') {
        return text.contains("\"asset\"").then_some("glTF");
    }
    if text.starts_with(['$', '*']) && has_line(&|line| is_keyword(line)) {
        return Some("LS-DYNA");
    }
    if text.starts_with("solid") && has_line(&|line| is_stl_line(line)) {
        return Some("STL");
    }
    has_line(&|line| is_obj_vertex(line)).then_some("OBJ")
}

fn is_keyword(line: &str) -> bool {
    ["*KEYWORD", "*NODE", "*ELEMENT", "*PART"].iter().any(|keyword| line.starts_with(keyword))
}

fn is_stl_line(line: &str) -> bool {
    line.starts_with("facet") || line.starts_with("endsolid")
}

fn is_obj_vertex(line: &str) -> bool {
    let mut words = line.split_ascii_whitespace();
    words.next() == Some("v") && words.next().is_some_and(|word| word.parse::<f64>().is_ok())
}

/// Whether the length is that of a binary STL with the stated number of triangles. Some begin with
/// "solid" like the ASCII form, so the length decides.
pub(super) fn is_binary_stl(bytes: &[u8]) -> bool {
    stated_triangles(bytes).is_some_and(|count| bytes.len() as u64 == 84 + 50 * u64::from(count))
}

/// The number of triangles stated by a binary STL.
pub(super) fn stated_triangles(bytes: &[u8]) -> Option<u32> {
    let count: [u8; 4] = bytes.get(80..84)?.try_into().ok()?;
    Some(u32::from_le_bytes(count))
}

#[cfg(test)]
mod tests;
