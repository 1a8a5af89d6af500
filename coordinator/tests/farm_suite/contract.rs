//! The document of the API and the router say the same.

use crate::farm::{Farm, problem, start};
use reqwest::Method;
use serde_json::Value;
use shearwater_shared::routes;
use std::collections::BTreeSet;

/// The constants of the module, as they stand in its text.
const ROUTES: &str = include_str!("../../../shared/src/routes.rs");

async fn document(farm: &Farm) -> Value {
    let answer = farm.get(routes::OPENAPI).await;
    let text = answer.text().await.expect("body");
    serde_json::from_str(&text).expect("JSON")
}

/// What stands between `before` and the next quotation mark, everywhere.
fn text_after<'a>(text: &'a str, before: &str) -> Vec<&'a str> {
    let places = text.split(before).skip(1);
    places.filter_map(|rest| rest.split('"').next()).collect()
}

fn methods(item: &Value) -> BTreeSet<String> {
    let item = item.as_object().expect("path item");
    let known = ["get", "put", "post", "delete", "patch"];
    let names = item.keys().filter(|name| known.contains(&name.as_str()));
    names.map(|name| name.to_uppercase()).collect()
}

#[tokio::test]
async fn every_path_is_described() {
    let farm = start().await;
    let api = document(&farm).await;
    assert_eq!(api["openapi"], "3.1.0");
    let described: BTreeSet<&str> = api["paths"]
        .as_object()
        .expect("paths")
        .keys()
        .map(String::as_str)
        .collect();
    let known: BTreeSet<&str> = ROUTES
        .lines()
        .filter(|line| line.starts_with("pub const "))
        .filter_map(|line| line.split('"').nth(1))
        .collect();
    assert!(known.len() > 20, "{known:?}");
    assert_eq!(described, known);
}

#[tokio::test]
async fn every_path_takes_the_methods_that_are_described_and_no_others() {
    let farm = start().await;
    let api = document(&farm).await;
    for (path, item) in api["paths"].as_object().expect("paths") {
        let described = methods(item);
        let url = farm.url(&path.replace("{id}", "1").replace("{hash}", &"0".repeat(64)));
        let request = farm.http.request(Method::TRACE, &url);
        let answer = request.send().await.expect("answer");
        let allowed = answer.headers()["allow"].to_str().expect("text").to_owned();
        problem(answer, 405, "method").await;
        let mut allowed: BTreeSet<String> =
            allowed.split(',').map(|m| m.trim().to_owned()).collect();
        assert_eq!(allowed.remove("HEAD"), described.contains("GET"), "{path}");
        assert_eq!(allowed, described, "{path}");
    }
}

#[tokio::test]
async fn every_answer_is_described_with_its_problems() {
    let farm = start().await;
    let api = document(&farm).await;
    let text = api.to_string();
    let mut names = Vec::new();
    for (path, item) in api["paths"].as_object().expect("paths") {
        for method in methods(item) {
            let operation = &item[method.to_lowercase()];
            let at = format!("{method} {path}");
            assert!(operation["summary"].is_string(), "{at}");
            names.push(operation["operationId"].as_str().expect("name"));
            let answers = operation["responses"].as_object().expect("responses");
            for (status, answer) in answers {
                assert_ne!(answer["description"], "", "{at} {status}");
                if status.as_str() >= "400" {
                    let schema = &answer["content"]["application/problem+json"]["schema"]["$ref"];
                    assert_eq!(schema, "#/components/schemas/Problem", "{at} {status}");
                }
            }
            for everywhere in ["500", "503"] {
                assert!(answers.contains_key(everywhere), "{at}");
            }
            let has_body = !operation["requestBody"].is_null();
            assert_eq!(has_body, answers.contains_key("413"), "{at}");
            assert!(
                !path.contains("{id}") || answers.contains_key("404"),
                "{at}"
            );
        }
    }
    let all = names.len();
    names.sort_unstable();
    names.dedup();
    assert!(all > 20 && names.len() == all, "{names:?}");
    // References lead somewhere.
    for name in text_after(&text, "\"#/components/schemas/") {
        assert!(api["components"]["schemas"][name].is_object(), "{name}");
    }
}

#[tokio::test]
async fn the_page_for_people_needs_nobody_else() {
    let farm = start().await;
    let page = farm.get(routes::DOCS).await;
    assert_eq!(page.url().path(), "/docs/", "redirected");
    let policy = page.headers()["content-security-policy"]
        .to_str()
        .expect("text");
    assert!(policy.starts_with("default-src 'self'"), "{policy}");
    let html = page.text().await.expect("page");
    let links = html.split("src=\"").chain(html.split("href=\"")).skip(1);
    let mut files = 0;
    for link in links.filter_map(|rest| rest.split('"').next()) {
        if link.starts_with("./") || !link.contains([' ', '<', ':']) {
            let file = farm.get(&format!("/docs/{link}")).await;
            assert_eq!(file.status(), 200, "{link}");
            files += 1;
        }
        assert!(
            !link.starts_with("http") && !link.starts_with("//"),
            "{link}"
        );
    }
    assert!(files >= 4, "{html}");
    let start = farm.get("/docs/swagger-initializer.js").await;
    let start = start.text().await.expect("script");
    assert!(start.contains(routes::OPENAPI), "{start}");
    problem(farm.get("/docs/nothing").await, 404, "no-route").await;
    // Found by fuzzing: it was refused with plain text.
    problem(farm.get("/docs/%ff").await, 400, "bad-request").await;
}
