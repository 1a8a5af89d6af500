//! A fixed order for the attributes in the header of an EXR file.
//!
//! The encoder keeps attributes of the caller's own in a hash map, whose order
//! changes from run to run; the same picture would give different files. The
//! header of a single-part file is a plain list (OpenEXR file layout, "Header"):
//! name, NUL, type, NUL, length as i32, data; an empty name ends it. Sorting the
//! entries by name, the order OpenEXR's own library writes, keeps the length,
//! so that no offset in the file changes.

use super::error::DevelopError;

/// Bytes before the first attribute: magic number and version.
const PREFIX_BYTES: usize = 8;

/// Most attributes of a header; ours have about twenty.
const ATTRIBUTES_MAX: usize = 256;

/// Puts the attributes of the single-part EXR `file` in the order of their
/// names' bytes.
///
/// # Errors
/// [`DevelopError::Layout`] if the header is not the list described above.
pub(super) fn sort_attributes(file: &mut [u8]) -> Result<(), DevelopError> {
    let header = file.get_mut(PREFIX_BYTES..).ok_or_else(cut_off)?;
    let mut attributes: Vec<(&[u8], &[u8])> = Vec::new();
    let mut rest: &[u8] = header;
    while rest.first() != Some(&0) {
        let name = until_nul(rest)?;
        let len = attribute_len(rest)?;
        let (attribute, behind) = rest.split_at_checked(len).ok_or_else(cut_off)?;
        attributes.push((name, attribute));
        if attributes.len() > ATTRIBUTES_MAX {
            return Err(layout("more attributes than expected"));
        }
        rest = behind;
    }
    attributes.sort_by_key(|&(name, _)| name);
    let sorted: Vec<u8> = attributes
        .iter()
        .flat_map(|&(_, attribute)| attribute)
        .copied()
        .collect();
    if let Some(target) = header.get_mut(..sorted.len()) {
        target.copy_from_slice(&sorted);
    }
    Ok(())
}

/// Bytes of the attribute that `bytes` begins with.
fn attribute_len(bytes: &[u8]) -> Result<usize, DevelopError> {
    let name = until_nul(bytes)?.len() + 1;
    let kind = until_nul(bytes.get(name..).ok_or_else(cut_off)?)?.len() + 1;
    let head = name + kind;
    let data: [u8; 4] = bytes
        .get(head..head + 4)
        .and_then(|size| size.try_into().ok())
        .ok_or_else(cut_off)?;
    let data = usize::try_from(i32::from_le_bytes(data))
        .map_err(|_| layout("an attribute of negative length"))?;
    Ok(head + 4 + data)
}

fn until_nul(bytes: &[u8]) -> Result<&[u8], DevelopError> {
    let end = bytes.iter().position(|&byte| byte == 0);
    end.and_then(|end| bytes.get(..end)).ok_or_else(cut_off)
}

fn cut_off() -> DevelopError {
    layout("the header is cut off")
}

fn layout(detail: &'static str) -> DevelopError {
    DevelopError::Layout {
        format: "EXR",
        detail,
    }
}
