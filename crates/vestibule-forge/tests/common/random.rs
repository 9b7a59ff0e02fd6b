//! A small generator: the tests do the same everywhere.

pub(crate) struct Random(pub(crate) u64);

impl Random {
    fn draw(&mut self) -> u64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        self.0 >> 33
    }

    /// From 0 to 1.
    pub(crate) fn next(&mut self) -> f64 {
        self.draw() as f64 / (1u64 << 31) as f64
    }

    /// Less than `limit`, or 0.
    pub(crate) fn below(&mut self, limit: usize) -> usize {
        self.draw() as usize % limit.max(1)
    }

    pub(crate) fn between(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.next()
    }

    /// In centimetres.
    pub(crate) fn rounded(&mut self, a: f64, b: f64) -> f64 {
        (self.between(a, b) * 100.0).round() / 100.0
    }

    pub(crate) fn chance(&mut self, share: f64) -> bool {
        self.next() < share
    }

    pub(crate) fn point(&mut self, reach: f64) -> glam::DVec3 {
        glam::DVec3::new(
            self.between(-reach, reach),
            self.between(-reach, reach),
            self.between(-reach, reach),
        )
    }
}
