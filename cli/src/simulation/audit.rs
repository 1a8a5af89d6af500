//! After a simulation: is every unit counted once, and is the film the right one?

use crate::api::Api;
use crate::exit::CliError;
use serde::Serialize;
use shearwater_shared::api::JobView;
use shearwater_shared::plan::Plan;
use shearwater_worker::simulate::{Counts, film_hash};

/// Most samples that are summed again to know the right films: a few seconds of a
/// core. Frames beyond are not looked at.
const BLOCK_PIXELS_MAX: u64 = 1 << 30;

/// What the coordinator says of the job, against what the workers know.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Audit {
    /// The job is done.
    pub(crate) done: bool,
    /// Units of the job.
    pub(crate) units_total: u64,
    /// Units counted, as the coordinator says.
    pub(crate) units_done: u64,
    /// Units of which a worker heard that they were counted; the rest was counted for
    /// workers that vanished meanwhile.
    pub(crate) units_acknowledged: u64,
    /// Units that were acknowledged as counted more than once.
    pub(crate) units_counted_twice: u64,
    /// Results with other bits than those counted before.
    pub(crate) unequal_results: u64,
    /// Frames whose film hash was compared with the right one.
    pub(crate) films_checked: u64,
    /// Of these, wrong ones.
    pub(crate) films_wrong: u64,
    /// What is wrong; empty when all is well.
    pub(crate) faults: Vec<String>,
}

/// Look at a job. `ended` says that it must be done, and its films complete.
pub(crate) async fn audit(
    api: &Api,
    job: &JobView,
    counts: &Counts,
    ended: bool,
) -> Result<Audit, CliError> {
    let (films_checked, films_wrong) = if ended {
        films(api, job).await?
    } else {
        (0, 0)
    };
    let mut audit = Audit {
        done: job.done,
        units_total: job.units_total,
        units_done: job.units_done,
        units_acknowledged: counts.units_counted,
        units_counted_twice: counts.units_counted_twice,
        unequal_results: job.unequal_results,
        films_checked,
        films_wrong,
        faults: Vec::new(),
    };
    let looks = [
        (
            ended && job.units_done != job.units_total,
            "units are missing",
        ),
        (
            counts.units_counted > job.units_done,
            "acknowledged units are not counted",
        ),
        (counts.units_counted_twice > 0, "units were counted twice"),
        (job.unequal_results > 0, "results were unequal"),
        (films_wrong > 0, "films are wrong"),
        (counts.foreign > 0, "work of other jobs was handed out"),
    ];
    let faults = looks.iter().filter(|(wrong, _)| *wrong);
    audit.faults = faults.map(|(_, fault)| (*fault).to_owned()).collect();
    if ended {
        audit
            .faults
            .extend(CliError::of_job(job).err().map(|e| e.to_string()));
    }
    Ok(audit)
}

/// How many films were compared, and how many of them are wrong.
async fn films(api: &Api, job: &JobView) -> Result<(u64, u64), CliError> {
    let plan = Plan::new(&job.settings);
    let cost = u64::from(plan.width()) * u64::from(plan.height()) * u64::from(plan.blocks());
    let most = (BLOCK_PIXELS_MAX / cost.max(1)).max(1);
    let (mut checked, mut wrong) = (0, 0);
    let mut token: Option<String> = None;
    loop {
        let page = api.frames(job.id, token.as_deref()).await?;
        for frame in &page.frames {
            if checked == most {
                return Ok((checked, wrong));
            }
            let number = job.settings.job_frame(frame.frame).unwrap_or(u32::MAX);
            let right = film_hash(&plan, number).ok();
            checked += 1;
            wrong += u64::from(right.is_none() || frame.film_hash != right);
        }
        token = page.next_page_token;
        if token.is_none() {
            return Ok((checked, wrong));
        }
    }
}
