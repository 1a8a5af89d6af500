//! The store's promises, as functions of a store: every engine runs the same.

mod audit;
mod commits;
mod ends;
mod engines;
mod errors;
mod events;
mod frames;
mod many;
mod objects;
mod races;
mod suite;

use engines::Database;
use shearwater_coordinator::store::DatabaseUrl;

/// Each promise as a test for each engine.
macro_rules! on_both_engines {
    ($($name:ident: $promise:path;)*) => {$(
        mod $name {
            #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
            async fn sqlite() {
                $promise(&super::Database::sqlite()).await;
            }

            #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
            async fn postgres() {
                if let Some(database) = super::Database::postgres(module_path!()).await {
                    $promise(&database).await;
                }
            }
        }
    )*};
}

on_both_engines! {
    promises: super::promises;
    every_order_of_events: super::every_order_of_events;
    created_by_many_at_once: super::created_by_many_at_once;
    everything_at_once: super::races::everything_at_once;
}

async fn promises(database: &Database) {
    suite::run(&database.open().await).await;
}

async fn every_order_of_events(database: &Database) {
    let store = database.open().await;
    for seed in 1..=12 {
        events::random_events_count_everything_once(&store, seed).await;
    }
}

async fn created_by_many_at_once(database: &Database) {
    let opens = (0..4).map(|_| {
        let url = database.url.clone();
        let open = async move { shearwater_coordinator::store::Store::open(&url).await };
        tokio::spawn(async move { open.await.expect("open").ping().await })
    });
    for open in opens.collect::<Vec<_>>() {
        open.await.expect("task").expect("answers");
    }
}

#[test]
fn unknown_engines_are_refused() {
    let error = DatabaseUrl::parse("mysql://x").expect_err("no such engine");
    assert!(error.to_string().contains("mysql"), "{error}");
}

#[tokio::test]
async fn a_wrong_password_is_said_without_it() {
    let Some(database) = Database::postgres("a wrong password").await else {
        return;
    };
    let right = std::env::var("SHEARWATER_TEST_POSTGRES").expect("set");
    let wrong = right.replace("farm-secret", "not-the-password");
    assert_ne!(right, wrong);
    let url = DatabaseUrl::parse(&wrong).expect("URL");
    let error = shearwater_coordinator::store::Store::open(&url).await;
    let error = error.expect_err("wrong password").to_string();
    assert!(!error.contains("not-the-password"), "{error}");
    assert!(error.contains("password"), "{error}");
    drop(database);
}
