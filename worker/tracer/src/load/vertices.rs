//! Vertices shared by the corners that agree in everything.

use glam::{Vec2, Vec3};
use std::collections::HashMap;

/// Longest list of different vertices at one point that is searched for an
/// equal one; beyond it a corner gets a vertex of its own.
const SHARED_MAX: usize = 64;
const NONE: u32 = u32::MAX;

/// Points told apart by their coordinates, not by their numbers in a file.
#[derive(Default)]
pub(super) struct Points {
    /// Coordinates in the order of first use.
    pub(super) positions: Vec<Vec3>,
    index: HashMap<[u32; 3], u32>,
}

impl Points {
    /// The number of a point; equal coordinates have equal numbers.
    pub(super) fn intern(&mut self, position: Vec3) -> u32 {
        // 0 + -0 is 0: one number for both zeros.
        let position = position + Vec3::ZERO;
        let next = self.positions.len() as u32;
        let key = position.to_array().map(f32::to_bits);
        let number = *self.index.entry(key).or_insert(next);
        if number == next {
            self.positions.push(position);
        }
        number
    }
}

/// The arrays of a mesh while its corners come in.
#[derive(Default)]
pub(super) struct Vertices {
    pub(super) positions: Vec<Vec3>,
    pub(super) normals: Vec<Vec3>,
    /// One for each vertex, or none at all.
    pub(super) uvs: Vec<Vec2>,
    /// First vertex of each point and next vertex of the same point.
    first: Vec<u32>,
    next: Vec<u32>,
    has_uv: bool,
}

impl Vertices {
    pub(super) fn new(points: usize, has_uv: bool) -> Self {
        Self {
            positions: Vec::with_capacity(points),
            normals: Vec::with_capacity(points),
            first: vec![NONE; points],
            has_uv,
            ..Self::default()
        }
    }

    /// The vertex of a corner at `point`: an equal one if there is one.
    pub(super) fn add(&mut self, point: u32, position: Vec3, normal: Vec3, uv: Vec2) -> u32 {
        let mut vertex = self.first[point as usize];
        for _ in 0..SHARED_MAX {
            if vertex == NONE {
                break;
            }
            let i = vertex as usize;
            if self.normals[i] == normal && (!self.has_uv || self.uvs[i] == uv) {
                return vertex;
            }
            vertex = self.next[i];
        }
        let new = self.positions.len() as u32;
        self.positions.push(position);
        self.normals.push(normal);
        if self.has_uv {
            self.uvs.push(uv);
        }
        self.next.push(self.first[point as usize]);
        self.first[point as usize] = new;
        new
    }
}
