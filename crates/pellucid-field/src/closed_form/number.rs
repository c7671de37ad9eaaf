//! Numbers that carry their gradient, so that a formula is written once and its gradient follows
//! by the chain rule (forward-mode differentiation).

use std::ops::{Add, Mul, Neg, Sub};

use glam::DVec3;

/// What a formula is evaluated with: `f64` for the value alone, [`Dual`] for value and gradient.
pub(crate) trait Number:
    Copy
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
{
    /// A number that does not depend on position.
    fn constant(value: f64) -> Self;

    /// The value alone: for branches, never for arithmetic (it drops the gradient).
    fn value(self) -> f64;

    /// `f(self)`, given f and its derivative at `self.value()`.
    fn chain(self, f: f64, derivative: f64) -> Self;

    fn sin(self) -> Self {
        let (sin, cos) = self.value().sin_cos();
        self.chain(sin, cos)
    }

    fn cos(self) -> Self {
        let (sin, cos) = self.value().sin_cos();
        self.chain(cos, -sin)
    }

    fn exp(self) -> Self {
        let exp = self.value().exp();
        self.chain(exp, exp)
    }

    fn recip(self) -> Self {
        let recip = self.value().recip();
        self.chain(recip, -recip * recip)
    }

    fn square(self) -> Self {
        self * self
    }

    /// Square root; the derivative at 0 is taken as 0, which is the gradient of every smooth
    /// radial function at its centre.
    fn sqrt(self) -> Self {
        let root = self.value().sqrt();
        self.chain(root, if root > 0.0 { 0.5 / root } else { 0.0 })
    }

    fn abs(self) -> Self {
        if self.value() < 0.0 { -self } else { self }
    }

    fn min(self, other: Self) -> Self {
        if other.value() < self.value() { other } else { self }
    }

    fn max(self, other: Self) -> Self {
        if other.value() > self.value() { other } else { self }
    }

    fn clamp(self, low: f64, high: f64) -> Self {
        let value = self.value();
        if value < low {
            Self::constant(low)
        } else if value > high {
            Self::constant(high)
        } else {
            self
        }
    }

    /// `self` at t = 0, `other` at t = 1.
    fn mix(self, other: Self, t: Self) -> Self {
        self + (other - self) * t
    }

    /// The quintic step: 0 up to 0, 1 from 1 on, with two continuous derivatives.
    fn smoothstep(self) -> Self {
        let t = self.value().clamp(0.0, 1.0);
        self.chain(t * t * t * (t * (6.0 * t - 15.0) + 10.0), 30.0 * (t * (1.0 - t)).powi(2))
    }
}

impl Number for f64 {
    fn constant(value: f64) -> Self {
        value
    }

    fn value(self) -> f64 {
        self
    }

    fn chain(self, f: f64, _: f64) -> Self {
        f
    }
}

/// A value and its gradient.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dual {
    pub value: f64,
    pub gradient: DVec3,
}

impl Dual {
    /// The three coordinates of a point as functions of position.
    pub fn coordinates(p: DVec3) -> [Self; 3] {
        [0, 1, 2].map(|axis| Self { value: p[axis], gradient: DVec3::AXES[axis] })
    }
}

impl Number for Dual {
    fn constant(value: f64) -> Self {
        Self { value, gradient: DVec3::ZERO }
    }

    fn value(self) -> f64 {
        self.value
    }

    fn chain(self, f: f64, derivative: f64) -> Self {
        Self { value: f, gradient: self.gradient * derivative }
    }
}

impl Neg for Dual {
    type Output = Self;
    fn neg(self) -> Self {
        Self { value: -self.value, gradient: -self.gradient }
    }
}

impl Add for Dual {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { value: self.value + other.value, gradient: self.gradient + other.gradient }
    }
}

impl Sub for Dual {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Dual {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self { value: self.value * other.value, gradient: self.gradient * other.value + other.gradient * self.value }
    }
}

impl Add<f64> for Dual {
    type Output = Self;
    fn add(self, other: f64) -> Self {
        Self { value: self.value + other, ..self }
    }
}

impl Sub<f64> for Dual {
    type Output = Self;
    fn sub(self, other: f64) -> Self {
        self + -other
    }
}

impl Mul<f64> for Dual {
    type Output = Self;
    fn mul(self, other: f64) -> Self {
        Self { value: self.value * other, gradient: self.gradient * other }
    }
}
