//! Signals that ask the program to end.

/// Completes at the first SIGINT or SIGTERM.
pub(crate) async fn asked_to_end() {
    #[cfg(unix)]
    {
        use tokio::signal::unix::{SignalKind, signal};
        if let Ok(mut terminate) = signal(SignalKind::terminate()) {
            tokio::select! {
                _ = tokio::signal::ctrl_c() => {}
                _ = terminate.recv() => {}
            }
            return;
        }
    }
    let _ = tokio::signal::ctrl_c().await;
}

/// Completes at the first signal, after which a second one ends the program at
/// once.
pub(crate) async fn asked_to_end_once() {
    asked_to_end().await;
    tracing::info!("ending; once more to end at once");
    tokio::spawn(async {
        asked_to_end().await;
        std::process::exit(crate::exit::Exit::Interrupted as i32);
    });
}
