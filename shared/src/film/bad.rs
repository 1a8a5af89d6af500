//! Samples that are no radiance: counted, described, never added.

use super::{FilmError, Half};
use crate::limits::BAD_SAMPLES_LISTED_MAX;
use serde::{Deserialize, Serialize};

/// Why a sample was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BadCause {
    /// A channel is NaN.
    NotANumber,
    /// A channel is infinite.
    Infinite,
    /// A channel is below zero.
    Negative,
    /// A channel exceeds [`super::SAMPLE_MAX`].
    Overflow,
}

impl BadCause {
    /// The gravest cause among the channels of a refused sample.
    #[must_use]
    pub fn of(rgb: [f32; 3]) -> Self {
        if rgb.iter().any(|v| v.is_nan()) {
            Self::NotANumber
        } else if rgb.iter().any(|v| v.is_infinite()) {
            Self::Infinite
        } else if rgb.iter().any(|&v| v < 0.0) {
            Self::Negative
        } else {
            Self::Overflow
        }
    }
}

/// Where to find one bad sample again: samples are pure functions, so this is
/// enough to repeat it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct BadSample {
    /// Column.
    pub x: u32,
    /// Row.
    pub y: u32,
    /// Half.
    pub half: Half,
    /// Sample index within the half.
    pub index: u32,
    /// Cause.
    pub cause: BadCause,
}

/// Bad samples of a run: all counted by cause, the first few described.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BadSamples {
    /// With a NaN channel.
    pub not_a_number: u64,
    /// With an infinite channel.
    pub infinite: u64,
    /// With a negative channel.
    pub negative: u64,
    /// Too large for the fixed point.
    pub overflow: u64,
    /// The first [`BAD_SAMPLES_LISTED_MAX`].
    pub listed: Vec<BadSample>,
}

impl BadSamples {
    /// Count one sample.
    pub fn record(&mut self, sample: BadSample) {
        *self.count_mut(sample.cause) += 1;
        if self.listed.len() < BAD_SAMPLES_LISTED_MAX {
            self.listed.push(sample);
        }
    }

    /// Bad samples of every cause.
    #[must_use]
    pub const fn total(&self) -> u64 {
        self.not_a_number
            .saturating_add(self.infinite)
            .saturating_add(self.negative)
            .saturating_add(self.overflow)
    }

    /// Add the counts of `other`; keep the first descriptions.
    pub fn merge(&mut self, other: &Self) {
        self.not_a_number = self.not_a_number.saturating_add(other.not_a_number);
        self.infinite = self.infinite.saturating_add(other.infinite);
        self.negative = self.negative.saturating_add(other.negative);
        self.overflow = self.overflow.saturating_add(other.overflow);
        let room = BAD_SAMPLES_LISTED_MAX.saturating_sub(self.listed.len());
        self.listed.extend(other.listed.iter().take(room));
    }

    pub(super) fn check(&self, samples: u64) -> Result<(), FilmError> {
        if self.total() > samples || self.listed.len() > BAD_SAMPLES_LISTED_MAX {
            return Err(FilmError::Shape("more bad samples than samples"));
        }
        Ok(())
    }

    fn count_mut(&mut self, cause: BadCause) -> &mut u64 {
        match cause {
            BadCause::NotANumber => &mut self.not_a_number,
            BadCause::Infinite => &mut self.infinite,
            BadCause::Negative => &mut self.negative,
            BadCause::Overflow => &mut self.overflow,
        }
    }
}
