// SPDX-License-Identifier: MIT OR Apache-2.0
use super::Profile;
use super::piece::{Curve, Piece};

impl Profile {
    /// Head of the rail 60E1 (UIC 60), uncanted, z = 0 at the crown, |y| <= 36 mm [EN13674-1].
    ///
    /// Arcs of radius 300, 80 and 13 mm joined tangentially at |y| = 10.228 and 26.027 mm; the last
    /// one ends where it meets the flank of slope 20:1.
    pub fn rail_60e1() -> Self {
        let mut right = Vec::new();
        let mut center = [0.0, -0.300];
        let mut radius = 0.300;
        let mut start = 0.0;
        for (next_radius, join) in [(0.080, 10.228e-3), (0.013, 26.027e-3), (0.0, f64::NAN)] {
            let sine = if next_radius > 0.0 {
                (join - center[0]) / radius
            } else {
                20.0 / 401.0_f64.sqrt()
            };
            let normal = [sine, (1.0 - sine * sine).sqrt()];
            let end = center[0] + radius * normal[0];
            let curve = Curve::Arc {
                center,
                radius,
                side: 1.0,
            };
            right.push(Piece::new(start, end, curve));
            for i in 0..2 {
                center[i] += (radius - next_radius) * normal[i];
            }
            radius = next_radius;
            start = end;
        }
        let mut pieces: Vec<Piece> = right.iter().rev().map(mirrored_arc).collect();
        pieces.extend(right);
        Self::from_pieces(pieces)
    }

    /// Wheel profile S1002 [EN13715], y from the tape circle, positive to the field side, flange
    /// negative; z up, so the flange hangs down.
    pub fn wheel_s1002() -> Self {
        let arc = |start: f64, end: f64, y: f64, z: f64, radius: f64, side: f64| {
            let curve = Curve::Arc {
                center: [1e-3 * y, -1e-3 * z],
                radius: 1e-3 * radius,
                side: -side,
            };
            Piece::new(1e-3 * start, 1e-3 * end, curve)
        };
        // coefficients of powers of y [mm] for z [mm] down
        let polynomial = |start: f64, end: f64, coefficients: &[f64]| {
            let mut scale = -1e-3;
            let coefficients = coefficients
                .iter()
                .map(|c| {
                    let scaled = c * scale;
                    scale *= 1e3;
                    scaled
                })
                .collect();
            let curve = Curve::Polynomial {
                origin: 0.0,
                coefficients,
            };
            Piece::new(1e-3 * start, 1e-3 * end, curve)
        };
        Self::from_pieces(vec![
            arc(-70.0, -62.764_705_882, -49.5, 9.519_259_302, 20.5, 1.0),
            arc(-62.764_705_882, -49.662_510_381, -55.0, 16.0, 12.0, 1.0),
            arc(
                -49.662_510_381,
                -39.763_574,
                -58.558_326_413,
                8.834_924_130,
                20.0,
                1.0,
            ),
            polynomial(
                -39.763_574,
                -38.426_669_071,
                &[-93.576_667_419, -2.747_477_419],
            ),
            arc(-38.426_669_071, -35.0, -26.210_665, 16.446, 13.0, -1.0),
            polynomial(
                -35.0,
                -26.0,
                &[
                    -4.320_221_063e3,
                    -1.038_384_026e3,
                    -1.065_501_873e2,
                    -6.051_367_875,
                    -2.054_332_446e-1,
                    -4.169_739_389e-3,
                    -4.687_195_829e-5,
                    -2.252_755_540e-7,
                ],
            ),
            polynomial(
                -26.0,
                32.157_96,
                &[
                    0.0,
                    -3.358_537_058e-2,
                    1.565_681_624e-3,
                    -2.810_427_944e-5,
                    5.844_240_864e-8,
                    -1.562_379_023e-8,
                    5.309_217_349e-15,
                    -5.957_839_843e-12,
                    2.646_656_573e-13,
                ],
            ),
            polynomial(32.157_96, 60.0, &[1.364_323_640, -0.066_666_667]),
        ])
    }
}

/// An arc mirrored about y = 0.
fn mirrored_arc(piece: &Piece) -> Piece {
    let mut mirrored = Piece::new(-piece.end, -piece.start, piece.curve.clone());
    if let Curve::Arc { center, .. } = &mut mirrored.curve {
        center[0] = -center[0];
    }
    mirrored
}
