// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_words::Short;

use super::hexahedra::{Curved, Hexahedra};
use super::layers::{ACROSS_RAIL, coarseness, layers};
use super::outline::Outline;
use super::section::{Quads, SectionMesh, divided};
use super::{SolidMesh, check_unknowns, doubled, least, rising, spaced, steps, symmetric};
use crate::error::{finite, out_of_range, positive};
use crate::{Error, Profile};

/// Elements over the height of web and foot of a rail and over half of its foot's width, where it is
/// [`ACROSS_RAIL`] elements wide.
const FAR_LAYERS: [f64; 3] = [5.0, 3.0, 6.0];

/// Half width of the head over that of the foot, at most: wider ones are not filled.
const WIDEST_HEAD: f64 = 4.0 / 3.0;

/// Points of the running surface in an outline.
const RUNNING_SURFACE: usize = 4001;

/// Section of a rail below the running surface of its head, simplified: its foot is straight from the toe to the web.
/// That of 60E1 is thinner there, so that its area is 5 % smaller than here, and its moments of area are 5 % (vertical
/// bending) and 15 % (lateral) smaller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RailSection {
    /// Half the thickness of the web [m].
    pub web_half_width: f64,
    /// Height z where the head meets the web [m].
    pub web_top: f64,
    /// Height z where the foot meets the web [m].
    pub web_bottom: f64,
    /// Lower corner of the head (y, z) [m].
    pub head_edge: [f64; 2],
    /// Half the width of the foot [m].
    pub foot_half_width: f64,
    /// Thickness of the foot at its toe [m].
    pub foot_toe: f64,
    /// Height z of the base [m].
    pub bottom: f64,
}

impl Default for RailSection {
    /// That of the rail 60E1 [EN13674-1].
    fn default() -> Self {
        Self {
            web_half_width: 8.25e-3,
            web_top: -51e-3,
            web_bottom: -142e-3,
            head_edge: [37.33e-3, -40.425e-3],
            foot_half_width: 75e-3,
            foot_toe: 11.5e-3,
            bottom: -172e-3,
        }
    }
}

/// One side of a profile, y > 0 or y < 0, over the distance |y|.
struct Flank<'a> {
    profile: &'a Profile,
    side: f64,
}

/// A section as a grid of columns, y rising, and layers.
struct Laid {
    /// y and z, layers fastest.
    plane: Vec<[f64; 2]>,
    /// Quadrilaterals that exist, layers fastest.
    keep: Vec<bool>,
    /// Places on the running surface, middles between the nodes included.
    fine: Vec<[f64; 2]>,
    /// First column of the doubled grid that has such a place.
    first: usize,
    /// Columns of quadrilaterals at y < 0.
    offset: usize,
    /// Layers of corners.
    layers: usize,
    /// First and last column of the contact strip of either flank.
    strips: [[usize; 2]; 2],
}

/// Half a rail section as a grid of columns (outwards) and layers (upwards).
struct Columns {
    /// Numbers of columns and layers.
    shape: [usize; 2],
    /// y and z, layers fastest.
    plane: Vec<[f64; 2]>,
    /// Cells that exist, layers fastest.
    keep: Vec<bool>,
    /// |y| of the nodes on the running surface, column by column.
    surface: Vec<f64>,
    /// First and last column of the contact strip.
    strip: [usize; 2],
}

impl RailSection {
    /// Rail of finite length with its web and foot; its head follows `profile`, whose crown is at z = 0.
    ///
    /// `x` [m] are the rising coordinates of the nodes along the contact; the mesh grows coarser towards the
    /// ends. `left` and `right` [m] are the rising |y| of the nodes over the contact strips at y > 0 and at
    /// y < 0; without the second one there is only the half y >= 0, for what is symmetric. `length` [m] is
    /// centred at x = 0. Node sets are "left" and "right" (the strips), "head" (the running surface, also
    /// "contact"), "base" (underside of the foot), "rear", "front" (ends), and "symmetry" (y = 0) of a half.
    ///
    /// # Errors
    /// [`Error::NotRising`], numbers that are not finite, a length that is not positive or shorter than the
    /// contact, a profile much wider than the foot, strips that leave the head, [`Error::TooManyTetrahedra`].
    pub fn solid(
        &self,
        profile: &Profile,
        x: &[f64],
        left: &[f64],
        right: Option<&[f64]>,
        length: f64,
        quadratic: bool,
    ) -> Result<SolidMesh, Error> {
        rising("x", x)?;
        rising("y", left)?;
        rising("right", right.unwrap_or(left))?;
        self.check()?;
        self.check_width(profile)?;
        let half_length = 0.5 * positive("length", length)?;
        let (x_first, x_last) = (x[0], x[x.len() - 1]);
        if x_first <= -half_length || x_last >= half_length {
            return Err(Error::ShortRail {
                length,
                start: x_first,
                end: x_last,
            });
        }
        let near = Flank { profile, side: 1.0 };
        let far = Flank {
            profile,
            side: -1.0,
        };
        let width = near.gauge_corner() + if right.is_some() { &far } else { &near }.gauge_corner();
        let step = least(steps(left)).min(least(steps(right.unwrap_or(left))));
        let end = |step: f64, reach: f64| {
            let places = layers(step, half_length - reach, width, ACROSS_RAIL, 1)?;
            Ok::<_, Error>(places[1..].to_vec())
        };
        let behind = end(x[1] - x_first, -x_first)?;
        let before = end(x_last - x[x.len() - 2], x_last)?;
        let mut along: Vec<f64> = behind.iter().rev().map(|b| x_first - b).collect();
        along.extend(x);
        along.extend(before.iter().map(|b| x_last + b));
        let (x, ahead) = symmetric(&along);
        let Laid {
            plane,
            keep,
            fine,
            first,
            offset,
            layers: n_layers,
            strips: [grid_strip, other_strip],
        } = self.laid(&near, left, right.map(|right| (&far, right)), step, width)?;
        let columns = plane.len() / n_layers;
        let kept = keep.iter().filter(|kept| **kept).count();
        check_unknowns(6.0 * x.len() as f64 * kept as f64, quadratic)?;
        let corners = x
            .iter()
            .flat_map(|&x| plane.iter().map(move |&[y, z]| [x, y, z]));
        let rows = fine.len();
        let head = n_layers - 1;
        let mesher = Hexahedra {
            shape: [x.len(), columns, n_layers],
            corners: corners.collect(),
            keep: Some(keep.repeat(x.len() - 1)),
            flipped: [ahead, (0..columns - 1).map(|k| k < offset).collect()],
            quadratic,
            curved: quadratic.then(|| Curved {
                layer: head,
                first,
                rows,
                places: doubled(&x)
                    .iter()
                    .flat_map(|&x| fine.iter().map(move |&[y, z]| [x, y, z]))
                    .collect(),
            }),
        };
        let (mut mesh, places) = mesher.tetrahedra()?;
        let last = places.shape.map(|n| n - 1);
        let strip = |from: usize, to: usize| {
            places.set(|[_, row, layer]| layer == last[2] && (from..=to).contains(&row))
        };
        let running = strip(first, first + rows - 1);
        let mut put = |name: &str, nodes| mesh.sets.push((name.to_owned(), nodes));
        let [start, stop] = grid_strip.map(|n| 2 * (offset + n));
        put("left", strip(start, stop));
        put("head", running.clone());
        put("contact", running);
        put("base", places.set(|[_, _, layer]| layer == 0));
        put("rear", places.set(|[column, _, _]| column == 0));
        put("front", places.set(|[column, _, _]| column == last[0]));
        match right {
            Some(_) => {
                let [stop, start] = other_strip.map(|n| 2 * (offset - n));
                put("right", strip(start, stop));
            }
            None => put("symmetry", places.set(|[_, row, _]| row == 0)),
        }
        Ok(mesh)
    }

    /// Outline of the section below a profile, whose crown is at z = 0: what is free above its base.
    ///
    /// The running surface is divided finely enough to be taken for the curve.
    ///
    /// # Errors
    /// A section that makes no sense, a profile much wider than the foot.
    pub fn outline(&self, profile: &Profile) -> Result<Outline, Error> {
        self.check()?;
        self.check_width(profile)?;
        let side = |side: f64| {
            [
                [side * self.foot_half_width, self.bottom],
                [side * self.foot_half_width, self.bottom + self.foot_toe],
                [side * self.web_half_width, self.web_bottom],
                [side * self.web_half_width, self.web_top],
                [side * self.head_edge[0], self.head_edge[1]],
            ]
        };
        let [from, to] = profile.arc_range();
        let arcs = spaced(from, to, RUNNING_SURFACE);
        let places = profile.position(&arcs)?;
        let heights = profile.stations(&places)?;
        let mut free = side(-1.0).to_vec();
        free.extend(places.iter().zip(heights).map(|(y, at)| [*y, at.height]));
        free.extend(side(1.0).into_iter().rev());
        Ok(Outline {
            free,
            base: Vec::new(),
        })
    }

    /// A profile much wider than the foot is not filled.
    fn check_width(&self, profile: &Profile) -> Result<(), Error> {
        let [start, end] = profile.range();
        let (widest, most) = (
            start.abs().max(end.abs()),
            WIDEST_HEAD * self.foot_half_width,
        );
        if widest > most {
            let accepted = format!(
                "the mesh of an elastic rail takes heads up to {} m: cut the profile there, or take a half-space",
                Short(most)
            );
            return Err(out_of_range("largest |y| of the profile", widest, accepted));
        }
        Ok(())
    }

    /// The whole section, or the half of one flank, as a grid of quadrilaterals with y rising.
    fn laid(
        &self,
        near: &Flank<'_>,
        left: &[f64],
        other: Option<(&Flank<'_>, &[f64])>,
        step: f64,
        width: f64,
    ) -> Result<Laid, Error> {
        // 1 at the underside, 0 on top
        let depth = layers(step, -self.web_top, width, ACROSS_RAIL, 2)?;
        let depth: Vec<f64> = depth.iter().rev().map(|d| d / -self.web_top).collect();
        let coarse = coarseness(step, width, ACROSS_RAIL);
        let grid = self.columns(near, left, &depth, coarse)?;
        // the half y < 0 stands before the other one, outermost column first
        let n_layers = grid.shape[1];
        let mut laid = Laid {
            plane: Vec::new(),
            keep: Vec::new(),
            fine: Vec::new(),
            first: 0,
            offset: 0,
            layers: n_layers,
            strips: [grid.strip, [0, 0]],
        };
        if let Some((far, right)) = other {
            let other = self.columns(far, right, &depth, coarse)?;
            laid.strips[1] = other.strip;
            laid.offset = other.shape[0] - 1;
            for column in other.plane.chunks_exact(n_layers).skip(1).rev() {
                laid.plane.extend(column.iter().map(|[y, z]| [-y, *z]));
            }
            for column in other.keep.chunks_exact(n_layers - 1).rev() {
                laid.keep.extend(column);
            }
            let surface = far.running_surface(&other.surface)?;
            laid.fine
                .extend(surface[1..].iter().rev().map(|[y, z]| [-y, *z]));
            laid.first = 2 * (laid.offset - (other.surface.len() - 1));
        }
        laid.plane.extend(&grid.plane);
        laid.keep.extend(&grid.keep);
        laid.fine.extend(near.running_surface(&grid.surface)?);
        Ok(laid)
    }

    /// Section of a prism whose head follows `profile`, whose crown is at z = 0.
    ///
    /// `strips` are the rising y [m] of the rows of each contact grid on the head, with `parts` elements between two
    /// of them.
    ///
    /// # Errors
    /// As of [`RailSection::solid`].
    pub fn section(
        &self,
        profile: &Profile,
        strips: &[&[f64]],
        parts: usize,
    ) -> Result<SectionMesh, Error> {
        self.check()?;
        self.check_width(profile)?;
        let lines = divided(strips, parts)?;
        let step = least(steps(&lines));
        let near = Flank { profile, side: 1.0 };
        let far = Flank {
            profile,
            side: -1.0,
        };
        // one flank without contact is divided as the other one
        let on = |side: f64| -> Vec<f64> {
            let mut own: Vec<f64> = lines
                .iter()
                .map(|y| side * y)
                .filter(|y| *y > 1e-3 * step)
                .collect();
            own.sort_by(f64::total_cmp);
            if lines[0] <= 0.0
                && lines[lines.len() - 1] >= 0.0
                && strips.iter().any(|s| s[0] <= 0.0 && s[s.len() - 1] >= 0.0)
            {
                own.insert(0, 0.0);
            }
            own
        };
        let (mut left, mut right) = (on(1.0), on(-1.0));
        if left.len() < 2 {
            left.clone_from(&right);
        }
        if right.len() < 2 {
            right.clone_from(&left);
        }
        let width = near.gauge_corner() + far.gauge_corner();
        let laid = self.laid(&near, &left, Some((&far, &right)), step, width)?;
        let quads = Quads {
            shape: [laid.plane.len() / laid.layers, laid.layers],
            plane: laid.plane,
            keep: laid.keep,
            flipped: laid.offset,
            top: (laid.first, laid.fine),
        };
        Ok(quads.triangles())
    }

    /// Head between its running surface and its underside, web below its inner columns, foot below all.
    ///
    /// `depth` are the layers of the head, 1 at its underside and 0 on top; `coarse` is the coarseness below.
    fn columns(
        &self,
        flank: &Flank<'_>,
        y: &[f64],
        depth: &[f64],
        coarse: f64,
    ) -> Result<Columns, Error> {
        let corner = flank.gauge_corner();
        let (first, last) = (y[0], y[y.len() - 1]);
        if first < 0.0 || last >= corner {
            let accepted = format!(
                "the contact strip lies between 0 and {} m on the head",
                Short(corner)
            );
            return Err(out_of_range(
                "y",
                if first < 0.0 { first } else { last },
                accepted,
            ));
        }
        if corner <= self.web_half_width {
            let accepted = format!(
                "the head of the rail is {} m wide to either side and wider than its web",
                Short(corner)
            );
            return Err(out_of_range(
                "web_half_width",
                self.web_half_width,
                accepted,
            ));
        }
        let number = |length: f64, size: f64| 2.max((length / size).round_ties_even() as usize);
        let inner = if first > 0.0 {
            spaced(0.0, first, number(first, y[1] - first) + 1)
        } else {
            vec![0.0]
        };
        let size = 1.3 * (last - y[y.len() - 2]);
        let outer = spaced(last, corner, number(corner - last, size) + 1);
        let surface = [&inner[..inner.len() - 1], y, &outer[1..]].concat();
        let n_web = 2.max(surface.partition_point(|s| *s < self.web_half_width));
        let n_columns = surface.len();
        // underside of the head: the web, then the slope to its lower edge
        let mut under: Vec<[f64; 2]> = spaced(0.0, self.web_half_width, n_web + 1)
            .into_iter()
            .map(|y| [y, self.web_top])
            .collect();
        under.truncate(n_web);
        let slope = [
            self.head_edge[0] - self.web_half_width,
            self.head_edge[1] - self.web_top,
        ];
        under.extend(
            spaced(0.0, 1.0, n_columns - n_web)
                .into_iter()
                .map(|share| {
                    [
                        self.web_half_width + share * slope[0],
                        self.web_top + share * slope[1],
                    ]
                }),
        );
        let top = flank.points(&surface)?;
        let bent = self.bent_flank(flank, corner, depth)?;
        let straight = |column: usize, layer: usize| -> [f64; 2] {
            let down = depth[layer];
            std::array::from_fn(|c| (1.0 - down) * top[column][c] + down * under[column][c])
        };
        let [n_web_layers, n_foot_layers, n_foot] =
            FAR_LAYERS.map(|n| 2.max((n / coarse).round_ties_even() as usize));
        let web_z = spaced(self.web_bottom, self.web_top, n_web_layers + 1);
        let columns = n_columns.max(n_web + n_foot + 1);
        let layers = n_foot_layers + n_web_layers + depth.len();
        let (base, neck) = (n_foot_layers, n_foot_layers + n_web_layers);
        let mut plane = vec![[0.0; 2]; columns * layers];
        let mut keep = vec![false; (columns - 1) * (layers - 1)];
        // what the outermost column adds to the straight line is shared out over the columns
        for (column, place) in surface.iter().enumerate() {
            let weight = (place / surface[n_columns - 1]).powi(2);
            for layer in 0..depth.len() {
                let (own, outermost) = (straight(column, layer), straight(n_columns - 1, layer));
                plane[column * layers + neck + layer] =
                    std::array::from_fn(|c| own[c] + weight * (bent[layer][c] - outermost[c]));
            }
            if column + 1 < n_columns {
                keep[column * (layers - 1) + neck..(column + 1) * (layers - 1)].fill(true);
            }
        }
        let mut feet = spaced(0.0, self.web_half_width, n_web + 1);
        for (column, y) in feet.iter().enumerate() {
            for (layer, z) in web_z.iter().enumerate() {
                plane[column * layers + base + layer] = [*y, *z];
            }
            if column < n_web {
                keep[column * (layers - 1) + base..][..n_web_layers].fill(true);
            }
        }
        let reach = self.foot_half_width - self.web_half_width;
        feet.extend(&spaced(self.web_half_width, self.foot_half_width, n_foot + 1)[1..]);
        let toe = self.bottom + self.foot_toe;
        let up = spaced(0.0, 1.0, n_foot_layers + 1);
        for (column, y) in feet.iter().enumerate() {
            let share = ((y - self.web_half_width) / reach).clamp(0.0, 1.0);
            let upper = self.web_bottom + share * (toe - self.web_bottom);
            for (layer, up) in up.iter().enumerate() {
                plane[column * layers + layer] = [*y, self.bottom + up * (upper - self.bottom)];
            }
            if column + 1 < feet.len() {
                keep[column * (layers - 1)..][..base].fill(true);
            }
        }
        let first = inner.len() - 1;
        Ok(Columns {
            shape: [columns, layers],
            plane,
            keep,
            surface,
            strip: [first, first + y.len() - 1],
        })
    }

    /// Points from the lower head edge up the flank and round the gauge corner to `corner`, one a layer.
    fn bent_flank(
        &self,
        flank: &Flank<'_>,
        corner: f64,
        depth: &[f64],
    ) -> Result<Vec<[f64; 2]>, Error> {
        let mut ring = flank.points(&spaced(corner, flank.end(), 60))?;
        ring.push(self.head_edge);
        let mut run = vec![0.0];
        for pair in ring.windows(2) {
            let [dy, dz] = [0, 1].map(|c| pair[1][c] - pair[0][c]);
            run.push(run[run.len() - 1] + (dy * dy + dz * dz).sqrt());
        }
        let total = run[run.len() - 1];
        let at = |depth: &f64| {
            let at = depth * total;
            let j = run.partition_point(|r| *r <= at) - 1;
            if j + 1 >= run.len() || run[j] == at {
                return ring[j.min(run.len() - 1)];
            }
            std::array::from_fn(|c| {
                let slope = (ring[j + 1][c] - ring[j][c]) / (run[j + 1] - run[j]);
                slope * (at - run[j]) + ring[j][c]
            })
        };
        Ok(depth.iter().map(at).collect())
    }

    fn check(&self) -> Result<(), Error> {
        for (name, value) in [
            ("web_half_width", self.web_half_width),
            ("foot_toe", self.foot_toe),
            ("depth of web_top below the crown", -self.web_top),
            ("height of the web", self.web_top - self.web_bottom),
            ("height of the foot", self.web_bottom - self.bottom),
            (
                "width of the foot beside the web",
                self.foot_half_width - self.web_half_width,
            ),
            (
                "width of the head beside the web",
                self.head_edge[0] - self.web_half_width,
            ),
        ] {
            positive(name, value)?;
        }
        finite("z of head_edge", self.head_edge[1])?;
        Ok(())
    }
}

impl Flank<'_> {
    fn end(&self) -> f64 {
        let [start, end] = self.profile.range();
        if self.side > 0.0 { end } else { -start }
    }

    /// (|y|, z) at distances from the middle.
    fn points(&self, y: &[f64]) -> Result<Vec<[f64; 2]>, Error> {
        let there: Vec<f64> = y.iter().map(|y| self.side * y).collect();
        let stations = self.profile.stations(&there)?;
        Ok(y.iter()
            .zip(stations)
            .map(|(y, station)| [*y, station.height])
            .collect())
    }

    fn running_surface(&self, y: &[f64]) -> Result<Vec<[f64; 2]>, Error> {
        self.points(&doubled(y))
    }

    /// |y| [m] on the gauge corner where the profile falls as steeply as it runs.
    fn gauge_corner(&self) -> f64 {
        let end = self.end();
        let places = spaced(0.5 * end, end, 2001);
        let slope = |y: f64| {
            self.profile
                .at(self.side * y)
                .map_or(0.0, |s| self.side * s.slope)
        };
        places.into_iter().find(|y| slope(*y) < -1.0).unwrap_or(end)
    }
}

/// Lines along x [m] for the mesh of a rail below contact grids, from the rising lines of each of them.
///
/// Grids that a turned shoe shifts against each other share evenly spaced lines, as those of one of them would favour
/// it. Every second line is left out but near the ends, where a sharp edge presses: quadratic elements twice as long
/// as the contact cells still have nodes at the contact points.
pub fn rail_lines(along: &[Vec<f64>]) -> Vec<f64> {
    let lines = shared(along);
    let last = lines.len().saturating_sub(1);
    let is_kept = |k: usize| {
        let from_end = k.min(last - k);
        // symmetric, and the cells in the middle no longer than the others
        from_end < 3 || from_end.is_multiple_of(2) || (last % 2 == 1 && from_end == last / 2)
    };
    let numbered = lines.iter().enumerate();
    numbered
        .filter(|(k, _)| is_kept(*k))
        .map(|(_, line)| *line)
        .collect()
}

/// The lines of all grids, where they are alike, or evenly spaced ones over all of them.
fn shared(along: &[Vec<f64>]) -> Vec<f64> {
    let Some(first) = along.first() else {
        return Vec::new();
    };
    let size = first[first.len() - 1] - first[0];
    let is_alike = |other: &Vec<f64>| {
        let mut pairs = first.iter().zip(other);
        other.len() == first.len() && pairs.all(|(a, b)| (a - b).abs() <= 1e-9 * size)
    };
    if along.iter().all(is_alike) {
        return first.clone();
    }
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for x in along {
        (low, high) = (low.min(x[0]), high.max(x[x.len() - 1]));
    }
    let counts = along.iter().map(|x| {
        let cells = (x.len() - 1) as f64;
        ((high - low) / (x[x.len() - 1] - x[0]) * cells)
            .round()
            .max(cells) as usize
    });
    let count = counts.fold(1, usize::max);
    let line = |k: usize| low + (high - low) * k as f64 / count as f64;
    (0..=count).map(line).collect()
}
