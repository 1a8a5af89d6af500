//! HTTP requests, by the template of their path.

use super::timer::Seconds;
use axum::http::{Method, StatusCode};
use prometheus_client::encoding::EncodeLabelSet;
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::metrics::histogram::Histogram;
use prometheus_client::registry::{Registry, Unit};
use std::time::Duration;

/// Path and method of a request, of which there are as many as routes.
#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
pub(crate) struct Route {
    method: &'static str,
    route: String,
}

impl Route {
    /// What a request asks for: the template that its path fits, if any.
    pub(crate) fn new(method: &Method, template: Option<&str>) -> Self {
        let method = match method.as_str() {
            "GET" => "GET",
            "HEAD" => "HEAD",
            "POST" => "POST",
            "PUT" => "PUT",
            "PATCH" => "PATCH",
            "DELETE" => "DELETE",
            "OPTIONS" => "OPTIONS",
            // Clients may invent methods.
            _ => "other",
        };
        // Whatever else was asked for is one.
        let route = template.unwrap_or("unmatched").to_owned();
        Self { method, route }
    }

    /// Its method.
    pub(crate) const fn method(&self) -> &'static str {
        self.method
    }

    /// Its template.
    pub(crate) fn template(&self) -> &str {
        &self.route
    }
}

/// How a request ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Answered {
    /// With this status; a body may still be on its way.
    With(StatusCode),
    /// Its client went away before.
    Left,
}

impl Answered {
    const fn class(self) -> &'static str {
        let Self::With(status) = self else {
            return "left";
        };
        match status.as_u16() / 100 {
            1 => "1xx",
            2 => "2xx",
            3 => "3xx",
            4 => "4xx",
            _ => "5xx",
        }
    }
}

#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
struct Answer {
    method: &'static str,
    route: String,
    status: &'static str,
}

/// Counters of requests.
#[derive(Debug)]
pub(crate) struct Requests {
    answers: Family<Answer, Counter>,
    seconds: Family<Route, Histogram, Seconds>,
    /// Those that wait for an answer.
    pub(crate) in_flight: Gauge,
}

impl Requests {
    pub(super) fn new(registry: &mut Registry) -> Self {
        let requests = Self {
            answers: Family::default(),
            seconds: Family::new_with_constructor(Seconds),
            in_flight: Gauge::default(),
        };
        registry.register(
            "http_requests",
            "Requests answered, by class of status; left: the client went away before",
            requests.answers.clone(),
        );
        registry.register_with_unit(
            "http_request",
            "From the head of a request to the head of its answer; a question for work waits up to 20 s",
            Unit::Seconds,
            requests.seconds.clone(),
        );
        registry.register(
            "http_requests_in_flight",
            "Requests that wait for an answer",
            requests.in_flight.clone(),
        );
        requests
    }

    /// A request has ended.
    pub(crate) fn ended(&self, route: &Route, answered: Answered, took: Duration) {
        let answer = Answer {
            method: route.method,
            route: route.route.clone(),
            status: answered.class(),
        };
        self.answers.get_or_create(&answer).inc();
        self.seconds
            .get_or_create(route)
            .observe(took.as_secs_f64());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_clients_invent_is_one_value() {
        let strange = Method::from_bytes(b"BREW").expect("a method");
        let route = Route::new(&strange, None);
        assert_eq!((route.method(), route.template()), ("other", "unmatched"));
        let route = Route::new(&Method::GET, Some("/v1/jobs/{id}"));
        assert_eq!((route.method(), route.template()), ("GET", "/v1/jobs/{id}"));
    }

    #[test]
    fn statuses_have_five_classes_and_one_for_none() {
        for (status, class) in [
            (100, "1xx"),
            (204, "2xx"),
            (308, "3xx"),
            (429, "4xx"),
            (503, "5xx"),
        ] {
            let status = StatusCode::from_u16(status).expect("status");
            assert_eq!(Answered::With(status).class(), class);
        }
        assert_eq!(Answered::Left.class(), "left");
    }
}
