//! The worker process: lease, fetch, render, upload.
