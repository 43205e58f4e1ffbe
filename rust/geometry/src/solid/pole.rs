// SPDX-License-Identifier: MIT OR Apache-2.0
use super::hexahedra::{Curved, Hexahedra};
use super::layers::{ACROSS, heights, layers};
use super::{Filling, SolidMesh, check_unknowns, doubled, extent, least, rising, steps, symmetric};
use crate::error::{out_of_range, positive};
use crate::{Error, PoleShoe};

impl PoleShoe {
    /// One pole as a solid in the shoe's own frame: sole on the profile, flat top `height` [m] above the crown.
    ///
    /// `pole` is 1 for the left one (y > 0) and -1 for the right one. `x` [m] are the rising coordinates of
    /// the nodes along the pole, `y` [m] the rising `|y|` of those over the conforming strip, from
    /// `inner_edge` to `conforming_to`. Node sets are "sole" (all of the underside), "inner", "outer",
    /// "contact" (the conforming strip), "top", "rear" and "front".
    ///
    /// # Errors
    /// Those of [`PoleShoe::grid`], a top that lies below the sole or the crown, coordinates that do not rise
    /// or do not span the strip, [`Error::TooManyTetrahedra`].
    pub fn solid(
        &self,
        pole: f64,
        height: f64,
        x: &[f64],
        y: &[f64],
        filling: Filling,
    ) -> Result<SolidMesh, Error> {
        self.check()?;
        rising("x", x)?;
        rising("y", y)?;
        positive("height", height)?;
        positive("thinner", filling.thinner)?;
        let (y_first, y_last) = (y[0], y[y.len() - 1]);
        if (y_first - self.inner_edge).abs() > 1e-9 || (y_last - self.conforming_to).abs() > 1e-9 {
            return Err(Error::OffStrip {
                start: y_first,
                end: y_last,
                inner: self.inner_edge,
                outer: self.conforming_to,
            });
        }
        let (x, ahead) = symmetric(x);
        let n_strip = y.len();
        let relief = self.outer_edge - self.conforming_to;
        let width = extent(&x).min(self.outer_edge - self.inner_edge);
        let mut y = y.to_vec();
        let step = least(steps(&x)).min(least(steps(&y)));
        if relief > 1e-9 {
            let first = (y_last - y[n_strip - 2]) / filling.thinner;
            let beyond = layers(first, relief, width, ACROSS, 1)?;
            y.extend(beyond[1..].iter().map(|s| y_last + s));
        }
        let sole_at = |y: f64| {
            let accepted = "the rail has no head there";
            self.sole(pole, pole * y)
                .map(|(z, _)| z)
                .ok_or_else(|| out_of_range("y of the sole", pole * y, accepted))
        };
        let sole = y
            .iter()
            .map(|&y| sole_at(y))
            .collect::<Result<Vec<_>, _>>()?;
        let thinnest = height - sole.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let tallest = height - least(sole.iter().copied());
        if thinnest <= 0.0 || height <= 0.0 {
            let accepted = "the top must lie above the sole and the crown";
            return Err(out_of_range("height", height, accepted));
        }
        let first = (step / filling.thinner).min(thinnest);
        let rise: Vec<f64> = heights(first, tallest, width, filling.halved, filling.clamped)?
            .into_iter()
            .map(|z| z / tallest)
            .collect();
        let cells = 6.0 * x.len() as f64 * y.len() as f64 * (rise.len() - 1) as f64;
        check_unknowns(cells, filling.quadratic)?;
        let mut corners = Vec::with_capacity(x.len() * y.len() * rise.len());
        for &x in &x {
            for (&y, &sole) in y.iter().zip(&sole) {
                corners.extend(rise.iter().map(|r| [x, y, sole + r * (height - sole)]));
            }
        }
        let fine_y = doubled(&y);
        let curved = if filling.quadratic {
            let fine = fine_y
                .iter()
                .map(|&y| Ok([y, sole_at(y)?]))
                .collect::<Result<Vec<_>, Error>>()?;
            let places = doubled(&x);
            let places = places
                .iter()
                .flat_map(|&x| fine.iter().map(move |&[y, z]| [x, y, z]));
            Some(Curved {
                layer: 0,
                first: 0,
                rows: fine_y.len(),
                places: places.collect(),
            })
        } else {
            None
        };
        let aside = vec![false; y.len() - 1];
        let grid = Hexahedra {
            shape: [x.len(), y.len(), rise.len()],
            corners,
            keep: None,
            flipped: [ahead, aside],
            quadratic: filling.quadratic,
            curved,
        };
        let (mut mesh, places) = grid.tetrahedra()?;
        let strip = places.set(|[_, row, layer]| layer == 0 && row < 2 * n_strip - 1);
        let [underside, top, rear, front, inner, outer] = places.sides();
        mesh.sets = [
            ("sole", underside.1),
            ("inner", inner.1),
            ("outer", outer.1),
            ("contact", strip),
            ("top", top.1),
            ("rear", rear.1),
            ("front", front.1),
        ]
        .map(|(name, nodes)| (name.to_owned(), nodes))
        .to_vec();
        Ok(if pole > 0.0 { mesh } else { mesh.mirrored() })
    }
}
