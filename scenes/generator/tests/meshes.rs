//! What the models promise: sizes, closed skins, outward winding, texture
//! coordinates inside the texture.

use shearwater_scenes::mesh::{Face, Mesh, NO_UV};
use shearwater_scenes::vec3::vec3;
use shearwater_scenes::{bridge, land, plane};
use std::collections::BTreeMap;

/// How often each directed edge of a part occurs.
fn edges(mesh: &Mesh, name: &str) -> BTreeMap<(u32, u32), u32> {
    let mut count = BTreeMap::new();
    for face in mesh
        .parts
        .iter()
        .filter(|p| p.name == name)
        .flat_map(|p| &p.faces)
    {
        let corners = face.corners();
        for (i, corner) in corners.iter().enumerate() {
            let next = corners[(i + 1) % corners.len()];
            *count.entry((corner.position, next.position)).or_insert(0) += 1;
        }
    }
    count
}

/// Every edge belongs to two faces that run along it in opposite senses, and
/// the enclosed volume is positive: closed, consistent, outward.
fn assert_closed_and_outward(mesh: &Mesh, name: &str) {
    let edges = edges(mesh, name);
    assert!(!edges.is_empty(), "no part {name}");
    for (&(a, b), &count) in &edges {
        assert_eq!(count, 1, "{name}: edge {a}-{b} is used twice in one sense");
        assert!(
            edges.contains_key(&(b, a)),
            "{name}: edge {a}-{b} has one face only"
        );
    }
    assert!(
        mesh.signed_volume(name) > 0.0,
        "{name} is wound inwards: {}",
        mesh.signed_volume(name)
    );
}

#[test]
fn triangle_counts_are_in_range() {
    let plane = plane::mesh().triangles();
    assert!((20_000..=80_000).contains(&plane), "plane: {plane}");
    let bridge = bridge::mesh().triangles();
    assert!((100_000..=300_000).contains(&bridge), "bridge: {bridge}");
    println!(
        "plane {plane}, propeller {}, bridge {bridge}, headland {}",
        plane::propeller_mesh().triangles(),
        land::mesh().triangles()
    );
}

#[test]
fn skins_are_closed_and_outward() {
    let plane = plane::mesh();
    for part in [
        "fuselage",
        "wing",
        "tailplane",
        "fin",
        "nacelle-left",
        "nacelle-right",
        "exhausts-left",
        "wheel-right",
        "cylinders-left",
        "lamp-left",
        "tail-wheel",
    ] {
        assert_closed_and_outward(&plane, part);
    }
    let propeller = plane::propeller_mesh();
    for part in ["spinner", "blades", "blade-tips"] {
        assert_closed_and_outward(&propeller, part);
    }
    let bridge = bridge::mesh();
    for part in [
        "pier-west",
        "tower-east",
        "trusses",
        "floor",
        "slab",
        "railings",
        "pylons-west",
        "bents-east",
    ] {
        assert_closed_and_outward(&bridge, part);
    }
    // The cables' hand ropes and the suspenders end inside other members.
    assert!(bridge.signed_volume("cable-left") > 0.0);
    assert!(bridge.signed_volume("suspenders-right") > 0.0);
}

#[test]
fn positions_are_finite_and_uvs_inside() {
    for mesh in [
        plane::mesh(),
        plane::propeller_mesh(),
        bridge::mesh(),
        land::mesh(),
    ] {
        for p in &mesh.positions {
            assert!(
                p.x.is_finite() && p.y.is_finite() && p.z.is_finite(),
                "{p:?}"
            );
        }
        for uv in &mesh.uvs {
            assert!(uv.iter().all(|v| (0.0..=1.0).contains(v)), "{uv:?}");
        }
    }
}

#[test]
fn the_livery_is_mapped_wherever_it_is_used() {
    let mesh = plane::mesh();
    for part in mesh.parts.iter().filter(|p| p.material == "livery") {
        for corner in part.faces.iter().flat_map(Face::corners) {
            assert_ne!(corner.uv, NO_UV, "{} has corners without UV", part.name);
        }
    }
}

#[test]
fn the_plane_has_the_size_it_claims() {
    let mesh = plane::mesh();
    let extent = |pick: fn(shearwater_scenes::vec3::Vec3) -> f64| {
        let values: Vec<f64> = mesh.positions.iter().map(|&p| pick(p)).collect();
        values.iter().copied().fold(f64::MIN, f64::max)
            - values.iter().copied().fold(f64::MAX, f64::min)
    };
    assert!((extent(|p| p.x) - 2.0 * plane::shape::SEMI_SPAN).abs() < 0.02);
    assert!((extent(|p| p.z) - plane::shape::LENGTH).abs() < 0.1);
    // Mirror symmetry of fuselage and wing.
    for name in ["fuselage", "wing"] {
        let part = mesh.parts.iter().find(|p| p.name == name).unwrap();
        let sum: f64 = part
            .faces
            .iter()
            .flat_map(Face::corners)
            .map(|c| mesh.positions[c.position as usize].x)
            .sum();
        assert!(sum.abs() < 1e-6, "{name} leans to one side: {sum}");
    }
}

/// Written positions are rounded; no triangle may lose its area by that.
#[test]
fn rounding_leaves_no_face_without_area() {
    for (name, mesh, decimals) in [
        ("plane", plane::mesh(), 1e4),
        ("propeller", plane::propeller_mesh(), 1e4),
        ("bridge", bridge::mesh(), 1e3),
        ("headland", land::mesh(), 1e1),
    ] {
        let round = |v: f64| (v * decimals).round() / decimals;
        for face in mesh.parts.iter().flat_map(|p| &p.faces) {
            let points: Vec<_> = face
                .corners()
                .iter()
                .map(|c| mesh.positions[c.position as usize])
                .map(|p| vec3(round(p.x), round(p.y), round(p.z)))
                .collect();
            for i in 1..points.len() - 1 {
                let area = (points[i] - points[0]).cross(points[i + 1] - points[0]);
                assert!(area.length() > 0.0, "{name}: {points:?}");
            }
        }
    }
}
