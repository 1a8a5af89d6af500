//! From counted sums to pictures.

use super::timer::{Seconds, Timer};
use prometheus_client::encoding::EncodeLabelSet;
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::{Family, MetricConstructor};
use prometheus_client::metrics::histogram::Histogram;
use prometheus_client::registry::{Registry, Unit};

#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
struct Format {
    format: &'static str,
}

/// Folds and developments.
#[derive(Debug)]
pub(crate) struct Pictures {
    fold: Histogram,
    png: Histogram,
    exr: Histogram,
    /// Frames whose film was made final here.
    pub(crate) frames: Counter,
}

impl Pictures {
    pub(super) fn new(registry: &mut Registry) -> Self {
        let develop = Family::<Format, Histogram, Seconds>::new_with_constructor(Seconds);
        let of = |format| develop.get_or_create_owned(&Format { format });
        let pictures = Self {
            fold: Seconds.new_metric(),
            png: of("png"),
            exr: of("exr"),
            frames: Counter::default(),
        };
        registry.register_with_unit(
            "fold",
            "Folding the parts of one tile into its film",
            Unit::Seconds,
            pictures.fold.clone(),
        );
        registry.register_with_unit(
            "develop",
            "Reading a film and developing a picture of it, its turn not counted",
            Unit::Seconds,
            develop,
        );
        registry.register(
            "frames_finished",
            "Frames whose film was made final",
            pictures.frames.clone(),
        );
        pictures
    }

    /// A tile is being folded.
    pub(crate) fn folding(&self) -> Timer {
        Timer::of(self.fold.clone())
    }

    /// A PNG is being made.
    pub(crate) fn developing_png(&self) -> Timer {
        Timer::of(self.png.clone())
    }

    /// An EXR is being made.
    pub(crate) fn developing_exr(&self) -> Timer {
        Timer::of(self.exr.clone())
    }
}
