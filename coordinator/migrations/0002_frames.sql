-- error: of a finished frame, as JSON; nmse_pico orders by it (10^-12).
ALTER TABLE frame ADD COLUMN error TEXT;
ALTER TABLE frame ADD COLUMN nmse_pico BIGINT;
CREATE INDEX frame_worst ON frame (job, nmse_pico) WHERE nmse_pico IS NOT NULL;
-- Frames per second of the scene's animation, as JSON; NULL without one.
ALTER TABLE job ADD COLUMN fps TEXT;
