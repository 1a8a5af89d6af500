//! What can be wrong with a material.

use glam::Vec3;

/// A material that cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum BsdfError {
    /// A parameter outside its range, or not a number.
    #[error("{name} is {value}, but must lie in [{low}, {high}]: correct the material")]
    OutOfRange {
        /// The parameter, as the scene names it.
        name: &'static str,
        /// What was given.
        value: f32,
        /// Smallest allowed value.
        low: f32,
        /// Largest allowed value.
        high: f32,
    },
    /// Diffuse and specular together reflect more than arrives.
    #[error("kd + ks reach {sum} in one channel, but may be at most 1: lower kd or ks")]
    TooBright {
        /// The largest channel of kd + ks.
        sum: f32,
    },
    /// The albedo table of this interface was not asked for.
    #[error("no albedo table for {what}: name it in `TableNeeds` before the tables are built")]
    MissingTable {
        /// The interface.
        what: &'static str,
    },
    /// More interfaces than tables are kept for.
    #[error("{count} different {what}, but at most {limit} are supported: share some")]
    TooMany {
        /// Which kind.
        what: &'static str,
        /// How many are asked for.
        count: usize,
        /// The limit.
        limit: usize,
    },
}

/// Refuses a value outside [low, high] and NaN.
pub(super) fn check_range(
    name: &'static str,
    value: f32,
    low: f32,
    high: f32,
) -> Result<f32, BsdfError> {
    if (low..=high).contains(&value) {
        Ok(value)
    } else {
        Err(BsdfError::OutOfRange {
            name,
            value,
            low,
            high,
        })
    }
}

/// Refuses a colour with a channel outside [0, 1].
pub(super) fn check_color(name: &'static str, color: Vec3) -> Result<Vec3, BsdfError> {
    for channel in color.to_array() {
        check_range(name, channel, 0.0, 1.0)?;
    }
    Ok(color)
}
