//! Settings and sizes outside their limits, refused by name.

use shearwater_coordinator::develop::{
    Bloom, DevelopError, ExrAttributes, PICTURE_SIDE_MAX, Picture, PostSettings, develop,
    encode_exr,
};

use crate::pictures::full_picture;

#[test]
fn settings_out_of_range_are_named() {
    let bloom = Bloom::default();
    let with = |bloom: Bloom| PostSettings {
        bloom: Some(bloom),
        ..PostSettings::default()
    };
    let exposed = |exposure_ev: f32| PostSettings {
        exposure_ev,
        ..PostSettings::default()
    };
    let cases = [
        ("exposure_ev", exposed(f32::NAN)),
        ("exposure_ev", exposed(33.0)),
        ("exposure_ev", exposed(f32::NEG_INFINITY)),
        (
            "bloom.threshold",
            with(Bloom {
                threshold: f32::NAN,
                ..bloom
            }),
        ),
        (
            "bloom.threshold",
            with(Bloom {
                threshold: -0.5,
                ..bloom
            }),
        ),
        (
            "bloom.strength",
            with(Bloom {
                strength: -0.1,
                ..bloom
            }),
        ),
        (
            "bloom.strength",
            with(Bloom {
                strength: f32::INFINITY,
                ..bloom
            }),
        ),
        (
            "bloom.radius",
            with(Bloom {
                radius: 1.1,
                ..bloom
            }),
        ),
        (
            "bloom.radius",
            with(Bloom {
                radius: f32::NAN,
                ..bloom
            }),
        ),
        ("bloom.passes", with(Bloom { passes: 0, ..bloom })),
        ("bloom.passes", with(Bloom { passes: 4, ..bloom })),
    ];
    let picture = full_picture(8, 8);
    for (expected, post) in cases {
        match develop(&picture, &post) {
            Err(DevelopError::Setting { name, .. }) => assert_eq!(name, expected),
            other => panic!("{expected}: {other:?}"),
        }
    }
    assert!(develop(&picture, &PostSettings::default()).is_ok());
    let off = with(Bloom {
        threshold: f32::INFINITY,
        ..bloom
    });
    assert!(develop(&picture, &off).is_ok());
}

#[test]
fn sizes_and_planes_are_checked() {
    let refused = |picture: &Picture| {
        let by_develop = develop(picture, &PostSettings::default())
            .unwrap_err()
            .to_string();
        let by_exr = encode_exr(picture, &ExrAttributes::default())
            .unwrap_err()
            .to_string();
        assert_eq!(by_develop, by_exr);
        by_develop
    };
    let mut picture = full_picture(8, 8);
    picture.normal.as_mut().unwrap().pop();
    assert_eq!(
        refused(&picture),
        "plane `normal` holds 63 values, expected 64 (width x height)"
    );
    for (width, height) in [
        (0, 8),
        (8, 0),
        (PICTURE_SIDE_MAX + 1, 1),
        (16_384, 16_384),
        (u32::MAX, u32::MAX),
    ] {
        let picture = Picture {
            width,
            height,
            ..full_picture(8, 8)
        };
        assert!(refused(&picture).starts_with(&format!("picture of {width} x {height} pixels")));
    }
}
