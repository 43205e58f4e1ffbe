// SPDX-License-Identifier: MIT OR Apache-2.0
use super::chunks::{WORK_UNWATCHED, transform_work};
use super::kernel::VALUE;
use super::*;

fn field(n: usize, seed: u64) -> Vec<f64> {
    let mut state = seed;
    (0..n)
        .map(|_| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        })
        .collect()
}

fn dense(
    source: [usize; 2],
    target: [usize; 2],
    kernel: impl Fn(isize, isize) -> f64,
    x: &[f64],
) -> Vec<f64> {
    let mut y = vec![0.0; target[0] * target[1]];
    for (t, y) in y.iter_mut().enumerate() {
        for (s, x) in x.iter().enumerate() {
            let i = (t % target[0]) as isize - (s % source[0]) as isize;
            let j = (t / target[0]) as isize - (s / source[0]) as isize;
            *y += kernel(i, j) * x;
        }
    }
    y
}

fn assert_close(a: &[f64], b: &[f64]) {
    let scale = b.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    for (a, b) in a.iter().zip(b) {
        assert!((a - b).abs() <= 1e-13 * scale, "{a} {b}");
    }
}

fn skewed(i: isize, j: isize) -> f64 {
    (i as f64 + 0.3) / (1.0 + (i * i) as f64 + 2.0 * (j * j) as f64 + 0.7 * j as f64).sqrt()
}

#[test]
fn equals_the_dense_product_between_different_shapes() {
    for (source, target) in [
        ([7, 5], [7, 5]),
        ([1, 1], [1, 1]),
        ([3, 8], [6, 2]),
        ([1, 9], [4, 1]),
    ] {
        let transform = Transform::new(source, target);
        let kernel = transform.kernel(skewed);
        let x = field(source[0] * source[1], 3);
        let mut y = vec![0.0; target[0] * target[1]];
        transform.apply_add(&kernel, 1.0, &x, &mut y);
        assert_close(&y, &dense(source, target, skewed, &x));
    }
}

#[test]
fn single_precision_errs_by_its_rounding_at_any_scale() {
    let odd = |i: usize, j: usize| (i * j) as f64 / (1.0 + (i * i + j * j) as f64);
    let both = |i: isize, j: isize| {
        (i.signum() * j.signum()) as f64 * odd(i.unsigned_abs(), j.unsigned_abs())
    };
    let shape = [37, 29];
    let x = [field(37 * 29, 3), field(37 * 29, 4)];
    let exact = [
        dense(shape, shape, skewed, &x[0]),
        dense(shape, shape, both, &x[1]),
    ];
    let exact: Vec<f64> = exact[0].iter().zip(&exact[1]).map(|(a, b)| a + b).collect();
    let transform = Transform::new(shape, shape);
    // the squares of these are no numbers of single precision
    for (stiff, large) in [(1.0, 1.0), (1e-40, 1e45), (1e50, 1e-60), (1e-120, 1e-100)] {
        let kernels = [
            transform.kernel(|i, j| stiff * skewed(i, j)),
            transform.odd_kernel(|i, j| stiff * odd(i, j)),
        ];
        let fields = x
            .each_ref()
            .map(|x| x.iter().map(|v| large * v).collect::<Vec<f64>>());
        let mut y = vec![0.0; 37 * 29];
        transform.single().apply_block(
            &[&[Some(&kernels[0]), Some(&kernels[1])]],
            1.0 / (stiff * large),
            &[&fields[0], &fields[1]],
            &mut [&mut y],
        );
        let size = exact.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        let wrong = (y.iter().zip(&exact)).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
        // some steps of rounding of 6e-8 each; in double precision none of this would be left
        assert!(
            (1e-9 * size..1e-6 * size).contains(&wrong),
            "{stiff} {large}: {}",
            wrong / size
        );
    }
    // nothing of nothing
    let kernel = transform.kernel(|_, _| 0.0);
    let mut y = vec![1.0; 37 * 29];
    transform
        .single()
        .apply_watched(&kernel, &x[0], &mut y, &unmonitored);
    assert!(y.iter().all(|v| *v == 0.0));
}

#[test]
fn even_kernel_equals_the_general_one() {
    let value = |i: usize, j: usize| 1.0 / (1.0 + (i * i + 3 * j * j) as f64).sqrt();
    for shape in [[9, 6], [8, 8], [2, 1], [130, 140]] {
        let transform = Transform::new(shape, shape);
        let even = transform.even_kernel(value);
        let general = transform.kernel(|i, j| value(i.unsigned_abs(), j.unsigned_abs()));
        let x = field(shape[0] * shape[1], 5);
        let (mut a, mut b) = (vec![0.0; x.len()], vec![0.0; x.len()]);
        transform.apply_add(&even, 2.0, &x, &mut a);
        transform.apply_add(&general, 2.0, &x, &mut b);
        assert_close(&a, &b);
    }
}

#[test]
fn odd_kernel_equals_the_general_one() {
    let value = |i: isize, j: isize| (i * j) as f64 / (1.0 + (i * i + 3 * j * j) as f64).powi(2);
    for shape in [[9, 6], [8, 8], [2, 1], [130, 140]] {
        let free = Transform::new(shape, shape);
        // with an odd number of columns and an even one of rows, which are half a period apart from themselves
        let wrapped = Transform::periodic([shape[0] | 1, shape[1]]);
        for (transform, half) in [(free, usize::MAX), (wrapped, shape[1] / 2)] {
            let at = |i: isize, j: isize| {
                if j.unsigned_abs() == half {
                    0.0
                } else {
                    value(i, j)
                }
            };
            let odd = transform.odd_kernel(|i, j| value(i as isize, j as isize));
            let general = transform.kernel(at);
            let [nx, ny] = transform.source();
            let x = field(nx * ny, 5);
            let (mut a, mut b, mut c) =
                (vec![0.0; x.len()], vec![0.0; x.len()], vec![0.0; x.len()]);
            transform.apply_add(&odd, 2.0, &x, &mut a);
            transform.apply_add(&general, 2.0, &x, &mut b);
            assert_close(&a, &b);
            let copy =
                transform.odd_kernel_from_spectrum(|kx, ky| transform.spectrum(&odd, kx, ky).re);
            transform.apply_add(&copy, 2.0, &x, &mut c);
            assert_close(&c, &b);
            for (kx, ky) in [(0, 0), (nx / 3, ny - 1), (nx / 3, ny / 2)] {
                let [found, wanted] = [&odd, &general].map(|k| transform.spectrum(k, kx, ky));
                assert!((found - wanted).norm() < 1e-12);
            }
        }
    }
}

#[test]
fn kernels_odd_along_one_axis_equal_the_general_one() {
    let value = |i: isize, j: isize, odd: [bool; 2]| {
        let size = 1.0 / (1.0 + (i * i + 3 * j * j) as f64).powi(2);
        let along = |k: isize, is_odd: bool| if is_odd { k as f64 } else { 1.0 };
        size * along(i, odd[0]) * along(j, odd[1])
    };
    for odd in [[true, false], [false, true], [true, true], [false, false]] {
        for shape in [[9, 6], [8, 8], [2, 1], [1, 3], [130, 140]] {
            let transform = Transform::new(shape, shape);
            let mirrored =
                transform.mirrored_kernel(odd, |i, j| value(i as isize, j as isize, odd));
            let general = transform.kernel(|i, j| value(i, j, odd));
            let x = field(shape[0] * shape[1], 5);
            let (mut a, mut b) = (vec![0.0; x.len()], vec![0.0; x.len()]);
            transform.apply_add(&mirrored, 2.0, &x, &mut a);
            transform.apply_add(&general, 2.0, &x, &mut b);
            assert_close(&a, &b);
            for (kx, ky) in [(0, 0), (1, 0), (1, 1), (0, transform.padded()[1] - 1)] {
                let [a, b] = [&mirrored, &general].map(|k| transform.spectrum(k, kx, ky));
                assert!((a - b).norm() < 1e-12, "{odd:?} {shape:?} {kx} {ky}");
            }
        }
    }
}

#[test]
fn products_of_spectra_equal_those_of_fields() {
    for shape in [[9, 6], [1, 4], [130, 140]] {
        let transform = Transform::new(shape, shape);
        let general = transform.kernel(skewed);
        let even = transform.even_kernel(|i, j| 1.0 / (1 + i + 2 * j) as f64);
        let n = shape[0] * shape[1];
        let (mut x, y) = (field(n, 5), field(n, 7));
        x[..shape[0]].fill(0.0);
        let spectra = transform.spectra(&[&x, &y]);
        let rows: [&[Option<&Kernel>]; 3] = [
            &[Some(&general), Some(&even)],
            &[None, Some(&general)],
            &[None, None],
        ];
        let mut found = vec![vec![1.0; n]; 3];
        let mut expected = vec![vec![0.0; n]; 3];
        for outputs in [&mut found, &mut expected] {
            let mut outputs: Vec<&mut [f64]> = outputs.iter_mut().map(Vec::as_mut_slice).collect();
            if outputs[0][0] == 0.0 {
                transform.apply_block(&rows, 1.0, &[&x, &y], &mut outputs);
            } else {
                transform.products(&rows, &spectra, &mut outputs);
            }
        }
        for (a, b) in found.iter().zip(&expected) {
            assert_close(a, b);
        }
        let empty = transform.spectra(&[&vec![0.0; n]]);
        let mut nothing = vec![1.0; n];
        transform.products(&[&[Some(&general)]], &empty, &mut [&mut nothing]);
        assert!(nothing.iter().all(|v| *v == 0.0));
    }
}

#[test]
fn zero_rows_are_skipped_without_a_trace() {
    let transform = Transform::new([6, 9], [6, 9]);
    let kernel = transform.kernel(skewed);
    let mut x = field(54, 7);
    x[..18].fill(0.0);
    x[42..].fill(0.0);
    let mut y = vec![0.0; 54];
    transform.apply_add(&kernel, 1.0, &x, &mut y);
    assert_close(&y, &dense([6, 9], [6, 9], skewed, &x));
    // a buffer that held other rows before does not leak into the next product
    let mut again = vec![0.0; 54];
    transform.apply_add(&kernel, 1.0, &field(54, 8), &mut again);
    again.fill(0.0);
    transform.apply_add(&kernel, 1.0, &x, &mut again);
    assert_eq!(y, again);
}

#[test]
fn shared_memory_leaves_no_trace() {
    let buffers = Buffers::default();
    let value = |i: usize, j: usize| 1.0 / (1.0 + (i * i + 3 * j * j) as f64).sqrt();
    let products = |transform: &Transform| {
        let [nx, ny] = transform.source();
        let x = field(nx * ny, 11);
        [transform.even_kernel(value), transform.kernel(skewed)].map(|kernel| {
            let mut y = vec![f64::NAN; nx * ny];
            transform.apply_watched(&kernel, &x, &mut y, &unmonitored);
            y
        })
    };
    // what earlier shapes leave in the memory is no number
    let large = Transform::new([40, 40], [40, 40]).sharing(&buffers);
    large.kernel(|_, _| f64::NAN);
    for n in 1..14 {
        let fresh = || {
            [
                Transform::new([n, n + 1], [n, n + 1]),
                Transform::periodic([n, n]),
            ]
        };
        for (transform, other) in fresh().into_iter().zip(fresh()) {
            assert_eq!(products(&transform.sharing(&buffers)), products(&other));
        }
        large.kernel(|_, _| f64::NAN);
    }
}

#[test]
fn a_block_of_kernels_shares_the_transforms() {
    let shape = [5, 4];
    let transform = Transform::new(shape, shape);
    let other = |i: isize, j: isize| skewed(j, i);
    let (a, b) = (transform.kernel(skewed), transform.kernel(other));
    let (x, z) = (field(20, 1), field(20, 2));
    let (mut u, mut v) = (vec![0.0; 20], vec![0.0; 20]);
    transform.apply_block_add(
        &[&[Some(&a), Some(&b)], &[None, Some(&a)]],
        1.0,
        &[&x, &z],
        &mut [&mut u, &mut v],
    );
    let first: Vec<f64> = dense(shape, shape, skewed, &x)
        .iter()
        .zip(dense(shape, shape, other, &z))
        .map(|(p, q)| p + q)
        .collect();
    assert_close(&u, &first);
    assert_close(&v, &dense(shape, shape, skewed, &z));
}

#[test]
fn periodic_wraps_around_and_keeps_its_spectrum() {
    for shape in [[6, 5], [7, 8], [1, 3]] {
        let transform = Transform::periodic(shape);
        let kernel = transform.kernel(skewed);
        let x = field(shape[0] * shape[1], 9);
        let mut y = vec![0.0; x.len()];
        transform.apply_add(&kernel, 1.0, &x, &mut y);
        let wrap = |i: isize, n: usize| {
            let n = n as isize;
            let i = i.rem_euclid(n);
            if i > n / 2 { i - n } else { i }
        };
        let wrapped = |i, j| skewed(wrap(i, shape[0]), wrap(j, shape[1]));
        assert_close(&y, &dense(shape, shape, wrapped, &x));
        let copy = transform.kernel_from_spectrum(|kx, ky| transform.spectrum(&kernel, kx, ky));
        let mut z = vec![0.0; x.len()];
        transform.apply_add(&copy, 1.0, &x, &mut z);
        assert_close(&z, &y);
    }
}

#[test]
fn sizes_are_even_and_fast() {
    assert_eq!(
        [1, 2, 7, 11, 13, 121, 1023].map(fast_even_size),
        [2, 2, 8, 12, 14, 128, 1024]
    );
}

#[test]
fn the_widest_instructions_give_what_any_processor_gives() {
    let transform = Transform::new([23, 14], [23, 14]);
    let value = |i: usize, j: usize| 1.0 / (1.0 + i as f64 + 2.0 * j as f64);
    let kernels = [
        transform.even_kernel(value),
        transform.odd_kernel(value),
        transform.kernel(skewed),
    ];
    let my = transform.padded()[1];
    let (re, im) = (field(my, 3), field(my, 4));
    let x: Vec<Complex<f64>> = (re.iter().zip(im))
        .map(|(a, b)| Complex::new(*a, b))
        .collect();
    for kernel in &kernels {
        for is_first in [true, false] {
            for kx in 0..transform.waves_x() {
                let (mut widely, mut plainly) = (x.clone(), x.clone());
                kernel.multiply(kx, &x, &mut widely, (is_first, 1.0));
                kernel.multiply_plainly(kx, &x, &mut plainly, (is_first, 1.0));
                assert_eq!(widely, plainly);
            }
        }
    }
}

#[test]
fn work_between_two_looks_is_bounded() {
    use std::cell::Cell;
    use std::ops::ControlFlow;
    use std::sync::atomic::{AtomicUsize, Ordering};

    let n = 1500;
    let transform = Transform::new([n, n], [n, n]);
    let values = AtomicUsize::new(0);
    let value = |i: usize, j: usize| {
        values.fetch_add(1, Ordering::Relaxed);
        1.0 / (1 + i + j) as f64
    };
    let (looks, seen, most) = (Cell::new(0_u32), Cell::new(0), Cell::new(0));
    let look = |_: crate::Progress| {
        let now = values.load(Ordering::Relaxed);
        most.set(most.get().max(now - seen.get()));
        seen.set(now);
        looks.set(looks.get() + 1);
        ControlFlow::Continue(())
    };
    let kernel = transform.even_kernel_watched(value, &look);
    assert_eq!(values.load(Ordering::Relaxed), n * n);
    assert!(
        VALUE * most.get() as f64 <= WORK_UNWATCHED,
        "{}",
        most.get()
    );
    // what is watched is what is computed else
    let x = field(n * n, 5);
    let (mut y, mut plain) = (vec![0.0; n * n], vec![0.0; n * n]);
    looks.set(0);
    transform.apply_add_watched(&kernel, 1.0, &x, &mut y, &look);
    transform.apply_add(&kernel, 1.0, &x, &mut plain);
    assert_eq!(y, plain);
    let [mx, my] = transform.padded();
    let work = 2.0 * n as f64 * transform_work(mx) + mx as f64 * transform_work(my);
    assert!(
        f64::from(looks.get()) > work / WORK_UNWATCHED - 4.0,
        "{}",
        looks.get()
    );
    // and it ends at the first word
    let stop = |_: crate::Progress| ControlFlow::Break(());
    let before = values.load(Ordering::Relaxed);
    transform.even_kernel_watched(value, &stop);
    assert!(values.load(Ordering::Relaxed) - before <= (WORK_UNWATCHED / VALUE) as usize);
}
