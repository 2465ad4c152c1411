//! Equations of state of weakly compressible liquids. A liquid is never under tension.

use crate::model::Liquid;

/// How pressure follows from the density, with the speed of sound `c` at rest and `ρ0 c²/7`, the stiffness of the material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Equation {
    /// Tait's with exponent 7, `p = ρ0 c²/7 ((ρ/ρ0)⁷ - 1)` (Batchelor 1967; Monaghan 1994, eq. 3.1).
    Tait,
    /// `p = c² (ρ - ρ0)`.
    Linear,
}

impl Liquid {
    /// Pressure at a density \[Pa\].
    pub(crate) fn pressure(&self, rho: f64) -> f64 {
        let ratio = rho / self.rho;
        let pressure = match self.equation {
            Equation::Tait => {
                let cube = ratio * ratio * ratio;
                self.stiffness * (cube * cube * ratio - 1.0)
            }
            Equation::Linear => 7.0 * self.stiffness * (ratio - 1.0),
        };
        pressure.max(0.0)
    }

    /// What a kilogram stores by its compression \[J/kg\]: `∫ p dρ/ρ²`.
    pub(crate) fn stored(&self, rho: f64) -> f64 {
        let s = (rho / self.rho).max(1.0);
        let of = match self.equation {
            Equation::Tait => {
                let cube = s * s * s;
                (cube * cube - 1.0) / 6.0 + 1.0 / s - 1.0
            }
            Equation::Linear => 7.0 * (libm::log(s) + 1.0 / s - 1.0),
        };
        self.stiffness / self.rho * of
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn liquid(equation: Equation) -> Liquid {
        Liquid {
            name: String::new(),
            rho: 1000.0,
            stiffness: 6e4,
            equation,
            sound: (7.0_f64 * 60.0).sqrt(),
            viscosity: 0.0,
            thickness: 0.0,
            cohesion: 0.0,
            tension: 0.0,
            ids: 0..0,
            coupled: false,
        }
    }

    #[test]
    fn what_is_stored_is_the_work_of_the_pressure() {
        for equation in [Equation::Tait, Equation::Linear] {
            let liquid = liquid(equation);
            // Simpson's rule over parts of 1e-3 of the density: its error is some 1e-12 of the whole.
            let (mut sum, h) = (0.0, 1.0);
            let power = |rho: f64| liquid.pressure(rho) / (rho * rho);
            for i in 0..150 {
                let a = 1000.0 + h * f64::from(i);
                sum += h / 6.0 * (power(a) + 4.0 * power(a + 0.5 * h) + power(a + h));
            }
            let stored = liquid.stored(1150.0);
            assert!((sum / stored - 1.0).abs() < 1e-9, "{sum} of {stored}");
            assert!(liquid.stored(900.0).abs() < 1e-15 && liquid.pressure(900.0).abs() < 1e-15);
        }
    }

    #[test]
    fn both_have_the_same_speed_of_sound_at_rest() {
        for equation in [Equation::Tait, Equation::Linear] {
            let liquid = liquid(equation);
            // `c² = dp/dρ`; the curvature adds 3 parts in a million here.
            let slope = liquid.pressure(1000.001) / 0.001;
            assert!((slope / liquid.sound.powi(2) - 1.0).abs() < 1e-5, "{slope}");
        }
    }
}
