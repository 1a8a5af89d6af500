//! The coordinator may vanish at any moment; what it acknowledged stays.

use crate::farm::{Farm, config, expected_hash, start};
use shearwater_coordinator::Coordinator;

/// Another coordinator on the same folder, the old one gone without a word.
async fn vanish_and_return(farm: Farm) -> Farm {
    let Farm {
        coordinator,
        http,
        dir,
    } = farm;
    drop(coordinator);
    let coordinator = Coordinator::start(config(dir.path()))
        .await
        .expect("start again");
    Farm {
        coordinator,
        http,
        dir,
    }
}

#[tokio::test]
async fn restarts_in_the_middle_lose_nothing() {
    let mut farm = start().await;
    let job = farm.submit().await;
    let lease = farm.lease("w", 1e9).await.expect("all of it");
    for (done, run) in lease.runs.iter().enumerate() {
        farm.deliver_run(&job, lease.id, run, "w").await;
        farm = vanish_and_return(farm).await;
        let view = farm.job(job.id).await;
        let counted: u64 = lease.runs[..=done]
            .iter()
            .map(|run| u64::from(run.block1 - run.block0))
            .sum();
        assert_eq!(view.units_done, counted, "what was acknowledged is there");
        // The lease is still alive: nothing to do for another worker but to help.
        assert!(farm.deliver_run(&job, lease.id, run, "w").await);
    }
    let done = farm.wait(job.id, |job| job.done).await;
    assert_eq!(done.film_hashes, [expected_hash(&job.settings, 0)]);
    let farm = vanish_and_return(farm).await;
    assert_eq!(farm.job(job.id).await.film_hashes, done.film_hashes);
}

#[tokio::test]
async fn two_coordinators_share_one_store() {
    let farm = start().await;
    let second = Coordinator::start(config(farm.dir.path()))
        .await
        .expect("second");
    let other = Farm {
        coordinator: second,
        http: farm.http.clone(),
        dir: tempfile::tempdir().expect("folder"),
    };
    let job = farm.submit().await;
    let mut turn = 0;
    while let Some(lease) = other.lease("w", 2e5).await {
        for run in &lease.runs {
            turn += 1;
            let through = if turn % 2 == 0 { &farm } else { &other };
            assert!(!through.deliver_run(&job, lease.id, run, "w").await);
        }
    }
    let done = farm.wait(job.id, |job| job.done).await;
    assert_eq!(done.film_hashes, [expected_hash(&job.settings, 0)]);
    assert_eq!(other.job(job.id).await.film_hashes, done.film_hashes);
}

#[tokio::test]
async fn objects_that_nobody_names_are_swept_after_their_grace() {
    let farm = start().await;
    let job = farm.submit().await;
    let lease = farm.lease("w", 1e9).await.expect("work");
    farm.deliver_run(&job, lease.id, &lease.runs[0], "w").await;
    // A crash between object and row.
    let orphan = farm.dir.path().join("objects/part/1/0/0/0-1-orphan");
    std::fs::create_dir_all(orphan.parent().expect("folder")).expect("folder");
    std::fs::write(&orphan, b"half").expect("write");
    let Farm {
        coordinator,
        http,
        dir,
    } = farm;
    coordinator.shutdown().await;
    // Longer than the grace, which films that are just being made need as well.
    tokio::time::sleep(std::time::Duration::from_millis(1_200)).await;
    let mut config = config(dir.path());
    config.orphan_grace_ms = 1_000;
    let coordinator = Coordinator::start(config).await.expect("start again");
    let farm = Farm {
        coordinator,
        http,
        dir,
    };
    for _ in 0..100 {
        tokio::time::sleep(std::time::Duration::from_millis(20)).await;
        if !orphan.exists() {
            break;
        }
    }
    assert!(!orphan.exists());
    for run in &lease.runs[1..] {
        farm.deliver_run(&job, lease.id, run, "w").await;
    }
    let done = farm.wait(job.id, |job| job.done).await;
    assert_eq!(done.film_hashes, [expected_hash(&job.settings, 0)]);
}
