//! The store's promises, as a function of a store: every engine runs the same.

mod commits;
mod ends;
mod errors;
mod events;
mod frames;
mod suite;

use shearwater_coordinator::store::Store;

async fn sqlite(folder: &std::path::Path) -> Store {
    let url = format!("sqlite://{}/farm.db?mode=rwc", folder.display());
    Store::open(&url).await.expect("open")
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn sqlite_keeps_its_promises() {
    let folder = tempfile::tempdir().expect("folder");
    suite::run(&sqlite(folder.path()).await).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn sqlite_survives_every_order_of_events() {
    let folder = tempfile::tempdir().expect("folder");
    let store = sqlite(folder.path()).await;
    for seed in 1..=12 {
        events::random_events_count_everything_once(&store, seed).await;
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn many_processes_may_create_one_database_at_once() {
    for _ in 0..5 {
        let folder = tempfile::tempdir().expect("folder");
        let opens = (0..4).map(|_| {
            let path = folder.path().to_owned();
            tokio::spawn(async move { sqlite(&path).await.ping().await })
        });
        for open in opens.collect::<Vec<_>>() {
            open.await.expect("task").expect("answers");
        }
    }
}

#[tokio::test]
async fn unknown_engines_are_refused() {
    let error = Store::open("mysql://x").await.expect_err("no such engine");
    assert!(error.to_string().contains("mysql://x"), "{error}");
}
