//! Assets by hash.

use crate::farm::{json, problem, start};
use reqwest::StatusCode;
use shearwater_shared::api::{MissingRequest, MissingResponse};
use shearwater_shared::hash::ContentHash;
use shearwater_shared::routes;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

fn place(hash: &ContentHash) -> String {
    routes::fill(routes::ASSET, &hash.to_string())
}

#[tokio::test]
async fn upload_find_and_download() {
    let farm = start().await;
    // Larger than any buffer on the way.
    let bytes: Vec<u8> = (0..3_000_000u32).map(|i| (i % 251) as u8).collect();
    let (hash, other) = (ContentHash::of(&bytes), ContentHash::of(b"other"));
    let ask = MissingRequest {
        hashes: vec![hash, other],
    };
    let answer = farm.post(routes::ASSETS_MISSING, &ask).await;
    assert_eq!(json::<MissingResponse>(answer).await.missing, [hash, other]);
    let put = async || {
        let request = farm.http.put(farm.url(&place(&hash))).body(bytes.clone());
        request.send().await.expect("answer").status()
    };
    assert_eq!(put().await, StatusCode::CREATED);
    assert_eq!(put().await, StatusCode::OK);
    let answer = farm.post(routes::ASSETS_MISSING, &ask).await;
    assert_eq!(json::<MissingResponse>(answer).await.missing, [other]);
    let head = farm.http.head(farm.url(&place(&hash))).send().await;
    let head = head.expect("answer");
    assert_eq!(head.status(), StatusCode::OK);
    assert_eq!(head.headers()["content-length"], "3000000");
    let got = farm.get(&place(&hash)).await.bytes().await.expect("body");
    assert_eq!(got, bytes);
    problem(farm.get(&place(&other)).await, 404, "not-found").await;
    problem(farm.get("/v1/assets/xyz").await, 400, "bad-request").await;
}

#[tokio::test]
async fn a_lost_or_damaged_asset_is_mended_by_sending_it_again() {
    let farm = start().await;
    let hash = farm.put_asset(b"precious").await;
    let file = farm.dir.path().join("objects/asset").join(hash.to_string());
    let missing = async || {
        let ask = MissingRequest { hashes: vec![hash] };
        let answer = farm.post(routes::ASSETS_MISSING, &ask).await;
        json::<MissingResponse>(answer).await.missing
    };
    for spoil in [
        (|file| std::fs::remove_file(file).expect("lost")) as fn(&std::path::Path),
        |file| std::fs::write(file, b"prec").expect("cut short"),
    ] {
        assert_eq!(missing().await, []);
        spoil(&file);
        assert_eq!(missing().await, [hash]);
        let gone = problem(farm.get(&place(&hash)).await, 404, "not-found").await;
        assert!(gone.detail.contains("upload it again"), "{}", gone.detail);
        farm.put_asset(b"precious").await;
    }
    std::fs::write(&file, b"Precious").expect("another bit");
    farm.put_asset(b"precious").await;
    let mended = farm.get(&place(&hash)).await.bytes().await.expect("body");
    assert_eq!(mended, b"precious"[..]);
}

#[tokio::test]
async fn content_that_is_not_its_name_is_never_visible() {
    let farm = start().await;
    let hash = ContentHash::of(b"true");
    let request = farm.http.put(farm.url(&place(&hash))).body("false");
    problem(request.send().await.expect("answer"), 422, "invalid").await;
    problem(farm.get(&place(&hash)).await, 404, "not-found").await;
    let folder = farm.dir.path().join("objects/asset");
    let left = std::fs::read_dir(folder).map_or(0, Iterator::count);
    assert_eq!(left, 0, "a refused upload leaves nothing");
}

#[tokio::test]
async fn an_upload_that_breaks_off_or_is_too_long_is_refused() {
    let farm = start().await;
    let hash = ContentHash::of(b"abc");
    let raw = async |head: String, body: &[u8]| {
        let mut stream = TcpStream::connect(farm.coordinator.addr())
            .await
            .expect("connect");
        stream.write_all(head.as_bytes()).await.expect("send");
        stream.write_all(body).await.expect("send");
        stream.shutdown().await.expect("close");
        let mut answer = String::new();
        let _ = stream.read_to_string(&mut answer).await;
        answer
    };
    let head = |length: u64| {
        format!(
            "PUT {} HTTP/1.1\r\nhost: localhost\r\ncontent-length: {length}\r\n\r\n",
            place(&hash)
        )
    };
    let answer = raw(head(u64::from(u32::MAX)), b"abc").await;
    assert!(answer.starts_with("HTTP/1.1 413"), "{answer}");
    assert!(
        answer.contains("urn:shearwater:problem:too-large"),
        "{answer}"
    );
    raw(head(10), b"abc").await;
    problem(farm.get(&place(&hash)).await, 404, "not-found").await;
    farm.put_asset(b"abc").await;
    assert_eq!(farm.get(&place(&hash)).await.status(), StatusCode::OK);
}
