//! One source for one query and for eight: the model is written over [`Lanes`], which is `f32`
//! or eight queries side by side in an `f32x8`.
//!
//! A single query fills the same registers another way: [`Lanes::each`] hands several of its
//! values (the lobes, the colour channels) to one vector call.

use std::ops::{Add, Div, Mul, Neg, Sub};
use wide::f32x8;

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for wide::f32x8 {}
}

/// A number, or eight of them: `f32` and [`wide::f32x8`], no others.
pub trait Lanes:
    sealed::Sealed
    + Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// One `T` for each lane.
    type PerLane<T: Copy>: AsRef<[T]> + Copy;

    /// The same number in each lane.
    fn splat(x: f32) -> Self;
    /// The value of lane `i`.
    fn lane(self, i: usize) -> f32;
    /// Builds a number lane by lane.
    fn from_lanes(f: impl FnMut(usize) -> f32) -> Self;
    /// Builds one `T` a lane.
    fn per_lane<T: Copy>(f: impl FnMut(usize) -> T) -> Self::PerLane<T>;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// The smaller of the two, neither being NaN.
    fn min(self, other: Self) -> Self;
    /// The larger of the two, neither being NaN.
    fn max(self, other: Self) -> Self;
    /// `x` where `self < limit`, else `y`.
    fn select_lt(self, limit: Self, x: Self, y: Self) -> Self;
    /// `f` of each of at most eight values, in as few vector calls as the lanes allow.
    fn each<const N: usize>(values: [Self; N], f: impl Fn(f32x8) -> f32x8) -> [Self; N];
    /// `f` of at most eight pairs.
    fn each2<const N: usize>(a: [Self; N], b: [Self; N], f: impl Fn(f32x8, f32x8) -> f32x8) -> [Self; N];
}

fn pack<const N: usize>(values: [f32; N]) -> f32x8 {
    const { assert!(N <= 8) }
    let mut lanes = [0.0; 8];
    lanes[..N].copy_from_slice(&values);
    f32x8::new(lanes)
}

fn unpack<const N: usize>(packed: f32x8) -> [f32; N] {
    let lanes = packed.to_array();
    std::array::from_fn(|i| lanes[i])
}

impl Lanes for f32 {
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
    fn from_lanes(mut f: impl FnMut(usize) -> f32) -> Self {
        f(0)
    }
    #[inline(always)]
    fn per_lane<T: Copy>(f: impl FnMut(usize) -> T) -> [T; 1] {
        std::array::from_fn(f)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f32::sqrt(self)
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
    fn each<const N: usize>(values: [Self; N], f: impl Fn(f32x8) -> f32x8) -> [Self; N] {
        unpack(f(pack(values)))
    }
    #[inline(always)]
    fn each2<const N: usize>(a: [Self; N], b: [Self; N], f: impl Fn(f32x8, f32x8) -> f32x8) -> [Self; N] {
        unpack(f(pack(a), pack(b)))
    }
}

impl Lanes for f32x8 {
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
    fn from_lanes(f: impl FnMut(usize) -> f32) -> Self {
        f32x8::new(std::array::from_fn(f))
    }
    #[inline(always)]
    fn per_lane<T: Copy>(f: impl FnMut(usize) -> T) -> [T; 8] {
        std::array::from_fn(f)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f32x8::sqrt(self)
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
    fn each<const N: usize>(values: [Self; N], f: impl Fn(f32x8) -> f32x8) -> [Self; N] {
        values.map(f)
    }
    #[inline(always)]
    fn each2<const N: usize>(a: [Self; N], b: [Self; N], f: impl Fn(f32x8, f32x8) -> f32x8) -> [Self; N] {
        std::array::from_fn(|i| f(a[i], b[i]))
    }
}
