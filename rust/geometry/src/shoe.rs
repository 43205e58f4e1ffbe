// SPDX-License-Identifier: MIT OR Apache-2.0
//! The pole shoe of a magnetic track brake, worn to the shape of its rail.

use crate::contact_points::{ContactPoint, MOST_CELLS, cell_count};
use crate::error::{finite, out_of_range, positive};
use crate::{ContactGrid, ContactPoints, Error, GridPatch, Profile};
use mtb_words::{Rough, Short};

/// A pole shoe on a rail: one or two poles, each worn to the side of the rail that it stands on.
///
/// In its own frame the sole of a pole follows the rail for `inner_edge <= |y| <= conforming_to`
/// and rises from there in a straight line of slope `relief_slope` to `outer_edge`. The poles are
/// mirror images where the rail is symmetric. The frame is
/// turned by `yaw` about z and then moved by `lateral` along y. Away from that centred place the
/// sole no longer conforms; each pole is then lowered or lifted until it just touches the rail
/// [Steininger2025, 3.1.2].
#[derive(Clone, Debug)]
pub struct PoleShoe {
    /// Head of the rail, crown at y = 0.
    pub rail: Profile,
    /// Extent along x [m].
    pub length: f64,
    /// Inner edge of a pole, |y| [m].
    pub inner_edge: f64,
    /// End of the conforming strip, |y| [m].
    pub conforming_to: f64,
    /// Outer edge of a pole, |y| [m].
    pub outer_edge: f64,
    /// dz/d|y| of the sole beyond `conforming_to` [-].
    pub relief_slope: f64,
    /// 1 (the left one, y > 0) or 2.
    pub poles: usize,
    /// Offset along y [m].
    pub lateral: f64,
    /// Rotation about z [rad].
    pub yaw: f64,
}

impl PoleShoe {
    /// Lays contact points over the conforming strip of every pole.
    ///
    /// The cells are regular in the shoe's own x and in the arc length of its sole, as near to
    /// `spacing` as whole numbers of them allow, so they fill the strip exactly; their points lie
    /// vertically below the sole on the rail, and their first tangent lies along the shoe. Both poles have
    /// as many cells; on a rail that is not symmetric those of one are wider. For the centred shoe
    /// the grid is regular in the rail's x and arc length, and the gap is exactly zero.
    ///
    /// # Errors
    /// Edges out of order, values that are not finite or not positive, a shoe that reaches beyond
    /// the head of the rail.
    ///
    /// # Example
    /// ```
    /// # use mtb_geometry::{PoleShoe, Profile};
    /// let shoe = PoleShoe {
    ///     rail: Profile::rail_60e1(),
    ///     length: 90e-3, inner_edge: 6e-3, conforming_to: 21.6e-3, outer_edge: 36e-3,
    ///     relief_slope: 0.02, poles: 2, lateral: 0.0, yaw: 0.0,
    /// };
    /// let grid = shoe.grid([3e-3, 3e-3]).unwrap();
    /// assert_eq!((grid.patches[0].nx, grid.patches[0].ny), (30, 5));
    /// assert!(grid.cells.gap.iter().all(|&g| g == 0.0));
    /// ```
    pub fn grid(&self, spacing: [f64; 2]) -> Result<ContactGrid, Error> {
        self.check()?;
        let dx = positive("spacing along x", spacing[0])?;
        let ds = positive("spacing across", spacing[1])?;
        let strips = self
            .sides()
            .iter()
            .map(|pole| self.strip(*pole))
            .collect::<Result<Vec<_>, _>>()?;
        let width = strips.iter().map(|s| s[1] - s[0]).fold(0.0, f64::max);
        if self.length / dx * (width / ds) > MOST_CELLS {
            return Err(out_of_range(
                "spacing",
                dx.min(ds),
                format!(
                    "it would take more than {} cells per pole",
                    Rough(MOST_CELLS)
                ),
            ));
        }
        let (nx, ny) = (cell_count(self.length, dx), cell_count(width, ds));
        let mut cells = Vec::new();
        let mut nodes = Vec::new();
        let mut patches = Vec::new();
        let mut areas = Vec::new();
        for (pole, [first, last]) in self.sides().iter().zip(strips) {
            let spacing = [self.length / nx as f64, (last - first) / ny as f64];
            let origin = [-0.5 * self.length, first];
            let grid = |axis: usize, n: usize, shift: f64| -> Vec<f64> {
                (0..n)
                    .map(|i| origin[axis] + spacing[axis] * (i as f64 + shift))
                    .collect()
            };
            let of_cells = self.points(*pole, &grid(0, nx, 0.5), &grid(1, ny, 0.5))?;
            let of_nodes = self.points(*pole, &grid(0, nx + 1, 0.0), &grid(1, ny + 1, 0.0))?;
            let drop = of_cells
                .iter()
                .chain(&of_nodes)
                .map(|p| p.gap)
                .fold(f64::INFINITY, f64::min);
            patches.push(GridPatch {
                nx,
                ny,
                start: cells.len(),
                node_start: nodes.len(),
                spacing,
                origin,
            });
            areas.extend(vec![spacing[0] * spacing[1]; of_cells.len()]);
            cells.extend(of_cells.iter().map(|p| self.settled(*pole, *p, drop)));
            nodes.extend(of_nodes.iter().map(|p| self.settled(*pole, *p, drop)));
        }
        Ok(ContactGrid {
            areas,
            cells: ContactPoints::new(&cells),
            nodes: ContactPoints::new(&nodes),
            patches,
        })
    }

    /// Sides of the rail with a pole: 1 for y > 0, -1 for y < 0.
    fn sides(&self) -> &'static [f64] {
        &[1.0, -1.0][..self.poles]
    }

    /// Arc lengths [m] at which the conforming strip of a pole begins and ends, rising with y.
    fn strip(&self, pole: f64) -> Result<[f64; 2], Error> {
        let edges = [self.inner_edge, self.conforming_to].map(|e| pole * e);
        let ends = self.rail.arc_length(&edges)?;
        Ok([ends[0].min(ends[1]), ends[0].max(ends[1])])
    }

    /// Height of the sole of a pole [m] in the shoe's frame at `y`, and its slope.
    ///
    /// The rail's shape goes on inside the inner edge, the relief beyond the outer one.
    pub fn sole(&self, pole: f64, y: f64) -> Option<(f64, f64)> {
        let beyond = pole * y - self.conforming_to;
        if beyond <= 0.0 {
            return self.rail.at(y).map(|s| (s.height, s.slope));
        }
        let end = self.rail.at(pole * self.conforming_to)?;
        let height = end.height + self.relief_slope * beyond;
        Some((height, pole * self.relief_slope))
    }

    /// Height and gradient of the sole of one pole in the common frame, before it is lowered.
    fn sole_at(&self, pole: f64, x: f64, y: f64) -> Option<(f64, [f64; 2])> {
        let (sin, cos) = self.yaw.sin_cos();
        let across = -sin * x + cos * (y - self.lateral);
        let (height, slope) = self.sole(pole, across)?;
        Some((height, [-sin * slope, cos * slope]))
    }

    /// Points of the rail vertically below those of the sole, with the vertical gap.
    fn points(&self, pole: f64, x: &[f64], s: &[f64]) -> Result<Vec<ContactPoint>, Error> {
        let (sin, cos) = self.yaw.sin_cos();
        let across = self.rail.position(s)?;
        let mut points = Vec::with_capacity(x.len() * s.len());
        let centred = self.yaw == 0.0 && self.lateral == 0.0;
        for (&across, &s) in across.iter().zip(s) {
            for &along in x {
                let x = cos * along - sin * across;
                let y = self.lateral + sin * along + cos * across;
                let Some(rail) = self.rail.at(y) else {
                    return Err(beyond(&self.rail, y));
                };
                let (sole, _) = self
                    .sole(pole, across)
                    .ok_or_else(|| beyond(&self.rail, across))?;
                points.push(ContactPoint {
                    position: [x, y, rail.height],
                    normal: [0.0, rail.normal()[0], rail.normal()[1]],
                    along: [cos, sin],
                    arc_length: if centred {
                        s
                    } else {
                        self.rail.arc_length(&[y])?[0]
                    },
                    gap: if centred { 0.0 } else { sole - rail.height },
                });
            }
        }
        Ok(points)
    }

    /// The point with its gap along the normal of the rail once the pole is lowered by `drop`.
    fn settled(&self, pole: f64, point: ContactPoint, drop: f64) -> ContactPoint {
        let [x, y, z] = point.position;
        let n = point.normal;
        let mut gap = 0.0;
        let mut above = point.gap - drop;
        // Newton on height(point + gap n) = 0; the sole is nearly parallel, so it takes a few steps
        for _ in 0..20 {
            let Some((_, gradient)) = self.sole_at(pole, x, y + gap * n[1]) else {
                break;
            };
            let step = above / (n[2] - gradient[1] * n[1]);
            gap += step;
            if step.abs() <= 1e-15 {
                break;
            }
            let Some((sole, _)) = self.sole_at(pole, x, y + gap * n[1]) else {
                break;
            };
            above = sole - drop - (z + gap * n[2]);
        }
        ContactPoint { gap, ..point }
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        positive("length", self.length)?;
        for (name, value) in [
            ("inner_edge", self.inner_edge),
            ("conforming_to", self.conforming_to),
            ("outer_edge", self.outer_edge),
            ("relief_slope", self.relief_slope),
            ("lateral", self.lateral),
            ("yaw", self.yaw),
        ] {
            finite(name, value)?;
        }
        if self.inner_edge < 0.0 {
            let accepted = "it is a distance from the middle and must not be negative";
            return Err(out_of_range("inner_edge", self.inner_edge, accepted));
        }
        if self.conforming_to <= self.inner_edge {
            let accepted = format!(
                "it must lie beyond inner_edge = {} m",
                Short(self.inner_edge)
            );
            return Err(out_of_range("conforming_to", self.conforming_to, accepted));
        }
        if self.outer_edge < self.conforming_to {
            let accepted = format!(
                "it must not lie inside conforming_to = {} m",
                Short(self.conforming_to)
            );
            return Err(out_of_range("outer_edge", self.outer_edge, accepted));
        }
        if !(1..=2).contains(&self.poles) {
            return Err(out_of_range(
                "poles",
                self.poles as f64,
                "a shoe has 1 or 2 poles",
            ));
        }
        let [right, left] = self.rail.range();
        for pole in self.sides() {
            let half_width = if *pole > 0.0 { left } else { -right };
            for (name, value) in [
                ("conforming_to", self.conforming_to),
                ("outer_edge", self.outer_edge),
            ] {
                if value > half_width {
                    let accepted = format!("the head of the rail ends at {} m", Short(half_width));
                    return Err(out_of_range(name, value, accepted));
                }
            }
        }
        if self.relief_slope < 0.0 {
            let accepted = "at least 0 is needed, because the sole rises beyond conforming_to";
            return Err(out_of_range("relief_slope", self.relief_slope, accepted));
        }
        for pole in self.sides() {
            let end = self.rail.at(pole * self.conforming_to);
            let end_slope = end.map_or(0.0, |s| pole * s.slope);
            if self.relief_slope <= end_slope {
                let accepted = format!(
                    "it must exceed the rail's own slope {} at conforming_to, \
                     or the sole would cut into the rail",
                    Short(end_slope)
                );
                return Err(out_of_range("relief_slope", self.relief_slope, accepted));
            }
        }
        if self.yaw.abs() > 0.5 {
            let accepted = "a yaw angle in radians within -0.5 .. 0.5 is accepted";
            return Err(out_of_range("yaw", self.yaw, accepted));
        }
        Ok(())
    }
}

fn beyond(rail: &Profile, y: f64) -> Error {
    let [start, end] = rail.range();
    out_of_range(
        "lateral",
        y,
        format!(
            "the sole would reach this y [m], beyond the head of the rail {} .. {} m",
            Short(start),
            Short(end)
        ),
    )
}
