-- Access tokens. id: the public part, by which people and logs name a token; hash: blake3 of the whole token, which
-- is stored nowhere. A store that has ever had a token demands one: rows of revoked tokens stay.
CREATE TABLE token (
  id TEXT PRIMARY KEY,
  hash TEXT NOT NULL,
  role TEXT NOT NULL,
  name TEXT NOT NULL,
  created_ms BIGINT NOT NULL,
  expires_ms BIGINT,
  revoked_ms BIGINT
);
-- The token that submitted a job; NULL where none was demanded.
ALTER TABLE job ADD COLUMN owner TEXT;
