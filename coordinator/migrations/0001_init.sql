-- BIGINT and TEXT only: the same text runs on SQLite and PostgreSQL.
-- Times are milliseconds since 1970. A hash is 64 hexadecimal digits.

CREATE TABLE counter (name TEXT PRIMARY KEY, value BIGINT NOT NULL);
INSERT INTO counter (name, value) VALUES ('job', 0), ('lease', 0);

-- ended: 0 live, 1 cancelled, 2 failed (3 by its scene, 4 by its workers). Everything else about a job's state is
-- derived from its counts.
CREATE TABLE job (
  id BIGINT PRIMARY KEY,
  name TEXT NOT NULL,
  manifest TEXT NOT NULL,
  scene_hash TEXT NOT NULL,
  settings TEXT NOT NULL,
  post TEXT NOT NULL,
  priority BIGINT NOT NULL,
  frames BIGINT NOT NULL,
  tiles BIGINT NOT NULL,
  blocks BIGINT NOT NULL,
  samples_total BIGINT NOT NULL,
  next_frame BIGINT NOT NULL DEFAULT 0,
  frames_done BIGINT NOT NULL DEFAULT 0,
  units_done BIGINT NOT NULL DEFAULT 0,
  samples_done BIGINT NOT NULL DEFAULT 0,
  core_us BIGINT NOT NULL DEFAULT 0,
  bad_samples BIGINT NOT NULL DEFAULT 0,
  depth_cap_hits BIGINT NOT NULL DEFAULT 0,
  unequal_results BIGINT NOT NULL DEFAULT 0,
  ended BIGINT NOT NULL DEFAULT 0,
  failure TEXT,
  submitted_ms BIGINT NOT NULL,
  first_lease_ms BIGINT,
  last_result_ms BIGINT,
  finished_ms BIGINT,
  rev BIGINT NOT NULL DEFAULT 1
);
CREATE INDEX job_live ON job (priority, id) WHERE finished_ms IS NULL;

CREATE TABLE frame (
  job BIGINT NOT NULL,
  frame BIGINT NOT NULL,
  units_done BIGINT NOT NULL DEFAULT 0,
  film_hash TEXT,
  PRIMARY KEY (job, frame)
);
CREATE INDEX frame_open ON frame (job, frame) WHERE film_hash IS NULL;

-- state: 0 ready, 1 leased, 2 counted. Rows are made frame by frame.
CREATE TABLE unit (
  job BIGINT NOT NULL,
  frame BIGINT NOT NULL,
  tile BIGINT NOT NULL,
  block BIGINT NOT NULL,
  state BIGINT NOT NULL DEFAULT 0,
  lease BIGINT NOT NULL DEFAULT 0,
  PRIMARY KEY (job, frame, tile, block)
);
-- One for each state: SQLite does not see that state = 0 implies state < 2.
CREATE INDEX unit_ready ON unit (job, frame, tile, block) WHERE state = 0;
CREATE INDEX unit_leased ON unit (job, frame, tile, block, lease) WHERE state = 1;

CREATE TABLE lease (
  id BIGINT PRIMARY KEY,
  job BIGINT NOT NULL,
  worker TEXT NOT NULL,
  runs TEXT NOT NULL,
  created_ms BIGINT NOT NULL,
  until_ms BIGINT NOT NULL,
  closed BIGINT NOT NULL DEFAULT 0
);
CREATE INDEX lease_open ON lease (until_ms) WHERE closed = 0;
CREATE INDEX lease_job ON lease (job) WHERE closed = 0;

-- One row per counted run, for ever: a late result is compared with sums_hash.
-- object: its sums until they are folded, then NULL.
CREATE TABLE part (
  job BIGINT NOT NULL,
  frame BIGINT NOT NULL,
  tile BIGINT NOT NULL,
  block0 BIGINT NOT NULL,
  block1 BIGINT NOT NULL,
  sums_hash TEXT NOT NULL,
  worker TEXT NOT NULL,
  object TEXT,
  PRIMARY KEY (job, frame, tile, block0)
);
CREATE INDEX part_open ON part (job, frame, tile) WHERE object IS NOT NULL;
CREATE INDEX part_object ON part (object) WHERE object IS NOT NULL;

-- The merged film of a tile: blocks of it that object holds.
CREATE TABLE tilefold (
  job BIGINT NOT NULL,
  frame BIGINT NOT NULL,
  tile BIGINT NOT NULL,
  version BIGINT NOT NULL DEFAULT 0,
  blocks BIGINT NOT NULL DEFAULT 0,
  object TEXT,
  error TEXT,
  PRIMARY KEY (job, frame, tile)
);
CREATE INDEX tilefold_object ON tilefold (object) WHERE object IS NOT NULL;

CREATE TABLE failure (
  job BIGINT NOT NULL,
  frame BIGINT NOT NULL,
  tile BIGINT NOT NULL,
  block BIGINT NOT NULL,
  worker TEXT NOT NULL,
  times BIGINT NOT NULL,
  reason TEXT NOT NULL,
  PRIMARY KEY (job, frame, tile, block, worker)
);

-- failed_in_row counts different failing runs since the last counted result.
CREATE TABLE worker (
  instance TEXT PRIMARY KEY,
  name TEXT NOT NULL,
  threads BIGINT NOT NULL,
  milli_samples_per_s BIGINT NOT NULL,
  seen_ms BIGINT NOT NULL,
  failed_in_row BIGINT NOT NULL DEFAULT 0,
  failed_last TEXT NOT NULL DEFAULT '',
  quarantined_until_ms BIGINT NOT NULL DEFAULT 0
);
CREATE INDEX worker_seen ON worker (seen_ms);

CREATE TABLE asset (hash TEXT PRIMARY KEY, size BIGINT NOT NULL, created_ms BIGINT NOT NULL);

CREATE TABLE idem (
  key TEXT PRIMARY KEY,
  body_hash TEXT NOT NULL,
  job BIGINT NOT NULL,
  created_ms BIGINT NOT NULL
);
