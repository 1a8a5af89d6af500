-- Frames of the scene's animation; NULL without one and for jobs of before.
ALTER TABLE job ADD COLUMN animation_frames BIGINT;
-- Of its counted runs; 0 for what was counted before.
ALTER TABLE frame ADD COLUMN bad_samples BIGINT NOT NULL DEFAULT 0;
