//! The end of a job is told although its coordinator is killed in between.

mod common;

use common::farm::Farm;
use common::stores::{Pair, on_both_pairs};
use common::until;
use serde_json::Value;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Duration;

on_both_pairs! {
    a_coordinator_killed_between_two_tries_goes_on_trying;
}

/// What came, with its event's name in the header.
struct Message {
    id: String,
    event: Value,
}

fn message(stream: &TcpStream) -> Message {
    let mut reader = BufReader::new(stream);
    let (mut length, mut id) = (0, String::new());
    loop {
        let mut line = String::new();
        reader.read_line(&mut line).expect("line");
        let Some((name, value)) = line.trim().split_once(": ") else {
            if line.trim().is_empty() {
                break;
            }
            continue;
        };
        match name.to_lowercase().as_str() {
            "content-length" => length = value.parse().expect("length"),
            "shearwater-event-id" => id = value.to_owned(),
            _ => {}
        }
    }
    let mut body = vec![0; length];
    reader.read_exact(&mut body).expect("body");
    Message {
        id,
        event: serde_json::from_slice(&body).expect("event"),
    }
}

/// A receiver that refuses the first `refusals` messages.
fn receiver(refusals: usize) -> (String, Receiver<Message>) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("listen");
    let url = format!("http://{}/", listener.local_addr().expect("address"));
    let (sender, messages): (Sender<Message>, _) = channel();
    std::thread::spawn(move || {
        for (number, stream) in listener.incoming().enumerate() {
            let mut stream = stream.expect("connection");
            let message = message(&stream);
            let status = if number < refusals {
                "503 Busy"
            } else {
                "200 OK"
            };
            let answer =
                format!("HTTP/1.1 {status}\r\ncontent-length: 0\r\nconnection: close\r\n\r\n");
            // Noted first: the test kills the coordinator before it is answered.
            if sender.send(message).is_err() {
                return;
            }
            std::thread::sleep(Duration::from_millis(100));
            let _ = stream.write_all(answer.as_bytes());
        }
    });
    (url, messages)
}

fn a_coordinator_killed_between_two_tries_goes_on_trying(pair: Pair) {
    let mut farm = Farm::start_on(pair);
    let (url, messages) = receiver(2);
    let small = ["--size", "64x64", "--spp", "4"];
    let secret = [
        "--webhook",
        &url,
        "--webhook-secret",
        "sixteen bytes or more",
    ];
    let id = farm.submit(&[&small[..], &secret].concat());
    let _worker = farm.worker(1);
    farm.film_hash(&id);
    let patience = Duration::from_secs(60);
    let mut names = Vec::new();
    for kill in [true, true, false] {
        let message = messages.recv_timeout(patience).expect("a message");
        assert_eq!(message.event["type"], "job.done");
        assert_eq!(message.event["job"]["id"].to_string(), id);
        assert_eq!(message.event["id"], message.id.as_str());
        names.push(message.id);
        if kill {
            farm.kill_coordinator();
            farm.restart_coordinator();
        }
    }
    names.dedup();
    assert_eq!(names.len(), 1, "one name for all tries");
    until("it is delivered", || {
        let webhook = &farm.job(&id)["webhook"];
        (webhook["state"] == "delivered").then_some(())
    });
    assert!(
        messages.recv_timeout(Duration::from_secs(3)).is_err(),
        "once taken, never again"
    );
}
