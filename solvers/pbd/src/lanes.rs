//! Four vertices at a time, each calculated as one alone is: the same operations in the same order give the same bits.

use wide::f64x4;

use crate::vertex::Vertex;

/// Vertices, or constraints, that are looked at together.
pub(crate) const LANES: usize = 4;

/// Four vectors.
pub(crate) type Fours = [f64x4; 3];

/// Four vertices.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Four {
    at: [u32; LANES],
    /// Position \[m\], velocity \[m/s\] and inverse mass \[1/kg\].
    pub(crate) x: Fours,
    pub(crate) u: Fours,
    pub(crate) w: f64x4,
}

impl Four {
    /// Those with these numbers.
    #[allow(clippy::inline_always, reason = "what it makes is used at once, and goes through memory otherwise")]
    #[inline(always)]
    pub(crate) fn of(vertices: &[Vertex], at: [u32; LANES]) -> Self {
        // A vertex is two rows of four numbers.
        let rows = |i: u32| {
            let v = &vertices[i as usize];
            (f64x4::new([v.x[0], v.x[1], v.x[2], v.u[0]]), f64x4::new([v.u[1], v.u[2], v.w, v.mass]))
        };
        let (a, b, c, d) = (rows(at[0]), rows(at[1]), rows(at[2]), rows(at[3]));
        let [x, y, z, u] = f64x4::transpose([a.0, b.0, c.0, d.0]);
        let [v, w, inverse, _] = f64x4::transpose([a.1, b.1, c.1, d.1]);
        Self { at, x: [x, y, z], u: [u, v, w], w: inverse }
    }

    /// Gives them an impulse each \[N s\].
    #[allow(clippy::inline_always, reason = "as above")]
    #[inline(always)]
    pub(crate) fn take(&self, impulse: Fours, vertices: &mut [Vertex]) {
        let u = add(self.u, scale(impulse, self.w));
        let [x, y, z] = [u[0].to_array(), u[1].to_array(), u[2].to_array()];
        for lane in 0..LANES {
            vertices[self.at[lane] as usize].u = [x[lane], y[lane], z[lane]];
        }
    }
}

/// What four constraints say.
#[inline]
pub(crate) fn lanes<T>(four: &[T; LANES], f: impl Fn(&T) -> f64) -> f64x4 {
    f64x4::new([f(&four[0]), f(&four[1]), f(&four[2]), f(&four[3])])
}

/// `a + b`.
#[inline]
pub(crate) fn add(a: Fours, b: Fours) -> Fours {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// `a - b`.
#[inline]
pub(crate) fn sub(a: Fours, b: Fours) -> Fours {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `s a`.
#[inline]
pub(crate) fn scale(a: Fours, s: f64x4) -> Fours {
    [a[0] * s, a[1] * s, a[2] * s]
}

/// `a × b`.
#[inline]
pub(crate) fn cross(a: Fours, b: Fours) -> Fours {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `a · b`.
#[inline]
pub(crate) fn dot(a: Fours, b: Fours) -> f64x4 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
