// SPDX-License-Identifier: MIT OR Apache-2.0
use std::f64::consts::PI;
use std::sync::Arc;

use mtb_elasticity::Material;
use mtb_elasticity::half_space::HalfSpace;
use mtb_operator::{Component, Grid, Relative, unmonitored};
use proptest::prelude::*;

use super::*;

/// A compliance that falls with the distance as that of the half-space does; 1 / r with the self term of a
/// square cell, in units without a name.
fn influence(offset: [f64; 2], cell: [f64; 2]) -> f64 {
    let corner = |x: f64, y: f64| {
        let part = |a: f64, b: f64| {
            if a == 0.0 {
                0.0
            } else {
                a * (b / a.abs()).asinh()
            }
        };
        part(x, y) + part(y, x)
    };
    let (x1, x2) = (offset[0] - 0.5 * cell[0], offset[0] + 0.5 * cell[0]);
    let (y1, y2) = (offset[1] - 0.5 * cell[1], offset[1] + 0.5 * cell[1]);
    corner(x2, y2) - corner(x1, y2) - corner(x2, y1) + corner(x1, y1)
}

fn wave(k: f64) -> f64 {
    if k == 0.0 { 0.0 } else { 2.0 * PI / k }
}

fn field(grid: &Grid, gap: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    let mut values = Vec::new();
    for j in 0..grid.ny {
        for i in 0..grid.nx {
            let x = (i as f64 + 0.5 - 0.5 * grid.nx as f64) * grid.dx;
            let y = (j as f64 + 0.5 - 0.5 * grid.ny as f64) * grid.dy;
            values.push(gap(x, y));
        }
    }
    values
}

fn run(
    grid: Grid,
    gap: &[f64],
    load: Load,
    moments: [Option<f64>; 2],
    method: Method,
) -> Result<NormalSolution, Error> {
    let surface = Surface::FreeSpace(&influence);
    let contact = NormalContact {
        gap,
        grid,
        surface,
        load,
        moments,
        hardness: None,
        rough: None,
        start: None,
    };
    solve_normal(
        &contact,
        Options {
            tolerance: Some(1e-10),
            method,
        },
        &unmonitored,
    )
}

fn assert_same(a: &NormalSolution, b: &NormalSolution) {
    assert_eq!((a.status, b.status), (Status::Solved, Status::Solved));
    let scale = b.pressure.iter().fold(0.0_f64, |m, p| m.max(*p));
    for (p, q) in a.pressure.iter().zip(&b.pressure) {
        assert!((p - q).abs() < 1e-8 * scale, "{p} {q}");
    }
    assert!((a.approach - b.approach).abs() < 1e-9 * b.approach.abs());
    for axis in 0..2 {
        assert!((a.tilts[axis] - b.tilts[axis]).abs() < 1e-8);
    }
}

#[test]
fn dense_and_fourier_agree() -> Result<(), Error> {
    let grid = Grid {
        nx: 33,
        ny: 37,
        dx: 2.0 / 33.0,
        dy: 2.2 / 37.0,
    };
    let bowl =
        |x: f64, y: f64| (x - 0.1).powi(2) + 1.4 * y * y + 0.2 * (7.0 * x).sin() * (5.0 * y).cos();
    let gap = field(&grid, bowl);
    for (load, moments) in [
        (Load::Force(0.4), [None, None]),
        (Load::Force(9.0), [None, None]),
        (Load::Approach(0.8), [None, None]),
        (Load::Force(1.0), [Some(0.3), None]),
        (Load::Force(1.0), [Some(-0.2), Some(0.25)]),
    ] {
        let dense = run(grid, &gap, load, moments, Method::Dense)?;
        let fourier = run(grid, &gap, load, moments, Method::Fourier)?;
        assert_same(&fourier, &dense);
    }
    Ok(())
}

#[test]
fn force_and_approach_are_two_sides_of_one_contact() -> Result<(), Error> {
    let grid = Grid {
        nx: 64,
        ny: 64,
        dx: 1.0 / 32.0,
        dy: 1.0 / 32.0,
    };
    let gap = field(&grid, |x, y| x * x + y * y);
    let by_force = run(grid, &gap, Load::Force(0.3), [None, None], Method::Auto)?;
    let by_approach = run(
        grid,
        &gap,
        Load::Approach(by_force.approach),
        [None, None],
        Method::Auto,
    )?;
    assert_same(&by_approach, &by_force);
    Ok(())
}

#[test]
fn a_flat_top_carries_at_any_approach_what_it_carries_under_the_force() -> Result<(), Error> {
    for n in [64, 65, 97, 128, 129] {
        let h = 2.0 / n as f64;
        let grid = Grid::new(n, n, h, h)?;
        // beside the top the gap is up to 1e12 times the displacements
        let gap = field(&grid, |x, y| (x * x + y * y - 0.16).max(0.0));
        for force in [1.0, 1e-3, 1e-6, 1e-9, 1e-12] {
            let by_force = run(
                grid,
                &gap,
                Load::Force(force),
                [None, None],
                Method::Fourier,
            )?;
            let by_approach = run(
                grid,
                &gap,
                Load::Approach(by_force.approach),
                [None, None],
                Method::Fourier,
            )?;
            assert_same(&by_approach, &by_force);
        }
    }
    Ok(())
}

#[test]
fn a_plane_gap_over_a_period_is_solved_by_either_method() -> Result<(), Error> {
    let layered = |k: f64| 0.3 + wave(k);
    let (alone, with_layer): (Surface<'_>, Surface<'_>) =
        (Surface::Periodic(&wave), Surface::Periodic(&layered));
    for (surface, mean) in [(alone, 0.0), (with_layer, 0.3)] {
        for (nx, ny) in [(1, 2), (7, 1), (5, 5), (13, 17), (40, 36)] {
            let grid = Grid::new(nx, ny, 0.1, 0.3)?;
            for height in [0.0, 0.7] {
                for method in [Method::Dense, Method::Fourier] {
                    let contact = NormalContact {
                        gap: &vec![height; grid.points()],
                        grid,
                        surface,
                        load: Load::Force(2.0),
                        moments: [None, None],
                        hardness: None,
                        rough: None,
                        start: None,
                    };
                    let options = Options {
                        tolerance: Some(1e-10),
                        method,
                    };
                    let found = solve_normal(&contact, options, &unmonitored)?;
                    assert_eq!(found.status, Status::Solved, "{nx} {ny} {method:?}");
                    let exact = 2.0 / (grid.cell_area() * grid.points() as f64);
                    for p in &found.pressure {
                        assert!((p / exact - 1.0).abs() < 1e-13, "{p} {exact}");
                    }
                    // beside what a wave of that pressure, as long as a cell, would move
                    let scale = height + (mean + wave(2.0 * PI / grid.dx)) * exact;
                    let wrong = found.approach - (height + mean * exact);
                    assert!(
                        wrong.abs() < 1e-13 * scale,
                        "{nx} {ny} {method:?} {height} {mean} {wrong}"
                    );
                }
            }
        }
    }
    Ok(())
}

#[test]
fn counts_do_not_grow_with_the_grid() -> Result<(), Error> {
    for n in [32, 64, 128, 256] {
        let h = 2.0 / n as f64;
        let grid = Grid {
            nx: n,
            ny: n,
            dx: h,
            dy: h,
        };
        let surface = Surface::FreeSpace(&influence);
        let options = Options {
            tolerance: Some(1e-8),
            method: Method::Fourier,
        };
        // [Johnson1985, ch. 4]: p0 = 1, a = 0.75
        let curved = field(&grid, |x, y| (x * x + y * y) * PI * PI / 3.0);
        let flat = vec![0.0; grid.points()];
        for (gap, force, limit) in [(&curved, 2.0 / 3.0 * PI * 0.5625, 11.0), (&flat, 1.0, 13.0)] {
            let load = Load::Force(force);
            let contact = NormalContact {
                gap,
                grid,
                surface,
                load,
                moments: [None, None],
                hardness: None,
                rough: None,
                start: None,
            };
            let found = solve_normal(&contact, options, &unmonitored)?;
            assert_eq!(found.status, Status::Solved);
            assert!(
                found.products < limit,
                "{n} {} {:?}",
                found.products,
                found.history
            );
            assert!(
                found.preconditionings < limit,
                "{n} {}",
                found.preconditionings
            );
        }
    }
    Ok(())
}

#[test]
fn a_start_near_by_saves_work_and_changes_nothing() -> Result<(), Error> {
    let n = 64;
    let h = 2.0 / n as f64;
    let grid = Grid {
        nx: n,
        ny: n,
        dx: h,
        dy: h,
    };
    let gap = field(&grid, |x, y| (x * x + y * y) * PI * PI / 3.0);
    let zero = vec![0.0; grid.points()];
    let run = |load, start| {
        let contact = NormalContact {
            gap: &gap,
            grid,
            surface: Surface::FreeSpace(&influence),
            load,
            moments: [None, None],
            hardness: None,
            rough: None,
            start,
        };
        let options = Options {
            tolerance: Some(1e-10),
            method: Method::Fourier,
        };
        solve_normal(&contact, options, &unmonitored)
    };
    let force = 2.0 / 3.0 * PI * 0.5625;
    let near = run(Load::Force(0.99 * force), None)?;
    let approach = run(Load::Force(force), None)?.approach;
    for load in [Load::Force(force), Load::Approach(approach)] {
        let cold = run(load, None)?;
        let warm = run(load, Some(&near.pressure))?;
        assert_eq!(warm.status, Status::Solved);
        let work = |found: &NormalSolution| (found.products, found.preconditionings);
        assert!(warm.products < cold.products && warm.preconditionings < cold.preconditionings);
        let most = cold.pressure.iter().copied().fold(0.0, f64::max);
        for (a, b) in warm.pressure.iter().zip(&cold.pressure) {
            assert!((a - b).abs() < 1e-8 * most);
        }
        assert_eq!(warm.discretisation_error, None);
        // one that presses nowhere is none
        assert_eq!(work(&run(load, Some(&zero))?), work(&cold));
        let short = run(load, Some(&zero[1..]));
        assert!(matches!(short, Err(Error::Shape { name: "start", .. })));
    }
    Ok(())
}

#[test]
fn whenever_it_is_asked_to_stop_it_stops() {
    use std::cell::Cell;
    use std::ops::ControlFlow;

    let n = 400;
    let grid = Grid {
        nx: n,
        ny: n,
        dx: 2.0 / n as f64,
        dy: 2.0 / n as f64,
    };
    let gap = field(&grid, |x, y| (x * x + y * y) * PI * PI / 3.0);
    let contact = NormalContact {
        gap: &gap,
        grid,
        surface: Surface::FreeSpace(&influence),
        load: Load::Force(1.0),
        moments: [None, None],
        hardness: None,
        rough: None,
        start: None,
    };
    let options = Options {
        tolerance: Some(1e-6),
        method: Method::Fourier,
    };
    let asked = Cell::new(0_usize);
    let stopped_at = |last: usize| {
        asked.set(0);
        let monitor = |_: mtb_operator::Progress| {
            asked.set(asked.get() + 1);
            if asked.get() == last {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        };
        solve_normal(&contact, options, &monitor)
    };
    assert!(stopped_at(usize::MAX).is_ok());
    let looks = asked.get();
    for last in (1..=looks).step_by(1 + looks / 12).chain([looks]) {
        assert!(
            matches!(stopped_at(last), Err(Error::Interrupted)),
            "{last}"
        );
        assert_eq!(asked.get(), last, "it was asked again");
    }
}

#[test]
fn a_wave_pressed_flat_follows_westergaard() -> Result<(), Error> {
    // full contact: the pressure wave that flattens the surface wave, on the mean pressure
    let grid = Grid {
        nx: 32,
        ny: 16,
        dx: 1.0 / 32.0,
        dy: 1.0 / 16.0,
    };
    let gap = field(&grid, |x, _| 0.1 * (1.0 - (2.0 * PI * x).cos()));
    let contact = NormalContact {
        gap: &gap,
        grid,
        surface: Surface::Periodic(&wave),
        load: Load::Force(0.5),
        moments: [None, None],
        hardness: None,
        rough: None,
        start: None,
    };
    let options = Options {
        tolerance: Some(1e-12),
        method: Method::Auto,
    };
    let found = solve_normal(&contact, options, &unmonitored)?;
    assert_eq!(found.status, Status::Solved);
    let exact = field(&grid, |x, _| 0.5 + 0.1 * (2.0 * PI * x).cos());
    for (p, e) in found.pressure.iter().zip(&exact) {
        assert!((p - e).abs() < 1e-10);
    }
    Ok(())
}

/// A body of one's own: springs [m/Pa] under the cells that do not know of each other.
struct Springs(Vec<f64>);

impl Compliance for Springs {
    fn points(&self) -> usize {
        self.0.len()
    }

    fn add_displacement(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        traction: &[f64],
        displacement: &mut [f64],
    ) {
        if (observed, loaded) == (Component::Normal, Component::Normal) {
            for ((u, p), l) in displacement.iter_mut().zip(traction).zip(&self.0) {
                *u += scale * l * p;
            }
        }
    }
}

#[test]
fn a_body_of_ones_own_carries_what_its_springs_carry() -> Result<(), Error> {
    for n in [12, 40] {
        let h = 2.0 / n as f64;
        let grid = Grid::new(n, n + 4, h, h)?;
        let gap = field(&grid, |x, y| x * x + 1.5 * y * y);
        // three times as soft on one side as on the other
        let springs = Springs(field(&grid, |x, _| 2.0 + x));
        for method in [Method::Auto, Method::Dense, Method::Fourier] {
            for load in [Load::Approach(0.3), Load::Force(0.2)] {
                let contact = NormalContact {
                    gap: &gap,
                    grid,
                    surface: Surface::Body(&springs),
                    load,
                    moments: [None, None],
                    hardness: None,
                    rough: None,
                    start: None,
                };
                let options = Options {
                    tolerance: Some(1e-11),
                    method,
                };
                let found = solve_normal(&contact, options, &unmonitored)?;
                assert_eq!(found.status, Status::Solved);
                assert_eq!(found.discretisation_error, None);
                assert!(found.residual <= found.tolerance, "{}", found.residual);
                let (mut wrong, mut squares, mut count) = (0.0_f64, 0.0, 0.0);
                for ((p, g), l) in found.pressure.iter().zip(&gap).zip(&springs.0) {
                    let apart = g + l * p - found.approach;
                    wrong = wrong.max(if *p > 0.0 { apart.abs() } else { -apart });
                    squares += (l * p).powi(2);
                    count += f64::from(*p > 0.0);
                }
                let measured = wrong / (squares / count).sqrt();
                assert!((measured - found.residual).abs() < 1e-14 + 1e-6 * measured);
                let mut force = 0.0;
                for ((p, g), l) in found.pressure.iter().zip(&gap).zip(&springs.0) {
                    let exact = ((found.approach - g) / l).max(0.0);
                    assert!((p - exact).abs() < 1e-9, "{p} {exact}");
                    force += p * h * h;
                }
                match load {
                    Load::Approach(approach) => assert_eq!(found.approach, approach),
                    Load::Force(wanted) => assert!((force / wanted - 1.0).abs() < 1e-10),
                }
            }
        }
    }
    let few = Springs(vec![1.0; 3]);
    let grid = Grid::new(2, 2, 1.0, 1.0)?;
    let contact = NormalContact {
        gap: &[0.0; 4],
        grid,
        surface: Surface::Body(&few),
        load: Load::Force(1.0),
        moments: [None, None],
        hardness: None,
        rough: None,
        start: None,
    };
    let options = Options {
        tolerance: None,
        method: Method::Auto,
    };
    assert!(matches!(
        solve_normal(&contact, options, &unmonitored),
        Err(Error::Shape {
            name: "surface",
            expected: 4,
            found: 3
        })
    ));
    Ok(())
}

/// [Johnson1985, section 4.2]
#[test]
fn two_bodies_as_a_compliance_follow_hertz() {
    let (radius, force, n, h) = (0.05, 60.0, 48, 1.5e-5);
    let grid = Grid::new(n, n, h, h).unwrap();
    let material = |ratio: f64| Material::new(80e9, ratio).unwrap();
    let body = |ratio| -> Option<Arc<dyn Compliance>> {
        Some(Arc::new(HalfSpace::new(material(ratio), grid).unwrap()))
    };
    let pair = Relative::new(body(0.3), body(0.1)).unwrap();
    let gap = field(&grid, |x, y| (x * x + y * y) / (2.0 * radius));
    let contact = NormalContact {
        gap: &gap,
        grid,
        surface: Surface::Body(&pair),
        load: Load::Force(force),
        moments: [None, None],
        hardness: None,
        rough: None,
        start: None,
    };
    let options = Options {
        tolerance: Some(1e-9),
        method: Method::Fourier,
    };
    let found = solve_normal(&contact, options, &unmonitored).unwrap();
    assert_eq!(found.status, Status::Solved);
    let modulus = 1.0
        / [0.3, 0.1]
            .map(|nu| (1.0 - nu) / (2.0 * 80e9))
            .iter()
            .sum::<f64>();
    let a = (0.75 * force * radius / modulus).cbrt();
    let peak = found.pressure.iter().copied().fold(0.0, f64::max);
    assert!(
        (peak / (1.5 * force / (PI * a * a)) - 1.0).abs() < 0.01,
        "{peak}"
    );
    assert!((found.approach / (a * a / radius) - 1.0).abs() < 0.005);
    // the rough inverse of its middle is a good one
    assert!(found.iterations < 20, "{}", found.iterations);
}

#[test]
fn bad_input_is_named() {
    let grid = Grid {
        nx: 2,
        ny: 2,
        dx: 1.0,
        dy: 1.0,
    };
    let bad = run(
        grid,
        &[0.0; 3],
        Load::Force(1.0),
        [None, None],
        Method::Auto,
    );
    assert!(matches!(
        bad,
        Err(Error::Shape {
            name: "gap",
            expected: 4,
            found: 3
        })
    ));
    let bad = run(
        grid,
        &[0.0; 4],
        Load::Force(-1.0),
        [None, None],
        Method::Auto,
    );
    assert!(matches!(bad, Err(Error::Number { name: "force", .. })));
    let bad = run(
        grid,
        &[0.0, f64::NAN, 0.0, 0.0],
        Load::Force(1.0),
        [None, None],
        Method::Auto,
    );
    assert!(matches!(
        bad,
        Err(Error::NotFinite {
            name: "gap",
            index: 1,
            ..
        })
    ));
}

/// Numbers about one and of every size, also those that are none.
fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![6 => 0.01..2.0_f64, 1 => -1.0..1.0_f64, 1 => prop::num::f64::ANY]
}

proptest! {
    #![proptest_config(ProptestConfig::default())]

    #[test]
    fn any_input_is_solved_or_refused(
        (nx, ny) in (0..9_usize, 1..9_usize),
        gap in prop::collection::vec(prop_oneof![40 => 0.0..1.0_f64, 1 => any_number()], 64),
        sides in prop::array::uniform2(any_number()),
        load in (any::<bool>(), any_number()),
        moments in prop::array::uniform2(prop::option::weighted(0.2, any_number())),
        method in prop_oneof![Just(Method::Auto), Just(Method::Dense), Just(Method::Fourier)],
    ) {
        let grid = Grid { nx, ny, dx: sides[0], dy: sides[1] };
        let gap = &gap[..(nx * ny).min(gap.len())];
        let by = if load.0 { Load::Force(load.1) } else { Load::Approach(load.1) };
        if let Ok(found) = run(grid, gap, by, moments, method)
            && found.status == Status::Solved
        {
            let moderate = |v: f64| v.abs() < 1e30 && (v == 0.0 || v.abs() > 1e-30);
            let all = gap.iter().chain(&sides).chain(moments.iter().flatten()).chain([&load.1]);
            // beyond what the door of the package lets in, sums of squares overflow
            if all.copied().all(moderate) {
                prop_assert!(found.pressure.iter().all(|p| p.is_finite() && *p >= 0.0));
                prop_assert!(found.gap.iter().all(|g| g.is_finite()));
                prop_assert!(found.approach.is_finite() && found.residual.is_finite());
            }
        }
    }
}
