//! What a study found, for people and for programs.

mod base64;
mod csv;
mod html;
mod markdown;
mod numbers;
mod plot;
mod rows;

pub use csv::csv;
pub use html::html;
pub use markdown::markdown;

/// What stands above a report.
#[derive(Clone, Debug, Default)]
pub struct Heading {
    /// Title of the page.
    pub title: String,
    /// The command that made it.
    pub command: String,
    /// Machine and day, as far as anybody knows them.
    pub machine: String,
}
