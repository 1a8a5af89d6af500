//! Error against time, as clients see it.

use crate::farm::{json, problem, start};
use shearwater_shared::api::{ErrorPage, JobView};
use shearwater_shared::routes;

#[tokio::test]
async fn a_client_can_draw_error_against_time() {
    let farm = start().await;
    let job = farm.submit().await;
    let path = routes::fill(routes::JOB_ERRORS, &job.id.to_string());
    let page =
        async |query: &str| -> ErrorPage { json(farm.get(&format!("{path}{query}")).await).await };
    assert_eq!(page("").await.points, [], "nothing came yet");
    assert_eq!((job.error, job.nmse_at_end), (None, None));
    farm.work(&job, "w").await;
    let done: JobView = farm.wait(job.id, |job| job.done).await;
    let points = page("").await.points;
    let last = points.last().expect("the final film");
    assert_eq!(last.samples_done, done.samples_done);
    assert_eq!(
        (Some(last.error), Some(last.clone())),
        (done.error, done.newest_error)
    );
    assert!((last.core_s - done.core_s).abs() < 1e-9, "{last:?}");
    assert!(
        points
            .windows(2)
            .all(|two| two[0].samples_done < two[1].samples_done)
    );
    let detail = last.error.detail.expect("told");
    assert_eq!(
        detail.pixels * u64::from(done.settings.samples),
        detail.samples
    );
    assert!(detail.mean > 0.0 && detail.relmse > 0.0, "{detail:?}");
    let share = detail.firefly_share.expect("a gauge");
    assert!(
        (1e-4..1e-2).contains(&share),
        "made-up light is even: {share}"
    );
    // By pages of one.
    let mut paged = Vec::new();
    let mut query = "?page_size=1".to_owned();
    loop {
        let one = page(&query).await;
        assert_eq!(one.points.len(), 1);
        paged.extend(one.points);
        let Some(token) = one.next_page_token else {
            break;
        };
        query = format!("?page_size=1&page_token={token}");
    }
    assert_eq!(paged, points);
    problem(farm.get(&format!("{path}?frame=9")).await, 404, "not-found").await;
    problem(
        farm.get(&format!("{path}?page_token=x")).await,
        400,
        "bad-request",
    )
    .await;
    problem(
        farm.get(&format!("{path}?frames=0")).await,
        400,
        "bad-request",
    )
    .await;
}
