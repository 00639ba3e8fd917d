//! Container and buffers of a glTF file: the GLB blob, data URIs, and side files from the resolver.

use super::super::collect::Collector;
use super::super::{BYTES_MAX, FilePosition, ImportError, MeshDefect, Resolver};
use ::gltf::{Glb, json};

/// The JSON tree and the GLB's binary blob.
pub(super) fn parse<'b>(
    bytes: &'b [u8],
    into: &Collector<'_>,
) -> Result<(json::Root, Option<Vec<u8>>), ImportError> {
    let fail = |fault: MeshDefect| into.fail(FilePosition::Whole, fault);
    let syntax = |fault: &dyn core::fmt::Display| fail(MeshDefect::Syntax(fault.to_string()));
    if bytes.is_empty() {
        return Err(fail(MeshDefect::Empty(": the file is empty".to_owned())));
    }
    if !bytes.starts_with(b"glTF") {
        check_version(bytes, into)?;
        let root = json::Root::from_slice(bytes).map_err(|fault| json_fault(&fault, into))?;
        return Ok((root, None));
    }
    if bytes.get(4..8) == Some(&1_u32.to_le_bytes()) {
        return Err(fail(MeshDefect::Former("glTF 1.0")));
    }
    // The crate subtracts 12 from this length without checking it.
    let stated = bytes.get(8..12).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
    match stated {
        Some(stated) if stated >= 20 && stated as usize <= bytes.len() => {}
        Some(stated) => {
            let fault = format!("its header states {stated} bytes, it has {}", bytes.len());
            return Err(fail(MeshDefect::Truncated(fault)));
        }
        None => return Err(fail(MeshDefect::Truncated("its header is cut".to_owned()))),
    }
    let glb: Glb<'b> = Glb::from_slice(bytes).map_err(|fault| syntax(&fault))?;
    let root = json::Root::from_slice(&glb.json).map_err(|fault| json_fault(&fault, into))?;
    Ok((root, glb.bin.map(std::borrow::Cow::into_owned)))
}

/// Refuses glTF 1.0 by its name: its lists are objects, which the reader of 2.0 takes for a fault.
fn check_version(bytes: &[u8], into: &Collector<'_>) -> Result<(), ImportError> {
    #[derive(serde::Deserialize)]
    struct Head {
        asset: Option<Asset>,
    }
    #[derive(serde::Deserialize)]
    struct Asset {
        version: Option<serde_json::Value>,
    }
    // What is no JSON is said with its line by whoever reads it next.
    let head: Option<Head> = serde_json::from_slice(bytes).ok();
    let version = head.and_then(|head| head.asset).and_then(|asset| asset.version);
    // The first files of 1.0 have a number there.
    match version.map(|version| version.as_str().map_or(version.to_string(), str::to_owned)) {
        Some(version) if version == "1" || version.starts_with("1.") => {
            Err(into.fail(FilePosition::Whole, MeshDefect::Former("glTF 1.0")))
        }
        _ => Ok(()),
    }
}

fn json_fault(fault: &json::Error, into: &Collector<'_>) -> ImportError {
    // The library's message ends with the line, too, which stands before it already.
    let text = fault.to_string();
    let text = text.rsplit_once(" at line ").map_or(&*text, |(text, _)| text);
    let said = format!("JSON: {text} (column {})", fault.column().max(1));
    into.fail(FilePosition::Line(fault.line().max(1)), MeshDefect::Syntax(said))
}

/// The content of every buffer, at least as long as stated.
pub(super) fn load(
    root: &json::Root,
    mut blob: Option<Vec<u8>>,
    resolve: Resolver<'_>,
    into: &mut Collector<'_>,
) -> Result<Vec<Vec<u8>>, ImportError> {
    let mut buffers: Vec<Vec<u8>> = Vec::new();
    let mut total = 0_usize;
    for (number, buffer) in root.buffers.iter().enumerate() {
        let place = || FilePosition::Element(format!("buffer {number}"));
        let content = match &buffer.uri {
            Some(uri) => match uri.strip_prefix("data:") {
                Some(data) => from_data_uri(data).map_err(|fault| into.fail(place(), fault))?,
                None => {
                    let content =
                        from_side_file(uri, resolve).map_err(|fault| into.fail(place(), fault))?;
                    into.hasher.update(&content);
                    content
                }
            },
            None if number == 0 && blob.is_some() => blob.take().unwrap_or_default(),
            None => {
                let fault = MeshDefect::Syntax("it has neither a URI nor a GLB blob".to_owned());
                return Err(into.fail(place(), fault));
            }
        };
        if (content.len() as u64) < buffer.byte_length.0 {
            let (stated, found) = (buffer.byte_length.0, content.len());
            let fault = format!("it states {stated} bytes, its source has {found}");
            return Err(into.fail(place(), MeshDefect::Truncated(fault)));
        }
        total = total.saturating_add(content.len());
        if total > BYTES_MAX {
            let (count, max) = (total as u64, BYTES_MAX as u64);
            return Err(into.fail(place(), MeshDefect::TooMany { what: "bytes", count, max }));
        }
        buffers.push(content);
    }
    Ok(buffers)
}

fn from_side_file(
    uri: &str,
    resolve: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
) -> Result<Vec<u8>, MeshDefect> {
    let refuse = |reason: &str| {
        Err(MeshDefect::SideFile { name: uri.to_owned(), reason: reason.to_owned() })
    };
    let Some(name) = percent_decoded(uri) else {
        return refuse("its name is malformed");
    };
    let leads_out = name.split(['/', '\\']).any(|step| step == "..");
    if leads_out || name.starts_with(['/', '\\']) || name.contains(':') || name.contains('\0') {
        return refuse("only files beside the mesh or below it are read");
    }
    resolve(&name).map_err(|reason| MeshDefect::SideFile { name, reason })
}

/// Decodes the percent-encoding of a URI, such as `%20`.
fn percent_decoded(uri: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((first, after)) = rest.split_first() {
        if *first == b'%' {
            let digit = |at: usize| char::from(*after.get(at)?).to_digit(16);
            bytes.push((digit(0)? * 16 + digit(1)?) as u8);
            rest = &after[2..];
        } else {
            bytes.push(*first);
            rest = after;
        }
    }
    String::from_utf8(bytes).ok()
}

/// The part after `data:`: a media type, `;base64,`, then the content.
fn from_data_uri(data: &str) -> Result<Vec<u8>, MeshDefect> {
    let Some((kind, content)) = data.split_once(',') else {
        return Err(MeshDefect::Syntax("its data URI has no comma".to_owned()));
    };
    if !kind.ends_with(";base64") {
        return Err(MeshDefect::Feature("a data URI that is not base64".to_owned()));
    }
    from_base64(content).ok_or_else(|| MeshDefect::Syntax("its data URI is not base64".to_owned()))
}

/// RFC 4648, section 4; padding is optional, anything else is rejected.
fn from_base64(text: &str) -> Option<Vec<u8>> {
    let digits = text.trim_end_matches('=').as_bytes();
    let value = |digit: u8| {
        Some(match digit {
            b'A'..=b'Z' => digit - b'A',
            b'a'..=b'z' => digit - b'a' + 26,
            b'0'..=b'9' => digit - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            _ => return None,
        })
    };
    let mut bytes = Vec::with_capacity(digits.len() / 4 * 3 + 2);
    for group in digits.chunks(4) {
        if group.len() == 1 {
            return None;
        }
        let mut bits = 0_u32;
        for digit in group {
            bits = bits << 6 | u32::from(value(*digit)?);
        }
        bits <<= 6 * (4 - group.len());
        bytes.extend_from_slice(&bits.to_be_bytes()[1..group.len()]);
    }
    Some(bytes)
}

#[cfg(test)]
mod tests;
