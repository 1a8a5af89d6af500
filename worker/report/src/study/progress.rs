//! How far it is, and how long it will take.

use std::time::Instant;

/// Counts samples and tells somebody.
pub(super) struct Progress<'a> {
    tell: &'a mut dyn FnMut(&Told<'_>),
    total: u64,
    /// Of runs that have ended or were there already.
    settled: u64,
    /// Rendered by this process.
    rendered: u64,
    began: Instant,
}

/// What is told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Told<'t> {
    /// What happens.
    pub text: &'t str,
    /// Whether it is worth a line of its own; else only a sign of life.
    pub milestone: bool,
    /// Share of all samples that is done, 0 to 1.
    pub share: f64,
    /// Seconds that are left, once that can be said.
    pub left_s: Option<f64>,
}

impl<'a> Progress<'a> {
    /// For `total` samples.
    pub(super) fn new(total: u64, tell: &'a mut dyn FnMut(&Told<'_>)) -> Self {
        Self {
            tell,
            total,
            settled: 0,
            rendered: 0,
            began: Instant::now(),
        }
    }

    /// Samples that this process has rendered.
    pub(super) const fn rendered(&self) -> u64 {
        self.rendered
    }

    /// Samples that need not be rendered (any more).
    pub(super) const fn skip(&mut self, samples: u64) {
        self.settled += samples;
    }

    /// Samples that are rendered now.
    pub(super) const fn finish(&mut self, samples: u64) {
        self.settled += samples;
        self.rendered += samples;
    }

    /// A line worth keeping.
    pub(super) fn say(&mut self, text: &str) {
        self.report(text, true, 0);
    }

    /// A sign of life, `running` samples into the present run.
    pub(super) fn alive(&mut self, text: &str, running: u64) {
        self.report(text, false, running);
    }

    fn report(&mut self, text: &str, milestone: bool, running: u64) {
        let done = (self.settled + running).min(self.total);
        let rendered = self.rendered + running;
        let elapsed = self.began.elapsed().as_secs_f64();
        // The first second says little.
        let speed = (elapsed > 1.0 && rendered > 0).then(|| rendered as f64 / elapsed);
        (self.tell)(&Told {
            text,
            milestone,
            share: done as f64 / self.total.max(1) as f64,
            left_s: speed.map(|speed| (self.total - done) as f64 / speed),
        });
    }
}
