//! The API keeps what its OpenAPI document says, whatever it is asked: schemathesis
//! against a real coordinator with jobs in every state.

mod common;

use common::farm::Farm;
use common::process::program;
use common::stores::{Pair, on_both_pairs};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

on_both_pairs! {
    every_answer_is_one_that_the_document_promises;
}

/// Cases of each operation and phase; 25 s in all on two cores.
const EXAMPLES: u32 = 25;
/// The same questions each time.
const SEED: u32 = 20_261_122;
/// The version that `tests/run` installs.
const VERSION: &str = "schemathesis==4.32.5";

/// Results are bytes.
const HOOKS: &str = "
import schemathesis
schemathesis.serializer.alias('application/vnd.shearwater.v1+bincode', 'application/octet-stream')
";

/// The program in the environment that `tests/run` sets up.
fn schemathesis() -> PathBuf {
    let built = program();
    let target = built.ancestors().nth(2).expect("target/<profile>/program");
    let tool = target.join("python/bin/schemathesis");
    assert!(
        tool.is_file(),
        "{} is not there: `tests/run` makes it, or `python3 -m venv target/python && \
         target/python/bin/pip install {VERSION}`",
        tool.display()
    );
    tool
}

/// One job that is done, one that was cancelled, one that waits.
fn jobs(farm: &Farm) -> Value {
    let small = ["--size", "64x64", "--spp", "4"];
    let done = farm.submit(&small);
    let worker = farm.worker(2);
    farm.film_hash(&done);
    worker.signal("TERM");
    worker.end().ok();
    let cancelled = farm.submit(&small);
    farm.client(&["cancel", &cancelled]).ok();
    farm.submit(&small);
    farm.job(&done)
}

/// Values that exist, so that not every question ends with 404.
fn settings(folder: &Path, done: &Value) -> PathBuf {
    std::fs::write(folder.join("hooks.py"), HOOKS).expect("hooks");
    let scene = done["scene_hash"].as_str().expect("hash");
    let text = format!(
        r#"
hooks = "hooks.py"
[dictionaries.jobs]
values = [1, 2, 3]
[dictionaries.hashes]
values = ["{scene}"]
[dictionaries.waits]
values = [0, 1]
[parameters]
"path.id" = {{ dictionary = "jobs", probability = 0.7 }}
"path.hash" = {{ dictionary = "hashes", probability = 0.5 }}
"body.manifest.scene" = {{ dictionary = "hashes", probability = 0.8 }}
"body.wait_ms" = {{ dictionary = "waits", probability = 1.0 }}
[generation]
database = "none"
deterministic = true
# The document names its own links.
[phases.stateful.inference]
algorithms = ["location-headers"]
# A readable request may still be wrong in what it says: a scene that is not
# stored, a webhook within a private network, nothing to add.
[checks.positive_data_acceptance]
expected-statuses = ["2xx", "3xx", 403, 404, 409, 416, 422]
# Sums are no text: any bytes but ours are refused, as they should be.
[[operations]]
include-operation-id = "deliver_result"
[operations.checks.positive_data_acceptance]
expected-statuses = ["2xx", 400, 404, 409, 422]
"#
    );
    let path = folder.join("schemathesis.toml");
    std::fs::write(&path, text).expect("settings");
    path
}

fn every_answer_is_one_that_the_document_promises(pair: Pair) {
    let farm = Farm::start_on(pair);
    let done = jobs(&farm);
    let config = settings(farm.folder(), &done);
    let output = Command::new(schemathesis())
        .arg("--config-file")
        .arg(&config)
        .args(["run", &format!("{}/openapi.json", farm.url)])
        .args(["--seed", &SEED.to_string()])
        .args(["--max-examples", &EXAMPLES.to_string()])
        .args(["--request-timeout", "30", "--warnings", "off", "--no-color"])
        .args(["--checks", "all"])
        .current_dir(farm.folder())
        .env("NO_PROXY", "*")
        .output()
        .expect("schemathesis runs");
    let text = String::from_utf8_lossy(&output.stdout);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{text}\n{errors}");
    // It was a test: cases were made, and some met what exists.
    assert!(text.contains("No issues found"), "{text}");
}
