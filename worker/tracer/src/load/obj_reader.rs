//! The text of an OBJ file as the parser wants it.
//!
//! `tobj` reads floats and indices well but stumbles over what the world
//! writes: continued lines, faces of which some corners have no normal, names
//! of materials that no MTL defines (it forgets them), and it says no line
//! numbers. This reader hands it the file line by line, checked and put right:
//!
//! - every index is checked against what stands above it, with its line;
//! - each run of faces of one material that have the same parts (texture
//!   coordinates, normals) is announced as a material of its own, a number,
//!   from which [`FaceKind::decode`] gets both back;
//! - groups, comments, colours of vertices and everything unknown is left out.

use crate::load::LoadNotes;
use shearwater_shared::limits::{MATERIALS_MAX, TRIANGLES_MAX, VERTICES_MAX};
use shearwater_shared::scene::SceneError;
use shearwater_shared::scene::references::{LogicalLine, argument, split_libraries};
use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, BufRead, Read, Write};

/// What the faces of one parsed model share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FaceKind {
    /// Index into the names, in the order of first use; none before `usemtl`.
    pub(super) material: Option<usize>,
    /// Every corner has texture coordinates.
    pub(super) uvs: bool,
    /// Every corner has a normal.
    pub(super) normals: bool,
}

impl FaceKind {
    fn encode(self) -> usize {
        let material = self.material.map_or(0, |index| index + 1);
        material * 4 + usize::from(self.uvs) + 2 * usize::from(self.normals)
    }

    /// From the number that stands for a material in the parsed models.
    pub(super) fn decode(code: usize) -> Self {
        Self {
            material: (code / 4).checked_sub(1),
            uvs: code % 2 == 1,
            normals: code / 2 % 2 == 1,
        }
    }
}

/// A name and the line where it stands first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Named {
    pub(super) name: String,
    pub(super) line: usize,
}

/// See the module.
pub(super) struct ObjReader<'a, I> {
    file: &'a str,
    lines: I,
    /// Line that was handed out last.
    pub(super) line: usize,
    /// Why reading stopped.
    pub(super) error: Option<SceneError>,
    /// Materials in the order of first use.
    pub(super) materials: Vec<Named>,
    material_index: BTreeMap<String, usize>,
    /// MTL files in the order of first mention.
    pub(super) libraries: Vec<Named>,
    pub(super) notes: LoadNotes,
    /// Positions, texture coordinates and normals so far.
    counts: [usize; 3],
    triangles: usize,
    material: Option<usize>,
    announced: BTreeSet<usize>,
    current: Option<usize>,
    /// Text made ready, and how much of it is taken.
    ready: Vec<u8>,
    taken: usize,
}

/// Names of the parts of a face's corner.
const PARTS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

impl<'a, I: Iterator<Item = LogicalLine<'a>>> ObjReader<'a, I> {
    pub(super) fn new(file: &'a str, lines: I) -> Self {
        Self {
            file,
            lines,
            line: 0,
            error: None,
            materials: Vec::new(),
            material_index: BTreeMap::new(),
            libraries: Vec::new(),
            notes: LoadNotes::default(),
            counts: [0; 3],
            triangles: 0,
            material: None,
            announced: BTreeSet::new(),
            current: None,
            ready: Vec::new(),
            taken: 0,
        }
    }

    /// An error at the line that was read last.
    pub(super) fn fail(&self, message: impl Into<String>) -> SceneError {
        SceneError::new(self.file, format!("line {}", self.line), message)
    }

    /// Make the next useful line ready; nothing is ready at the end.
    fn advance(&mut self) -> Result<(), SceneError> {
        self.ready.clear();
        self.taken = 0;
        while self.ready.is_empty() {
            let Some(line) = self.lines.next() else {
                return Ok(());
            };
            self.line = line.number;
            self.statement(line.text.trim_ascii())?;
        }
        Ok(())
    }

    fn statement(&mut self, text: &[u8]) -> Result<(), SceneError> {
        let end = text
            .iter()
            .position(u8::is_ascii_whitespace)
            .unwrap_or(text.len());
        match &text[..end] {
            b"v" => self.numbers(text, 0, VERTICES_MAX),
            b"vt" => self.numbers(text, 1, VERTICES_MAX),
            b"vn" => self.numbers(text, 2, VERTICES_MAX),
            b"f" => self.face(text),
            b"usemtl" => self.use_material(text),
            b"mtllib" => {
                if let Some(rest) = argument(text, b"mtllib") {
                    for name in split_libraries(&rest) {
                        if !self.libraries.iter().any(|known| known.name == name) {
                            let line = self.line;
                            self.libraries.push(Named { name, line });
                        }
                    }
                }
                if self.libraries.len() > MATERIALS_MAX {
                    return Err(self.fail(format!("more than {MATERIALS_MAX} MTL files")));
                }
                Ok(())
            }
            b"l" | b"p" => {
                self.notes.points_and_lines += 1;
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// A position, texture coordinate or normal: only the numbers that count.
    fn numbers(&mut self, text: &[u8], part: usize, most: usize) -> Result<(), SceneError> {
        let mut words = text
            .split(u8::is_ascii_whitespace)
            .filter(|w| !w.is_empty());
        let keyword = words.next().unwrap_or_default();
        let values: Vec<&[u8]> = words.take_while(|word| word[0] != b'#').take(7).collect();
        // A position may carry a weight (4) or a colour (6), which is dropped.
        let (least, keep) = match (part, values.len()) {
            (0, 4) => (3, 4),
            (1, _) => (1, 2),
            _ => (3, 3),
        };
        if values.len() < least {
            return Err(self.fail(format!(
                "{} numbers after `{}`: expected {least}",
                values.len(),
                String::from_utf8_lossy(keyword)
            )));
        }
        if self.counts[part] >= most {
            return Err(self.fail(format!("more than {most} of `{}`", lossy(keyword))));
        }
        self.counts[part] += 1;
        self.ready.extend_from_slice(keyword);
        for value in values.iter().take(keep) {
            self.ready.push(b' ');
            self.ready.extend_from_slice(plain_number(value));
        }
        if part == 1 && values.len() == 1 {
            self.ready.extend_from_slice(b" 0");
        }
        self.ready.push(b'\n');
        Ok(())
    }

    fn use_material(&mut self, text: &[u8]) -> Result<(), SceneError> {
        let name = argument(text, b"usemtl").unwrap_or_default();
        if name.is_empty() {
            return Err(self.fail("`usemtl` without a name: expected one"));
        }
        if let Some(&known) = self.material_index.get(name.as_ref()) {
            self.material = Some(known);
            return Ok(());
        }
        if self.materials.len() >= MATERIALS_MAX {
            return Err(self.fail(format!("more than {MATERIALS_MAX} materials")));
        }
        let (name, line) = (name.into_owned(), self.line);
        self.material = Some(self.materials.len());
        self.material_index
            .insert(name.clone(), self.materials.len());
        self.materials.push(Named { name, line });
        Ok(())
    }

    fn face(&mut self, text: &[u8]) -> Result<(), SceneError> {
        let mut corners: Vec<[Option<i64>; 3]> = Vec::with_capacity(4);
        for word in text[1..].split(u8::is_ascii_whitespace) {
            if word.first() == Some(&b'#') {
                break;
            }
            if !word.is_empty() {
                corners.push(self.corner(word)?);
            }
        }
        if corners.len() < 3 {
            self.notes.degenerate_faces += 1;
            return Ok(());
        }
        self.triangles += corners.len() - 2;
        if self.triangles > TRIANGLES_MAX {
            return Err(self.fail(format!("more than {TRIANGLES_MAX} triangles")));
        }
        if self.material.is_none() {
            self.notes.unnamed_material_faces += 1;
        }
        let kind = FaceKind {
            material: self.material,
            uvs: corners.iter().all(|corner| corner[1].is_some()),
            normals: corners.iter().all(|corner| corner[2].is_some()),
        };
        self.announce(kind.encode());
        self.write_face(&corners, kind);
        Ok(())
    }

    /// Start a run of faces of one kind.
    fn announce(&mut self, code: usize) {
        if self.current == Some(code) {
            return;
        }
        self.current = Some(code);
        // Writing into a vector cannot fail.
        if self.announced.insert(code) {
            let _ = writeln!(self.ready, "mtllib {code}");
        }
        let _ = writeln!(self.ready, "usemtl {code}");
    }

    fn write_face(&mut self, corners: &[[Option<i64>; 3]], kind: FaceKind) {
        self.ready.push(b'f');
        for [v, vt, vn] in corners {
            let uv = vt.filter(|_| kind.uvs);
            let normal = vn.filter(|_| kind.normals);
            let _ = write!(self.ready, " {}", v.unwrap_or(0));
            if uv.is_some() || normal.is_some() {
                self.ready.push(b'/');
            }
            if let Some(uv) = uv {
                let _ = write!(self.ready, "{uv}");
            }
            if let Some(normal) = normal {
                let _ = write!(self.ready, "/{normal}");
            }
        }
        self.ready.push(b'\n');
    }

    /// The indices of `v`, `v/vt`, `v//vn` or `v/vt/vn`, counted from 1.
    fn corner(&self, word: &[u8]) -> Result<[Option<i64>; 3], SceneError> {
        let mut corner = [None; 3];
        for (part, digits) in word.split(|&b| b == b'/').enumerate() {
            if part >= 3 || (part == 0 && digits.is_empty()) {
                return Err(self.fail(format!(
                    "`{}` in a face: expected v, v/vt, v//vn or v/vt/vn",
                    lossy(word)
                )));
            }
            if !digits.is_empty() {
                corner[part] = Some(self.index(digits, part)?);
            }
        }
        Ok(corner)
    }

    fn index(&self, digits: &[u8], part: usize) -> Result<i64, SceneError> {
        let Some(index) = integer(digits) else {
            return Err(self.fail(format!(
                "`{}` in a face: expected a whole number",
                lossy(digits)
            )));
        };
        let count = i64::try_from(self.counts[part]).unwrap_or(i64::MAX);
        let absolute = if index < 0 { count + 1 + index } else { index };
        if (1..=count).contains(&absolute) {
            return Ok(absolute);
        }
        Err(self.fail(format!(
            "{} {index} in a face: only {count} stand above it, counted from 1",
            PARTS[part]
        )))
    }
}

impl<'a, I: Iterator<Item = LogicalLine<'a>>> BufRead for ObjReader<'a, I> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.taken >= self.ready.len()
            && let Err(error) = self.advance()
        {
            self.error = Some(error);
            return Err(io::Error::from(io::ErrorKind::InvalidData));
        }
        Ok(self.ready.get(self.taken..).unwrap_or_default())
    }

    fn consume(&mut self, amount: usize) {
        self.taken += amount;
    }
}

impl<'a, I: Iterator<Item = LogicalLine<'a>>> Read for ObjReader<'a, I> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let ready = self.fill_buf()?;
        let count = ready.len().min(into.len());
        into[..count].copy_from_slice(&ready[..count]);
        self.consume(count);
        Ok(count)
    }
}

/// What C runtimes write for values that are not numbers (`-nan(ind)`,
/// `1.#QNAN`) as text that parses.
fn plain_number(word: &[u8]) -> &[u8] {
    let odd = word.contains(&b'#') || word.contains(&b'(');
    if odd { b"nan" } else { word }
}

/// A decimal integer of at most 18 digits, so that nothing overflows.
fn integer(digits: &[u8]) -> Option<i64> {
    let (negative, digits) = match digits {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, digits),
    };
    if digits.is_empty() || digits.len() > 18 || !digits.iter().all(u8::is_ascii_digit) {
        return None;
    }
    let value = digits
        .iter()
        .fold(0_i64, |value, digit| value * 10 + i64::from(digit - b'0'));
    Some(if negative { -value } else { value })
}

/// Text for a message: no longer than a line.
fn lossy(bytes: &[u8]) -> String {
    String::from_utf8_lossy(&bytes[..bytes.len().min(40)]).into_owned()
}
