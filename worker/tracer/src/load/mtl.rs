//! MTL files: the materials beside an OBJ.
//!
//! Read here rather than by `tobj`, whose reader panics on `Kd 0.5` and leaves
//! the options of `map_Kd` in the name.

use shearwater_shared::limits::MATERIALS_MAX;
use shearwater_shared::scene::SceneError;
use shearwater_shared::scene::references::{argument, logical_lines, resolve, strip_map_options};
use std::collections::BTreeMap;

/// What an MTL file says about one material, as far as the renderer uses it.
#[derive(Clone, Debug, PartialEq)]
pub struct MtlMaterial {
    /// Diffuse share `Kd`, linear RGB, clamped to 0..1; 1 where only a texture
    /// is given, 0.5 where nothing is.
    pub kd: [f32; 3],
    /// Specular share `Ks`, linear RGB, clamped to 0..1; 0 with `illum` 0 or 1.
    pub ks: [f32; 3],
    /// Phong exponent `Ns`, 0 to 1e7.
    pub ns: f32,
    /// Roughness `Pr` of the PBR extension, 0 to 1.
    pub roughness: Option<f32>,
    /// Metalness `Pm` of the PBR extension, 0 to 1.
    pub metalness: Option<f32>,
    /// Texture that multiplies `kd` (`map_Kd`).
    pub map_kd: Option<MtlMap>,
    /// Texture whose red channel multiplies `roughness` (`map_Pr`).
    pub map_pr: Option<MtlMap>,
    /// Texture whose red channel multiplies `metalness` (`map_Pm`).
    pub map_pm: Option<MtlMap>,
}

/// A texture that an MTL file names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MtlMap {
    /// Asset name of the texture.
    pub asset: String,
    /// The MTL file that names it, for errors.
    pub file: String,
    /// The line, from 1.
    pub line: usize,
}

/// A material under construction: what was said so far.
#[derive(Default)]
struct Draft {
    name: String,
    kd: Option<[f32; 3]>,
    ks: [f32; 3],
    ns: f32,
    illum: Option<f32>,
    roughness: Option<f32>,
    metalness: Option<f32>,
    map_kd: Option<(String, usize)>,
    map_pr: Option<(String, usize)>,
    map_pm: Option<(String, usize)>,
}

/// Add the materials of an MTL file to `materials`; of two with one name the
/// first counts, as in other readers.
///
/// # Errors
/// A statement that is used and does not parse, or too many materials.
pub(super) fn read_mtl(
    file: &str,
    bytes: &[u8],
    materials: &mut BTreeMap<String, MtlMaterial>,
) -> Result<(), SceneError> {
    let mut draft: Option<Draft> = None;
    for line in logical_lines(bytes) {
        let text = line.text.trim_ascii();
        let fail =
            |message: String| SceneError::new(file, format!("line {}", line.number), message);
        if let Some(name) = argument(text, b"newmtl") {
            if name.is_empty() {
                return Err(fail("`newmtl` without a name: expected one".to_owned()));
            }
            finish(file, draft.take(), materials);
            if materials.len() >= MATERIALS_MAX {
                return Err(fail(format!("more than {MATERIALS_MAX} materials")));
            }
            draft = Some(Draft {
                name: name.into_owned(),
                ..Draft::default()
            });
        } else if let Some(draft) = &mut draft {
            statement(draft, text, line.number).map_err(fail)?;
        }
    }
    finish(file, draft, materials);
    Ok(())
}

fn statement(draft: &mut Draft, text: &[u8], line: usize) -> Result<(), String> {
    let argument = |keyword: &str| argument(text, keyword.as_bytes());
    if let Some(rest) = argument("Kd") {
        draft.kd = Some(color("Kd", &rest)?);
    } else if let Some(rest) = argument("Ks") {
        draft.ks = color("Ks", &rest)?;
    } else if let Some(rest) = argument("Ns") {
        draft.ns = number("Ns", &rest)?.clamp(0.0, 1e7);
    } else if let Some(rest) = argument("illum") {
        draft.illum = Some(number("illum", &rest)?);
    } else if let Some(rest) = argument("Pr") {
        draft.roughness = Some(number("Pr", &rest)?.clamp(0.0, 1.0));
    } else if let Some(rest) = argument("Pm") {
        draft.metalness = Some(number("Pm", &rest)?.clamp(0.0, 1.0));
    } else if let Some(rest) = argument("map_Kd") {
        texture(&mut draft.map_kd, &rest, line);
    } else if let Some(rest) = argument("map_Pr") {
        texture(&mut draft.map_pr, &rest, line);
    } else if let Some(rest) = argument("map_Pm") {
        texture(&mut draft.map_pm, &rest, line);
    }
    Ok(())
}

fn texture(map: &mut Option<(String, usize)>, rest: &str, line: usize) {
    let name = strip_map_options(rest);
    if !name.is_empty() {
        *map = Some((name.to_owned(), line));
    }
}

/// One grey value or three channels.
fn color(keyword: &str, rest: &str) -> Result<[f32; 3], String> {
    let words: Vec<&str> = rest.split_whitespace().take(3).collect();
    match words.as_slice() {
        [grey] => Ok([number(keyword, grey)?.clamp(0.0, 1.0); 3]),
        [r, g, b] => {
            let mut rgb = [0.0; 3];
            for (channel, word) in rgb.iter_mut().zip([r, g, b]) {
                *channel = number(keyword, word)?.clamp(0.0, 1.0);
            }
            Ok(rgb)
        }
        _ => Err(format!("`{keyword} {rest}`: expected one or three numbers")),
    }
}

fn number(keyword: &str, rest: &str) -> Result<f32, String> {
    rest.split_whitespace()
        .next()
        .and_then(|word| word.parse::<f32>().ok())
        .filter(|value| value.is_finite())
        .ok_or_else(|| {
            let shown: String = rest.chars().take(40).collect();
            format!("`{keyword} {shown}`: expected a number")
        })
}

fn finish(file: &str, draft: Option<Draft>, materials: &mut BTreeMap<String, MtlMaterial>) {
    let Some(draft) = draft else { return };
    let unsaid = if draft.map_kd.is_some() { 1.0 } else { 0.5 };
    let map = |named: Option<(String, usize)>| {
        named.map(|(name, line)| MtlMap {
            asset: resolve(file, &name),
            file: file.to_owned(),
            line,
        })
    };
    let matte = draft.illum.is_some_and(|illum| illum < 2.0);
    materials.entry(draft.name).or_insert_with(|| MtlMaterial {
        kd: draft.kd.unwrap_or([unsaid; 3]),
        ks: if matte { [0.0; 3] } else { draft.ks },
        ns: draft.ns,
        roughness: draft.roughness,
        metalness: draft.metalness,
        map_kd: map(draft.map_kd),
        map_pr: map(draft.map_pr),
        map_pm: map(draft.map_pm),
    });
}
