//! The re-execution audit: which runs are rendered again, who lied, and for how long
//! the end of a frame waits to know it.

use shearwater_shared::hash::ContentHash;
use shearwater_shared::job::JobId;
use shearwater_shared::plan::Run;

/// Shares are in millionths.
pub const WHOLE_PPM: u32 = 1_000_000;
/// Workers that are asked about one run: with this many different answers the run
/// itself must be at fault.
const CLAIMS_MAX: usize = 5;
/// Leases of an audit that may bring nothing before it is given up; not within
/// [`LEASED_WAIT_MS`]: workers may be killed, and a coordinator whose clock is wrong ends
/// leases too soon.
const TRIES_MAX: u64 = 3;
/// How long the end of a frame waits for an audit that nobody works on: longer than a
/// present worker takes to ask for work (its poll and its present lease).
const IDLE_WAIT_MS: i64 = 60_000;
/// How long it waits for one that a worker has under way, a run of the slowest worker, and
/// for a further answer where two differ and somebody could give it.
const LEASED_WAIT_MS: i64 = 10 * 60_000;

/// What a worker delivered for a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Claim {
    /// Worker (instance).
    pub worker: String,
    /// Hash of its sums.
    pub sums_hash: ContentHash,
}

/// What follows from the claims about a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AuditVerdict {
    /// Another worker is asked.
    Ask,
    /// All agree.
    Equal,
    /// Two agree; these workers delivered something else.
    Wrong(Vec<String>),
    /// As many as may be asked, and no two agree.
    Nobody,
}

/// An open audit, as the decision to wait sees it.
#[derive(Clone, Debug)]
pub struct WaitingAudit {
    /// Workers (instances) that have delivered the run.
    pub claimants: Vec<String>,
    /// Some worker has it under way.
    pub leased: bool,
    /// Leases that brought nothing.
    pub tries: u64,
    /// For how long its frame has waited for nothing else, as whoever decides saw it.
    pub held_ms: i64,
    /// For how long of that nothing has changed.
    pub waited_ms: i64,
}

/// Whether a counted run is rendered again by another worker: `share_ppm` millionths
/// of all runs, by a hash of what the run is and of a number that workers do not know.
#[must_use]
pub fn is_audited(salt: i64, job: JobId, run: &Run, share_ppm: u32) -> bool {
    let mut hasher = blake3::Hasher::new();
    hasher.update(b"shearwater audit 1");
    hasher.update(&salt.to_le_bytes());
    hasher.update(&job.0.to_le_bytes());
    for number in [run.frame, run.tile, run.block0] {
        hasher.update(&number.to_le_bytes());
    }
    let mut bits = [0; 8];
    hasher.finalize_xof().fill(&mut bits);
    let scaled = (u128::from(u64::from_le_bytes(bits)) * u128::from(WHOLE_PPM)) >> 64;
    scaled < u128::from(share_ppm)
}

/// Judge the claims about one run, one of each worker, the counted one first.
#[must_use]
pub fn judge(claims: &[Claim]) -> AuditVerdict {
    let agrees = |claim: &Claim| {
        let same = claims.iter().filter(|c| c.sums_hash == claim.sums_hash);
        same.count() >= 2
    };
    let Some(right) = claims.iter().find(|claim| agrees(claim)) else {
        return if claims.len() < CLAIMS_MAX {
            AuditVerdict::Ask
        } else {
            AuditVerdict::Nobody
        };
    };
    let wrong: Vec<String> = claims
        .iter()
        .filter(|claim| claim.sums_hash != right.sums_hash)
        .map(|claim| claim.worker.clone())
        .collect();
    if wrong.is_empty() {
        AuditVerdict::Equal
    } else {
        AuditVerdict::Wrong(wrong)
    }
}

/// Whether the end of a frame goes on waiting for an audit. `present` are the workers
/// (instances) that could be asked. Nobody is waited for without end, and a farm of one
/// worker waits for nobody.
#[must_use]
pub fn audit_waits(audit: &WaitingAudit, present: &[&str]) -> bool {
    let is_other = |worker: &&str| audit.claimants.iter().all(|claimant| claimant != *worker);
    let others = present.iter().any(is_other);
    let disputed = audit.claimants.len() > 1;
    let patience_ms = if audit.leased || (disputed && others) {
        LEASED_WAIT_MS
    } else {
        IDLE_WAIT_MS
    };
    if audit.waited_ms >= patience_ms {
        return false;
    }
    let is_tried = audit.tries >= TRIES_MAX && audit.held_ms >= LEASED_WAIT_MS;
    // A third one may yet come: two answers are worse than a minute.
    audit.leased || (!is_tried && (disputed || others))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn claims(words: &str) -> Vec<Claim> {
        (0..)
            .zip(words.chars())
            .map(|(at, letter)| Claim {
                worker: format!("w{at}"),
                sums_hash: ContentHash::of(letter.to_string().as_bytes()),
            })
            .collect()
    }

    fn wrong(workers: &[&str]) -> AuditVerdict {
        AuditVerdict::Wrong(workers.iter().map(|&w| w.to_owned()).collect())
    }

    #[test]
    fn two_that_agree_are_right() {
        let cases = [
            ("", AuditVerdict::Ask),
            ("a", AuditVerdict::Ask),
            ("aa", AuditVerdict::Equal),
            ("ab", AuditVerdict::Ask),
            ("aba", wrong(&["w1"])),
            ("abb", wrong(&["w0"])),
            ("abc", AuditVerdict::Ask),
            ("abcb", wrong(&["w0", "w2"])),
            ("abcd", AuditVerdict::Ask),
            ("abcde", AuditVerdict::Nobody),
            ("abcda", wrong(&["w1", "w2", "w3"])),
        ];
        for (words, verdict) in cases {
            assert_eq!(judge(&claims(words)), verdict, "{words}");
        }
    }

    #[test]
    fn a_share_of_runs_is_chosen_and_always_the_same() {
        let run = |n: u32| Run {
            frame: n % 7,
            tile: n / 7 % 100,
            block0: n / 700,
            block1: n / 700 + 1,
        };
        let chosen = |salt, ppm| -> Vec<u32> {
            (0..100_000)
                .filter(|&n| is_audited(salt, JobId(3), &run(n), ppm))
                .collect()
        };
        let some = chosen(1, 5000);
        // Binomial with a mean of 500: five standard deviations are 112.
        assert!((388..612).contains(&some.len()), "{}", some.len());
        assert_eq!(some, chosen(1, 5000));
        assert_ne!(some, chosen(2, 5000));
        assert_eq!(chosen(1, 0).len(), 0);
        assert_eq!(chosen(1, WHOLE_PPM).len(), 100_000);
    }

    const OPEN: WaitingAudit = WaitingAudit {
        claimants: Vec::new(),
        leased: false,
        tries: 0,
        held_ms: 0,
        waited_ms: 0,
    };

    #[test]
    fn a_farm_of_one_waits_for_nobody() {
        let audit = WaitingAudit {
            claimants: vec!["only".into()],
            ..OPEN
        };
        assert!(!audit_waits(&audit, &["only"]));
        assert!(!audit_waits(&audit, &[]));
        assert!(audit_waits(&audit, &["only", "other"]));
        let long = WaitingAudit {
            waited_ms: 60_000,
            ..audit
        };
        assert!(!audit_waits(&long, &["only", "other"]));
    }

    #[test]
    fn a_dispute_waits_a_minute_for_a_third() {
        let audit = WaitingAudit {
            claimants: vec!["a".into(), "b".into()],
            waited_ms: 59_000,
            ..OPEN
        };
        assert!(audit_waits(&audit, &["a", "b"]));
        let long = WaitingAudit {
            waited_ms: 61_000,
            ..audit.clone()
        };
        assert!(!audit_waits(&long, &["a", "b"]));
        assert!(audit_waits(&long, &["a", "b", "c"]), "it could be asked");
        let failing = WaitingAudit {
            tries: TRIES_MAX,
            held_ms: 599_000,
            ..audit
        };
        assert!(audit_waits(&failing, &["c"]));
        let long = WaitingAudit {
            held_ms: 600_000,
            ..failing
        };
        assert!(!audit_waits(&long, &["c"]));
    }

    proptest! {
        // Whatever is present and under way: there is a moment after which nobody waits.
        #[test]
        fn no_wait_is_without_end(
            leased: bool,
            tries in 0u64..10,
            waited_ms in 600_000i64..i64::MAX,
            others in 0usize..4,
        ) {
            let audit = WaitingAudit { leased, tries, waited_ms, ..OPEN };
            let present = ["a", "b", "c"];
            prop_assert!(!audit_waits(&audit, &present[..others.min(3)]));
        }
    }
}
