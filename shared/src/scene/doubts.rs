//! What in a valid scene is probably not what its author meant: mostly reasons for
//! a black picture, which should never come without a word.

use super::range::length_squared;
use super::{SceneDescription, Sky};

impl SceneDescription {
    /// Texts for people, each with the place in scene.json; none for most scenes.
    #[must_use]
    pub fn doubts(&self) -> Vec<String> {
        let mut doubts = Vec::new();
        let sun = self
            .sun
            .as_ref()
            .is_some_and(|sun| sun.radiance.is_some_and(|radiance| radiance != [0.0; 3]));
        if !sun && !self.sky.as_ref().is_some_and(shines) {
            doubts.push("sky, sun: nothing gives light, so the picture will be black".to_owned());
        }
        let eye = self.camera.position_m;
        if let Some(water) = &self.water
            && eye[1] < water.look().height_m
        {
            doubts.push(format!(
                "camera.position_m: at height {} the camera is under the water (height_m {}), \
                 which lets no light through",
                eye[1],
                water.look().height_m
            ));
        }
        if let Some(Sky::Dome(dome)) = &self.sky {
            let way: [f64; 3] = std::array::from_fn(|axis| eye[axis] - dome.centre_m[axis]);
            if length_squared(way) > dome.radius_m * dome.radius_m {
                doubts.push(
                    "camera.position_m: the camera is outside the dome, which shines inwards only"
                        .to_owned(),
                );
            }
        }
        doubts
    }
}

fn shines(sky: &Sky) -> bool {
    match sky {
        Sky::Constant(sky) => sky.radiance != [0.0; 3],
        Sky::Map(map) => map.intensity > 0.0,
        Sky::Dome(dome) => dome.intensity > 0.0,
        Sky::Atmosphere(sky) => sky.intensity > 0.0,
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::parse;
    use crate::scene::test_scene::{full, with};
    use serde_json::json;

    #[test]
    fn a_scene_that_stays_black_is_doubted() {
        let doubts = |text: &str| parse(text.as_bytes()).expect("valid").doubts();
        assert_eq!(doubts(&full().to_string()), Vec::<String>::new());
        let mut dark = full();
        dark["sky"]["intensity"] = json!(0);
        dark["sun"]["radiance"] = json!([0, 0, 0]);
        assert!(doubts(&dark.to_string())[0].contains("nothing gives light"));
        let sunk = with("/camera/position_m", json!([0, -1, 10]));
        assert!(doubts(&sunk)[0].contains("under the water"));
    }
}
