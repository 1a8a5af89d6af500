-- Error against time. What was folded before stays without: no rows, no histogram, zero samples.

-- Histogram of the brightness of a tile's samples, as JSON.
ALTER TABLE tilefold ADD COLUMN brightness TEXT;
-- Core time of a part, to be added to its frame when it is folded.
ALTER TABLE part ADD COLUMN core_us BIGINT NOT NULL DEFAULT 0;
-- Of what its films hold: samples over pixels, microseconds of cores.
ALTER TABLE frame ADD COLUMN samples_folded BIGINT NOT NULL DEFAULT 0;
ALTER TABLE frame ADD COLUMN core_us_folded BIGINT NOT NULL DEFAULT 0;

-- The error of a frame at so many folded samples; one row when it has changed enough, one for its final film.
CREATE TABLE error_point (
  job BIGINT NOT NULL,
  frame BIGINT NOT NULL,
  samples BIGINT NOT NULL,
  at_ms BIGINT NOT NULL,
  core_us BIGINT NOT NULL,
  error TEXT NOT NULL,
  PRIMARY KEY (job, frame, samples)
);
CREATE INDEX error_point_newest ON error_point (job, at_ms);
