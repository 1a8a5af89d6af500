-- paused_ms: since when its user has it paused; NULL when it goes on.
ALTER TABLE job ADD COLUMN paused_ms BIGINT;
-- Number of its last lease: jobs that are otherwise equal are served in turn.
ALTER TABLE job ADD COLUMN served BIGINT NOT NULL DEFAULT 0;

-- Re-execution audit. audit_salt: random, so that nobody knows which runs are chosen; 0 for jobs of before.
ALTER TABLE job ADD COLUMN audit_salt BIGINT NOT NULL DEFAULT 0;
ALTER TABLE job ADD COLUMN audits_equal BIGINT NOT NULL DEFAULT 0;
ALTER TABLE job ADD COLUMN audits_unequal BIGINT NOT NULL DEFAULT 0;
ALTER TABLE job ADD COLUMN audits_skipped BIGINT NOT NULL DEFAULT 0;
-- What a withdrawn part takes back from its frame and job; 0 for what was counted before.
ALTER TABLE part ADD COLUMN bad_samples BIGINT NOT NULL DEFAULT 0;
ALTER TABLE part ADD COLUMN depth_cap_hits BIGINT NOT NULL DEFAULT 0;
CREATE INDEX part_worker ON part (worker, job);
-- A counted run that is to be compared; gone when it is decided. lease: under which it is being rendered again,
-- or 0. claims: what other workers said, as JSON. tries: leases that brought nothing.
CREATE TABLE audit (
  job BIGINT NOT NULL,
  frame BIGINT NOT NULL,
  tile BIGINT NOT NULL,
  block0 BIGINT NOT NULL,
  block1 BIGINT NOT NULL,
  lease BIGINT NOT NULL DEFAULT 0,
  claims TEXT NOT NULL DEFAULT '[]',
  tries BIGINT NOT NULL DEFAULT 0,
  changed_ms BIGINT NOT NULL,
  PRIMARY KEY (job, frame, tile, block0)
);
CREATE INDEX audit_lease ON audit (lease) WHERE lease > 0;
-- Workers that delivered wrong sums: nothing of theirs is counted, now or later.
CREATE TABLE distrust (
  worker TEXT PRIMARY KEY,
  reason TEXT NOT NULL,
  at_ms BIGINT NOT NULL
);
ALTER TABLE worker ADD COLUMN quarantine_reason TEXT;

-- A ring for each job: slot is seq modulo its length, seq the job's rev. runs: JSON.
CREATE TABLE job_log (
  job BIGINT NOT NULL,
  slot BIGINT NOT NULL,
  seq BIGINT NOT NULL,
  at_ms BIGINT NOT NULL,
  kind TEXT NOT NULL,
  worker TEXT,
  lease BIGINT,
  runs TEXT NOT NULL,
  ms BIGINT,
  text TEXT,
  PRIMARY KEY (job, slot)
);
