// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bodies of one's own and several loads at once, against statics, a closed form, and numbers of Python.

use mtb::geometry::Interpolation;
use mtb::geometry::solid::{self, Filling, RailSection};
use mtb::{
    BlockOnPlane, Body, BodyOnPlane, Contact, Error, Friction, Grid, Held, Hold, Load, Material,
    PoleShoeOnRail, Profile, Rail, STEEL, State, Support, descent, half_spaces, tilts, unmonitored,
};

/// Force [N] up, and moments [N m] about x and y, by the pressure on the body above.
fn carried(contact: &Contact, state: &State) -> [f64; 3] {
    let g = contact.problem.geometry();
    let n = contact.points();
    let mut sum = [0.0; 3];
    for i in 0..n {
        // of each hat, not the mean over its point
        let force = g.area[i] * state.outcome.solution.pressure[i];
        sum[0] += force;
        sum[1] += force * g.points[n + i];
        sum[2] -= force * g.points[i];
    }
    sum
}

fn assert_close(found: f64, expected: f64, tolerance: f64) {
    assert!(
        (found - expected).abs() <= tolerance * expected.abs(),
        "{found} is not {expected}"
    );
}

#[test]
fn own_body_without_lateral_strain_is_a_bar() {
    // E d / h, uniform, for Poisson's ratio 0
    let (size, approach) = ([0.04, 0.03, 0.02], 1e-6);
    let cork = Material {
        shear_modulus: 1e9,
        poisson_ratio: 0.0,
    };
    let even = |extent: f64, cells: u32| -> Vec<f64> {
        (0..=cells)
            .map(|k| (f64::from(k) / f64::from(cells) - 0.5) * extent)
            .collect()
    };
    let (x, y) = (even(size[0], 8), even(size[1], 6));
    let mesh = solid::block(&x, &y, size[2], Filling::default()).unwrap();
    let top: Vec<usize> = (0..mesh.nodes.len())
        .filter(|i| mesh.nodes[*i][2] > size[2] - 1e-9)
        .collect();
    let own = BodyOnPlane {
        mesh,
        material: cork,
        supports: vec![Support {
            name: "glued".to_owned(),
            nodes: top,
            hold: [Hold::Prescribed; 3],
        }],
        face: [size[0], size[1]],
        spacing: [0.005; 2],
        lower: None,
    };
    let contact = own.stand(&unmonitored).unwrap();
    let state = contact
        .press(&[Load::Approach(approach)], &unmonitored)
        .unwrap();
    // hats are integrated by points between which edges of elements run, which costs some 0.2 % at a point
    let bar = 2e9 * approach / size[2];
    for pressure in &state.pressure {
        assert_close(*pressure, bar, 5e-3);
    }
    assert_close(-state.outcome.force[2], bar * size[0] * size[1], 2e-4);
}

#[test]
fn half_spaces_carry_a_force_and_moments() {
    let grid = Grid::new(30, 24, 0.5e-3, 0.5e-3).unwrap();
    let [about_x, about_y] = tilts(grid);
    let motions = vec![descent(grid.points()), about_x, about_y];
    let gap = |x: f64, y: f64| 0.5 * (x * x / 1.0 + y * y / 0.7);
    let contact = half_spaces(Some(STEEL), Some(STEEL), grid, gap, motions).unwrap();
    let loads = [
        Load::Force(600.0),
        Load::Moments([0.2, 0.0]),
        Load::Moments([0.0, -0.3]),
    ];
    let state = contact.press(&loads, &unmonitored).unwrap();
    let [force, about_x, about_y] = carried(&contact, &state);
    assert_close(force, 600.0, 1e-9);
    assert_close(about_x, -0.2, 1e-9);
    assert_close(about_y, 0.3, 1e-9);
}

#[test]
fn moments_need_a_body_that_tilts() {
    let grid = Grid::new(8, 8, 1e-3, 1e-3).unwrap();
    let contact = half_spaces(Some(STEEL), None, grid, |_, _| 0.0, vec![descent(64)]).unwrap();
    let error = contact
        .press(&[Load::Force(1.0), Load::Moments([0.0, 1.0])], &unmonitored)
        .unwrap_err();
    assert!(error.to_string().contains("tilt about y"), "{error}");
}

#[test]
fn an_approach_needs_bodies_that_stay_or_are_pressed() {
    // its top moves freely along z
    let contact = standing();
    let loads = [Load::Approach(1e-6)];
    let refused = Error::Contact(mtb::contact::Error::GivesWay { approach: 1e-6 });
    let error = contact.press(&loads, &unmonitored).unwrap_err();
    assert_eq!(error, refused);
    assert!(error.to_string().contains("approach is 1e-06 m"), "{error}");
    // a pull or a force sets the pressure then, and the approach would change nothing
    let pull = vec![1e6; contact.points()];
    for other in [Load::Pull(&pull, Body::Upper), Load::Force(200.0)] {
        for loads in [[Load::Approach(1e-6), other], [other, Load::Approach(1e-6)]] {
            assert_eq!(contact.press(&loads, &unmonitored).unwrap_err(), refused);
            let slid = contact.slide(&loads, [1.0, 0.0], Friction::Field(&pull), &unmonitored);
            assert_eq!(slid.unwrap_err(), refused);
        }
    }
    let clamped = BlockOnPlane {
        held: Held::ClampedTop,
        ..block()
    };
    let clamped = clamped.stand(&unmonitored).unwrap();
    let both = [Load::Approach(1e-6), Load::Pull(&pull, Body::Upper)];
    let [one, two] = [&both[..1], &both].map(|loads| {
        let state = clamped.press(loads, &unmonitored).unwrap();
        carried(&clamped, &state)[0]
    });
    assert!(two > 1.1 * one, "{two} {one}");
    let grid = Grid::new(8, 8, 1e-3, 1e-3).unwrap();
    let free = half_spaces(Some(STEEL), None, grid, |_, _| 0.0, vec![descent(64)]).unwrap();
    let loads = [Load::Approach(1e-6)];
    assert_eq!(free.press(&loads, &unmonitored).unwrap_err(), refused);
    let ball = |x: f64, y: f64| x * x + y * y;
    let held = half_spaces(Some(STEEL), None, grid, ball, Vec::new()).unwrap();
    assert!(held.press(&loads, &unmonitored).unwrap().peak_pressure() > 0.0);
}

#[test]
fn a_profile_much_wider_than_the_foot_is_no_elastic_rail() {
    let wide = Profile::from_points(&[-0.2, 0.0, 0.2], &[0.0; 3], Interpolation::Linear).unwrap();
    let mut shoe = PoleShoeOnRail {
        lower: Rail::Elastic {
            material: STEEL,
            section: RailSection::default(),
            length: 0.18,
        },
        spacing: [6e-3; 2],
        ..PoleShoeOnRail::default()
    };
    shoe.shoe.rail = wide;
    shoe.shoe.relief_slope = 0.1;
    let error = shoe.stand(&unmonitored).err().unwrap().to_string();
    assert!(error.contains("takes heads up to 0.1 m"), "{error}");
}

/// A block of 60 x 40 x 30 mm whose top keeps its place along x and y.
fn block() -> BlockOnPlane {
    BlockOnPlane {
        size: [0.06, 0.04, 0.03],
        spacing: [0.01; 2],
        held: Held::DrivenTop,
        upper: STEEL,
        lower: Some(STEEL),
    }
}

fn standing() -> Contact {
    block().stand(&unmonitored).unwrap()
}

#[test]
fn elastic_block_carries_a_force_moments_and_a_pull() {
    let contact = standing();
    let pull = vec![1e6; contact.points()];
    let loads = [
        Load::Force(2000.0),
        Load::Moments([5.0, -8.0]),
        Load::Pull(&pull, Body::Upper),
    ];
    let state = contact.press(&loads, &unmonitored).unwrap();
    let [force, about_x, about_y] = carried(&contact, &state);
    assert_close(force, 2000.0 + 1e6 * 0.06 * 0.04, 1e-9);
    assert_close(about_x, -5.0, 1e-6);
    assert_close(about_y, 8.0, 1e-6);
}

#[test]
fn two_poles_carry_a_force_and_a_moment_in_shares() {
    // about y only: on a crowned rail the tops take a part of what turns about x
    let shoe = PoleShoeOnRail {
        spacing: [6e-3; 2],
        ..PoleShoeOnRail::default()
    };
    let contact = shoe.stand(&unmonitored).unwrap();
    let turned_by = |moment: f64| {
        let loads = [Load::Force(2e4), Load::Moments([0.0, moment])];
        let state = contact.press(&loads, &unmonitored).unwrap();
        [-state.outcome.force[2], state.outcome.moment[1]]
    };
    let (plain, turned) = (turned_by(0.0), turned_by(20.0));
    assert_close(plain[0], 2e4, 1e-6);
    assert_close(turned[0], 2e4, 1e-6);
    assert_close(turned[1] - plain[1], 20.0, 1e-6);
}

#[test]
fn elastic_block_under_a_force_and_moments_is_that_of_python() {
    // import numpy as np, mtb_rs as mtb
    // from mtb_rs.bodies.mesh import block_mesh
    // x, y = (np.arange(7) / 6 - 0.5) * 0.06, (np.arange(5) / 4 - 0.5) * 0.04
    // block = mtb.ElasticBody(
    //     block_mesh(x, y, 0.03), mtb.steel, "contact", [mtb.Support("top", x=0, y=0)]
    // )
    // for friction in (0.0, 0.2):
    //     scene = mtb.Scene(
    //         upper=block, lower=mtb.steel, friction=friction, spacing=0.01, force=4400.0, moments=(5.0, -8.0)
    //     )
    //     pressure = scene.solve().pressure
    //     print(pressure.max(), pressure.min())
    let contact = standing();
    let loads = [Load::Force(4400.0), Load::Moments([5.0, -8.0])];
    for (coefficient, most, least) in [
        (0.0, 3_081_252.455_637, 1_396_295.426_229),
        (0.2, 3_892_071.476_662, 1_088_503.340_832),
    ] {
        let friction = vec![coefficient; contact.points()];
        let friction = Friction::Field(&friction);
        let state = contact
            .slide(&loads, [1.0, 0.0], friction, &unmonitored)
            .unwrap();
        let smallest = state.pressure.iter().copied().fold(f64::INFINITY, f64::min);
        assert_close(state.peak_pressure(), most, 1e-9);
        assert_close(smallest, least, 1e-9);
    }
}
