//! Which files an asset refers to: what must travel with a scene beside the
//! files that scene.json itself names.
//!
//! An OBJ names MTL files, an MTL names textures, each relative to its own
//! folder. Whoever bundles a scene and whoever builds it use these functions,
//! so that both always mean the same file.

use crate::limits::ASSETS_MAX;
use std::borrow::Cow;

/// Names that stand in the `mtllib` lines of an OBJ file, in their order, each
/// once. A name may hold spaces; several names on one line are told apart by
/// their ending `.mtl`.
#[must_use]
pub fn obj_libraries(bytes: &[u8]) -> Vec<String> {
    let mut names = Vec::new();
    for line in logical_lines(bytes) {
        if let Some(rest) = argument(&line.text, b"mtllib") {
            for name in split_libraries(&rest) {
                push_once(&mut names, name);
            }
        }
    }
    names
}

/// Statements of an MTL file whose textures the renderer reads: colour,
/// roughness and metalness.
const MTL_MAPS: [&[u8]; 3] = [b"map_Kd", b"map_Pr", b"map_Pm"];

/// Names of the textures of an MTL file that the renderer reads (`map_Kd`,
/// `map_Pr`, `map_Pm`), in their order, each once. Options before the name are
/// taken away.
#[must_use]
pub fn mtl_textures(bytes: &[u8]) -> Vec<String> {
    let mut names = Vec::new();
    for line in logical_lines(bytes) {
        for rest in MTL_MAPS.iter().filter_map(|map| argument(&line.text, map)) {
            let name = strip_map_options(&rest);
            if !name.is_empty() {
                push_once(&mut names, name.to_owned());
            }
        }
    }
    names
}

/// The asset that `name` means inside `base_file`: relative to the folder of
/// `base_file`, with `/` between the parts and without `.` and `a/..`. A name
/// that climbs above the scene's folder keeps its leading `..`.
#[must_use]
pub fn resolve(base_file: &str, name: &str) -> String {
    let base = base_file.replace('\\', "/");
    let name = name.replace('\\', "/");
    let folder = match base.rfind('/') {
        Some(end) if !name.starts_with('/') => &base[..end],
        _ => "",
    };
    let mut parts: Vec<&str> = Vec::new();
    for part in folder.split('/').chain(name.split('/')) {
        match part {
            "" | "." => {}
            ".." if parts.last().is_some_and(|last| *last != "..") => {
                parts.pop();
            }
            _ => parts.push(part),
        }
    }
    parts.join("/")
}

/// The name in the arguments of a `map_...` line: options such as `-s 1 1 1`
/// or `-clamp on` are skipped, the rest of the line is the name.
#[must_use]
pub fn strip_map_options(arguments: &str) -> &str {
    let mut rest = arguments.trim();
    while let Some((option, after)) = split_word(rest) {
        // Options of the MTL specification and how many words follow: vectors
        // take one to three numbers, the others exactly so many.
        let (least, most) = match option {
            "-blendu" | "-blendv" | "-cc" | "-clamp" | "-boost" | "-bm" | "-imfchan"
            | "-texres" | "-type" => (1, 1),
            "-mm" => (2, 2),
            "-o" | "-s" | "-t" => (1, 3),
            _ => break,
        };
        rest = after;
        for taken in 0..most {
            match split_word(rest) {
                Some((word, after)) if taken < least || word.parse::<f32>().is_ok() => rest = after,
                _ => break,
            }
        }
    }
    rest.trim()
}

/// One line of an OBJ or MTL file after joining continued lines.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogicalLine<'a> {
    /// Number of its first line in the file, from 1.
    pub number: usize,
    /// The text without line ends; borrowed unless lines were joined.
    pub text: Cow<'a, [u8]>,
}

/// The lines of an OBJ or MTL file: `\n` and `\r\n` end a line, a backslash
/// before the end joins the next one to it.
pub fn logical_lines(bytes: &[u8]) -> impl Iterator<Item = LogicalLine<'_>> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut lines = bytes.split(|&b| b == b'\n').enumerate();
    std::iter::from_fn(move || {
        let (index, line) = lines.next()?;
        let mut text = Cow::Borrowed(trim_end(line));
        while text.ends_with(b"\\") {
            let joined = text.to_mut();
            joined.pop();
            joined.push(b' ');
            let next = lines.next().map_or(&b""[..], |(_, next)| trim_end(next));
            joined.extend_from_slice(next);
        }
        Some(LogicalLine {
            number: index + 1,
            text,
        })
    })
}

/// What follows `keyword` on a line, or nothing when the line starts
/// otherwise. Bytes that are not UTF-8 become U+FFFD.
#[must_use]
pub fn argument<'a>(line: &'a [u8], keyword: &[u8]) -> Option<Cow<'a, str>> {
    let rest = line.trim_ascii_start().strip_prefix(keyword)?;
    match rest.first() {
        None => Some(Cow::Borrowed("")),
        Some(b' ' | b'\t') => Some(String::from_utf8_lossy(rest.trim_ascii())),
        Some(_) => None,
    }
}

/// Names in the arguments of one `mtllib` line.
#[must_use]
pub fn split_libraries(arguments: &str) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    let mut rest = arguments.trim();
    let mut start = rest;
    while let Some((word, after)) = split_word(rest) {
        rest = after;
        let ends = word.len() >= 4
            && word
                .get(word.len() - 4..)
                .is_some_and(|end| end.eq_ignore_ascii_case(".mtl"));
        if ends || after.is_empty() {
            let length = start.len() - after.len();
            names.push(start[..length].trim().to_owned());
            start = after;
        }
    }
    names
}

/// First word and what follows it without leading blanks.
fn split_word(text: &str) -> Option<(&str, &str)> {
    let text = text.trim_start();
    if text.is_empty() {
        return None;
    }
    let end = text.find(char::is_whitespace).unwrap_or(text.len());
    Some((&text[..end], text[end..].trim_start()))
}

fn trim_end(line: &[u8]) -> &[u8] {
    line.strip_suffix(b"\r").unwrap_or(line)
}

fn push_once(names: &mut Vec<String>, name: String) {
    // One more than the limit, so that whoever counts them notices.
    if names.len() <= ASSETS_MAX && !names.contains(&name) {
        names.push(name);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn libraries_with_spaces_and_line_ends() {
        let obj = b"# c\r\nmtllib my plane.mtl\r\n mtllib\tb.MTL c d.mtl\nmtllib my plane.mtl\nmtllibx no.mtl\nmtllib odd name\n";
        assert_eq!(
            obj_libraries(obj),
            ["my plane.mtl", "b.MTL", "c d.mtl", "odd name"]
        );
        assert!(obj_libraries(b"v 0 0 0\nmtllib\nmtllib   \n").is_empty());
        assert_eq!(obj_libraries(b"mtllib \\\r\n a.mtl"), ["a.mtl"]);
        assert_eq!(obj_libraries(b"\xef\xbb\xbfmtllib a.mtl"), ["a.mtl"]);
    }

    #[test]
    fn many_libraries_stay_linear_enough() {
        let line = "\\\n".repeat(20_000);
        assert!(obj_libraries(line.as_bytes()).is_empty());
    }

    #[test]
    fn textures_without_their_options() {
        let mtl = b"newmtl a\r\nmap_Kd -s 1 1 1 -o 0.5 livery one.png\r\nmap_Ks no.png\n\tmap_Kd -clamp on -mm 0 1 b.png\nmap_Kd -o 1 c.png\nmap_Kd\nmap_Kd -s 2 2 2\nmap_Kd -x.png\nmap_Pr -imfchan g orm.png\nmap_Pm orm.png\nmap_Pm metal.png\n";
        assert_eq!(
            mtl_textures(mtl),
            [
                "livery one.png",
                "b.png",
                "c.png",
                "-x.png",
                "orm.png",
                "metal.png"
            ]
        );
    }

    #[test]
    fn names_are_relative_to_the_file_that_holds_them() {
        for (base, name, meant) in [
            ("plane.obj", "plane.mtl", "plane.mtl"),
            ("models/plane.obj", "plane.mtl", "models/plane.mtl"),
            ("models/plane.obj", "../tex/a.png", "tex/a.png"),
            ("models\\plane.obj", "..\\tex\\a.png", "tex/a.png"),
            ("a/b/c.obj", "./d/../e.mtl", "a/b/e.mtl"),
            ("a.obj", "../x.mtl", "../x.mtl"),
            ("a/b.obj", "../../../x.mtl", "../../x.mtl"),
            ("a/b.obj", "/abs/x.mtl", "abs/x.mtl"),
            ("a/b.obj", "my tex.png", "a/my tex.png"),
        ] {
            assert_eq!(resolve(base, name), meant, "{base} {name}");
        }
    }
}
