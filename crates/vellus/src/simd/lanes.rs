//! The same source code evaluates one query or eight. The model is generic over [`Lanes`], which is `f32` for one
//! query, or `f32x8` for eight.
//!
//! Some quantities come in fours: the lobes with a Gaussian along the fibre, and the colour channels with a spare. They
//! are stored in a [`Quad`], which is one register of four numbers for one query, and four registers for eight queries.

use crate::simd::special;
use std::ops::{Add, Div, Mul, Neg, Sub};
use wide::{f32x4, f32x8};

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for wide::f32x8 {}
}

/// One number or eight. Only `f32` and [`wide::f32x8`] implement it.
pub trait Lanes:
    sealed::Sealed
    + Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// Four numbers of this type.
    #[doc(hidden)]
    type Quad: Quad<Self>;
    /// One `T` for each lane.
    #[doc(hidden)]
    type PerLane<T: Copy>: AsRef<[T]> + Copy;

    /// The same number in each lane.
    fn splat(x: f32) -> Self;
    /// The value of lane `i`.
    fn lane(self, i: usize) -> f32;
    /// The first lanes of `values`.
    fn from_lanes(values: &[f32; 8]) -> Self;
    /// One `T` for each lane.
    #[doc(hidden)]
    fn per_lane<T: Copy>(f: impl FnMut(usize) -> T) -> Self::PerLane<T>;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Natural logarithm.
    fn ln(self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// The smaller of two numbers, neither of which is NaN.
    fn min(self, other: Self) -> Self;
    /// The larger of two numbers, neither of which is NaN.
    fn max(self, other: Self) -> Self;
    /// `x` if `self < limit`, else `y`.
    fn select_lt(self, limit: Self, x: Self, y: Self) -> Self;
    /// atan2(y, x) of two pairs.
    fn atan2_pair(y: [Self; 2], x: [Self; 2]) -> [Self; 2];
}

/// Four numbers of type `V` that are computed together.
#[doc(hidden)]
pub trait Quad<V>:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    fn new(values: [V; 4]) -> Self;
    fn splat(x: V) -> Self;
    fn constant(values: [f32; 4]) -> Self;
    fn array(self) -> [V; 4];
    fn abs(self) -> Self;
    fn sqrt(self) -> Self;
    fn max(self, other: Self) -> Self;
    /// self · factor + other.
    fn mul_add(self, factor: Self, other: Self) -> Self;
    fn exp(self) -> Self;
    fn bessel_i0e(self) -> Self;
    fn atan2(self, x: Self) -> Self;
}

impl Lanes for f32 {
    type Quad = f32x4;
    type PerLane<T: Copy> = [T; 1];

    #[inline(always)]
    fn splat(x: f32) -> Self {
        x
    }
    #[inline(always)]
    fn lane(self, _: usize) -> f32 {
        self
    }
    #[inline(always)]
    fn from_lanes(values: &[f32; 8]) -> Self {
        values[0]
    }
    #[inline(always)]
    fn per_lane<T: Copy>(mut f: impl FnMut(usize) -> T) -> [T; 1] {
        [f(0)]
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f32::sqrt(self)
    }
    #[inline(always)]
    fn ln(self) -> Self {
        f32::ln(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f32::abs(self)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    #[inline(always)]
    fn select_lt(self, limit: Self, x: Self, y: Self) -> Self {
        if self < limit { x } else { y }
    }
    #[inline(always)]
    fn atan2_pair(y: [Self; 2], x: [Self; 2]) -> [Self; 2] {
        let angles = special::atan2(f32x4::new([y[0], y[1], 0.0, 0.0]), f32x4::new([x[0], x[1], 1.0, 1.0])).to_array();
        [angles[0], angles[1]]
    }
}

impl Quad<f32> for f32x4 {
    #[inline(always)]
    fn new(values: [f32; 4]) -> Self {
        f32x4::new(values)
    }
    #[inline(always)]
    fn splat(x: f32) -> Self {
        f32x4::splat(x)
    }
    #[inline(always)]
    fn constant(values: [f32; 4]) -> Self {
        f32x4::new(values)
    }
    #[inline(always)]
    fn array(self) -> [f32; 4] {
        self.to_array()
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f32x4::abs(self)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f32x4::sqrt(self)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.fast_max(other)
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, other: Self) -> Self {
        f32x4::mul_add(self, factor, other)
    }
    #[inline(always)]
    fn exp(self) -> Self {
        special::exp(self)
    }
    #[inline(always)]
    fn bessel_i0e(self) -> Self {
        special::bessel_i0e(self)
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        special::atan2(self, x)
    }
}

impl Lanes for f32x8 {
    type Quad = Four;
    type PerLane<T: Copy> = [T; 8];

    #[inline(always)]
    fn splat(x: f32) -> Self {
        f32x8::splat(x)
    }
    #[inline(always)]
    fn lane(self, i: usize) -> f32 {
        self.to_array()[i]
    }
    #[inline(always)]
    fn from_lanes(values: &[f32; 8]) -> Self {
        f32x8::new(*values)
    }
    #[inline(always)]
    fn per_lane<T: Copy>(mut f: impl FnMut(usize) -> T) -> [T; 8] {
        [f(0), f(1), f(2), f(3), f(4), f(5), f(6), f(7)]
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f32x8::sqrt(self)
    }
    #[inline(always)]
    fn ln(self) -> Self {
        f32x8::ln(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f32x8::abs(self)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.fast_min(other)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.fast_max(other)
    }
    #[inline(always)]
    fn select_lt(self, limit: Self, x: Self, y: Self) -> Self {
        self.simd_lt(limit).select(x, y)
    }
    #[inline(always)]
    fn atan2_pair(y: [Self; 2], x: [Self; 2]) -> [Self; 2] {
        [special::atan2(y[0], x[0]), special::atan2(y[1], x[1])]
    }
}

/// The [`Quad`] of eight queries.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct Four([f32x8; 4]);

macro_rules! four_operator {
    ($trait:ident, $method:ident, $operator:tt) => {
        impl $trait for Four {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                let (a, b) = (self.0, other.0);
                Four([a[0] $operator b[0], a[1] $operator b[1], a[2] $operator b[2], a[3] $operator b[3]])
            }
        }
    };
}
four_operator!(Add, add, +);
four_operator!(Sub, sub, -);
four_operator!(Mul, mul, *);
four_operator!(Div, div, /);

impl Neg for Four {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        let a = self.0;
        Four([-a[0], -a[1], -a[2], -a[3]])
    }
}

impl Quad<f32x8> for Four {
    #[inline(always)]
    fn new(values: [f32x8; 4]) -> Self {
        Four(values)
    }
    #[inline(always)]
    fn splat(x: f32x8) -> Self {
        Four([x; 4])
    }
    #[inline(always)]
    fn constant(v: [f32; 4]) -> Self {
        Four([f32x8::splat(v[0]), f32x8::splat(v[1]), f32x8::splat(v[2]), f32x8::splat(v[3])])
    }
    #[inline(always)]
    fn array(self) -> [f32x8; 4] {
        self.0
    }
    #[inline(always)]
    fn abs(self) -> Self {
        let a = self.0;
        Four([a[0].abs(), a[1].abs(), a[2].abs(), a[3].abs()])
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        let (a, b) = (self.0, other.0);
        Four([a[0].fast_max(b[0]), a[1].fast_max(b[1]), a[2].fast_max(b[2]), a[3].fast_max(b[3])])
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, other: Self) -> Self {
        let (a, b, c) = (self.0, factor.0, other.0);
        Four([a[0].mul_add(b[0], c[0]), a[1].mul_add(b[1], c[1]), a[2].mul_add(b[2], c[2]), a[3].mul_add(b[3], c[3])])
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        let a = self.0;
        Four([a[0].sqrt(), a[1].sqrt(), a[2].sqrt(), a[3].sqrt()])
    }
    #[inline(always)]
    fn exp(self) -> Self {
        let a = self.0;
        Four([special::exp(a[0]), special::exp(a[1]), special::exp(a[2]), special::exp(a[3])])
    }
    #[inline(always)]
    fn bessel_i0e(self) -> Self {
        let a = self.0;
        Four([
            special::bessel_i0e(a[0]),
            special::bessel_i0e(a[1]),
            special::bessel_i0e(a[2]),
            special::bessel_i0e(a[3]),
        ])
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        let (a, b) = (self.0, x.0);
        Four([
            special::atan2(a[0], b[0]),
            special::atan2(a[1], b[1]),
            special::atan2(a[2], b[2]),
            special::atan2(a[3], b[3]),
        ])
    }
}
