//! `shearwater gc`.

use crate::args::DEFAULT_LISTEN;
use crate::commands::coordinator::{Stores, config};
use crate::exit::CliError;
use crate::output;
use clap::Args;
use serde_json::{Map, json};
use shearwater_coordinator::sweep::Grace;

/// Longest grace time that can be given, in hours: a century.
const HOURS_MAX: u64 = 876_000;

/// Remove what no job needs any more: assets, left-over parts and films
///
/// A running coordinator does the same every hour. This does it once, now, on the
/// stores themselves; coordinators may run meanwhile.
///
/// Example: shearwater gc --data /var/lib/shearwater --assets-after 24
#[derive(Args, Debug)]
pub(crate) struct Gc {
    #[command(flatten)]
    stores: Stores,
    /// Keep assets that somebody uploaded, asked for or submitted within the last N hours; with 0,
    /// nobody may be submitting
    #[arg(long, value_name = "N", default_value_t = 168, value_parser = clap::value_parser!(u64).range(..=HOURS_MAX))]
    assets_after: u64,
    /// Keep parts and films that no row names for N hours: a result may be on its way; with 0, no
    /// coordinator may run
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(..=HOURS_MAX))]
    orphans_after: u64,
}

const HOUR_MS: u64 = 3_600_000;

pub(crate) async fn run(args: &Gc, json: bool) -> Result<(), CliError> {
    let listen = DEFAULT_LISTEN
        .parse()
        .map_err(|e| CliError::Coordinator(format!("{DEFAULT_LISTEN}: {e}")))?;
    let config = config(&args.stores, listen)?;
    let grace = Grace {
        orphan_ms: args.orphans_after.saturating_mul(HOUR_MS),
        asset_ms: args.assets_after.saturating_mul(HOUR_MS),
    };
    let report = shearwater_coordinator::gc(&config, grace)
        .await
        .map_err(|e| CliError::Coordinator(e.to_string()))?;
    let swept = report.swept;
    let removed = [
        ("deleted jobs", swept.jobs),
        ("parts", swept.parts),
        ("films", swept.films),
        ("assets", swept.assets),
        ("leavings", swept.leavings),
    ];
    if json {
        let rows: Map<_, _> = report
            .rows
            .into_iter()
            .map(|(table, rows)| (table.to_owned(), rows.into()))
            .collect();
        let removed: Map<_, _> = removed
            .into_iter()
            .map(|(what, n)| (what.replace(' ', "_"), n.into()))
            .collect();
        output::object(&json!({ "removed": removed, "rows": rows }));
        return Ok(());
    }
    let rows = removed.map(|(what, number)| (what, number.to_string()));
    output::line(output::table(&rows));
    Ok(())
}
