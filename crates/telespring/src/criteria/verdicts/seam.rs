//! Temporary stand-ins for the exact criteria of one axis: to be deleted and replaced by
//! `use super::super::{crossings, critical_stiffness, ...}`.

use nalgebra::DMatrix;
use num_complex::Complex64;

use crate::error::Result;
use crate::model::DyadAxis;

pub(super) struct Crossing {
    pub delay: f64,
    pub frequency: f64,
    pub direction: i8,
}

fn mul(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut p = vec![0.0; a.len() + b.len() - 1];
    for (i, x) in a.iter().enumerate() {
        for (j, y) in b.iter().enumerate() {
            p[i + j] += x * y;
        }
    }
    p
}

fn f(axis: &DyadAxis, k: f64) -> Vec<f64> {
    let c = axis.coupling_damping;
    let [a, b] = axis.sides.map(|s| {
        let kk = k + s.ground_stiffness;
        let d = s.damping + c;
        vec![kk * kk, d * d - 2.0 * s.mass * kk, s.mass * s.mass]
    });
    let mut p = mul(&a, &b);
    for (x, y) in p.iter_mut().zip(mul(&[k * k, c * c], &[k * k, c * c])) {
        *x -= y;
    }
    if axis.is_free() {
        p.remove(0);
    }
    p
}

fn positive_roots(p: &[f64]) -> Vec<f64> {
    let n = p.len() - 1;
    let scale = p
        .iter()
        .enumerate()
        .take(n)
        .map(|(i, c)| (c / p[n]).abs().powf(1.0 / (n - i) as f64))
        .fold(1e-300, f64::max);
    let mut m = DMatrix::zeros(n, n);
    for i in 0..n {
        m[(0, i)] = -p[n - 1 - i] / p[n] / scale.powi(i as i32 + 1);
        if i + 1 < n {
            m[(i + 1, i)] = 1.0;
        }
    }
    let mut out: Vec<f64> = m
        .complex_eigenvalues()
        .iter()
        .filter(|z| z.re > 1e-13 && z.im.abs() < 1e-9 * z.norm())
        .map(|z| {
            let mut x = z.re * scale;
            for _ in 0..3 {
                let (v, d) = p.iter().rev().fold((0.0, 0.0), |(v, d), c| (v * x + c, d * x + v));
                if d != 0.0 && (v / d).abs() < 1e-3 * x {
                    x -= v / d;
                }
            }
            x
        })
        .collect();
    out.sort_by(f64::total_cmp);
    out
}

pub(super) fn crossings(axis: &DyadAxis, k: f64) -> Result<Vec<Crossing>> {
    let p = f(axis, k);
    let mut out: Vec<Crossing> = positive_roots(&p)
        .into_iter()
        .map(|x| {
            let w = x.sqrt();
            let c = axis.coupling_damping;
            let pp: Complex64 = axis
                .sides
                .iter()
                .map(|s| Complex64::new(k + s.ground_stiffness - s.mass * x, (s.damping + c) * w))
                .product();
            let q = Complex64::new(k, c * w);
            let arg = (pp / (q * q)).arg();
            let d = p.iter().rev().fold((0.0, 0.0), |(v, d), c| (v * x + c, d * x + v)).1;
            Crossing {
                delay: (-arg).rem_euclid(2.0 * std::f64::consts::PI) / w / 2.0,
                frequency: w,
                direction: if d > 0.0 { 1 } else { -1 },
            }
        })
        .collect();
    out.sort_by(|a, b| a.delay.total_cmp(&b.delay));
    Ok(out)
}

pub(super) fn critical_stiffness(axis: &DyadAxis) -> Result<f64> {
    let bad = |k: f64| !positive_roots(&f(axis, k)).is_empty();
    let mut lo = 1e-2;
    let mut hi = 1e-2;
    while !bad(hi) {
        lo = hi;
        hi *= 1.05;
        if hi > 1e12 {
            return Ok(f64::INFINITY);
        }
    }
    for _ in 0..80 {
        let m = 0.5 * (lo + hi);
        if bad(m) { hi = m } else { lo = m }
    }
    Ok(lo)
}

pub(super) fn maximum_delay(axis: &DyadAxis, k: f64) -> Result<f64> {
    Ok(crossings(axis, k)?.first().map_or(f64::INFINITY, |c| c.delay))
}

pub(super) fn stable_delays(axis: &DyadAxis, k: f64, horizon: f64) -> Result<Vec<(f64, f64)>> {
    let mut events: Vec<(f64, i32)> = Vec::new();
    for c in crossings(axis, k)? {
        let mut d = c.delay;
        while d < horizon && events.len() < 100_000 {
            events.push((d, i32::from(c.direction)));
            d += std::f64::consts::PI / c.frequency;
        }
    }
    events.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut count, mut start, mut out) = (0, 0.0, Vec::new());
    for (d, e) in events {
        if count == 0 && e > 0 {
            out.push((start, d));
        }
        count += e;
        if count == 0 {
            start = d;
        }
    }
    if count == 0 {
        out.push((start, horizon));
    }
    Ok(out)
}

pub(super) fn maximum_stiffness(axis: &DyadAxis, delay: f64) -> Result<f64> {
    if delay == 0.0 {
        return Ok(f64::INFINITY);
    }
    let ok = |k: f64| maximum_delay(axis, k).is_ok_and(|d| d > delay);
    let (mut lo, mut hi) = (1e-2, 1e-2);
    while ok(hi) {
        lo = hi;
        hi *= 1.05;
        if hi > 1e12 {
            return Ok(f64::INFINITY);
        }
    }
    for _ in 0..80 {
        let m = 0.5 * (lo + hi);
        if ok(m) { lo = m } else { hi = m }
    }
    Ok(lo)
}

pub(super) fn minimum_damping(axis: &DyadAxis, k: f64, delay: f64) -> Result<f64> {
    let ok = |d: f64| {
        let mut a = *axis;
        for s in &mut a.sides {
            s.damping += d;
        }
        maximum_delay(&a, k).is_ok_and(|m| m > delay)
    };
    if ok(0.0) {
        return Ok(0.0);
    }
    let (mut lo, mut hi) = (0.0, 1e6);
    for _ in 0..100 {
        let m = 0.5 * (lo + hi);
        if ok(m) { hi = m } else { lo = m }
    }
    Ok(hi)
}
