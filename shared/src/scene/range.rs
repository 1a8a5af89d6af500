//! Checks of single values of a scene: each says the value, what was expected
//! and in which unit.

use super::SceneError;
use super::at::At;
use super::references::resolve;
use crate::film::SAMPLE_MAX;
use crate::limits::ASSET_NAME_BYTES_MAX;

/// Largest coordinate, size or distance in metres, near the sun's distance in
/// thousands of kilometres: squares and products of two stay far inside f32.
pub(super) const LENGTH_M_MAX: f64 = 1e9;
/// Largest angle in degrees where any turn is meant: some thousand full turns,
/// beyond which the reduction to one turn eats the digits.
pub(super) const TURN_DEG_MAX: f64 = 1e6;
/// Largest radiance and factor on radiance: what a sample can hold. Brighter
/// light would be refused by the film wherever the camera sees it.
pub(super) const RADIANCE_MAX: f64 = SAMPLE_MAX as f64;
/// Slack of `kd + ks <= 1`, for decimals that f32 rounds up.
const SHARE_SLACK: f32 = 1e-6;

/// What a number must lie in.
#[derive(Clone, Copy)]
pub(super) enum Range {
    /// From the first to the second, both allowed.
    Closed(f64, f64),
    /// Above the first, up to the second.
    Above(f64, f64),
    /// Above the first, below the second.
    Between(f64, f64),
}

/// 0 to 1.
pub(super) const SHARE: Range = Range::Closed(0.0, 1.0);
/// Any coordinate.
pub(super) const COORDINATE: Range = Range::Closed(-LENGTH_M_MAX, LENGTH_M_MAX);
/// A length that may be nothing.
pub(super) const LENGTH: Range = Range::Closed(0.0, LENGTH_M_MAX);
/// A length that must be something: no smaller than a tenth of a nanometre,
/// where its square would leave f32.
pub(super) const SIZE: Range = Range::Closed(1e-10, LENGTH_M_MAX);
/// Any turn.
pub(super) const TURN: Range = Range::Closed(-TURN_DEG_MAX, TURN_DEG_MAX);
/// Any velocity in metres per second: beyond the fastest spacecraft.
pub(super) const VELOCITY_MPS: Range = Range::Closed(-1e5, 1e5);
/// Radiance.
pub(super) const RADIANCE: Range = Range::Closed(0.0, RADIANCE_MAX);

impl Range {
    fn holds(self, value: f64) -> bool {
        match self {
            Self::Closed(low, high) => value >= low && value <= high,
            Self::Above(low, high) => value > low && value <= high,
            Self::Between(low, high) => value > low && value < high,
        }
    }

    fn describe(self, unit: &str) -> String {
        let unit = if unit.is_empty() {
            String::new()
        } else {
            format!(" {unit}")
        };
        match self {
            Self::Closed(low, high) => format!("{low} to {high}{unit}"),
            Self::Above(low, high) => format!("more than {low}, at most {high}{unit}"),
            Self::Between(low, high) => format!("more than {low}, less than {high}{unit}"),
        }
    }
}

/// One number; NaN and infinities are outside of every range.
pub(super) fn number(
    at: &At<'_>,
    value: impl Into<f64>,
    range: Range,
    unit: &str,
) -> Result<(), SceneError> {
    let value = value.into();
    if range.holds(value) {
        Ok(())
    } else {
        Err(at.error(format!("{value}: expected {}", range.describe(unit))))
    }
}

/// Every number of an array.
pub(super) fn numbers<T: Into<f64> + Copy>(
    at: &At<'_>,
    values: &[T],
    range: Range,
    unit: &str,
) -> Result<(), SceneError> {
    values
        .iter()
        .enumerate()
        .try_for_each(|(i, &value)| number(&at.index(i), value, range, unit))
}

/// Smallest and largest of something, in that order.
pub(super) fn bounds<T: Into<f64> + Copy>(
    at: &At<'_>,
    bounds: &[T; 2],
    range: Range,
    unit: &str,
) -> Result<(), SceneError> {
    numbers(at, bounds, range, unit)?;
    let [low, high] = bounds.map(Into::into);
    if low <= high {
        Ok(())
    } else {
        Err(at.error(format!("[{low}, {high}]: expected the smaller value first")))
    }
}

/// A direction: any length but zero.
pub(super) fn direction(at: &At<'_>, vector: &[f64; 3]) -> Result<(), SceneError> {
    numbers(at, vector, COORDINATE, "")?;
    if length_squared(*vector) > 0.0 {
        Ok(())
    } else {
        Err(at.error(format!("{vector:?}: expected a vector that is not zero")))
    }
}

/// A count.
pub(super) fn count(at: &At<'_>, value: u64, low: u64, high: u64) -> Result<(), SceneError> {
    if (low..=high).contains(&value) {
        Ok(())
    } else {
        Err(at.error(format!("{value}: expected {low} to {high}")))
    }
}

/// Two shares that together may not exceed 1 in any channel.
pub(super) fn shares(at: &At<'_>, kd: &[f32; 3], ks: &[f32; 3]) -> Result<(), SceneError> {
    for (channel, (d, s)) in ["red", "green", "blue"].iter().zip(kd.iter().zip(ks)) {
        let sum = d + s;
        if sum > 1.0 + SHARE_SLACK {
            return Err(at.error(format!(
                "kd + ks is {sum} in {channel}: expected at most 1, or the surface adds light"
            )));
        }
    }
    Ok(())
}

/// The name of an asset: relative to scene.json, with `/` between the parts and
/// in its shortest form, because it is a key of the job's manifest: two
/// spellings of one file would be two assets.
pub(super) fn asset(at: &At<'_>, name: &str) -> Result<(), SceneError> {
    if name.len() > ASSET_NAME_BYTES_MAX {
        let message = format!(
            "{} bytes: expected at most {ASSET_NAME_BYTES_MAX}",
            name.len()
        );
        return Err(at.error(message));
    }
    if name.chars().any(char::is_control) {
        return Err(at.error(format!("{name:?}: expected no control characters")));
    }
    if name.starts_with(['/', '\\']) {
        return Err(at.error(format!("`{name}`: expected a name relative to scene.json")));
    }
    let plain = resolve("", name);
    if plain.is_empty() || plain == ".." || plain.ends_with("/..") {
        return Err(at.error(format!("`{name}`: expected the name of a file")));
    }
    if plain != name {
        return Err(at.error(format!("`{name}`: expected `{plain}`")));
    }
    Ok(())
}

/// A name that must stand in a table; the message lists what does.
pub(super) fn defined<'a>(
    at: &At<'_>,
    what: &str,
    name: &str,
    known: impl Iterator<Item = &'a String> + Clone,
) -> Result<(), SceneError> {
    if known.clone().any(|k| k == name) {
        return Ok(());
    }
    Err(at.error(format!(
        "`{name}`: no {what} of that name; {}",
        list_known(known)
    )))
}

/// `known: a, b, c and 12 more`, or `none are defined`.
pub(super) fn list_known<'a>(known: impl Iterator<Item = &'a String>) -> String {
    /// More names than these hide the message.
    const LISTED_MAX: usize = 12;
    let mut names = Vec::new();
    let mut more = 0_usize;
    for name in known {
        if names.len() < LISTED_MAX {
            names.push(format!("`{name}`"));
        } else {
            more += 1;
        }
    }
    match (names.is_empty(), more) {
        (true, _) => "none are defined".to_owned(),
        (false, 0) => format!("known: {}", names.join(", ")),
        (false, more) => format!("known: {} and {more} more", names.join(", ")),
    }
}

pub(super) fn length_squared([x, y, z]: [f64; 3]) -> f64 {
    x * x + y * y + z * z
}
