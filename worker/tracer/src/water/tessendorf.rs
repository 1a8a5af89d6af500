//! The sea of a wave spectrum: slope maps at the times of one frame.

use super::slopes::{SlopeMap, Slopes};
use super::spectrum::{Field, Spectrum};
use super::whitecaps::foam;
use glam::Vec2;
use shearwater_shared::scene::{TessendorfWater, Whitecaps};

/// What all frames share.
#[derive(Clone, Debug)]
pub(super) struct TessendorfStage {
    spectrum: Spectrum,
    tile_m: f64,
    time_s: f64,
    shutter_fields: u32,
    whitecaps: Option<Whitecaps>,
}

/// The waves of one frame.
#[derive(Clone, Debug)]
pub(super) struct TessendorfSea {
    /// The field at even times from the opening of the shutter to its end; one of
    /// them, at the opening, stands for the whole time.
    fields: Vec<SlopeMap>,
    /// Steps between fields in a second.
    fields_per_s: f32,
    /// Tile coordinates of the render origin, in [0, 1).
    origin: Vec2,
    per_metre: f32,
}

impl TessendorfStage {
    pub(super) fn new(sea: &TessendorfWater) -> Self {
        Self {
            spectrum: Spectrum::new(sea),
            tile_m: sea.tile_m,
            time_s: sea.time_s,
            shutter_fields: sea.shutter_fields,
            whitecaps: sea.whitecaps,
        }
    }

    /// `origin_m` is the point of the undrifted field that lies at the render
    /// origin when the shutter opens.
    pub(super) fn at(&self, time_s: f64, shutter_s: f64, origin_m: [f64; 2]) -> TessendorfSea {
        // Without a shutter all times are one.
        let steps = if shutter_s > 0.0 {
            self.shutter_fields - 1
        } else {
            0
        };
        let times = (0..=steps).map(|i| match i {
            0 => 0.0,
            i => shutter_s * f64::from(i) / f64::from(steps),
        });
        let fields = times.map(|t| self.slopes(self.time_s + time_s + t));
        let wrap = |v: f64| {
            let tiles = v / self.tile_m;
            (tiles - libm::floor(tiles)) as f32
        };
        TessendorfSea {
            fields: fields.collect(),
            fields_per_s: fields_per_s(steps, shutter_s),
            origin: Vec2::from_array(origin_m.map(wrap)),
            per_metre: (1.0 / self.tile_m) as f32,
        }
    }

    fn slopes(&self, time_s: f64) -> SlopeMap {
        const SLOPES: [Field; 2] = [Field::SlopeX, Field::SlopeZ];
        let n = self.spectrum.n();
        let Some(caps) = &self.whitecaps else {
            let [x, z] = self.spectrum.fields(time_s, SLOPES);
            return SlopeMap::new(n, &x, &z, &[]);
        };
        let [x, z] = SLOPES;
        let wanted = [x, z, Field::SqueezeX, Field::SqueezeZ, Field::SqueezeXz];
        let [x, z, squeeze_x, squeeze_z, squeeze_xz] = self.spectrum.fields(time_s, wanted);
        let foam = foam(caps, &squeeze_x, &squeeze_z, &squeeze_xz);
        SlopeMap::new(n, &x, &z, &foam)
    }
}

impl TessendorfSea {
    /// Slopes at `p` metres from the render origin, `time_s` after the shutter
    /// opened, under a ray `footprint_m` wide. Between two fields slopes change
    /// linearly.
    #[inline]
    pub(super) fn at(&self, p: Vec2, time_s: f32, footprint_m: f32) -> Slopes {
        let tile = p * self.per_metre + self.origin;
        let width = footprint_m * self.per_metre;
        let step = time_s * self.fields_per_s;
        let before = (step as usize).min(self.fields.len() - 1);
        let slopes = self.fields[before].lookup(tile, width);
        match self.fields.get(before + 1) {
            None => slopes,
            Some(after) => slopes.towards(after.lookup(tile, width), step - before as f32),
        }
    }
}

// 0 when the shutter is too short for floats: every ray then sees the first field.
fn fields_per_s(steps: u32, shutter_s: f64) -> f32 {
    let rate = (f64::from(steps) / shutter_s) as f32;
    if rate.is_finite() { rate } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::fields_per_s;

    #[test]
    fn a_shutter_too_short_for_floats_sees_the_first_field() {
        assert_eq!(fields_per_s(3, 0.5), 6.0);
        for (steps, shutter_s) in [(0, 0.0), (0, 1.0), (3, 1e-50), (3, 0.0)] {
            assert_eq!(fields_per_s(steps, shutter_s), 0.0);
        }
    }
}
