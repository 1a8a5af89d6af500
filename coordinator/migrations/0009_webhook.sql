-- Whom the end of a job is told. ended_ms: finished_ms of the job when it ended the way that is being told, 0 before
-- the first try; state: 0 not taken yet, 1 taken; next_ms: nobody tries before.
CREATE TABLE webhook (
  job BIGINT PRIMARY KEY,
  url TEXT NOT NULL,
  secret TEXT,
  ended_ms BIGINT NOT NULL DEFAULT 0,
  state BIGINT NOT NULL DEFAULT 0,
  attempts BIGINT NOT NULL DEFAULT 0,
  next_ms BIGINT NOT NULL DEFAULT 0,
  last_status BIGINT,
  last_error TEXT,
  delivered_ms BIGINT
);
-- Jobs that ended lately.
CREATE INDEX job_finished ON job (finished_ms) WHERE finished_ms IS NOT NULL;
