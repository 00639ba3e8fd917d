//! The name decides unless the content plainly says otherwise.

use super::*;
use diagnostic::Diagnostic as _;

fn detect(file: &str, bytes: &[u8]) -> Result<Format, String> {
    Format::detect(file, bytes).map_err(|fault| fault.to_string())
}

#[test]
fn right_names_are_believed() {
    let mut stl = vec![b' '; 84 + 50];
    stl[..5].copy_from_slice(b"solid");
    stl[80..84].copy_from_slice(&1_u32.to_le_bytes());
    let cases: [(&str, &[u8], Format); 12] = [
        ("a.obj", b"# x\nv 1 2 3\n", Format::Obj),
        ("b/A.OBJ", b"", Format::Obj),
        ("a.stl", b"solid a\n facet normal\n", Format::Stl),
        ("a.stl", &stl, Format::Stl),
        ("a.ply", b"ply\r\nformat", Format::Ply),
        ("a.gltf", b" {\"asset\": {}}", Format::Gltf),
        ("a.glb", b"glTF\x02\0\0\0", Format::Glb),
        ("a.b.glb", b"nonsense", Format::Glb),
        ("a.dae", b"<?xml?><COLLADA>", Format::Collada),
        ("a.k", b"$ a deck\n*KEYWORD\n", Format::LsDyna),
        ("a.KEY", b"*KEYWORD\n", Format::LsDyna),
        ("a.gltf", b"\xef\xbb\xbf{\"asset\": {}}", Format::Gltf),
    ];
    for (file, bytes, format) in cases {
        assert_eq!(detect(file, bytes), Ok(format), "{file}");
    }
}

#[test]
fn wrong_names_are_refused_with_what_the_content_looks_like() {
    let cases: [(&str, &[u8], &str); 11] = [
        ("a.obj", b"ply\nformat", "a.obj: named OBJ, but its content looks like PLY"),
        ("a.stl", b"v 1 2 3\nf 1 2 3\n", "a.stl: named STL, but its content looks like OBJ"),
        ("a.ply", b"solid a\nendsolid a\n", "a.ply: named PLY, but its content looks like STL"),
        ("a.gltf", b"glTF\x02", "a.gltf: named glTF, but its content looks like GLB"),
        ("a.glb", b"{\"asset\": {}}", "a.glb: named GLB, but its content looks like glTF"),
        ("a.obj", b"\xFF\xFEv\0", "a.obj: named OBJ, but its content looks like UTF-16 text"),
        ("a.stl", b"PK\x03\x04", "a.stl: named STL, but its content looks like a ZIP archive"),
        ("a.obj", b"<?xml?><COLLADA>", "a.obj: named OBJ, but its content looks like COLLADA"),
        ("a.dae", b"*KEYWORD\n", "a.dae: named COLLADA, but its content looks like LS-DYNA"),
        ("a.dae", b"<svg>", "a.dae: named COLLADA, but its content looks like XML"),
        (
            "noname",
            b"v 1 2 3\n",
            "noname: a file without extension that looks like OBJ cannot be \
                                  imported",
        ),
    ];
    for (file, bytes, expected) in cases {
        assert_eq!(detect(file, bytes).expect_err(file), expected);
    }
    let remedy = |file: &str, bytes: &[u8]| {
        let fault = Format::detect(file, bytes).expect_err(file);
        fault.remedy().unwrap_or_default().into_owned()
    };
    // Unpacking it leads nowhere.
    assert!(remedy("a.3mf", b"PK\x03\x04").starts_with("convert it"));
    let pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 3\n";
    assert!(remedy("a.ply", pointer).ends_with("git lfs pull"));
    assert!(remedy("a.off", pointer).ends_with("git lfs pull"));
    let fault = Format::detect("a.obj", b"ply\n").expect_err("misnamed");
    assert_eq!(fault.remedy().unwrap_or_default(), "rename it to end in .ply");
}

/// Regression: the remedy was to convert them to OBJ.
#[test]
fn archives_are_to_be_unpacked() {
    for (file, bytes, remedy) in [
        ("car.obj.gz", &b"\x1F\x8B\x08\0"[..], "gunzip -k car.obj.gz"),
        ("car.obj", b"\x1F\x8B\x08\0", "gunzip -k car.obj"),
        ("car.zip", b"PK\x03\x04", "unzip car.zip"),
    ] {
        let fault = Format::detect(file, bytes).expect_err(file);
        assert!(fault.remedy().unwrap_or_default().ends_with(remedy), "{:?}", fault.remedy());
    }
}

#[test]
fn lines_that_end_with_cr_alone_are_told() {
    for (format, bytes, is_so) in [
        (Format::Obj, &b"v 0 0 0\rv 1 0 0\rf 1 2 1\r"[..], true),
        (Format::Obj, b"v 0 0 0\r\nv 1 0 0\r\n", false),
        (Format::Stl, b"solid a\rfacet\r", true),
        (Format::LsDyna, b"*KEYWORD\r*NODE\r", true),
        (Format::Ply, b"ply\rformat ascii 1.0\r", true),
        (Format::Ply, b"ply\r\nformat ascii 1.0\r\n", false),
        (Format::Gltf, b"{\r}", false),
        (Format::Obj, b"", false),
    ] {
        assert_eq!(format.has_cr_line_ends(bytes), is_so, "{format}: {bytes:?}");
    }
}
