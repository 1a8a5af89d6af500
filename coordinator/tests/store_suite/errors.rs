//! The error of a frame over its samples.

use crate::suite::{claim, gone, part, submit};
use shearwater_coordinator::store::{
    ERROR_POINTS_MAX, ErrorRow, FoldTask, Folded, FrameTile, Store,
};
use shearwater_shared::film::{Brightness, ErrorDetail, ErrorEstimate, TileError};
use shearwater_shared::plan::Run;

pub(crate) fn error_row(frame: u32, samples: u64, nmse: f64) -> ErrorRow {
    ErrorRow {
        frame,
        samples,
        at_ms: samples as i64,
        core_us: 3 * samples,
        error: ErrorEstimate {
            nmse,
            detail: Some(ErrorDetail::default()),
            ..ErrorEstimate::default()
        },
    }
}

pub(crate) fn brightness(light: i64) -> Brightness {
    let mut brightness = Brightness::zero();
    (0..100).for_each(|_| brightness.record(light));
    brightness
}

pub(crate) async fn errors_are_noted_when_they_have_changed(store: &Store) {
    let job = submit(store).await;
    while claim(store, job, 64, 1, 100).await.is_some() {}
    let fold = async |block: u32, core_us: u64| {
        let run = Run {
            frame: 1,
            tile: 0,
            block0: block,
            block1: block + 1,
        };
        let mut record = part(job, run, 0, 0);
        record.core_us = core_us;
        store.commit(&record, 2).await.expect("commit");
        let at = FrameTile {
            job,
            frame: 1,
            tile: 0,
        };
        let old = store.tile_state(&at).await.expect("read").expect("tile");
        let fold = FoldTask {
            at,
            old,
            film: format!("film/{job}/{block}"),
            error: TileError::default(),
            brightness: brightness(1 << block),
            samples: 100,
        };
        assert!(store.swap_film(&fold).await.expect("swap"));
    };
    let due = async || store.error_due(job, 1).await.expect("read");
    assert_eq!(due().await, None, "nothing is folded");
    fold(0, 5).await;
    let folded = |samples, core_us| Some(Folded { samples, core_us });
    assert_eq!(due().await, folded(100, 5));
    let rev = async || store.job_rev(job).await.expect("read");
    let before = rev().await;
    let first = error_row(1, 100, 0.5);
    store.add_error(job, &first).await.expect("add");
    assert!(rev().await > before, "watchers see it");
    assert_eq!(due().await, None, "nothing is new");
    fold(1, 7).await;
    assert_eq!(due().await, folded(200, 12));
    let text = store.brightness(job, 1).await.expect("read");
    assert_eq!(text, brightness(2), "the film's, not the sum of all films");
    // As many samples again, from another coordinator: the first stays.
    store
        .add_error(job, &error_row(1, 100, 0.4))
        .await
        .expect("add");
    store
        .add_error(job, &error_row(1, 180, 0.3))
        .await
        .expect("add");
    assert_eq!(due().await, None, "200 are less than 1.2 times 180");
    let page = async |after, limit| {
        let rows = store.errors(job, 1, after, limit).await.expect("read");
        rows.iter().map(|row| row.samples).collect::<Vec<_>>()
    };
    assert_eq!(
        (page(0, 9).await, page(100, 9).await),
        (vec![100, 180], vec![180])
    );
    assert_eq!(page(0, 1).await, [100]);
    let last = store.last_error(job, 1).await.expect("read");
    assert_eq!(last, Some(error_row(1, 180, 0.3)));
    store
        .add_error(job, &error_row(2, 170, 0.9))
        .await
        .expect("add");
    let newest = store.newest_error(job).await.expect("read");
    assert_eq!(newest.map(|row| (row.frame, row.samples)), Some((1, 180)));
    assert_eq!(page(0, 1).await.len(), 1);
    // A bound, whatever happens.
    for samples in 1..=u64::from(ERROR_POINTS_MAX) {
        store
            .add_error(job, &error_row(1, samples, 0.1))
            .await
            .expect("add");
    }
    fold(2, 1).await;
    assert_eq!(due().await, None);
    store.delete_job(job).await.expect("delete");
    gone(store, job).await;
    assert_eq!(page(0, 9).await, [0; 0], "gone with its job");
    store.add_error(job, &first).await.expect("no job, no row");
    assert_eq!(page(0, 9).await, [0; 0]);
}
