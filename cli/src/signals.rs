//! Signals that ask the program to end.

/// Completes at the first SIGINT or SIGTERM. Listens from the call on, not only
/// from the first wait.
pub(crate) fn asked_to_end() -> impl Future<Output = ()> {
    #[cfg(unix)]
    let signals = {
        use tokio::signal::unix::{SignalKind, signal};
        (
            signal(SignalKind::interrupt()).ok(),
            signal(SignalKind::terminate()).ok(),
        )
    };
    async move {
        #[cfg(unix)]
        if let (Some(mut interrupt), Some(mut terminate)) = signals {
            tokio::select! {
                _ = interrupt.recv() => {}
                _ = terminate.recv() => {}
            }
            return;
        }
        let _ = tokio::signal::ctrl_c().await;
    }
}

/// Completes at the first signal, after which a second one ends the program at
/// once. Listens from the call on.
pub(crate) fn asked_to_end_once() -> impl Future<Output = ()> {
    let first = asked_to_end();
    async {
        first.await;
        tracing::info!("ending; once more to end at once");
        let second = asked_to_end();
        tokio::spawn(async {
            second.await;
            std::process::exit(crate::exit::Exit::Interrupted as i32);
        });
    }
}

/// Call `act` at each SIGHUP, which then does not end the program; never completes.
pub(crate) async fn at_each_hangup(act: impl Fn()) {
    #[cfg(unix)]
    {
        use tokio::signal::unix::{SignalKind, signal};
        if let Ok(mut hangup) = signal(SignalKind::hangup()) {
            while hangup.recv().await.is_some() {
                act();
            }
        }
    }
    #[cfg(not(unix))]
    let _ = act;
    std::future::pending::<()>().await;
}
