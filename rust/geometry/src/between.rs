// SPDX-License-Identifier: MIT OR Apache-2.0
//! The contact points and the gap between two arbitrary surfaces.

use mtb_words::Short;
use rayon::prelude::*;

use crate::contact_points::{ContactPoint, cell_count};
use crate::error::{finite, out_of_range, positive};
use crate::{ContactGrid, ContactPoints, Error, Found, GridPatch, Look, Surface};

/// More points than this are taken for a mistake in the spacing.
const MOST_POINTS: f64 = 1e7;
/// Points between two looks at a wish to stop: a few tenths of a second.
const POINTS_UNWATCHED: usize = 20_000;
/// Share of the approach that the facets may be off.
const SMALL: f64 = 0.1;

/// Two bodies, placed in the common frame.
pub struct SurfacePair<'a> {
    /// The body below.
    pub lower: &'a dyn Surface,
    /// The body above.
    pub upper: &'a dyn Surface,
    /// Distance along the normal up to which the upper body is looked for [m].
    pub reach: f64,
}

/// The contact points between two surfaces, with what is known about its accuracy.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceGap {
    /// Points on the lower body and the gap along its normal; infinite where there is no upper body.
    pub grid: ContactGrid,
    /// Estimated error of the gap at the cell centres because bodies are known by facets only [m].
    pub facet_errors: Vec<f64>,
    /// Whether the normal misses the upper body, so that the gap is the distance of its nearest point.
    pub nearest: Vec<bool>,
}

struct Measured {
    point: ContactPoint,
    /// Normal of the lower body against the vertical.
    rise: f64,
    facet_error: f64,
    nearest: bool,
}

impl SurfacePair<'_> {
    /// Lays cells over the rectangle `x` by `y` [m] seen from above and measures the gap.
    ///
    /// The points lie vertically above the grid on the lower body; areas are those of its surface.
    /// With `approach` [m] the facets must be good enough for contact that deep.
    ///
    /// # Errors
    /// Bad ranges or spacing, a lower body that does not cover the rectangle, bodies that are nowhere
    /// within reach, [`Error::FacetsTooCoarse`] where contact is expected (gaps up to twice the
    /// approach above the least one).
    ///
    /// # Example
    /// ```
    /// use mtb_geometry::{HeightSurface, SurfacePair};
    /// let plane = HeightSurface::Plane { height: 0.0 };
    /// let ball = HeightSurface::Paraboloid { radii: [0.1, 0.1] };
    /// let pair = SurfacePair { lower: &plane, upper: &ball, reach: 0.01 };
    /// let gap = pair.grid([-1e-3, 1e-3], [-1e-3, 1e-3], [5e-4, 5e-4], None, &mtb_geometry::unwatched).unwrap();
    /// assert!((gap.grid.cells.gap[0] - 0.75e-3_f64.powi(2) / 0.1).abs() < 1e-15);
    /// ```
    pub fn grid(
        &self,
        x: [f64; 2],
        y: [f64; 2],
        spacing: [f64; 2],
        approach: Option<f64>,
        look: Look<'_>,
    ) -> Result<SurfaceGap, Error> {
        positive("reach", self.reach)?;
        let mut counts = [0; 2];
        let mut steps = [0.0; 2];
        for (i, (range, names)) in [
            (x, ["x from", "x to", "spacing along x"]),
            (y, ["y from", "y to", "spacing across"]),
        ]
        .into_iter()
        .enumerate()
        {
            finite(names[0], range[0])?;
            if finite(names[1], range[1])? <= range[0] {
                let accepted = format!("it must lie above {}", Short(range[0]));
                return Err(out_of_range(names[1], range[1], accepted));
            }
            counts[i] = cell_count(range[1] - range[0], positive(names[2], spacing[i])?);
            steps[i] = (range[1] - range[0]) / counts[i] as f64;
        }
        let [nx, ny] = counts.map(|count| count as f64);
        if nx * ny > MOST_POINTS {
            return Err(Error::TooManyPoints {
                nx,
                ny,
                dx: spacing[0],
                dy: spacing[1],
                most: MOST_POINTS,
            });
        }
        let [nx, ny] = counts;
        let line = |n: usize, shift: f64, start: f64, step: f64| -> Vec<f64> {
            (0..n).map(|i| start + step * (i as f64 + shift)).collect()
        };
        let cells = self.measure(
            &line(nx, 0.5, x[0], steps[0]),
            &line(ny, 0.5, y[0], steps[1]),
            look,
        )?;
        let nodes = self.measure(
            &line(nx + 1, 0.0, x[0], steps[0]),
            &line(ny + 1, 0.0, y[0], steps[1]),
            look,
        )?;
        let least = cells
            .iter()
            .map(|c| c.point.gap)
            .fold(f64::INFINITY, f64::min);
        if least == f64::INFINITY {
            return Err(Error::NeverTouch {
                reason: format!(
                    "the upper body is nowhere within {} m of the lower one",
                    Short(self.reach)
                ),
            });
        }
        if let Some(approach) = approach {
            let approach = positive("approach", approach)?;
            let worst = cells
                .iter()
                .filter(|c| c.point.gap <= least + 2.0 * approach)
                .max_by(|a, b| a.facet_error.total_cmp(&b.facet_error));
            if let Some(worst) = worst
                && worst.facet_error > SMALL * approach
            {
                return Err(Error::FacetsTooCoarse {
                    error: worst.facet_error,
                    approach,
                    x: worst.point.position[0],
                    y: worst.point.position[1],
                });
            }
        }
        let of = |measured: &[Measured]| {
            ContactPoints::new(&measured.iter().map(|m| m.point).collect::<Vec<_>>())
        };
        Ok(SurfaceGap {
            grid: ContactGrid {
                cells: of(&cells),
                nodes: of(&nodes),
                areas: cells.iter().map(|c| steps[0] * steps[1] / c.rise).collect(),
                patches: vec![GridPatch {
                    nx,
                    ny,
                    start: 0,
                    node_start: 0,
                    spacing: steps,
                    origin: [x[0], y[0]],
                }],
            },
            facet_errors: cells.iter().map(|c| c.facet_error).collect(),
            nearest: cells.iter().map(|c| c.nearest).collect(),
        })
    }

    /// The gap over every point of a grid, x fastest.
    fn measure(&self, x: &[f64], y: &[f64], look: Look<'_>) -> Result<Vec<Measured>, Error> {
        let count = x.len() * y.len();
        let mut measured = Vec::with_capacity(count);
        for start in (0..count).step_by(POINTS_UNWATCHED) {
            let round = (start..count.min(start + POINTS_UNWATCHED)).into_par_iter();
            let found: Vec<Measured> = round
                .map(|k| {
                    let (x, y) = (x[k % x.len()], y[k / x.len()]);
                    // on the last line of a body rounding decides, so look a hair inside as well
                    let below = self
                        .lower
                        .top(x, y)
                        .or_else(|| self.lower.top(x * INWARDS, y * INWARDS))
                        .ok_or(Error::NoSurface { x, y })?;
                    let position = [x, y, below.distance];
                    let above = self.upper.cast(position, below.normal, self.reach);
                    Ok(Measured {
                        point: ContactPoint {
                            position,
                            normal: below.normal,
                            along: [1.0, 0.0],
                            arc_length: y,
                            gap: above.map_or(f64::INFINITY, |hit| hit.distance),
                        },
                        rise: below.normal[2],
                        facet_error: below.facet_error * below.normal[2]
                            + above.map_or(0.0, |hit| hit.facet_error),
                        nearest: above.is_some_and(|hit| hit.found == Found::Nearest),
                    })
                })
                .collect::<Result<_, Error>>()?;
            measured.extend(found);
            if look().is_break() {
                return Err(Error::Interrupted);
            }
        }
        Ok(measured)
    }
}

/// Factor that moves a point a rounding error towards the origin.
const INWARDS: f64 = 1.0 - 1e-12;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Closure, HeightField, HeightSurface, PoleShoe, Profile, SurfaceMesh, unwatched};

    /// A height field over a square as an open mesh, looking down.
    fn facetted(n: usize, half: f64, f: impl Fn(f64, f64) -> f64) -> SurfaceMesh {
        let at = |i: usize| half * (2.0 * i as f64 / n as f64 - 1.0);
        let vertices = (0..(n + 1) * (n + 1))
            .map(|k| (at(k % (n + 1)), at(k / (n + 1))))
            .map(|(x, y)| [x, y, f(x, y)])
            .collect();
        let faces = (0..n * n)
            .flat_map(|k| {
                let a = k / n * (n + 1) + k % n;
                [[a, a + n + 1, a + 1], [a + 1, a + n + 1, a + n + 2]]
            })
            .collect();
        SurfaceMesh::new(vertices, faces, Closure::Open).unwrap()
    }

    #[test]
    fn mesh_on_curved_rail_converges_to_the_analytic_gap() {
        let rail = HeightSurface::Prism {
            profile: Profile::rail_60e1(),
            length: 0.1,
        };
        let shape =
            |x: f64, y: f64| 3.0 * x * x + 5.0 * y * y + 0.4 * x * y + 60.0 * x * y * y + 2e-4;
        // an analytic stand-in for the upper body: its own fine height field
        let heights: Vec<f64> = (0..321 * 321)
            .map(|k| {
                (
                    f64::from(k % 321) / 160.0 - 1.0,
                    f64::from(k / 321) / 160.0 - 1.0,
                )
            })
            .map(|(x, y)| shape(0.012 * x, 0.012 * y))
            .collect();
        let field = HeightField::new(&heights, [321, 321], [-0.012; 2], [0.024 / 320.0; 2]);
        let smooth = HeightSurface::Field(field.unwrap());
        let gap = |upper: &dyn Surface| {
            let pair = SurfacePair {
                lower: &rail,
                upper,
                reach: 5e-3,
            };
            pair.grid([-5e-3, 5e-3], [-5e-3, 5e-3], [1e-3, 1e-3], None, &unwatched)
                .unwrap()
        };
        let exact = gap(&smooth).grid.cells.gap;
        let error = |n: usize| {
            let found = gap(&facetted(n, 0.012, shape));
            assert!(found.nearest.iter().all(|&n| !n));
            exact
                .iter()
                .zip(&found.grid.cells.gap)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max)
        };
        // cubic terms are in the shape; what is left is the tilt of the fits' frames
        let (coarse, fine) = (error(10), error(20));
        assert!(
            coarse < 1e-7 && (coarse / fine).log2() > 3.5,
            "{coarse} {fine}"
        );
    }

    #[test]
    fn coarse_facets_are_refused_and_fine_ones_pass() {
        let plane = HeightSurface::Plane { height: 0.0 };
        let shape = |x: f64, y: f64| 0.08 - (0.08_f64 * 0.08 - x * x - y * y).sqrt();
        let grid = |n: usize| {
            let mesh = facetted(n, 0.03, shape);
            let pair = SurfacePair {
                lower: &plane,
                upper: &mesh,
                reach: 0.02,
            };
            pair.grid(
                [-2e-3, 2e-3],
                [-2e-3, 2e-3],
                [5e-4; 2],
                Some(1e-6),
                &unwatched,
            )
        };
        let error = grid(4).unwrap_err();
        assert!(matches!(error, Error::FacetsTooCoarse { .. }), "{error}");
        let fine = grid(30).unwrap();
        let exact = |x: f64, y: f64| shape(x, y);
        for (k, gap) in fine.grid.cells.gap.iter().enumerate() {
            let n = fine.grid.cells.len();
            let p = &fine.grid.cells.positions;
            assert!((gap - exact(p[k], p[n + k])).abs() < 1e-7);
        }
    }

    #[test]
    fn conforming_shoe_as_surfaces_has_no_gap() {
        // the sole of a pole shoe and the rail are the same prism
        let rail = HeightSurface::Prism {
            profile: Profile::rail_60e1(),
            length: 0.2,
        };
        let pair = SurfacePair {
            lower: &rail,
            upper: &rail,
            reach: 1e-3,
        };
        let flat = pair.grid(
            [-45e-3, 45e-3],
            [6e-3, 21.6e-3],
            [3e-3, 3e-3],
            None,
            &unwatched,
        );
        let flat = flat.unwrap();
        assert!(flat.grid.cells.gap.iter().all(|g| g.abs() < 1e-16));
        let shoe = PoleShoe {
            rail: Profile::rail_60e1(),
            length: 90e-3,
            inner_edge: 6e-3,
            conforming_to: 21.6e-3,
            outer_edge: 36e-3,
            relief_slope: 0.02,
            poles: 1,
            lateral: 0.0,
            yaw: 0.0,
        };
        let area = |grid: &ContactGrid| grid.areas.iter().sum::<f64>();
        let grid = shoe.grid([3e-3, 3e-4]).unwrap();
        let fine = pair.grid(
            [-45e-3, 45e-3],
            [6e-3, 21.6e-3],
            [3e-3, 3e-4],
            None,
            &unwatched,
        );
        assert!((area(&fine.unwrap().grid) / area(&grid) - 1.0).abs() < 1e-5);
    }

    #[test]
    fn impossible_areas_are_named() {
        let plane = HeightSurface::Plane { height: 0.0 };
        let block = HeightSurface::Block {
            size: [0.01, 0.01],
            height: 0.02,
        };
        let message = |lower: &HeightSurface, upper: &HeightSurface, x: [f64; 2], spacing: f64| {
            let pair = SurfacePair {
                lower,
                upper,
                reach: 0.01,
            };
            match pair.grid(x, [-1e-3, 1e-3], [spacing; 2], Some(1e-6), &unwatched) {
                Ok(_) => String::from("accepted"),
                Err(error) => error.to_string(),
            }
        };
        let x = [-1e-3, 1e-3];
        assert!(message(&plane, &block, x, 1e-3).contains("never touch"));
        assert!(message(&block, &plane, [-0.02, 0.02], 1e-3).contains("no surface at"));
        assert!(message(&plane, &block, [1e-3, -1e-3], 1e-3).contains("x to is -0.001"));
        assert!(message(&plane, &block, x, 0.0).contains("spacing along x is 0"));
        assert!(message(&plane, &block, x, 1e-8).contains("at most 10000000 are accepted"));
        assert!(message(&plane, &plane, x, 1e-3).contains("accepted"));
    }
}
