//! The object store's promises, over a folder and over S3.

use crate::engines::left_out;
use axum::body::Bytes;
use futures_util::StreamExt;
use shearwater_coordinator::objects::{Objects, ObjectsUrl};

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_folder_keeps_objects() {
    let folder = tempfile::tempdir().expect("folder");
    let url = format!("file://{}", folder.path().display());
    promises(&ObjectsUrl::parse(&url).expect("URL").open().expect("open")).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn s3_keeps_objects() {
    let Ok(bucket) = std::env::var("SHEARWATER_TEST_S3") else {
        left_out("objects in S3", "SHEARWATER_TEST_S3");
        return;
    };
    let _ = rustls::crypto::ring::default_provider().install_default();
    let url = format!("{bucket}/objects-{}", std::process::id());
    promises(&ObjectsUrl::parse(&url).expect("URL").open().expect("open")).await;
}

async fn promises(objects: &Objects) {
    what_is_put_is_there(objects).await;
    names_are_written_once(objects).await;
    pieces_become_one_object(objects).await;
    what_is_deleted_is_gone(objects).await;
}

async fn what_is_put_is_there(objects: &Objects) {
    objects
        .put("part/1/0/0/a", b"one".to_vec())
        .await
        .expect("put");
    objects
        .put("part/12/0/0/b", b"two".to_vec())
        .await
        .expect("put");
    let got = objects.get("part/1/0/0/a").await.expect("get");
    assert_eq!(&got[..], b"one");
    assert_eq!(objects.size("part/1/0/0/a").await.expect("size"), Some(3));
    assert_eq!(objects.size("part/1/0/0/c").await.expect("size"), None);
    let missing = objects.get("part/1/0/0/c").await.expect_err("missing");
    assert!(missing.is_missing(), "{missing}");
    // A prefix is whole parts of a name: job 1 is not job 12.
    let listed: Vec<_> = objects.list("part/1").collect().await;
    let names: Vec<String> = listed
        .into_iter()
        .map(|meta| meta.expect("listed").location.to_string())
        .collect();
    assert_eq!(names, ["part/1/0/0/a"]);
}

async fn names_are_written_once(objects: &Objects) {
    objects
        .put("film/1/x", b"first".to_vec())
        .await
        .expect("put");
    // The same again is a repetition whose first answer was lost.
    objects
        .put("film/1/x", b"first".to_vec())
        .await
        .expect("same");
    objects
        .put("film/1/x", b"other".to_vec())
        .await
        .expect_err("taken");
    let got = objects.get("film/1/x").await.expect("get");
    assert_eq!(&got[..], b"first");
    let mut racers = tokio::task::JoinSet::new();
    for racer in 0..8u8 {
        let objects = objects.clone();
        racers.spawn(async move { objects.put("film/1/race", vec![racer; 1000]).await.is_ok() });
    }
    let won = racers
        .join_all()
        .await
        .into_iter()
        .filter(|&won| won)
        .count();
    assert_eq!(won, 1, "one of them is there");
}

async fn pieces_become_one_object(objects: &Objects) {
    // Nothing, less than a part of S3, and more than two of them.
    for (bytes, piece) in [(0usize, 1usize), (100_000, 30_000), (11 << 20, 700_001)] {
        let content: Vec<u8> = (0..bytes).map(|at| (at * 7 / 3) as u8).collect();
        let name = format!("asset/{bytes}");
        let mut upload = objects.upload(&name);
        for piece in content.chunks(piece) {
            upload
                .put(Bytes::copy_from_slice(piece))
                .await
                .expect("piece");
        }
        assert_eq!(objects.size(&name).await.expect("size"), None, "not yet");
        upload.complete().await.expect("complete");
        assert_eq!(objects.get(&name).await.expect("get"), content);
        // Again, as a client does that mends a damaged copy.
        let mut upload = objects.upload(&name);
        upload
            .put(Bytes::from(content.clone()))
            .await
            .expect("piece");
        upload.complete().await.expect("complete");
        assert_eq!(objects.get(&name).await.expect("get"), content);
    }
    let mut given_up = objects.upload("asset/given-up");
    let piece = Bytes::from(vec![1; 6 << 20]);
    given_up.put(piece).await.expect("piece");
    given_up.abort().await.expect("abort");
    assert_eq!(objects.size("asset/given-up").await.expect("size"), None);
}

async fn what_is_deleted_is_gone(objects: &Objects) {
    objects.put("probe/x", b"x".to_vec()).await.expect("put");
    objects.delete("probe/x").await.expect("delete");
    objects.delete("probe/x").await.expect("twice is fine");
    assert_eq!(objects.size("probe/x").await.expect("size"), None);
}
