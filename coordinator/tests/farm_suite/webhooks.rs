//! The end of a job is told: signed, again and again until somebody takes it.

use crate::farm::{Farm, json, problem, start, start_with};
use hmac::{Hmac, KeyInit, Mac};
use sha2::Sha256;
use shearwater_coordinator::{Config, Coordinator, Secret};
use shearwater_shared::api::{
    JobView, SubmitRequest, WebhookEvent, WebhookEventKind, WebhookRequest, WebhookState,
};
use shearwater_shared::routes;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};

const SECRET: &str = "sixteen bytes or more";

/// A message as it came.
#[derive(Clone, Debug)]
struct Message {
    head: String,
    body: Vec<u8>,
}

impl Message {
    fn header(&self, name: &str) -> String {
        let lines = self.head.lines().filter_map(|line| line.split_once(": "));
        let mut found = lines.filter(|(given, _)| given.eq_ignore_ascii_case(name));
        found.next().expect(name).1.to_owned()
    }

    fn event(&self) -> WebhookEvent {
        serde_json::from_slice(&self.body).expect("event")
    }

    /// What a receiver computes from the documentation alone.
    fn is_signed_with(&self, secret: &str) -> bool {
        let mut mac = Hmac::<Sha256>::new_from_slice(secret.as_bytes()).expect("key");
        mac.update(format!("{}.", self.header("shearwater-timestamp")).as_bytes());
        mac.update(&self.body);
        let digits = mac.finalize().into_bytes();
        let digits: String = digits.iter().map(|byte| format!("{byte:02x}")).collect();
        self.header("shearwater-signature") == format!("v1={digits}")
    }
}

/// Somebody who answers each message with the next of some heads, at last with 204.
struct Receiver {
    url: String,
    got: Arc<Mutex<Vec<Message>>>,
}

async fn message(stream: &mut TcpStream) -> Message {
    let mut bytes = Vec::new();
    loop {
        let text = String::from_utf8_lossy(&bytes).into_owned();
        if let Some(end) = text.find("\r\n\r\n") {
            let head = text[..end].to_owned();
            let mut message = Message {
                head,
                body: bytes[end + 4..].to_vec(),
            };
            let length: usize = message.header("content-length").parse().expect("length");
            let have = message.body.len();
            message.body.resize(length, 0);
            stream
                .read_exact(&mut message.body[have..])
                .await
                .expect("body");
            return message;
        }
        let mut some = [0; 1024];
        let read = stream.read(&mut some).await.expect("read");
        assert!(read > 0, "{text}");
        bytes.extend_from_slice(&some[..read]);
    }
}

async fn receiver(answers: &[&str]) -> Receiver {
    let listener = TcpListener::bind("127.0.0.1:0").await.expect("listen");
    let url = format!(
        "http://{}/hook?key=private",
        listener.local_addr().expect("address")
    );
    let got = Arc::new(Mutex::new(Vec::new()));
    let kept = Arc::clone(&got);
    let mut answers: VecDeque<String> = answers.iter().map(|&a| a.to_owned()).collect();
    tokio::spawn(async move {
        while let Ok((mut stream, _)) = listener.accept().await {
            let message = message(&mut stream).await;
            kept.lock().expect("lock").push(message);
            let head = answers
                .pop_front()
                .unwrap_or_else(|| "204 No Content".into());
            let answer =
                format!("HTTP/1.1 {head}\r\ncontent-length: 0\r\nconnection: close\r\n\r\n");
            let _ = stream.write_all(answer.as_bytes()).await;
        }
    });
    Receiver { url, got }
}

fn allow(config: &mut Config) {
    config.webhook_allow = vec!["127.0.0.1".into()];
}

async fn request(farm: &Farm, url: &str) -> SubmitRequest {
    let webhook = WebhookRequest {
        url: url.to_owned(),
        secret: Some(SECRET.into()),
    };
    SubmitRequest {
        webhook: Some(webhook),
        ..farm.scene_request().await
    }
}

async fn submit(farm: &Farm, url: &str) -> JobView {
    let request = request(farm, url).await;
    let job: JobView = json(farm.post(routes::JOBS, &request).await).await;
    let webhook = job.webhook.clone().expect("webhook");
    assert_eq!(webhook.state, WebhookState::Waiting);
    assert!(!webhook.url.contains("private"), "{}", webhook.url);
    job
}

fn state(job: &JobView) -> Option<WebhookState> {
    job.webhook.as_ref().map(|webhook| webhook.state)
}

#[tokio::test]
async fn an_end_is_told_until_it_is_taken_and_never_again() {
    let farm = start_with(allow).await;
    let receiver = receiver(&["500 No", "302 Found\r\nlocation: /elsewhere"]).await;
    let job = submit(&farm, &receiver.url).await;
    farm.work(&job, "w").await;
    let told = farm
        .wait(job.id, |job| state(job) == Some(WebhookState::Delivered))
        .await;
    let webhook = told.webhook.expect("webhook");
    assert_eq!((webhook.attempts, webhook.last_status), (3, Some(204)));
    assert!(webhook.delivered_ms.is_some() && webhook.last_error.is_none());
    // Nothing more comes.
    tokio::time::sleep(std::time::Duration::from_millis(2500)).await;
    let got = receiver.got.lock().expect("lock").clone();
    assert_eq!(got.len(), 3, "no redirect was followed either");
    for message in &got {
        assert!(
            message.head.starts_with("POST /hook?key=private "),
            "{message:?}"
        );
        assert!(message.is_signed_with(SECRET) && !message.is_signed_with("another secret"));
        let event = message.event();
        assert_eq!(event.kind, WebhookEventKind::Done);
        assert_eq!(message.header("shearwater-event-id"), event.id);
        assert_eq!(event.id, got[0].event().id, "one name for all tries");
        assert_eq!(event.job.film_hashes, told.film_hashes);
        assert_eq!(Some(event.at_ms), told.finished_ms);
    }
}

#[tokio::test]
async fn every_kind_of_end_is_told_and_a_second_end_again() {
    let farm = start_with(|config| {
        allow(config);
        config.webhook_secret = Some(Secret::from("the farm's own secret".to_owned()));
    })
    .await;
    let receiver = receiver(&[]).await;
    let mut request = request(&farm, &receiver.url).await;
    request.webhook.as_mut().expect("webhook").secret = None;
    let job: JobView = json(farm.post(routes::JOBS, &request).await).await;
    let cancel = routes::fill(routes::JOB_CANCEL, &job.id.to_string());
    assert!(farm.post(&cancel, &()).await.status().is_success());
    let delivered = |job: &JobView| state(job) == Some(WebhookState::Delivered);
    farm.wait(job.id, delivered).await;
    let job = submit(&farm, &receiver.url).await;
    farm.work(&job, "w").await;
    let first = farm.wait(job.id, delivered).await;
    let more = routes::fill(routes::JOB_SAMPLES, &job.id.to_string());
    let more = farm.post(&more, &serde_json::json!({"add": 128})).await;
    let going: JobView = json(more).await;
    assert_eq!(state(&going), Some(WebhookState::Waiting));
    farm.work(&going, "w").await;
    let second = farm
        .wait(job.id, |job| {
            delivered(job) && job.finished_ms != first.finished_ms
        })
        .await;
    assert!(second.done);
    let got = receiver.got.lock().expect("lock").clone();
    let kinds: Vec<_> = got.iter().map(|message| message.event().kind).collect();
    let [cancelled, done] = [WebhookEventKind::Cancelled, WebhookEventKind::Done];
    assert_eq!(kinds, [cancelled, done, done]);
    assert!(got[0].is_signed_with("the farm's own secret"));
    assert_ne!(got[1].event().id, got[2].event().id);
}

#[tokio::test]
async fn several_coordinators_tell_once() {
    let farm = start_with(allow).await;
    let mut others = Vec::new();
    for _ in 0..3 {
        let mut config = crate::farm::config(farm.dir.path());
        allow(&mut config);
        others.push(Coordinator::start(config).await.expect("another"));
    }
    let receiver = receiver(&[]).await;
    let mut jobs = Vec::new();
    for _ in 0..10 {
        jobs.push(submit(&farm, &receiver.url).await.id);
    }
    for id in &jobs {
        let cancel = routes::fill(routes::JOB_CANCEL, &id.to_string());
        assert!(farm.post(&cancel, &()).await.status().is_success());
    }
    for id in &jobs {
        let delivered = |job: &JobView| state(job) == Some(WebhookState::Delivered);
        farm.wait(*id, delivered).await;
    }
    assert_eq!(receiver.got.lock().expect("lock").len(), jobs.len());
    for other in others {
        other.shutdown().await;
    }
}

#[tokio::test]
async fn webhooks_into_private_networks_and_without_secrets_are_refused() {
    let farm = start().await;
    for url in [
        "http://127.0.0.1/",
        "http://[::1]:80/",
        "ftp://a/",
        "http://u:p@farm.example/",
    ] {
        let bad = request(&farm, url).await;
        problem(farm.post(routes::JOBS, &bad).await, 422, "invalid").await;
    }
    let mut bad = request(&farm, "https://farm.example/").await;
    for secret in [None, Some("short".to_owned()), Some("x".repeat(201))] {
        bad.webhook.as_mut().expect("webhook").secret = secret;
        let text = problem(farm.post(routes::JOBS, &bad).await, 422, "invalid").await;
        assert!(text.detail.contains("webhook.secret"), "{}", text.detail);
    }
    // A name that leads into a private network is found out when it is called.
    let job = submit(&farm, "http://localhost:1/").await;
    let cancel = routes::fill(routes::JOB_CANCEL, &job.id.to_string());
    assert!(farm.post(&cancel, &()).await.status().is_success());
    let tried = farm
        .wait(job.id, |job| {
            job.webhook.as_ref().is_some_and(|w| w.last_error.is_some())
        })
        .await;
    let webhook = tried.webhook.expect("webhook");
    let error = webhook.last_error.expect("error");
    assert!(error.contains("--webhook-allow localhost"), "{error}");
    assert_eq!(webhook.state, WebhookState::Trying);
}
