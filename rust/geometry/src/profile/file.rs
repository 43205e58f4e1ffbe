// SPDX-License-Identifier: MIT OR Apache-2.0
use super::{Interpolation, Profile};
use crate::Error;
use crate::columns::{Column, LENGTHS, content, read_columns, unreadable};
use crate::error::positive;

/// Which way z of a profile file points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Vertical {
    /// Up, as everywhere here.
    Up,
    /// Down, into the rail.
    Down,
    /// The way of the larger departure from the median height is down: rails fall off at their
    /// flanks, wheels at their flange.
    Guess,
}

/// Points of a profile file with what its header says to do with them.
struct Table {
    points: Vec<[f64; 2]>,
    shift: [f64; 2],
    rotation: f64,
    bounds: [[f64; 2]; 2],
    mirror: [bool; 2],
    /// Length units per metre.
    per_metre: Option<f64>,
    /// Angle units per radian.
    per_radian: f64,
    least_distance: f64,
}

impl Profile {
    /// A profile from the text of a file: two columns y and z, or the `.prr` / `.prw` form with
    /// `point.begin` .. `point.end` and a header of shifts, rotation, bounds, mirrors and units.
    ///
    /// `unit` is the length unit [m] of files that do not state theirs, in a header or in the heading of the
    /// columns. Columns are read by [`read_columns`]; between `point.begin` and `point.end` the third is a weight,
    /// which means something with smoothing only.
    ///
    /// # Errors
    /// Those of [`read_columns`], smoothing asked for by the header, tables that [`Profile::from_points`] refuses.
    pub fn parse(
        text: &str,
        unit: f64,
        vertical: Vertical,
        interpolation: Interpolation,
    ) -> Result<Self, Error> {
        positive("unit", unit)?;
        let table = if text.contains("point.begin") {
            Table::with_header(text)?
        } else {
            Table::columns(text)?
        };
        let [y, mut z] = table.coordinates(unit);
        if points_down(vertical, &z) {
            for v in &mut z {
                *v = -*v;
            }
        }
        Self::from_points(&y, &z, interpolation)
    }
}

fn points_down(vertical: Vertical, z: &[f64]) -> bool {
    match vertical {
        Vertical::Up => false,
        Vertical::Down => true,
        Vertical::Guess => {
            let mut sorted = z.to_vec();
            sorted.sort_by(f64::total_cmp);
            match (sorted.first(), sorted.get(sorted.len() / 2), sorted.last()) {
                (Some(low), Some(median), Some(high)) => high - median > median - low,
                _ => false,
            }
        }
    }
}

/// Columns of a profile.
const COORDINATES: [Column<'_>; 2] = [
    Column {
        names: &["y"],
        units: LENGTHS,
        is_other: false,
    },
    Column {
        names: &["z"],
        units: LENGTHS,
        is_other: false,
    },
];

impl Table {
    fn new() -> Self {
        Self {
            points: Vec::new(),
            shift: [0.0; 2],
            rotation: 0.0,
            bounds: [[f64::NEG_INFINITY, f64::INFINITY]; 2],
            mirror: [false; 2],
            per_metre: None,
            per_radian: 1.0,
            least_distance: 0.0,
        }
    }

    /// The points of two columns, as their heading names them.
    fn columns(text: &str) -> Result<Self, Error> {
        let read = read_columns(text.lines().enumerate(), &COORDINATES)?;
        let mut table = Self::new();
        table.points = read.rows;
        match read.units {
            [None, None] => {}
            [Some(across), Some(up)] => {
                for point in &mut table.points {
                    *point = [across * point[0], up * point[1]];
                }
                table.per_metre = Some(1.0);
            }
            _ => {
                let reason = "the heading states the unit of one of y and z: state both, or none";
                return Err(unreadable(0, reason.into()));
            }
        }
        Ok(table)
    }

    fn with_header(text: &str) -> Result<Self, Error> {
        let lines: Vec<(usize, &str)> = text.lines().enumerate().collect();
        let place = |key: &str| lines.iter().position(|(_, l)| content(l) == key);
        let (Some(begin), Some(end)) = (place("point.begin"), place("point.end")) else {
            let reason = "point.begin and point.end are needed, each on its own line".into();
            return Err(unreadable(lines.len().saturating_sub(1), reason));
        };
        let points = lines.get(begin + 1..end).unwrap_or_default();
        let mut table = Self::new();
        for &(number, whole) in points {
            let line = content(whole);
            // y, z and a weight, which means something with smoothing only
            let mut words = line
                .split(|c: char| c.is_whitespace() || c == ',' || c == ';')
                .filter(|w| !w.is_empty());
            let mut next = || {
                words
                    .next()
                    .and_then(|w| w.parse::<f64>().ok())
                    .filter(|v| v.is_finite())
            };
            match (next(), next()) {
                (Some(y), Some(z)) => table.points.push([y, z]),
                _ if line.is_empty() => {}
                _ => {
                    let reason = format!("{line:?} is not two finite numbers, y and z");
                    return Err(unreadable(number, reason));
                }
            }
        }
        let mut bounds = [[0.0, -1.0]; 2];
        for &(number, line) in &lines[..begin] {
            let Some((key, value)) = content(line).split_once('=') else {
                continue;
            };
            let (key, value) = (key.trim(), value.trim());
            let slot = match key {
                "shift.y" => &mut table.shift[0],
                "shift.z" => &mut table.shift[1],
                "rotate" => &mut table.rotation,
                "units.ang.f" => &mut table.per_radian,
                "point.dist.min" => &mut table.least_distance,
                "bound.y.min" => &mut bounds[0][0],
                "bound.y.max" => &mut bounds[0][1],
                "bound.z.min" => &mut bounds[1][0],
                "bound.z.max" => &mut bounds[1][1],
                "units.len.f" => table.per_metre.insert(1.0),
                "mirror.y" | "mirror.z" => {
                    let flag = value.split_whitespace().next().unwrap_or_default();
                    table.mirror[usize::from(key == "mirror.z")] = match flag.parse::<f64>() {
                        Ok(0.0) => false,
                        Ok(1.0) => true,
                        _ => {
                            let reason = format!("{key} = {value:?} is neither 0 nor 1");
                            return Err(unreadable(number, reason));
                        }
                    };
                    continue;
                }
                "approx.smooth" => &mut 0.0,
                _ => continue,
            };
            *slot = value
                .parse()
                .map_err(|_| unreadable(number, format!("{key} = {value:?} is not a number")))?;
            if key == "approx.smooth" && *slot != 0.0 {
                let reason = format!(
                    "{key} = {value}: profiles are not smoothed here; set it to 0 to take the points as they are, or export points that are smoothed already"
                );
                return Err(unreadable(number, reason));
            }
            if slot.is_nan() {
                let reason = format!("{key} = {value} is not a number");
                return Err(unreadable(number, reason));
            }
            if key.starts_with("units") && !(*slot > 0.0 && slot.is_finite()) {
                return Err(unreadable(
                    number,
                    format!("{key} = {value} must be positive"),
                ));
            }
        }
        for (to, from) in table.bounds.iter_mut().zip(bounds) {
            // a minimum above the maximum means no bounds
            if from[0] < from[1] {
                *to = from;
            }
        }
        Ok(table)
    }

    /// y and z in metres, after everything the header asks for, in its order.
    fn coordinates(&self, unit: f64) -> [Vec<f64>; 2] {
        let scale = self.per_metre.map_or(unit, |n| 1.0 / n);
        let (sin, cos) = (self.rotation / self.per_radian).sin_cos();
        let mut kept: Vec<[f64; 2]> = Vec::new();
        for p in &self.points {
            let near = kept
                .last()
                .is_some_and(|q| (p[0] - q[0]).hypot(p[1] - q[1]) < self.least_distance);
            if !near {
                kept.push(*p);
            }
        }
        kept.into_iter()
            .map(|p| [p[0] + self.shift[0], p[1] + self.shift[1]])
            .map(|p| [cos * p[0] - sin * p[1], sin * p[0] + cos * p[1]])
            .filter(|p| (0..2).all(|i| !(p[i] < self.bounds[i][0] || p[i] > self.bounds[i][1])))
            .map(|p| {
                let turned = |i: usize| if self.mirror[i] { -p[i] } else { p[i] };
                (scale * turned(0), scale * turned(1))
            })
            .unzip::<f64, f64, Vec<f64>, Vec<f64>>()
            .into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PRR: &str = "\
! a rail
header.begin
  version = 1
header.end
spline.begin
  approx.smooth = 0.0
  comment = 'z down, mirrored'
  shift.y = 1.0   ! 2: y shift
  mirror.y = 1
  bound.y.min = -4.0
  bound.y.max = 4.0
  units.len.f = 1000.0
  point.begin
    ! y z weight
    -4.0  1.0  1.0
    -2.0  0.25 1.0
     0.0  0.0  1.0
     2.0  0.3  1.0
     9.0  8.0  1.0
  point.end
spline.end
";

    fn message(text: &str) -> String {
        Profile::parse(text, 1e-3, Vertical::Up, Interpolation::Linear)
            .unwrap_err()
            .to_string()
    }

    #[test]
    fn header_is_obeyed_in_its_order() {
        let rail = Profile::parse(PRR, 1.0, Vertical::Guess, Interpolation::Linear).unwrap();
        let [start, end] = rail.range();
        assert!((start + 3e-3).abs() < 1e-15 && (end - 3e-3).abs() < 1e-15);
        assert!((rail.at(-1e-3).unwrap().height).abs() < 1e-15);
        assert!((rail.at(3e-3).unwrap().height + 1e-3).abs() < 1e-15);
    }

    #[test]
    fn two_columns_in_common_dresses() {
        for text in [
            "y,z\n0,0\n1,-2\n2,-3\n",
            "# rail\n0;0\n1;-2\n\n2;-3",
            "s,y,z\n0,0,0\n2,1,-2\n4,2,-3\n",
            "# z [mm]; y [mm]; weight\n0;0;9\n-2;1;9\n-3;2;9",
            "% arc_m y_mm z_mm\n7 0 0\n8 1 -2\n9 2 -3",
            "  0 0 // crown\n  1 -2\n 2\t-3",
        ] {
            let profile = Profile::parse(text, 1e-3, Vertical::Up, Interpolation::Linear).unwrap();
            assert!((profile.at(1e-3).unwrap().height + 2e-3).abs() < 1e-15);
        }
    }

    #[test]
    fn the_unit_of_a_heading_counts() {
        for text in [
            "y [m],z [m]\n0,0\n0.001,-0.002\n0.002,-0.003",
            "z_um y_mm\n0 0\n-2000 1\n-3000 2",
            "# y (cm); z (cm)\n0;0\n0.1;-0.2\n0.2;-0.3",
            "y;z\nin;in\n0;0\n0.03937007874015748;-0.07874015748031496\n0.08;-0.1",
        ] {
            let profile = Profile::parse(text, 7.0, Vertical::Up, Interpolation::Linear).unwrap();
            assert!(
                (profile.at(1e-3).unwrap().height + 2e-3).abs() < 1e-15,
                "{text}"
            );
        }
        assert!(message("y [mm],z\n0,0\n1,1").contains("state both"));
    }

    #[test]
    fn unreadable_files_are_named() {
        assert!(message("").contains("at least 2 points"));
        assert!(message("0 0\n1 one\n").contains("line 2"));
        assert!(message("0 0\n1\n").contains("line 2"));
        assert!(message("0 0\n1 nan\n").contains("line 2"));
        for columns in [
            "0 0 0\n1 1 -2",
            "y y z\n0 0 0",
            "0 0 crown",
            "1,5,-2,5\n2,5,-3,5",
        ] {
            assert!(
                message(columns).contains("columns: two are needed"),
                "{columns}"
            );
        }
        for uneven in ["s y z\n0 0\n", "y z\n0;0;9\n"] {
            assert!(
                message(uneven).contains("the heading in line 1 names"),
                "{uneven}"
            );
        }
        for commas in ["0,0 0,0\n1,5 -2,5\n", "y;z\n0;0\n1,5;-2\n", "1,5\t-2,5"] {
            assert!(message(commas).contains("decimal commas"), "{commas}");
        }
        let ban = "[Header]\nProgramName=Miniprof\n\n-35.2\t14.1\n";
        assert!(message(ban).contains("MiniProf"));
        assert!(message("0 0\n1 0\n1 2\n").contains("row 3"));
        let smoothed = PRR.replace("approx.smooth = 0.0", "approx.smooth = 0.1");
        assert!(
            message(&smoothed).contains("line 6") && message(&smoothed).contains("set it to 0")
        );
        assert!(message(&PRR.replace("point.end", "")).contains("point.end"));
        assert!(message(&PRR.replace("= 1000.0", "= 0")).contains("must be positive"));
        assert!(message(&PRR.replace("shift.y = 1.0", "shift.y = a")).contains("shift.y"));
    }
}
