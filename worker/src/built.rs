//! What is built and kept: the last stages and, of each, the last frames.

use std::sync::Arc;

/// Stages that are kept: the one that renders and the one that comes next; each
/// may take gigabytes.
const STAGES_KEPT: usize = 2;
/// Frames of a stage that are kept. Two are rendered while a lease reaches from
/// one into the next, another is handed out once more near the end, and one is
/// being built; a frame has its own sea and its own top of the tree.
const FRAMES_KEPT: usize = 4;

/// Values by key, the least recently used out first.
#[derive(Debug)]
struct Recent<K, V> {
    // Most recently used last.
    entries: Vec<(K, V)>,
    most: usize,
}

impl<K: PartialEq, V> Recent<K, V> {
    const fn new(most: usize) -> Self {
        Self {
            entries: Vec::new(),
            most,
        }
    }

    fn get(&mut self, key: &K) -> Option<&mut V> {
        let at = self.entries.iter().position(|(other, _)| other == key)?;
        let entry = self.entries.remove(at);
        self.entries.push(entry);
        self.entries.last_mut().map(|(_, value)| value)
    }

    /// Drop entries until one more fits.
    fn make_room(&mut self) {
        while self.entries.len() >= self.most {
            self.entries.remove(0);
        }
    }

    fn put(&mut self, key: K, value: V) {
        self.entries.retain(|(other, _)| *other != key);
        self.make_room();
        self.entries.push((key, value));
    }
}

/// Stages by `S`, each with frames by `F`. Whoever drops a stage drops its
/// frames, which would keep it alive.
#[derive(Debug)]
pub(crate) struct Built<S, Stage, F, Frame> {
    stages: Recent<S, Staged<Stage, F, Frame>>,
}

#[derive(Debug)]
struct Staged<Stage, F, Frame> {
    stage: Arc<Stage>,
    frames: Recent<F, Arc<Frame>>,
}

impl<S: PartialEq, Stage, F: PartialEq, Frame> Built<S, Stage, F, Frame> {
    /// Nothing yet.
    pub(crate) const fn new() -> Self {
        Self {
            stages: Recent::new(STAGES_KEPT),
        }
    }

    /// A stage that is kept.
    pub(crate) fn stage(&mut self, key: &S) -> Option<Arc<Stage>> {
        self.stages.get(key).map(|staged| staged.stage.clone())
    }

    /// Drop what would be dropped for another stage: two need not fit beside a
    /// third that is being built.
    pub(crate) fn make_room(&mut self) {
        self.stages.make_room();
    }

    /// Keep a stage.
    pub(crate) fn put_stage(&mut self, key: S, stage: Arc<Stage>) {
        let frames = Recent::new(FRAMES_KEPT);
        self.stages.put(key, Staged { stage, frames });
    }

    /// A frame that is kept.
    pub(crate) fn frame(&mut self, stage: &S, key: &F) -> Option<Arc<Frame>> {
        let frame = self.stages.get(stage)?.frames.get(key);
        frame.map(|frame| frame.clone())
    }

    /// Keep a frame, as long as its stage is kept.
    pub(crate) fn put_frame(&mut self, stage: &S, key: F, frame: Arc<Frame>) {
        if let Some(staged) = self.stages.get(stage) {
            staged.frames.put(key, frame);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Numbers = Built<u32, u32, u32, u32>;

    #[test]
    fn the_least_recently_used_stage_goes_with_its_frames() {
        let mut built = Numbers::new();
        let first = Arc::new(10);
        let frame = Arc::new(100);
        built.put_stage(1, first.clone());
        built.put_frame(&1, 7, frame.clone());
        built.put_stage(2, Arc::new(20));
        assert_eq!(built.stage(&1), Some(first.clone()));
        built.make_room();
        assert!(built.stage(&2).is_none() && built.stage(&1).is_some());
        built.put_stage(3, Arc::new(30));
        built.put_stage(4, Arc::new(40));
        assert!(built.stage(&1).is_none() && built.frame(&1, &7).is_none());
        built.put_frame(&1, 7, frame.clone());
        assert_eq!(Arc::strong_count(&frame), 1, "nobody keeps it");
        assert_eq!(Arc::strong_count(&first), 1, "nobody keeps it");
    }

    // Runs of neighbouring frames alternate where leases meet.
    #[test]
    fn frames_that_alternate_stay() {
        let mut built = Numbers::new();
        built.put_stage(1, Arc::new(10));
        let mut builds = 0;
        for frame in [0, 1, 0, 1, 2, 0, 1, 3, 2, 0, 3] {
            if built.frame(&1, &frame).is_none() {
                builds += 1;
                built.put_frame(&1, frame, Arc::new(frame));
            }
        }
        assert_eq!(builds, 4);
        for frame in 0..100 {
            built.put_frame(&1, frame, Arc::new(frame));
        }
        let kept = (0..100).filter(|f| built.frame(&1, f).is_some()).count();
        assert_eq!(kept, FRAMES_KEPT);
    }
}
