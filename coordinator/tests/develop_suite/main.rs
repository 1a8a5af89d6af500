//! Development of pictures: bloom, views, PNG and EXR against their definitions.

mod bloom;
mod exr_file;
mod pictures;
mod png_file;
mod settings;
mod view;
