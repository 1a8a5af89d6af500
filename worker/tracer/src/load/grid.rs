//! `.vol` files: a density on a grid of voxels.
//!
//! The format, version 3, all numbers little endian: the letters `VOL`, a byte 3;
//! i32 encoding (1: float32); i32 voxels along x, y, z; i32 channels (1 here); six
//! f32 of a bounding box, which is not used; then the values as f32, x fastest.

use crate::medium::DensityGrid;
use glam::UVec3;
use shearwater_shared::limits::VOXELS_MAX;
use shearwater_shared::scene::SceneError;

const HEADER_BYTES: usize = 48;
const FLOAT32: i32 = 1;

/// The densities of a `.vol` file; `path` is the place of the scene that names it.
///
/// # Errors
/// What is wrong with the file, and where in it.
pub fn load_grid(file: &str, path: &str, bytes: &[u8]) -> Result<DensityGrid, SceneError> {
    let error = |message: String| SceneError::new(file, path, message);
    let Some((header, data)) = bytes.split_at_checked(HEADER_BYTES) else {
        let length = bytes.len();
        return Err(error(format!(
            "{length} bytes: expected a .vol file, which begins with {HEADER_BYTES} bytes of header"
        )));
    };
    if &header[..4] != b"VOL\x03" {
        return Err(error(
            "expected a .vol file of version 3, which begins with the letters VOL and a byte 3"
                .to_owned(),
        ));
    }
    let field = |at: usize| {
        let bytes = [header[at], header[at + 1], header[at + 2], header[at + 3]];
        i32::from_le_bytes(bytes)
    };
    let encoding = field(4);
    if encoding != FLOAT32 {
        return Err(error(format!(
            "encoding {encoding}: expected {FLOAT32}, float32"
        )));
    }
    let sides = [8, 12, 16].map(field);
    let channels = field(20);
    if channels != 1 {
        return Err(error(format!(
            "{channels} channels: expected 1, the density"
        )));
    }
    let size = UVec3::from_array(sides.map(|side| u32::try_from(side).unwrap_or(0)));
    let [x, y, z] = size.to_array().map(u128::from);
    let voxels = x * y * z;
    if voxels == 0 || voxels > VOXELS_MAX as u128 {
        return Err(error(format!(
            "{sides:?} voxels: expected at least 1 along each axis and at most {VOXELS_MAX} in all"
        )));
    }
    if data.len() as u128 != voxels * 4 {
        return Err(error(format!(
            "{} bytes of values: expected {} for {sides:?} voxels of 4 bytes",
            data.len(),
            voxels * 4
        )));
    }
    let values: Vec<f32> = data
        .chunks_exact(4)
        .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        .collect();
    if let Some(bad) = values.iter().position(|v| !(v.is_finite() && *v >= 0.0)) {
        let (x, y) = (size.x as usize, size.y as usize);
        return Err(error(format!(
            "voxel [{}, {}, {}] (x, y, z) is {}: expected a density, finite and at least 0",
            bad % x,
            bad / x % y,
            bad / (x * y),
            values[bad]
        )));
    }
    DensityGrid::new(size, values).ok_or_else(|| error("expected densities".to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vol(size: [i32; 3], values: &[f32]) -> Vec<u8> {
        let mut bytes = b"VOL\x03".to_vec();
        for v in [1].into_iter().chain(size).chain([1]) {
            bytes.extend(v.to_le_bytes());
        }
        bytes.extend([0u8; 24]);
        bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
        bytes
    }

    fn fails(bytes: &[u8], message: &str) {
        let error = load_grid("a.vol", "clouds[0].shape.file", bytes).unwrap_err();
        assert_eq!(
            (&*error.file, &*error.path),
            ("a.vol", "clouds[0].shape.file")
        );
        assert!(error.message.contains(message), "{error}");
    }

    #[test]
    fn a_grid_reads_x_fastest() {
        let grid = load_grid("a.vol", "", &vol([2, 1, 2], &[0.0, 1.0, 2.0, 5.0])).unwrap();
        assert_eq!(grid.size(), UVec3::new(2, 1, 2));
        assert_eq!(grid.max(), 5.0);
        assert_eq!(grid.density(glam::Vec3::new(1.5, 0.5, 0.5)), 1.0);
        assert_eq!(grid.density(glam::Vec3::new(1.0, 0.5, 1.5)), 3.5);
        let black = load_grid("a.vol", "", &vol([1, 1, 2], &[0.0, -0.0])).unwrap();
        assert_eq!(black.max(), 0.0);
    }

    #[test]
    fn wrong_files_say_what_is_wrong() {
        fails(b"", "header");
        fails(&[7; 100], "version 3");
        let good = vol([2, 1, 1], &[0.0, 1.0]);
        let with = |at: usize, value: i32| {
            let mut bytes = good.clone();
            bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
            bytes
        };
        fails(&with(4, 2), "encoding 2");
        fails(&with(20, 3), "3 channels");
        fails(&with(8, 0), "at least 1 along each axis");
        fails(&with(8, -5), "[-5, 1, 1] voxels");
        fails(&with(8, i32::MAX), "at most 134217728");
        fails(&with(8, 3), "8 bytes of values: expected 12");
        fails(&good[..good.len() - 1], "7 bytes of values");
        for bad in [f32::NAN, f32::INFINITY, -1.0] {
            fails(&vol([2, 2, 1], &[0.0, 1.0, bad, 0.0]), "voxel [0, 1, 0]");
        }
    }
}
