-- units_due: units to be counted, as far as known. It grows with each pass of an error stop and shrinks when
-- the time is up; samples_total is what they hold. blocks: those of a tile that its frame's rows are made with.
ALTER TABLE job ADD COLUMN units_due BIGINT NOT NULL DEFAULT 0;
UPDATE job SET units_due = frames * tiles * blocks;
-- Counts additions of samples; whoever decided by the settings of before must look again.
ALTER TABLE job ADD COLUMN extended BIGINT NOT NULL DEFAULT 0;
-- Seconds of a time stop, and when they began to run.
ALTER TABLE job ADD COLUMN stop_s BIGINT;
ALTER TABLE job ADD COLUMN timed_from_ms BIGINT;
-- Why its frames ended: the largest of 0 not yet, 1 error, 2 samples, 3 time.
ALTER TABLE job ADD COLUMN stopped BIGINT NOT NULL DEFAULT 0;
-- Samples per pixel in finished frames, least and most.
ALTER TABLE job ADD COLUMN samples_min BIGINT;
ALTER TABLE job ADD COLUMN samples_max BIGINT;
-- Numeric build of its first counted result; NULL before it, and for jobs of before.
ALTER TABLE job ADD COLUMN build TEXT;
ALTER TABLE frame ADD COLUMN units_due BIGINT NOT NULL DEFAULT 0;
UPDATE frame SET units_due = (SELECT tiles * blocks FROM job WHERE job.id = frame.job);
-- Passes of an error stop that were decided about.
ALTER TABLE frame ADD COLUMN pass BIGINT NOT NULL DEFAULT 0;
-- Blocks of the tile that are to be counted, as far as known.
ALTER TABLE tilefold ADD COLUMN due BIGINT NOT NULL DEFAULT 0;
UPDATE tilefold SET due = (SELECT blocks FROM job WHERE job.id = tilefold.job);
-- unit.state 3: withheld, since the time of its job is up.
