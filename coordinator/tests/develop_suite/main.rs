//! Development of pictures: bloom, views, PNG and EXR against their definitions.

mod bloom;
mod exr_file;
mod hard;
mod pictures;
mod png_file;
mod settings;
mod view;

#[path = "../../../worker/tracer/tests/hard/document.rs"]
mod document;
#[path = "../../../worker/tracer/tests/hard/table.rs"]
mod table;
