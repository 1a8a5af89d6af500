//! Placement of instances.

use glam::{Affine3A, DMat3, Mat3};

/// Ry * Rx * Rz of angles about x, y and z in degrees.
pub(super) fn rotation(rotate_deg: [f64; 3]) -> DMat3 {
    let [rx, ry, rz] = rotate_deg.map(f64::to_radians);
    axis_rotation(ry, 1) * axis_rotation(rx, 0) * axis_rotation(rz, 2)
}

/// The map of normals: inverse transpose, up to a positive factor.
pub(super) fn normal_from_local(world_from_local: &Affine3A) -> Mat3 {
    Mat3::from(world_from_local.inverse().matrix3).transpose()
}

// Right-handed rotation about axis 0, 1 or 2; multiples of 90 degrees are exact.
fn axis_rotation(angle_rad: f64, axis: usize) -> DMat3 {
    let quarter = angle_rad / std::f64::consts::FRAC_PI_2;
    let (sin, cos) = match libm::round(quarter) {
        whole if whole == quarter => match whole.rem_euclid(4.0) as i32 {
            0 => (0.0, 1.0),
            1 => (1.0, 0.0),
            2 => (0.0, -1.0),
            _ => (-1.0, 0.0),
        },
        _ => (libm::sin(angle_rad), libm::cos(angle_rad)),
    };
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut columns = DMat3::IDENTITY.to_cols_array_2d();
    columns[u][u] = cos;
    columns[u][v] = sin;
    columns[v][u] = -sin;
    columns[v][v] = cos;
    DMat3::from_cols_array_2d(&columns)
}

#[cfg(test)]
mod tests {
    use super::super::motion::{Exposure, push_joints};
    use super::*;
    use crate::geometry;
    use glam::{DVec3, Vec3};
    use shearwater_shared::scene::Instance;

    fn place(rotate_deg: [f64; 3], scale: [f64; 3]) -> Affine3A {
        let instance = Instance {
            mesh: "m".into(),
            translate_m: [1.0, 2.0, 3.0],
            rotate_deg,
            scale,
            material: None,
            name: None,
            parent: None,
            velocity_mps: [0.0; 3],
            spin: None,
            path: Vec::new(),
        };
        let exposure = Exposure {
            open_s: 0.0,
            shutter_s: 0.5,
        };
        let mut joints = Vec::new();
        push_joints(&mut joints, &instance, DVec3::new(1.0, 2.0, 3.0), exposure);
        let placed = geometry::Instance::moving(0, joints, 0.5).unwrap();
        assert!(!placed.is_moving());
        *placed.world_from_local()
    }

    #[test]
    fn yaw_pitch_and_roll_turn_the_right_way() {
        let near = |a: Vec3, b: Vec3| (a - b).length() < 1e-6;
        let one = [1.0; 3];
        // About +y by 90 degrees: +z goes to +x.
        assert!(near(
            place([0.0, 90.0, 0.0], one).transform_point3(Vec3::Z),
            Vec3::X
        ));
        assert!(near(
            place([90.0, 0.0, 0.0], one).transform_point3(Vec3::Y),
            Vec3::Z
        ));
        assert!(near(
            place([0.0, 0.0, 90.0], one).transform_point3(Vec3::X),
            Vec3::Y
        ));
        // Roll first, yaw last: x rolls up to y, which yaw leaves alone.
        assert!(near(
            place([0.0, 37.0, 90.0], one).transform_point3(Vec3::X),
            Vec3::Y
        ));
    }

    #[test]
    fn normals_stay_normal_under_uneven_scale_and_mirrors() {
        let affine = place([10.0, 20.0, 30.0], [2.0, 0.5, -1.0]);
        let (tangent, normal) = (Vec3::new(1.0, -1.0, 0.0), Vec3::new(1.0, 1.0, 0.0));
        let moved = normal_from_local(&affine) * normal;
        assert!(moved.dot(affine.transform_vector3(tangent)).abs() < 1e-5);
    }
}
