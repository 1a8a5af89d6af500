//! Parts and films: each counts once, whoever comes first.

use crate::errors::brightness;
use crate::suite::{SETTINGS, claim, part, submit};
use shearwater_coordinator::store::{CommitOutcome, FoldTask, FrameTile, Store};
use shearwater_shared::film::TileError;
use shearwater_shared::plan::{Plan, Run};

pub(crate) async fn racing_overlapping_commits_never_tear(store: &Store) {
    let job = submit(store).await;
    let claimed = claim(store, job, 16, 1, 1000).await.expect("frame 0");
    for tile in 0..4 {
        let mut racers = tokio::task::JoinSet::new();
        for racer in 0..12u32 {
            let store = store.clone();
            let block0 = racer % 4;
            let block1 = (block0 + 1 + racer / 4).min(4);
            let run = Run {
                frame: 0,
                tile,
                block0,
                block1,
            };
            racers.spawn(async move {
                let record = part(job, run, claimed.id, racer.into());
                (run, store.commit(&record, 2).await.expect("commit"))
            });
        }
        let mut counted = Vec::new();
        while let Some(race) = racers.join_next().await {
            let (run, outcome) = race.expect("task");
            if outcome == CommitOutcome::Counted {
                counted.extend(run.block0..run.block1);
            }
        }
        counted.sort_unstable();
        let mut once = counted.clone();
        once.dedup();
        assert_eq!(once, counted, "no block twice");
        assert!(!counted.is_empty(), "whoever comes first is counted");
        let state = store
            .tile_states(job, 0, tile, tile + 1)
            .await
            .expect("tile");
        let parts: Vec<u32> = state[0]
            .parts
            .iter()
            .flat_map(|p| p.block0..p.block1)
            .collect();
        assert_eq!(parts, counted, "the rows are what was acknowledged");
    }
    let row = store.job(job).await.expect("read").expect("job");
    let parts = store.tile_states(job, 0, 0, 4).await.expect("tiles");
    let blocks: u32 = parts
        .iter()
        .flat_map(|t| &t.parts)
        .map(|p| p.block1 - p.block0)
        .sum();
    assert_eq!(row.units_done, u64::from(blocks));
}

pub(crate) async fn racing_folds_take_every_part_once(store: &Store) {
    let job = submit(store).await;
    let claimed = claim(store, job, 16, 1, 1000).await.expect("frame 0");
    let at = FrameTile {
        job,
        frame: 0,
        tile: 2,
    };
    for block in 0..4 {
        let run = Run {
            frame: 0,
            tile: 2,
            block0: block,
            block1: block + 1,
        };
        let record = part(job, run, claimed.id, 0);
        assert_eq!(
            store.commit(&record, 2).await.expect("commit"),
            CommitOutcome::Counted
        );
        let old = store.tile_state(&at).await.expect("read").expect("tile");
        let mut racers = tokio::task::JoinSet::new();
        for racer in 0..6 {
            let (store, old) = (store.clone(), old.clone());
            racers.spawn(async move {
                let fold = FoldTask {
                    at,
                    old,
                    film: format!("film/{job}/{block}-{racer}"),
                    error: TileError::default(),
                    brightness: brightness(1 << block),
                    samples: Plan::new(&SETTINGS).run_samples(&run),
                };
                store.swap_film(&fold).await.expect("swap")
            });
        }
        let won = racers
            .join_all()
            .await
            .into_iter()
            .filter(|&won| won)
            .count();
        assert_eq!(won, 1, "one fold wins");
        let state = store.tile_state(&at).await.expect("read").expect("tile");
        assert_eq!((state.blocks, state.parts.len()), (block + 1, 0));
        let film = state.film.expect("film");
        assert!(store.names_object(&film).await.expect("look"));
    }
}
