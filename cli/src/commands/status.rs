//! `shearwater status`.

use crate::args::Target;
use crate::exit::CliError;
use crate::{error_text, output};
use clap::Args;
use shearwater_shared::job::JobId;
use std::str::FromStr;

/// Show where a job stands
///
/// Ends with 0 whatever the job's state; `watch` ends with 1 when it failed.
#[derive(Args, Debug)]
pub(crate) struct Status {
    /// Number of the job
    id: i64,
    /// Show error against time too: of this frame of the scene [default: the job's first]
    #[arg(long, value_name = "FRAME", num_args = 0..=1, default_missing_value = "first")]
    errors: Option<WhichFrame>,
    #[command(flatten)]
    target: Target,
}

/// A frame by its number, or the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum WhichFrame {
    First,
    Number(u32),
}

impl FromStr for WhichFrame {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "first" => Ok(Self::First),
            number => number
                .parse()
                .map(Self::Number)
                .map_err(|_| "expected the number of a frame".to_owned()),
        }
    }
}

pub(crate) async fn run(args: &Status, json: bool) -> Result<(), CliError> {
    let api = args.target.api()?;
    let job = api.job(JobId(args.id)).await?;
    let frame = args.errors.map(|which| match which {
        WhichFrame::First => job.settings.first_frame,
        WhichFrame::Number(frame) => frame,
    });
    let points = match frame {
        Some(frame) => Some(api.errors(job.id, frame).await?),
        None => None,
    };
    if json {
        let mut value = output::job_value(&job);
        if let Some(points) = &points {
            value["errors"] = serde_json::json!(points);
        }
        output::object(&value);
    } else {
        output::line(output::job_text(&job));
        if let Some(points) = &points {
            output::line(error_text::points(points));
        }
    }
    Ok(())
}
