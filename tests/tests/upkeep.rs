//! Back-up and restore, and what is left when nobody needs anything any more.

mod common;

use common::farm::{Farm, film_hash_of, render, right_answer};
use common::scene;
use common::stores::{
    Pair, Places, new_database, new_prefix, on_both_pairs, postgres_program, psql, variable,
};
use serde_json::Value;
use std::path::Path;
use std::process::Command;

on_both_pairs! {
    a_copy_goes_on_where_the_farm_was;
    a_deleted_job_leaves_nothing;
}

/// A copy taken in the middle of a job, while no coordinator runs.
fn a_copy_goes_on_where_the_farm_was(pair: Pair) {
    let mut farm = Farm::start_on(pair);
    let short = farm.submit(&["--spp", "16"]);
    let worker = farm.worker(1);
    let finished = farm.film_hash(&short);
    let id = farm.submit(&[]);
    farm.under_way(&id, 3);
    farm.kill_coordinator();
    worker.kill();
    let copy = tempfile::tempdir().expect("temporary folder");
    let places = match pair {
        Pair::Laptop => copy_folder(farm.folder(), copy.path()),
        Pair::Servers => copy_servers(&farm.places, copy.path()),
    };
    // The first farm goes on, too: the copy has nothing in common with it.
    farm.restart_coordinator();
    farm.delete(&short);
    farm.delete(&id);

    let restored = Farm::start_with(places);
    assert_eq!(film_hash_of(&restored.job(&short)), finished);
    let done = restored.job(&id)["units_done"].as_u64();
    assert!(done >= Some(3), "{done:?} units were done before the copy");
    let out = restored.folder().to_str().expect("UTF-8");
    restored.client(&["download", &short, "-o", out]).ok();
    let _worker = restored.worker(2);
    assert_eq!(restored.film_hash(&id), right_answer());
}

fn copy_folder(farm: &Path, copy: &Path) -> Places {
    let status = Command::new("cp")
        .arg("-a")
        .arg(farm.join("data"))
        .arg(copy)
        .status();
    assert!(status.expect("cp").success());
    Places::folder(&copy.join("data"))
}

fn copy_servers(farm: &Places, copy: &Path) -> Places {
    let dump = copy.join("farm.dump");
    let dump = dump.to_str().expect("UTF-8");
    let (old, new) = (&farm.envs[0].1, new_database());
    postgres_program("pg_dump", &["--no-owner", "-f", dump, old]);
    psql(&new, &["-o", "/dev/null", "-f", dump]);
    let prefix = new_prefix();
    const PROGRAM: &str = "import boto3, os, sys\n\
        s3 = boto3.resource('s3', endpoint_url=os.environ['AWS_ENDPOINT_URL'])\n\
        (bucket, old), (_, new) = (url[5:].split('/', 1) for url in sys.argv[1:3])\n\
        for item in s3.Bucket(bucket).objects.filter(Prefix=old + '/'):\n\
        \x20   to = s3.Object(bucket, new + item.key[len(old):])\n\
        \x20   to.copy_from(CopySource={'Bucket': bucket, 'Key': item.key})\n";
    let status = Command::new(variable("SHEARWATER_TEST_PYTHON"))
        .args(["-c", PROGRAM, &farm.args[1], &prefix])
        .status();
    assert!(status.expect("python").success());
    Places::servers(&new, &prefix)
}

fn a_deleted_job_leaves_nothing(pair: Pair) {
    let mut farm = Farm::start_on(pair);
    let id = farm.submit(&["--spp", "64"]);
    let worker = farm.worker(2);
    farm.film_hash(&id);
    let kept = farm.gc(&[]);
    assert_eq!(kept["removed"]["assets"], 0, "they are too new, and needed");
    let one_frame = Bounds::of(&kept["rows"]);
    assert_eq!(one_frame.tiles, 8, "one row for each tile");
    assert!(one_frame.parts <= one_frame.units, "{kept}");
    farm.delete(&id);
    drop(worker);
    farm.kill_coordinator();
    let swept = farm.gc(&["--assets-after", "0", "--orphans-after", "0"]);
    assert_eq!(swept["removed"]["assets"], 3, "scene, OBJ and MTL: {swept}");
    let rows = swept["rows"].as_object().expect("rows");
    for (table, number) in rows {
        assert_eq!(number, 0, "{table} of {swept}");
    }
    let again = farm.gc(&["--assets-after", "0", "--orphans-after", "0"]);
    for what in ["deleted_jobs", "parts", "films", "assets"] {
        assert_eq!(again["removed"][what], 0, "{again}");
    }
    // And everything is there again when somebody needs it.
    farm.restart_coordinator();
    let _worker = farm.worker(2);
    let id = farm.submit(&["--spp", "64"]);
    let alone = tempfile::tempdir().expect("temporary folder");
    assert_eq!(
        farm.film_hash(&id),
        render(&scene::write(alone.path()), &["--spp", "64"])
    );
}

struct Bounds {
    units: u64,
    parts: u64,
    tiles: u64,
}

impl Bounds {
    fn of(rows: &Value) -> Self {
        let number = |table: &str| rows[table].as_u64().expect("rows");
        Self {
            units: number("unit"),
            parts: number("part"),
            tiles: number("tilefold"),
        }
    }
}

impl Farm {
    /// A sweep by hand; its report.
    fn gc(&self, more: &[&str]) -> Value {
        let mut command = common::process::command(["gc", "--json"]);
        command
            .args(&self.places.args)
            .envs(self.places.envs.iter().cloned())
            .args(more);
        common::process::Process::start(&mut command)
            .end()
            .ok()
            .json()
    }
}
