//! The coordinator: farm decisions, store, API, development of pictures.
