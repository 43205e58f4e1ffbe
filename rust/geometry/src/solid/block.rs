// SPDX-License-Identifier: MIT OR Apache-2.0
use super::hexahedra::Hexahedra;
use super::layers::heights;
use super::{Filling, SolidMesh, check_unknowns, extent, least, rising, steps, symmetric};
use crate::Error;
use crate::error::positive;

/// Block that stands on the plane z = 0.
///
/// `x` and `y` [m] are the rising coordinates of the nodes of its foot, those of the contact grid. Node sets
/// are "contact" (z = 0), "top", "rear" (least x), "front", "right" (least y) and "left".
///
/// # Errors
/// [`Error::NotRising`], a height or `thinner` that is not positive, [`Error::TooManyTetrahedra`].
///
/// # Example
/// ```
/// # use mtb_geometry::solid::{Filling, block};
/// let line = [-0.02, -0.01, 0.0, 0.01, 0.02];
/// let mesh = block(&line, &line, 0.03, Filling::default())?;
/// // corners and middles of edges
/// assert_eq!(mesh.set("contact").map(<[usize]>::len), Some(81));
/// # Ok::<(), mtb_geometry::Error>(())
/// ```
pub fn block(x: &[f64], y: &[f64], height: f64, filling: Filling) -> Result<SolidMesh, Error> {
    rising("x", x)?;
    rising("y", y)?;
    let step = least(steps(x)).min(least(steps(y)));
    let width = extent(x).min(extent(y));
    let z = heights(
        step / positive("thinner", filling.thinner)?,
        positive("height", height)?,
        width,
        filling.halved,
        filling.clamped,
    )?;
    let ((x, ahead), (y, aside)) = (symmetric(x), symmetric(y));
    let cells = 6.0 * x.len() as f64 * y.len() as f64 * (z.len() - 1) as f64;
    check_unknowns(cells, filling.quadratic)?;
    let mut corners = Vec::with_capacity(x.len() * y.len() * z.len());
    for &x in &x {
        for &y in &y {
            corners.extend(z.iter().map(|&z| [x, y, z]));
        }
    }
    let grid = Hexahedra {
        shape: [x.len(), y.len(), z.len()],
        corners,
        keep: None,
        flipped: [ahead, aside],
        quadratic: filling.quadratic,
        curved: None,
    };
    let (mesh, places) = grid.tetrahedra()?;
    Ok(SolidMesh {
        sets: places.sides().to_vec(),
        ..mesh
    })
}
