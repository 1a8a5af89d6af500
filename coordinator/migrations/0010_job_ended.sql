-- Ended jobs by how they ended: counted for /metrics without reading their rows.
CREATE INDEX job_ended ON job (ended) WHERE finished_ms IS NOT NULL;
