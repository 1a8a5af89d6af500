//! The kinds of problems: what `type` of an error can say. The table in
//! `docs/api.md`, the statuses of the OpenAPI document and the answers
//! themselves come from here.

/// What all types begin with.
pub(crate) const PREFIX: &str = "urn:shearwater:problem:";

macro_rules! kinds {
    ($($kind:ident $status:literal $name:literal $title:literal, $when:literal;)*) => {
        /// A kind of problem. Its name is a promise: clients compare it.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum Kind {
            $(#[doc = $when] $kind,)*
        }

        impl Kind {
            /// Every kind.
            pub(crate) const ALL: &'static [Self] = &[$(Self::$kind,)*];

            /// HTTP status.
            pub(crate) const fn status(self) -> u16 {
                match self { $(Self::$kind => $status,)* }
            }

            /// What follows [`PREFIX`] in `type`.
            pub(crate) const fn name(self) -> &'static str {
                match self { $(Self::$kind => $name,)* }
            }

            /// `title`.
            pub(crate) const fn title(self) -> &'static str {
                match self { $(Self::$kind => $title,)* }
            }

            /// When it comes, for the OpenAPI document.
            pub(crate) const fn when(self) -> &'static str {
                match self { $(Self::$kind => $when,)* }
            }
        }
    };
}

kinds! {
    BadRequest 400 "bad-request" "Bad request", "a body, query or header that cannot be read";
    Unauthorized 401 "unauthorized" "No valid token", "no token, or none that is valid here";
    Forbidden 403 "forbidden" "Forbidden", "the token's role may not, or the job is another's, or a worker lacks its certificate";
    Quarantined 403 "quarantined" "Worker quarantined", "a worker that failed on different runs in a row, or whose sums were found to be wrong";
    NotFound 404 "not-found" "Not found", "no such thing";
    NoRoute 404 "no-route" "No such path", "no such path";
    Method 405 "method" "Method not allowed", "see the Allow header";
    Timeout 408 "timeout" "Body too slow", "the body came too slowly";
    Build 409 "build" "Another numeric build", "a worker of another numeric build";
    Protocol 409 "protocol" "Another protocol", "a worker of another protocol";
    JobBuild 409 "job-build" "Another numeric build", "a job that another numeric build began";
    JobEndedEarly 409 "job-ended-early" "Job has ended", "more samples for a job that was cancelled or has failed";
    JobNotFailed 409 "job-not-failed" "Job has not failed", "a retry of a job that was cancelled or is done";
    UnequalResult 409 "unequal-result" "Unequal result", "this run was counted with other sums: an alarm";
    JobEnded 410 "job-ended" "Job has ended", "a result for a job that was cancelled or has failed";
    TooLarge 413 "too-large" "Body too large", "a body above the limit of its request";
    MediaType 415 "media-type" "Unsupported media type", "Content-Type is not the one expected";
    Encoding 415 "content-encoding" "Unsupported content encoding", "a packed body";
    Range 416 "range" "Range not satisfiable", "the range begins behind the end; Content-Range names the length";
    Invalid 422 "invalid" "Invalid content", "a readable body whose content is wrong";
    KeyReused 422 "idempotency-key-reused" "Idempotency key reused", "the key came with another body before";
    TooMany 429 "too-many-requests" "Too many requests", "of one token or address; Retry-After says when";
    QueueFull 429 "queue-full" "Queue is full", "too many jobs that have not ended";
    Internal 500 "internal" "Internal error", "the log of the coordinator says why";
    Busy 503 "busy" "Busy", "try again in a few seconds";
    StoreUnavailable 503 "store-unavailable" "Store unavailable", "the database or the object store fails at the moment";
    NotReady 503 "not-ready" "Not ready", "`/readyz` alone: what fails, and why";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_type_stands_in_the_documentation_with_its_status() {
        let text = include_str!("../../../docs/api.md");
        let rows: Vec<Vec<&str>> = text
            .lines()
            .filter(|line| line.starts_with("| `"))
            .map(|line| line.split('|').map(str::trim).collect())
            .collect();
        for kind in Kind::ALL {
            let name = format!("`{}`", kind.name());
            let row = rows
                .iter()
                .find(|row| row[1].split(", ").any(|n| n == name));
            let row = row.unwrap_or_else(|| panic!("docs/api.md lacks {name}"));
            assert_eq!(row[2], kind.status().to_string(), "{name}");
        }
    }

    #[test]
    fn names_are_different() {
        let mut names: Vec<&str> = Kind::ALL.iter().map(|kind| kind.name()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), Kind::ALL.len());
    }
}
