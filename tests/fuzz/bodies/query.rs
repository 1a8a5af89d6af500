//! Requests to the API: paths, queries, headers, tokens, bodies.

use super::farm::Farm;
use super::request;
use axum::http::{Method, StatusCode, header};
use serde_json::Value;
use shearwater_shared::api::Problem;
use std::cell::RefCell;
use tokio::runtime::Runtime;

/// Requests after which a farm is made anew: jobs and tokens' rates pile up.
const REQUESTS_MAX: u32 = 1_000;

struct Farms {
    open: Farm,
    guarded: Farm,
    requests: u32,
    runtime: Runtime,
}

thread_local! {
    static FARMS: RefCell<Option<Farms>> = const { RefCell::new(None) };
}

fn start() -> Farms {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build();
    let runtime = runtime.expect("runtime");
    let entered = runtime.enter();
    let open = Farm::start(&runtime, false);
    let guarded = Farm::start(&runtime, true);
    drop(entered);
    Farms {
        open,
        guarded,
        requests: 0,
        runtime,
    }
}

/// Drops them where their runtime is at hand, which the database asks for.
fn stop(farms: Farms) {
    let Farms {
        open,
        guarded,
        runtime,
        ..
    } = farms;
    let entered = runtime.enter();
    drop((open, guarded));
    drop(entered);
}

/// Stop the coordinators of this thread, so that nothing of them is left.
pub fn end() {
    FARMS.with_borrow_mut(|farms| farms.take().into_iter().for_each(stop));
}

/// A request, as [`request::parse`] reads it. One with an `Authorization` goes to
/// a coordinator that demands tokens.
pub fn query(data: &[u8]) {
    let Some(request) = request::parse(data) else {
        return;
    };
    let is_head = request.method() == Method::HEAD;
    let is_guarded = request.headers().contains_key(header::AUTHORIZATION);
    FARMS.with_borrow_mut(|farms| {
        if farms
            .as_ref()
            .is_some_and(|farms| farms.requests >= REQUESTS_MAX)
        {
            farms.take().into_iter().for_each(stop);
        }
        let farms = farms.get_or_insert_with(start);
        farms.requests += 1;
        let farm = if is_guarded {
            &farms.guarded
        } else {
            &farms.open
        };
        let Some((answer, body)) = farms.runtime.block_on(farm.answer(request)) else {
            return;
        };
        let status = answer.status();
        // Whatever is asked, the fault is the client's.
        assert!(
            !status.is_server_error(),
            "{status}: {}",
            text(body.as_deref())
        );
        assert_eq!(answer.headers()[header::X_CONTENT_TYPE_OPTIONS], "nosniff");
        if (status.is_client_error()) && !is_head {
            let body = body.expect("problems come at once");
            let problem: Problem = serde_json::from_slice(&body)
                .unwrap_or_else(|e| panic!("{status}, {e}: {}", text(Some(&body))));
            assert_eq!(problem.status, status.as_u16());
            assert_eq!(
                answer.headers()[header::CONTENT_TYPE],
                "application/problem+json"
            );
        } else if status == StatusCode::OK
            && answer
                .headers()
                .get(header::CONTENT_TYPE)
                .is_some_and(|t| t == "application/json")
            && let Some(body) = body
            && !is_head
        {
            serde_json::from_slice::<Value>(&body).expect("JSON");
        }
    });
}

fn text(body: Option<&[u8]>) -> String {
    String::from_utf8_lossy(body.unwrap_or_default()).into_owned()
}
