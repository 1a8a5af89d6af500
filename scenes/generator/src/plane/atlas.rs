//! Where each skin of the plane lies in the livery texture.

/// Side of the square texture in pixels.
pub const SIZE: u32 = 2048;

/// A rectangle of the texture and the two skin coordinates it spans: `a` runs
/// along the picture's x, `b` down its y.
#[derive(Clone, Copy, Debug)]
pub struct Island {
    /// Left, top, width, height in pixels.
    pub pixels: [f64; 4],
    /// First and last value of a.
    pub a: (f64, f64),
    /// First and last value of b.
    pub b: (f64, f64),
}

impl Island {
    /// Texture coordinates (v upwards) of a point of the skin.
    #[must_use]
    pub fn uv(&self, a: f64, b: f64) -> [f64; 2] {
        let [x, y, w, h] = self.pixels;
        let fa = ((a - self.a.0) / (self.a.1 - self.a.0)).clamp(0.0, 1.0);
        let fb = ((b - self.b.0) / (self.b.1 - self.b.0)).clamp(0.0, 1.0);
        let side = f64::from(SIZE);
        [(x + fa * w) / side, 1.0 - (y + fb * h) / side]
    }

    /// Skin coordinates at a place of the picture, in pixels.
    #[must_use]
    pub fn skin(&self, px: f64, py: f64) -> (f64, f64) {
        let [x, y, w, h] = self.pixels;
        (
            self.a.0 + (px - x) / w * (self.a.1 - self.a.0),
            self.b.0 + (py - y) / h * (self.b.1 - self.b.0),
        )
    }
}

/// Fuselage: a = station, b = turn (see `shape::angle_of_turn`).
pub const FUSELAGE: Island = Island {
    pixels: [8.0, 8.0, 2032.0, 880.0],
    a: (0.0, 12.2),
    b: (0.0, 1.0),
};
/// Wing from above: a = x, b = z.
pub const WING_UPPER: Island = Island {
    pixels: [8.0, 904.0, 2032.0, 332.0],
    a: (-8.8, 8.8),
    b: (-1.12, 2.11),
};
/// Wing from below: a = x, b = z.
pub const WING_LOWER: Island = Island {
    pixels: [8.0, 1248.0, 2032.0, 332.0],
    a: (-8.8, 8.8),
    b: (-1.12, 2.11),
};
/// Tailplane from above: a = x, b = z.
pub const TAIL_UPPER: Island = Island {
    pixels: [8.0, 1592.0, 690.0, 196.0],
    a: (-3.0, 3.0),
    b: (5.5, 7.25),
};
/// Tailplane from below: a = x, b = z.
pub const TAIL_LOWER: Island = Island {
    pixels: [706.0, 1592.0, 690.0, 196.0],
    a: (-3.0, 3.0),
    b: (5.5, 7.25),
};
/// Fin, right side: a = z, b = y (downwards).
pub const FIN_RIGHT: Island = Island {
    pixels: [1404.0, 1592.0, 420.0, 220.0],
    a: (4.1, 7.8),
    b: (2.64, 0.3),
};
/// Fin, left side: a = z, b = y (downwards).
pub const FIN_LEFT: Island = Island {
    pixels: [1404.0, 1820.0, 420.0, 220.0],
    a: (4.1, 7.8),
    b: (2.64, 0.3),
};
/// Nacelle and cowling: a = station from the lip, b = turn.
pub const NACELLE: Island = Island {
    pixels: [8.0, 1800.0, 690.0, 240.0],
    a: (-0.05, 4.6),
    b: (0.0, 1.0),
};
/// A plain patch for the small painted parts.
pub const PLAIN: Island = Island {
    pixels: [706.0, 1800.0, 240.0, 240.0],
    a: (0.0, 1.0),
    b: (0.0, 1.0),
};
