//! What coordinator and worker both speak: scenes, jobs, plans, exact film, wire codec.
