//! What this process counts and measures, and what the farm looks like: `GET /metrics`.
//!
//! Counters and histograms are of this process and cost a few atomic adds; several
//! coordinators are added up by whoever asks. Gauges of jobs, units and workers are of the
//! store, the same whichever coordinator is asked, and read when somebody asks. No label
//! ever holds what a user chose: the number of series does not grow with the farm.

mod census;
mod leases;
mod local;
mod pictures;
mod process;
mod requests;
mod results;
mod stores;
mod text;
mod timer;

pub(crate) use requests::{Answered, Route};
pub(crate) use stores::{Audited, ObjectMeasures, Operation, StoreMeasures, Transaction};

use crate::app::App;
use census::CensusCache;
use leases::Leases;
use pictures::Pictures;
use process::Process;
use prometheus_client::encoding::text::{encode_eof, encode_registry};
use prometheus_client::metrics::info::Info;
use prometheus_client::registry::Registry;
use requests::Requests;
use results::Results;

/// What every name of ours begins with; those of [`process`] are everybody's.
const PREFIX: &str = "shearwater";

/// In which of its two forms the text is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Form {
    /// OpenMetrics 1.0.
    OpenMetrics,
    /// Prometheus' older text format, 0.0.4.
    Plain,
}

/// Everything that is counted while the process runs.
#[derive(Debug)]
pub(crate) struct Metrics {
    pub(crate) leases: Leases,
    pub(crate) results: Results,
    pub(crate) pictures: Pictures,
    pub(crate) requests: Requests,
    census: CensusCache,
    process: Process,
    registry: Registry,
}

/// What a process is, for its `build_info`.
#[derive(Debug)]
pub(crate) struct About {
    /// Numeric build of the farm.
    pub(crate) build: String,
    /// `sqlite` or `postgres`.
    pub(crate) database: &'static str,
    /// `folder` or `s3`.
    pub(crate) objects: &'static str,
}

impl Metrics {
    /// Nothing counted yet; what the stores measure is told here, too.
    pub(crate) fn new(about: &About, store: &StoreMeasures, objects: &ObjectMeasures) -> Self {
        let mut registry = Registry::with_prefix(PREFIX);
        let info = Info::new(vec![
            ("version", env!("CARGO_PKG_VERSION").to_owned()),
            ("numeric_build", about.build.clone()),
            ("database", about.database.to_owned()),
            ("objects", about.objects.to_owned()),
        ]);
        registry.register("build", "What this coordinator is", info);
        store.register(&mut registry);
        objects.register(&mut registry);
        Self {
            leases: Leases::new(&mut registry),
            results: Results::new(&mut registry),
            pictures: Pictures::new(&mut registry),
            requests: Requests::new(&mut registry),
            census: CensusCache::default(),
            process: Process::start(),
            registry,
        }
    }

    /// All of it as text.
    ///
    /// # Errors
    /// Never, as far as is known: the writer is a string.
    pub(crate) async fn text(&self, app: &App, form: Form) -> Result<String, std::fmt::Error> {
        let counted = self.census.now(app).await;
        let mut text = String::with_capacity(64 << 10);
        encode_registry(&mut text, &self.registry)?;
        let mut state = Registry::with_prefix(PREFIX);
        census::register(&mut state, counted.as_deref());
        local::register(&mut state, app);
        encode_registry(&mut text, &state)?;
        let mut own = Registry::default();
        self.process.register(&mut own);
        encode_registry(&mut text, &own)?;
        encode_eof(&mut text)?;
        Ok(match form {
            Form::OpenMetrics => text,
            Form::Plain => text::plain(&text),
        })
    }
}
