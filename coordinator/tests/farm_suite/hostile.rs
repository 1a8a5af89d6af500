//! Requests that no client of ours would send.

use crate::farm::{BUILD, Farm, lease_request, part, problem, start, sums};
use reqwest::Response;
use shearwater_shared::api::{HeartbeatRequest, WorkerId};
use shearwater_shared::plan::{Plan, Run};
use shearwater_shared::routes;
use shearwater_shared::wire::{self, MESSAGE_BYTES_MAX, PartUpload};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

#[tokio::test]
async fn unknown_paths_and_methods_are_problems_too() {
    let farm = start().await;
    problem(farm.get("/").await, 404, "no-route").await;
    problem(farm.get("/v1/nothing/here").await, 404, "no-route").await;
    let put = farm
        .http
        .put(farm.url(routes::JOBS))
        .send()
        .await
        .expect("answer");
    assert!(put.headers().contains_key("allow"));
    problem(put, 405, "method").await;
    for id in ["0", "-1", "x", "99999999999999999999", "%00", "1.5"] {
        let path = routes::fill(routes::JOB, id);
        problem(farm.get(&path).await, 404, "not-found").await;
    }
    for route in [
        routes::JOB,
        routes::JOB_PNG,
        routes::JOB_EXR,
        routes::JOB_EVENTS,
        routes::ASSET,
    ] {
        // No UTF-8: refused before any of our code sees it, and still a problem.
        let path = routes::fill(route, "%FF");
        problem(farm.get(&path).await, 400, "bad-request").await;
    }
    let path = routes::fill(routes::JOB_PNG, "7");
    problem(farm.get(&path).await, 404, "not-found").await;
    problem(
        farm.get(&routes::fill(routes::JOB_EVENTS, "7")).await,
        404,
        "not-found",
    )
    .await;
}

#[tokio::test]
async fn json_bodies_are_refused_with_the_place_of_the_fault() {
    let farm = start().await;
    let post = async |body: &'static str, media_type: &'static str| {
        let request = farm.http.post(farm.url(routes::JOBS)).body(body);
        request
            .header("content-type", media_type)
            .send()
            .await
            .expect("answer")
    };
    problem(post("{}", "text/plain").await, 415, "media-type").await;
    problem(post("{", "application/json").await, 400, "bad-request").await;
    problem(post("\u{0}", "application/json").await, 400, "bad-request").await;
    let deep = "[".repeat(100_000);
    let request = farm.http.post(farm.url(routes::JOBS)).body(deep);
    let answer = request
        .header("content-type", "application/json")
        .send()
        .await;
    problem(answer.expect("answer"), 400, "bad-request").await;
    let answer = post(
        r#"{"manifest": {"scene": 5}}"#,
        "application/json; charset=utf-8",
    )
    .await;
    let text = problem(answer, 400, "bad-request").await.detail;
    assert!(text.contains("manifest.scene"), "{text}");
    let long = format!("\"{}\"", "x".repeat(2 << 20));
    let request = farm.http.post(farm.url(routes::WORKER_RELEASE)).body(long);
    let answer = request
        .header("content-type", "application/json")
        .send()
        .await;
    problem(answer.expect("answer"), 413, "too-large").await;
}

#[tokio::test]
async fn a_huge_announced_length_is_refused_unread() {
    let farm = start().await;
    for path in [routes::WORKER_RESULTS, routes::JOBS] {
        let media_type = if path == routes::JOBS {
            "application/json"
        } else {
            wire::CONTENT_TYPE
        };
        let mut stream = TcpStream::connect(farm.coordinator.addr())
            .await
            .expect("connect");
        let head = format!(
            "POST {path} HTTP/1.1\r\nhost: localhost\r\ncontent-type: {media_type}\r\n\
             content-length: 99999999999\r\n\r\n"
        );
        stream.write_all(head.as_bytes()).await.expect("send");
        let mut answer = vec![0; 12];
        stream
            .read_exact(&mut answer)
            .await
            .expect("an answer at once");
        assert_eq!(answer, b"HTTP/1.1 413");
    }
}

async fn refused(farm: &Farm, part: &PartUpload, word: &str) {
    let text = problem(farm.deliver(part).await, 422, "invalid")
        .await
        .detail;
    assert!(text.contains(word), "{text}");
}

#[tokio::test]
async fn damaged_results_are_refused_and_change_nothing() {
    let farm = start().await;
    let job = farm.submit().await;
    let lease = farm.lease("w", 1e6).await.expect("work");
    let good = part(&job, lease.id, &lease.runs[0], "w");
    let bytes = wire::encode_part(&good).expect("encode");

    let send = async |body: Vec<u8>| farm.deliver_bytes(body).await;
    for garbage in [
        vec![],
        b"GET / HTTP/1.1".to_vec(),
        bytes[..bytes.len() - 1].to_vec(),
    ] {
        problem(send(garbage).await, 400, "bad-request").await;
    }
    let mut flipped = bytes.clone();
    flipped[100] ^= 1;
    problem(send(flipped).await, 400, "bad-request").await;
    problem(send(vec![0; MESSAGE_BYTES_MAX + 1]).await, 413, "too-large").await;
    let mut version = bytes.clone();
    version[8] = 200;
    problem(send(version).await, 409, "protocol").await;
    let untyped: Response = farm
        .http
        .post(farm.url(routes::WORKER_RESULTS))
        .body(bytes)
        .send()
        .await
        .expect("answer");
    problem(untyped, 415, "media-type").await;

    let after = farm.job(job.id).await;
    assert_eq!(after.units_done, 0);
}

#[tokio::test]
async fn sums_that_cannot_be_are_refused_and_change_nothing() {
    let farm = start().await;
    let job = farm.submit().await;
    let lease = farm.lease("w", 1e6).await.expect("work");
    let good = part(&job, lease.id, &lease.runs[0], "w");
    let with = |change: &dyn Fn(&mut PartUpload)| {
        let mut part = good.clone();
        change(&mut part);
        part
    };
    let other_job = with(&|p| p.job.0 = 77);
    problem(farm.deliver(&other_job).await, 404, "not-found").await;
    let other_build = with(&|p| p.build = "another".into());
    problem(farm.deliver(&other_build).await, 409, "build").await;
    refused(&farm, &with(&|p| p.run.tile = 99), "run").await;
    refused(&farm, &with(&|p| p.run.frame = 1), "run").await;
    refused(&farm, &with(&|p| p.run.block1 = 99), "run").await;
    refused(&farm, &with(&|p| p.run.block0 = p.run.block1), "run").await;
    refused(&farm, &with(&|p| p.sums.radiance[0][0] = -1), "negative").await;
    refused(
        &farm,
        &with(&|p| p.sums.radiance[1][0] = i64::MAX),
        "larger",
    )
    .await;
    let lost = with(&|p| p.sums.radiance[0][0] += 1);
    refused(&farm, &lost, "other light than the sums").await;
    let few = with(&|p| {
        p.sums.brightness.bins.pop();
    });
    refused(&farm, &few, "bins").await;
    refused(
        &farm,
        &with(&|p| {
            p.sums.radiance[1].pop();
        }),
        "3 values",
    )
    .await;
    refused(
        &farm,
        &with(&|p| p.sums.samples_per_half += 1),
        "samples_per_half",
    )
    .await;
    refused(
        &farm,
        &with(&|p| p.sums.bad.infinite = u64::MAX),
        "bad samples",
    )
    .await;
    refused(
        &farm,
        &with(&|p| p.sums.depth_cap_hits = i64::MAX as u64),
        "depth_cap_hits",
    )
    .await;
    refused(&farm, &with(&|p| p.core_us = u64::MAX), "core_us").await;
    // Sums of another tile's shape under this tile's name.
    let plan = Plan::new(&job.settings);
    let last_tile = Run {
        tile: plan.tiles() - 1,
        ..good.run
    };
    refused(
        &farm,
        &with(&|p| p.sums = sums(&plan, &last_tile, 0)),
        "3 values",
    )
    .await;

    let after = farm.job(job.id).await;
    assert_eq!((after.units_done, after.bad_samples), (0, 0));
    assert!(!farm.deliver_run(&job, lease.id, &lease.runs[0], "w").await);
}

#[tokio::test]
async fn workers_of_another_kind_are_told_what_to_install() {
    let farm = start().await;
    farm.submit().await;
    let mut build = lease_request("w", 0.0, 0);
    build.build = "other".into();
    let answer = farm.post(routes::WORKER_LEASES, &build).await;
    let text = problem(answer, 409, "build").await.detail;
    assert!(
        text.contains(BUILD) && text.contains("Install Shearwater"),
        "{text}"
    );
    let mut protocol = lease_request("w", 0.0, 0);
    protocol.protocol += 1;
    let answer = farm.post(routes::WORKER_LEASES, &protocol).await;
    problem(answer, 409, "protocol").await;
    let mut nameless = lease_request("w", 0.0, 0);
    nameless.worker.instance.clear();
    let answer = farm.post(routes::WORKER_LEASES, &nameless).await;
    problem(answer, 422, "invalid").await;
    let many = HeartbeatRequest {
        worker: WorkerId {
            name: "w".into(),
            instance: "i".into(),
        },
        leases: (0..100).collect(),
    };
    problem(
        farm.post(routes::WORKER_HEARTBEAT, &many).await,
        422,
        "invalid",
    )
    .await;
}
