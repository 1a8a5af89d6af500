-- Jobs that are deleted but not yet gone: their rows go in small steps, then their objects, then the row here.
CREATE TABLE deletion (job BIGINT PRIMARY KEY);
-- Which job needs which asset. assets_noted: whether the job's are here; jobs of before are noted by the first sweep.
CREATE TABLE job_asset (hash TEXT NOT NULL, job BIGINT NOT NULL, PRIMARY KEY (hash, job));
CREATE INDEX job_asset_job ON job_asset (job);
ALTER TABLE job ADD COLUMN assets_noted BIGINT NOT NULL DEFAULT 0;
-- used_ms: when somebody last uploaded it, asked for it or submitted a job with it. doomed: its object is about to go.
ALTER TABLE asset ADD COLUMN used_ms BIGINT NOT NULL DEFAULT 0;
UPDATE asset SET used_ms = created_ms;
ALTER TABLE asset ADD COLUMN doomed BIGINT NOT NULL DEFAULT 0;
CREATE INDEX asset_doomed ON asset (hash) WHERE doomed = 1;
-- Counted up to see whether the database can be written.
INSERT INTO counter (name, value) VALUES ('probe', 0);
