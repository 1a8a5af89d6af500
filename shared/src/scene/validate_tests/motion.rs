//! What moves, and when.

use crate::scene::test_scene::{fails, full, with};
use serde_json::json;

#[test]
fn motion_out_of_range_is_named() {
    for (pointer, value, path, message) in [
        (
            "/animation/fps",
            json!(0),
            "animation.fps",
            "0: expected 0.1 to 1000 frames per second",
        ),
        (
            "/animation/frames",
            json!(0),
            "animation.frames",
            "0: expected 1 to 1000000",
        ),
        (
            "/animation/start_s",
            json!(1e7),
            "animation.start_s",
            "-1000000 to 1000000 s",
        ),
        (
            "/animation/fps",
            json!(24),
            "camera.shutter_s",
            "0.5: expected at most 0.041666666666666664 s, the time of one frame at 24 frames per second",
        ),
        (
            "/camera/velocity_mps/2",
            json!(1e6),
            "camera.velocity_mps[2]",
            "-100000 to 100000 m/s",
        ),
        (
            "/camera/path/0/offset_m/1",
            json!(1e10),
            "camera.path[0].offset_m[1]",
            "m",
        ),
        (
            "/camera/path/1/target_offset_m",
            json!([0, 1, 10]),
            "camera.path[1]",
            "the target is where the eye is",
        ),
        (
            "/camera/path/1/target_offset_m",
            json!([0, 9, 10]),
            "camera.path[1]",
            "the view is along `up`",
        ),
        (
            "/camera/path/1/time_s",
            json!(0),
            "camera.path[1].time_s",
            "0: expected a time after 0 s",
        ),
        (
            "/instances/0/velocity_mps/0",
            json!(-2e5),
            "instances[0].velocity_mps[0]",
            "m/s",
        ),
        (
            "/instances/0/name",
            json!(""),
            "instances[0].name",
            "1 to 200 bytes",
        ),
        (
            "/instances/1/name",
            json!("first"),
            "instances[1].name",
            "`first` is also the name of instances[0]",
        ),
        (
            "/instances/1/parent",
            json!("nobody"),
            "instances[1].parent",
            "`nobody`: no instance of that name; known: `first`, `second`",
        ),
        (
            "/instances/1/parent",
            json!("second"),
            "instances[1].parent",
            "expected no instance that is placed within this one",
        ),
        (
            "/instances/0/parent",
            json!("second"),
            "instances[0].parent",
            "expected no instance that is placed within this one",
        ),
        (
            "/instances/1/spin/axis",
            json!([0, 0, 0]),
            "instances[1].spin.axis",
            "a vector that is not zero",
        ),
        (
            "/instances/1/spin/rpm",
            json!(1e7),
            "instances[1].spin.rpm",
            "10000000: expected -1000000 to 1000000 turns per minute",
        ),
        (
            "/instances/1/spin/pivot_m/0",
            json!(1e10),
            "instances[1].spin.pivot_m[0]",
            "m",
        ),
        (
            "/instances/1/path/1/time_s",
            json!(-1),
            "instances[1].path[1].time_s",
            "-1: expected a time after 0 s",
        ),
        (
            "/instances/1/path/1/turn_deg/1",
            json!(1e7),
            "instances[1].path[1].turn_deg[1]",
            "degrees",
        ),
        (
            "/instances/1/path/0/time_s",
            json!(-1e7),
            "instances[1].path[0].time_s",
            "-1000000 to 1000000 s",
        ),
    ] {
        fails(&with(pointer, value), path, message);
    }
}

#[test]
fn long_chains_and_circles_of_parents_are_refused() {
    let chain = |count: usize| {
        let mut scene = full();
        let link = |i: usize| {
            json!({"mesh": "plane", "name": i.to_string(),
                "parent": if i == 0 { None } else { Some((i - 1).to_string()) }})
        };
        scene["instances"] = (0..count).map(link).collect();
        scene
    };
    let most = crate::limits::INSTANCE_DEPTH_MAX;
    assert!(crate::scene::parse(chain(most).to_string().as_bytes()).is_ok());
    let path = format!("instances[{most}].parent");
    fails(&chain(most + 1).to_string(), &path, "expected at most 8");
    // A circle that the first instance only leads into.
    let mut circle = chain(3);
    circle["instances"][0]["parent"] = json!("1");
    circle["instances"][1]["parent"] = json!("2");
    circle["instances"][2]["parent"] = json!("1");
    fails(&circle.to_string(), "instances[0].parent", "or a circle");
}

#[test]
fn frames_follow_each_other_from_the_start() {
    let mut scene = crate::scene::parse(full().to_string().as_bytes()).unwrap();
    assert_eq!([0, 1, 4].map(|f| scene.frame_time_s(f)), [1.0, 1.5, 3.0]);
    scene.animation = None;
    assert_eq!(scene.frame_time_s(7), 0.0);
}
