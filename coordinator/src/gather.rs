//! Many callers, one transaction.
//!
//! Whatever is asked while one batch is under way makes the next batch: with one caller
//! nothing waits, with thousands the cost of a transaction is shared. No timer is needed.

use tokio::sync::{mpsc, oneshot};

/// The callers' side.
#[derive(Debug)]
pub(crate) struct Gatherer<T, R> {
    sender: mpsc::Sender<Asked<T, R>>,
}

/// A question with the way back of its answer.
#[derive(Debug)]
pub(crate) struct Asked<T, R> {
    /// The question.
    pub(crate) item: T,
    /// Closed once nobody waits for it any more.
    pub(crate) answer: oneshot::Sender<R>,
}

/// The side that answers.
#[derive(Debug)]
pub(crate) struct Gathered<T, R> {
    receiver: mpsc::Receiver<Asked<T, R>>,
}

/// Both sides; `waiting_max` questions may stand in line, further callers wait before it.
pub(crate) fn gather<T, R>(waiting_max: usize) -> (Gatherer<T, R>, Gathered<T, R>) {
    let (sender, receiver) = mpsc::channel(waiting_max);
    (Gatherer { sender }, Gathered { receiver })
}

impl<T, R> Gatherer<T, R> {
    /// Ask; `None` when nobody answers any more: the process ends.
    pub(crate) async fn ask(&self, item: T) -> Option<R> {
        let (answer, answered) = oneshot::channel();
        let asked = Asked { item, answer };
        self.sender.send(asked).await.ok()?;
        answered.await.ok()
    }
}

impl<T, R> Gathered<T, R> {
    /// The next question; `None` when nobody asks any more. May be dropped while it waits.
    pub(crate) async fn next(&mut self) -> Option<Asked<T, R>> {
        self.receiver.recv().await
    }

    /// Add questions that stand in line, until `batch` has `batch_max`.
    pub(crate) fn take_more(&mut self, batch: &mut Vec<Asked<T, R>>, batch_max: usize) {
        while batch.len() < batch_max
            && let Ok(asked) = self.receiver.try_recv()
        {
            batch.push(asked);
        }
    }

    /// The next batch, of at most `batch_max` questions; `None` when nobody asks any more.
    pub(crate) async fn batch(&mut self, batch_max: usize) -> Option<Vec<Asked<T, R>>> {
        let mut batch = vec![self.next().await?];
        self.take_more(&mut batch, batch_max);
        Some(batch)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use futures_util::future::join_all;

    #[tokio::test]
    async fn what_is_asked_meanwhile_is_one_batch() {
        let (gatherer, mut gathered) = gather::<u32, u32>(100);
        let sizes = tokio::spawn(async move {
            let mut sizes = Vec::new();
            while let Some(batch) = gathered.batch(4).await {
                sizes.push(batch.len());
                for asked in batch {
                    let _ = asked.answer.send(asked.item * 2);
                }
            }
            sizes
        });
        let answers = join_all((0..10).map(|item| gatherer.ask(item))).await;
        drop(gatherer);
        assert_eq!(answers, (0..10).map(|n| Some(n * 2)).collect::<Vec<_>>());
        assert_eq!(sizes.await.expect("answers"), [4, 4, 2]);
    }
}
