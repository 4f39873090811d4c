//! Names of units in outputs; nothing is converted.

/// A consistent set of units, by the names that figures and tables show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Units {
    /// Of lengths.
    pub length: &'static str,
    /// Of times.
    pub time: &'static str,
    /// Of percussions.
    pub percussion: &'static str,
    /// Of works and energies.
    pub energy: &'static str,
}

impl Units {
    /// m, s, kg, and so N, N s, J.
    pub const SI: Self = Self { length: "m", time: "s", percussion: "N s", energy: "J" };

    /// mm, ms, g, and so N, MPa, mN s, mJ.
    pub const MM_MS_G: Self = Self { length: "mm", time: "ms", percussion: "mN s", energy: "mJ" };

    /// The name of a unit that a system gives in metres, such as `m` or `rad`.
    pub fn rename(&self, unit: &str) -> String {
        if unit == "m" { self.length.into() } else { unit.into() }
    }
}
