//! What coordinator and worker both speak.
//!
//! Scene descriptions ([`scene`]), jobs and their plans ([`job`], [`plan`]), the
//! exact film ([`film`]), the worker wire format ([`wire`]), the JSON types of
//! the REST API ([`api`]), its paths ([`routes`]) and every limit ([`limits`]).
//! Nothing here performs input or output, reads a clock or starts a thread.

pub mod api;
pub mod film;
pub mod hash;
pub mod job;
pub mod limits;
pub mod plan;
pub mod routes;
pub mod scene;
pub mod stop;
pub mod wire;
