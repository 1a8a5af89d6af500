//! Results that workers delivered to this process.

use super::timer::{Seconds, Timer};
use crate::api::ApiError;
use prometheus_client::encoding::EncodeLabelSet;
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::{Family, MetricConstructor};
use prometheus_client::metrics::histogram::Histogram;
use prometheus_client::registry::{Registry, Unit};
use std::sync::atomic::AtomicU64;

#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
struct Outcome {
    outcome: &'static str,
}

/// Counters of results.
#[derive(Debug)]
pub(crate) struct Results {
    counted: Counter,
    duplicate: Counter,
    unequal: Counter,
    refused: Counter,
    failed: Counter,
    units: Counter,
    samples: Counter,
    core_s: Counter<f64, AtomicU64>,
    bad_samples: Counter,
    bytes: Counter,
    handling: Histogram,
}

impl Results {
    pub(super) fn new(registry: &mut Registry) -> Self {
        let outcomes = Family::<Outcome, Counter>::default();
        let of = |outcome| outcomes.get_or_create_owned(&Outcome { outcome });
        let results = Self {
            counted: of("counted"),
            duplicate: of("duplicate"),
            unequal: of("unequal"),
            refused: of("refused"),
            failed: of("failed"),
            units: Counter::default(),
            samples: Counter::default(),
            core_s: Counter::default(),
            bad_samples: Counter::default(),
            bytes: Counter::default(),
            handling: Seconds.new_metric(),
        };
        registry.register(
            "results",
            "Results by what became of them; unequal is an alarm",
            outcomes,
        );
        registry.register("units_counted", "Units counted", results.units.clone());
        registry.register("samples", "Samples counted", results.samples.clone());
        registry.register(
            "bad_samples",
            "Samples counted that were no numbers",
            results.bad_samples.clone(),
        );
        registry.register_with_unit(
            "render_core",
            "Time of cores that counted results name",
            Unit::Seconds,
            results.core_s.clone(),
        );
        registry.register_with_unit(
            "result_received",
            "Bodies of results",
            Unit::Bytes,
            results.bytes.clone(),
        );
        registry.register_with_unit(
            "result_handling",
            "From the last byte of a result to its answer",
            Unit::Seconds,
            results.handling.clone(),
        );
        results
    }

    /// A body has come whole; its handling lasts until the answer is dropped.
    pub(crate) fn received(&self, bytes: usize) -> Timer {
        self.bytes.inc_by(bytes as u64);
        Timer::of(self.handling.clone())
    }

    /// A result was counted, once and for ever.
    pub(crate) fn counted(&self, part: &crate::store::PartRecord) {
        self.units
            .inc_by(u64::from(part.run.block1.saturating_sub(part.run.block0)));
        self.samples.inc_by(part.samples);
        self.core_s.inc_by(part.core_us as f64 / 1e6);
        self.bad_samples.inc_by(part.bad_samples);
    }

    /// What a worker was told: whether its result was a repetition.
    pub(crate) fn answered(&self, duplicate: Result<bool, &ApiError>) {
        let counter = match duplicate {
            Ok(false) => &self.counted,
            Ok(true) => &self.duplicate,
            Err(ApiError::Unequal) => &self.unequal,
            Err(error) if error.is_ours() => &self.failed,
            Err(_) => &self.refused,
        };
        counter.inc();
    }
}
