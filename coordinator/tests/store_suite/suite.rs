//! One promise after the other, on a store that may hold other jobs; what they share.

use crate::{commits, ends, errors, frames, many};
use shearwater_coordinator::farm::{Unit, Wish, cut_runs};
use shearwater_coordinator::store::{
    Beat, ClaimQuery, Claimed, NewJob, PartRecord, Store, Submitted,
};
use shearwater_shared::hash::ContentHash;
use shearwater_shared::job::{JobId, Manifest, RenderSettings};
use shearwater_shared::plan::{Plan, Run};

pub(crate) const SETTINGS: RenderSettings = RenderSettings {
    width: 96,
    height: 80,
    samples: 512,
    seed: 0,
    frames: 3,
    first_frame: 5,
    stop: shearwater_shared::stop::Stop::NONE,
};

pub(crate) async fn submit(store: &Store) -> JobId {
    submit_frames(store, SETTINGS.frames).await
}

pub(crate) async fn submit_frames(store: &Store, frames: u32) -> JobId {
    submit_with(store, RenderSettings { frames, ..SETTINGS }).await
}

pub(crate) async fn submit_with(store: &Store, settings: RenderSettings) -> JobId {
    let new = NewJob {
        name: "job".into(),
        manifest: Manifest {
            scene: ContentHash::of(b"scene"),
            files: [].into(),
        },
        settings,
        post: shearwater_shared::scene::Post::default(),
        fps: Some(24.0),
        animation_frames: Some(8),
        priority: 0,
        owner: None,
        audit_salt: 7,
        webhook: None,
        idempotency: None,
    };
    let scene = new.manifest.scene;
    assert!(store.add_asset(&scene, 5, 1).await.expect("asset"));
    match store.submit(&new, 1).await.expect("submit") {
        Submitted::New(id) => id,
        other => panic!("{other:?}"),
    }
}

pub(crate) async fn claim(
    store: &Store,
    job: JobId,
    units_max: usize,
    now_ms: i64,
    until_ms: i64,
) -> Option<Claimed> {
    let wish = Wish {
        worker: "w".into(),
        units_max,
        threads: 1,
    };
    let claimed = claim_all(store, job, vec![wish], 0, now_ms, until_ms).await;
    claimed.into_iter().next().flatten()
}

/// One answer for each wish.
pub(crate) async fn claim_all(
    store: &Store,
    job: JobId,
    wishes: Vec<Wish>,
    present: u64,
    now_ms: i64,
    until_ms: i64,
) -> Vec<Option<Claimed>> {
    let query = ClaimQuery {
        job,
        wishes,
        present,
        timed: false,
    };
    let cut = |ready: &[Unit], wish: &Wish| cut_runs(ready, &Plan::new(&SETTINGS), wish.threads);
    store
        .claim(&query, cut, now_ms, until_ms)
        .await
        .expect("claim")
}

/// A heartbeat for one lease: whether it is wanted.
pub(crate) async fn beat(store: &Store, worker: &str, lease: i64, until_ms: i64) -> bool {
    let beat = Beat {
        lease,
        worker: worker.into(),
    };
    let wanted = store.hear(&[beat], until_ms).await.expect("hear");
    wanted.contains(&lease)
}

pub(crate) fn part(job: JobId, run: Run, lease: i64, nonce: u64) -> PartRecord {
    PartRecord {
        job,
        run,
        lease,
        worker: "w".into(),
        build: "b".into(),
        sums_hash: ContentHash::of(format!("{run:?}").as_bytes()),
        object: format!("part/{job}/{run:?}/{nonce}"),
        samples: Plan::new(&SETTINGS).run_samples(&run),
        core_us: 1,
        bad_samples: 0,
        depth_cap_hits: 0,
        audited: false,
    }
}

/// Remove a deleted job's rows, as the background does.
pub(crate) async fn gone(store: &Store, job: JobId) {
    assert!(store.deletions().await.expect("read").contains(&job));
    while store.delete_some(job).await.expect("step") > 0 {}
    store.deletion_done(job).await.expect("end");
    assert!(!store.deletions().await.expect("read").contains(&job));
}

pub(crate) async fn run(store: &Store) {
    frames::frames_are_made_when_they_are_needed(store).await;
    frames::ten_thousand_frames_are_submitted_at_once(store).await;
    frames::the_worst_frame_is_known(store).await;
    errors::errors_are_noted_when_they_have_changed(store).await;
    commits::racing_overlapping_commits_never_tear(store).await;
    commits::racing_folds_take_every_part_once(store).await;
    many::those_who_ask_together_are_served_together(store).await;
    many::what_one_failed_on_goes_to_others(store).await;
    many::results_are_counted_together_or_not_at_all(store).await;
    many::workers_are_heard_together(store).await;
    ends::what_ended_stays_ended(store).await;
    ends::expiry_frees_and_late_results_count(store).await;
    ends::a_clock_set_back_ends_leases_in_time(store).await;
    ends::a_lease_ends_with_its_last_run(store).await;
    ends::everything_of_a_deleted_job_goes(store).await;
    crate::audit::run(store).await;
}
