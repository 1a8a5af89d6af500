//! What ends a job before all of its samples, and where its blocks end for that.

use crate::limits;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;
use utoipa::openapi::schema::Schema;
use utoipa::openapi::{ObjectBuilder, RefOr, Type};
use utoipa::{PartialSchema, ToSchema};

/// Rules that end a job before its samples per pixel are reached, and the cuts
/// of its samples that such ends need. The default is a job of one number of
/// samples, cut as the plan cuts.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ToSchema,
)]
#[serde(deny_unknown_fields)]
pub struct Stop {
    /// Stop where the picture's error is at most this; `samples` is the most that
    /// any pixel gets. The picture stays a function of scene and settings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<ErrorTarget>,
    /// Hand out no more work so many seconds after the first lease. What is
    /// counted then is the picture, so that it depends on the speed of the farm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seconds: Option<u32>,
    /// Where blocks end besides the places that every plan has.
    #[serde(default, skip_serializing_if = "Cuts::is_empty")]
    pub cuts: Cuts,
}

impl Stop {
    /// Neither rule nor cut.
    pub const NONE: Self = Self {
        error: None,
        seconds: None,
        cuts: Cuts::NONE,
    };

    /// Neither rule nor cut: nothing to be written.
    #[must_use]
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// A relative mean squared error, larger than 0 and at most
/// [`limits::ERROR_TARGET_MAX`].
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "f64", into = "f64")]
#[schemars(with = "f64")]
pub struct ErrorTarget(f64);

impl PartialSchema for ErrorTarget {
    fn schema() -> RefOr<Schema> {
        ObjectBuilder::new()
            .schema_type(Type::Number)
            .minimum(Some(limits::ERROR_TARGET_MIN))
            .maximum(Some(limits::ERROR_TARGET_MAX))
            .description(Some("relative mean squared error"))
            .into()
    }
}

impl ToSchema for ErrorTarget {}

/// Never NaN: [`ErrorTarget::new`] refuses it.
impl Eq for ErrorTarget {}

/// An error target out of its range.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("error is {0}: expected a relative mean squared error, {min:e} to {max}, for example 0.01",
        min = limits::ERROR_TARGET_MIN, max = limits::ERROR_TARGET_MAX)]
pub struct ErrorTargetError(f64);

impl ErrorTarget {
    /// A target.
    ///
    /// # Errors
    /// Not a number from [`limits::ERROR_TARGET_MIN`] to [`limits::ERROR_TARGET_MAX`].
    pub fn new(value: f64) -> Result<Self, ErrorTargetError> {
        if (limits::ERROR_TARGET_MIN..=limits::ERROR_TARGET_MAX).contains(&value) {
            Ok(Self(value))
        } else {
            Err(ErrorTargetError(value))
        }
    }

    /// As a number.
    #[must_use]
    pub const fn get(self) -> f64 {
        self.0
    }
}

impl TryFrom<f64> for ErrorTarget {
    type Error = ErrorTargetError;

    fn try_from(value: f64) -> Result<Self, ErrorTargetError> {
        Self::new(value)
    }
}

impl From<ErrorTarget> for f64 {
    fn from(target: ErrorTarget) -> Self {
        target.0
    }
}

impl fmt::Display for ErrorTarget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// Sample counts of each half, rising, at which a block ends although the plan
/// would not end one there. A job that was added to keeps the ends of before, so
/// that its counted blocks stay what they are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "Vec<u32>", into = "Vec<u32>")]
#[schemars(with = "Vec<u32>")]
pub struct Cuts {
    len: u8,
    ends: [u32; limits::CUTS_MAX],
}

impl PartialSchema for Cuts {
    fn schema() -> RefOr<Schema> {
        Vec::<u32>::schema()
    }
}

impl ToSchema for Cuts {}

/// Cuts that no job has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("cuts: expected at most {max} sample counts, each larger than the one before and than 0",
        max = limits::CUTS_MAX)]
pub struct CutsError;

impl Cuts {
    /// No cut.
    pub const NONE: Self = Self {
        len: 0,
        ends: [0; limits::CUTS_MAX],
    };

    /// No cut.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The cuts, rising.
    #[must_use]
    pub fn ends(&self) -> &[u32] {
        self.ends.get(..usize::from(self.len)).unwrap_or(&[])
    }

    /// These cuts and one more; the same when it is one of them.
    ///
    /// # Errors
    /// One too many.
    pub fn with(&self, end: u32) -> Result<Self, CutsError> {
        let mut ends = self.ends().to_vec();
        if let Err(at) = ends.binary_search(&end) {
            ends.insert(at, end);
        }
        Self::try_from(ends)
    }
}

impl TryFrom<Vec<u32>> for Cuts {
    type Error = CutsError;

    fn try_from(ends: Vec<u32>) -> Result<Self, CutsError> {
        let rising = ends.windows(2).all(|pair| pair[0] < pair[1]);
        if !rising || ends.first() == Some(&0) {
            return Err(CutsError);
        }
        let mut cuts = Self {
            len: u8::try_from(ends.len()).map_err(|_| CutsError)?,
            ..Self::default()
        };
        let place = cuts.ends.get_mut(..ends.len()).ok_or(CutsError)?;
        place.copy_from_slice(&ends);
        Ok(cuts)
    }
}

impl From<Cuts> for Vec<u32> {
    fn from(cuts: Cuts) -> Self {
        cuts.ends().to_vec()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_have_a_range() {
        assert_eq!(ErrorTarget::new(0.01).map(ErrorTarget::get), Ok(0.01));
        for bad in [0.0, -1.0, 1e-12, 11.0, f64::NAN, f64::INFINITY] {
            assert!(ErrorTarget::new(bad).is_err(), "{bad}");
        }
        assert!(serde_json::from_str::<ErrorTarget>("0").is_err());
    }

    #[test]
    fn cuts_rise_and_are_few() {
        let cuts = Cuts::default().with(50).and_then(|cuts| cuts.with(20));
        let cuts = cuts.expect("two cuts");
        assert_eq!(cuts.ends(), [20, 50]);
        assert_eq!(cuts.with(50), Ok(cuts));
        for bad in [vec![0, 1], vec![2, 2], vec![3, 1], (1..99).collect()] {
            assert_eq!(Cuts::try_from(bad), Err(CutsError));
        }
    }

    #[test]
    fn nothing_is_written_of_a_plain_job_and_all_of_another() {
        let text = |stop: &Stop| serde_json::to_string(stop).expect("text");
        assert_eq!(text(&Stop::default()), "{}");
        let stop = Stop {
            error: ErrorTarget::new(0.02).ok(),
            seconds: Some(60),
            cuts: Cuts::try_from(vec![32]).expect("cuts"),
        };
        assert_eq!(text(&stop), r#"{"error":0.02,"seconds":60,"cuts":[32]}"#);
        assert_eq!(serde_json::from_str(&text(&stop)).ok(), Some(stop));
    }
}
