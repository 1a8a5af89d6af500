//! The OpenAPI document, made of the handlers themselves: a route without a
//! description does not compile.

use super::conditional::{Tag, unchanged};
use super::kinds::Kind;
use axum::Extension;
use axum::body::Bytes;
use axum::http::{HeaderMap, header};
use axum::response::{IntoResponse, Response};
use serde_json::{Map, Value, json};
use shearwater_shared::api::{Problem, WebhookEvent};
use shearwater_shared::routes;
use std::collections::BTreeMap;
use utoipa::openapi::response::ResponseBuilder;
use utoipa::openapi::{ContentBuilder, OpenApiVersion, Ref, RefOr, Type};
use utoipa::{IntoResponses, OpenApi, PartialSchema, ToSchema};

/// Statuses of problems that every request can meet.
const EVERYWHERE: [u16; 6] = [401, 403, 415, 429, 500, 503];
/// Content type of every error.
const PROBLEM_JSON: &str = "application/problem+json";

/// What the document says beside the routes.
#[derive(OpenApi)]
#[openapi(
    info(
        title = "Shearwater",
        description = "A render farm in one binary: submit scenes, watch jobs, fetch pictures; and the \
            protocol of its workers. Every answer that is no success is a problem (RFC 9457) whose `type` is \
            stable. Where tokens are demanded, send `Authorization: Bearer` with yours. Wherever `GET` is, `HEAD` is too. Within /v1 fields may be added to answers; requests with \
            unknown fields are refused."
    ),
    tags(
        (name = "jobs", description = "Submit, watch, change and remove jobs"),
        (name = "pictures", description = "What a job has rendered so far"),
        (name = "assets", description = "Scenes and their files, by the blake3 of their content"),
        (name = "workers", description = "Who renders"),
        (name = "worker protocol", description = "Between a worker and a coordinator of one build"),
        (name = "service", description = "Probes, and this document")
    ),
    components(schemas(Problem, WebhookEvent))
)]
struct Base;

/// What the document begins with.
pub(super) fn base() -> utoipa::openapi::OpenApi {
    let mut base = Base::openapi();
    base.openapi = OpenApiVersion::Version31;
    base
}

/// The problems of one status, for the document.
#[derive(Debug)]
pub(super) struct Fails<const STATUS: u16>;

impl<const STATUS: u16> IntoResponses for Fails<STATUS> {
    fn responses() -> BTreeMap<String, RefOr<utoipa::openapi::Response>> {
        [(STATUS.to_string(), problem_response(STATUS).into())].into()
    }
}

fn problem_response(status: u16) -> utoipa::openapi::Response {
    let kinds = Kind::ALL.iter().filter(|kind| kind.status() == status);
    let texts: Vec<String> = kinds
        .map(|kind| format!("`{}`: {}", kind.name(), kind.when()))
        .collect();
    let schema = Ref::from_schema_name(Problem::name());
    let content = ContentBuilder::new().schema(Some(schema)).build();
    ResponseBuilder::new()
        .description(texts.join("; "))
        .content(PROBLEM_JSON, content)
        .build()
}

/// Bytes of any kind.
#[derive(Debug)]
pub(super) struct Octets;

impl PartialSchema for Octets {
    fn schema() -> RefOr<utoipa::openapi::schema::Schema> {
        let format =
            utoipa::openapi::SchemaFormat::KnownFormat(utoipa::openapi::KnownFormat::Binary);
        utoipa::openapi::ObjectBuilder::new()
            .schema_type(Type::String)
            .format(Some(format))
            .into()
    }
}

impl ToSchema for Octets {}

/// The finished document.
#[derive(Clone, Debug)]
pub(super) struct Document {
    bytes: Bytes,
    tag: Tag,
}

impl Document {
    /// Of what the routes say.
    ///
    /// # Errors
    /// It cannot be written as JSON.
    pub(super) fn new(api: &utoipa::openapi::OpenApi) -> Result<Self, serde_json::Error> {
        let mut value = serde_json::to_value(api)?;
        add_common_problems(&mut value)?;
        tidy(&mut value);
        // The one number of a request that has 16 bits; the derive calls it 32.
        let protocol = "/components/schemas/LeaseRequest/properties/protocol/maximum";
        if let Some(most) = value.pointer_mut(protocol) {
            *most = json!(u16::MAX);
        }
        let bytes = Bytes::from(serde_json::to_vec_pretty(&value)?);
        let tag = Tag::weak(&bytes);
        Ok(Self { bytes, tag })
    }
}

/// This document: the whole API as OpenAPI 3.1.
#[utoipa::path(
    get,
    path = routes::OPENAPI,
    operation_id = "get_openapi",
    tag = "service",
    params(("If-None-Match" = Option<String>, Header, description = "an `ETag`")),
    responses(
        (status = 200, description = "OpenAPI 3.1", content_type = "application/json", body = Value),
        (status = 304, description = "The client has it")
    )
)]
pub(super) async fn document(
    Extension(document): Extension<Document>,
    headers: HeaderMap,
) -> Response {
    if document.tag.is_known(&headers) {
        return unchanged(&document.tag);
    }
    let fields = [
        (header::CONTENT_TYPE, "application/json"),
        (header::CACHE_CONTROL, "no-cache"),
        (header::ETAG, document.tag.text()),
    ];
    (fields, document.bytes).into_response()
}

fn add_common_problems(api: &mut Value) -> Result<(), serde_json::Error> {
    let Some(paths) = api.get_mut("paths").and_then(Value::as_object_mut) else {
        return Ok(());
    };
    for operation in paths.values_mut().filter_map(Value::as_object_mut) {
        for operation in operation.values_mut() {
            let answers = operation.get_mut("responses");
            let Some(answers) = answers.and_then(Value::as_object_mut) else {
                continue;
            };
            for status in EVERYWHERE {
                let answer = serde_json::to_value(problem_response(status))?;
                answers.entry(status.to_string()).or_insert(answer);
            }
        }
    }
    Ok(())
}

/// Say what the types mean but the derives leave out: the range of each integer,
/// and that a parameter is absent rather than null.
fn tidy(value: &mut Value) {
    match value {
        Value::Array(items) => items.iter_mut().for_each(tidy),
        Value::Object(object) => {
            bound_integers(object);
            if object.contains_key("in") && object.contains_key("name") {
                never_null(object);
            }
            object.values_mut().for_each(tidy);
        }
        _ => {}
    }
}

fn bound_integers(object: &mut Map<String, Value>) {
    let is_integer = match object.get("type") {
        Some(Value::String(one)) => one == "integer",
        Some(Value::Array(many)) => many.iter().any(|one| one == "integer"),
        _ => false,
    };
    if !is_integer {
        return;
    }
    let unsigned = object.contains_key("minimum");
    let (least, most) = match (object.get("format").and_then(Value::as_str), unsigned) {
        (Some("int32"), true) => (json!(0), json!(u32::MAX)),
        (Some("int32"), false) => (json!(i32::MIN), json!(i32::MAX)),
        (Some("int64"), true) => (json!(0), json!(u64::MAX)),
        (Some("int64"), false) => (json!(i64::MIN), json!(i64::MAX)),
        _ => return,
    };
    object.entry("minimum").or_insert(least);
    object.entry("maximum").or_insert(most);
}

fn never_null(parameter: &mut Map<String, Value>) {
    let kinds = parameter
        .get_mut("schema")
        .and_then(|schema| schema.get_mut("type"));
    if let Some(kinds) = kinds
        && let Some(many) = kinds.as_array_mut()
    {
        many.retain(|kind| kind != "null");
        if let [one] = many.as_slice() {
            *kinds = one.clone();
        }
    }
}
