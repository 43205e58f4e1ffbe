// SPDX-License-Identifier: MIT OR Apache-2.0
use super::{Interpolation, Profile};
use crate::Error;
use crate::columns::{Column, Columns, LENGTHS, content, number_of, read_columns, unreadable};
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

/// The form of a profile file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProfileForm {
    /// Columns without a heading that names them: y, then z.
    Columns,
    /// Columns named by a heading.
    Heading,
    /// Points between `point.begin` and `point.end`: `.prr` of rails and `.prw` of wheels.
    Framed,
    /// A header of `key=value` and columns below it: MiniProf's `.ban` of rails and `.whl` of wheels.
    MiniProf,
}

/// Points of a profile as its file has them, after what a header asks for, in the unit of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct ProfileTable {
    /// Coordinates across (n).
    pub y: Vec<f64>,
    /// Vertical coordinates (n).
    pub z: Vec<f64>,
    /// Length unit [m], where the file states it.
    pub unit: Option<f64>,
    /// The form of the file.
    pub form: ProfileForm,
}

/// Points of a `.prr` or `.prw` file with what its header says to do with them.
struct Framed {
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
    /// A profile from the text of a file, as [`ProfileTable::read`] takes it.
    ///
    /// `unit` is the length unit [m] of files that do not state theirs, in a header or in the heading of the
    /// columns.
    ///
    /// # Errors
    /// Those of [`ProfileTable::read`], tables that [`Profile::from_points`] refuses.
    pub fn parse(
        text: &str,
        unit: f64,
        vertical: Vertical,
        interpolation: Interpolation,
    ) -> Result<Self, Error> {
        positive("unit", unit)?;
        let table = ProfileTable::read(text)?;
        let scale = table.unit.unwrap_or(unit);
        let scaled = |values: &[f64]| -> Vec<f64> { values.iter().map(|v| scale * v).collect() };
        let (y, mut z) = (scaled(&table.y), scaled(&table.z));
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

/// Names of the columns across and up: as here, of a section by itself, and in the frame of MiniProf.
const COORDINATES: [[&str; 2]; 3] = [["y", "z"], ["x", "z"], ["x", "y"]];

/// Keys of the header by which a MiniProf file is known.
const MINIPROF: [&str; 4] = [
    "ProgramName",
    "XYPoints",
    "ColumnDef",
    "PrimaryIdentification",
];

impl ProfileTable {
    /// Points from the text of a file: two columns y and z, MiniProf's `.ban` and `.whl`, or the `.prr` / `.prw` form
    /// with `point.begin` .. `point.end` and a header of shifts, rotation, bounds, mirrors and units.
    ///
    /// Columns are read by [`read_columns`]; a heading may call them x and z, or x and y, too. Between `point.begin` and `point.end` the third is a weight, which
    /// means something with smoothing only. Of a MiniProf header `ColumnDef`, which names the columns (X and Y are
    /// read), and `XYPoints`, their number, count; the coordinates are those that the file has.
    ///
    /// # Errors
    /// Those of [`read_columns`], smoothing asked for by the header, more than one profile, fewer rows than the
    /// header says, lists of sections along the track (slices).
    pub fn read(text: &str) -> Result<Self, Error> {
        refuse_slices(text)?;
        let has_key = |line: &str| {
            let line = line.trim_start_matches('\u{feff}');
            let key = line.split_once('=').map(|(key, _)| key.trim());
            key.is_some_and(|key| MINIPROF.contains(&key))
        };
        if ["point.begin", "header.begin", "spline.begin"]
            .iter()
            .any(|word| text.contains(word))
        {
            Framed::with_header(text).map(Framed::table)
        } else if text.lines().any(has_key) {
            Self::miniprof(text)
        } else {
            Self::columns(text)
        }
    }

    fn new(points: &[[f64; 2]], unit: Option<f64>, form: ProfileForm) -> Self {
        Self {
            y: points.iter().map(|p| p[0]).collect(),
            z: points.iter().map(|p| p[1]).collect(),
            unit,
            form,
        }
    }

    /// The points of two columns, as their heading names them.
    fn columns(text: &str) -> Result<Self, Error> {
        let read = |names: &[&str; 2]| {
            let columns = [&names[..1], &names[1..]].map(|names| Column {
                names,
                units: LENGTHS,
                is_other: false,
            });
            read_columns(text.lines().enumerate(), &columns)
        };
        let is_named =
            |read: &Result<Columns<2>, Error>| read.as_ref().is_ok_and(|read| read.is_named);
        let read = match COORDINATES.iter().map(read).find(is_named) {
            Some(named) => named?,
            None => read(&COORDINATES[0])?,
        };
        let form = if read.is_named {
            ProfileForm::Heading
        } else {
            ProfileForm::Columns
        };
        match read.units {
            [None, None] => Ok(Self::new(&read.rows, None, form)),
            [Some(across), Some(up)] => {
                let points: Vec<[f64; 2]> = read
                    .rows
                    .iter()
                    .map(|row| [across * row[0], up * row[1]])
                    .collect();
                Ok(Self::new(&points, Some(1.0), form))
            }
            _ => {
                let reason = "the heading states the unit of one of the columns across and up: state both, or none";
                Err(unreadable(0, reason.into()))
            }
        }
    }

    /// The points below a MiniProf header.
    fn miniprof(text: &str) -> Result<Self, Error> {
        let mut places = [0, 1];
        let mut stated: Option<(usize, &str)> = None;
        let mut points = Vec::new();
        for (number, whole) in text.lines().enumerate() {
            let line = whole.trim_start_matches('\u{feff}').trim();
            if let Some((key, value)) = line.split_once('=') {
                if !points.is_empty() {
                    let reason = format!(
                        "{line:?} begins another header below the points: one profile a file is read"
                    );
                    return Err(unreadable(number, reason));
                }
                match key.trim() {
                    "XYPoints" => stated = Some((number, value.trim())),
                    "ColumnDef" => places = named_xy(number, value)?,
                    _ => {}
                }
                continue;
            }
            let cells: Vec<&str> = line
                .split(|c: char| c.is_whitespace() || c == ',' || c == ';')
                .filter(|cell| !cell.is_empty())
                .collect();
            let is_title = points.is_empty() && cells.iter().all(|c| number_of(c).is_none());
            if cells.is_empty() || is_title {
                continue;
            }
            let value = |place: usize| {
                let found = cells.get(place).and_then(|c| number_of(c));
                found.filter(|v| v.is_finite()).ok_or_else(|| {
                    let reason = format!("{line:?} is not finite numbers, X and Y among them");
                    unreadable(number, reason)
                })
            };
            points.push([value(places[0])?, value(places[1])?]);
        }
        if let Some((number, value)) = stated
            && value.parse::<usize>() != Ok(points.len())
        {
            let reason = format!(
                "XYPoints={value}, and {} rows of points follow: the file is cut short or has been changed",
                points.len()
            );
            return Err(unreadable(number, reason));
        }
        Ok(Self::new(&points, None, ProfileForm::MiniProf))
    }
}

/// Where the columns X and Y stand, by the value of `ColumnDef`.
fn named_xy(number: usize, value: &str) -> Result<[usize; 2], Error> {
    let names: Vec<&str> = value.split([',', ';', '\t', ' ']).map(str::trim).collect();
    let place = |wanted: &str| names.iter().position(|n| n.eq_ignore_ascii_case(wanted));
    if let (Some(x), Some(y)) = (place("X"), place("Y")) {
        Ok([x, y])
    } else {
        let reason = format!("ColumnDef={value} does not name the columns X and Y");
        Err(unreadable(number, reason))
    }
}

/// A list of sections along the track or around a wheel names other files, one a line.
fn refuse_slices(text: &str) -> Result<(), Error> {
    let named: Vec<(usize, &str)> = text
        .lines()
        .enumerate()
        .filter_map(|(number, line)| {
            let last = line.split(['\'', '"', ' ', '\t', ',']);
            let file = last.into_iter().find(|word| {
                let lower = word.to_ascii_lowercase();
                [".prr", ".prw", ".ban", ".whl"]
                    .iter()
                    .any(|e| lower.ends_with(e))
            })?;
            let first = line.split_whitespace().next()?;
            number_of(first).is_some().then_some((number, file))
        })
        .collect();
    let [(number, file), _, ..] = named[..] else {
        return Ok(());
    };
    let reason = format!(
        "{file:?} is one of {} sections along the track or around the wheel (slices), and a profile is one section: read one of these files",
        named.len()
    );
    Err(unreadable(number, reason))
}

impl Framed {
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

    fn with_header(text: &str) -> Result<Self, Error> {
        let lines: Vec<(usize, &str)> = text.lines().enumerate().collect();
        let place = |key: &str| lines.iter().position(|(_, l)| content(l) == key);
        let (Some(begin), Some(end)) = (place("point.begin"), place("point.end")) else {
            let reason = "point.begin and point.end are needed, each on its own line".into();
            return Err(unreadable(lines.len().saturating_sub(1), reason));
        };
        if let Some(again) = lines[begin + 1..]
            .iter()
            .find(|(_, l)| content(l) == "point.begin")
        {
            let reason = "a second point.begin: one profile a file is read".into();
            return Err(unreadable(again.0, reason));
        }
        let points = lines.get(begin + 1..end).unwrap_or_default();
        let mut table = Self::new();
        for &(number, whole) in points {
            let line = content(whole);
            // y, z and a weight, which means something with smoothing only
            let mut words = line
                .split(|c: char| c.is_whitespace() || c == ',' || c == ';')
                .filter(|w| !w.is_empty());
            let mut next = || words.next().and_then(number_of).filter(|v| v.is_finite());
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
                    table.mirror[usize::from(key == "mirror.z")] = match number_of(flag) {
                        Some(0.0) => false,
                        Some(1.0) => true,
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
            *slot = number_of(value)
                .ok_or_else(|| unreadable(number, format!("{key} = {value:?} is not a number")))?;
            if key == "approx.smooth" && *slot != 0.0 {
                let reason = format!(
                    "{key} = {value}: a file is read without smoothing; set it to 0 to take the points as they are, and smooth the profile itself"
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

    /// The points after everything the header asks for, in its order.
    fn table(self) -> ProfileTable {
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
        let points: Vec<[f64; 2]> = kept
            .into_iter()
            .map(|p| [p[0] + self.shift[0], p[1] + self.shift[1]])
            .map(|p| [cos * p[0] - sin * p[1], sin * p[0] + cos * p[1]])
            .filter(|p| (0..2).all(|i| !(p[i] < self.bounds[i][0] || p[i] > self.bounds[i][1])))
            .map(|p| {
                let turned = |i: usize| if self.mirror[i] { -p[i] } else { p[i] };
                [turned(0), turned(1)]
            })
            .collect();
        let unit = self.per_metre.map(|n| 1.0 / n);
        ProfileTable::new(&points, unit, ProfileForm::Framed)
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
            "X Z\n0 0\n1 -2\n2 -3",
            "# Z;X\n0;0\n-2;1\n-3;2",
            "x [mm],y [mm]\n0,0\n1,-2\n2,-3",
            "x y z\n9 0 0\n9 1 -2\n9 2 -3",
            "0.0D+00 0.0D+00\n0.1D+01 -2d0\n0.2D+01 -0.3D1",
        ] {
            let profile = Profile::parse(text, 1e-3, Vertical::Up, Interpolation::Linear).unwrap();
            assert!((profile.at(1e-3).unwrap().height + 2e-3).abs() < 1e-15);
        }
    }

    #[test]
    fn miniprof_columns_are_found_by_their_names() {
        for text in [
            "ProgramName=MiniProf\nXYPoints=3\nColumnDef=X,Y,A,C\n\n0\t0\t9\t9\n1\t-2\t9\t9\n2\t-3\t9\t9\n",
            "[Header]\nProgramName=MiniProf\nColumnDef=A,Y,X\n9 0 0\n9 -2 1\n9 -3 2\n",
            "\u{feff}XYPoints=3\r\n\r\n0 0\r\n1 -2\r\n2 -3\r\n",
        ] {
            let table = ProfileTable::read(text).unwrap();
            assert_eq!((table.form, table.unit), (ProfileForm::MiniProf, None));
            assert_eq!(
                (table.y, table.z),
                (vec![0.0, 1.0, 2.0], vec![0.0, -2.0, -3.0])
            );
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
        for commas in ["0,0 0,0\n1,5 -2,5\n", "y;z\n0;0\n1,500.0;-2\n", "1,5 -2,5"] {
            assert!(message(commas).contains("decimal commas"), "{commas}");
        }
        assert!(message("scene = x\n0 0\n1 1").contains("belongs to a header"));
        let ban = "ProgramName=MiniProf\nXYPoints=2\n\n-35.2\t14.1\n";
        assert!(message(ban).contains("XYPoints=2, and 1 rows"));
        let short = "ProgramName=MiniProf\nColumnDef=X,Y\n\n-35.2\n";
        assert!(message(short).contains("line 4"));
        assert!(message("ColumnDef=A,B\n0 0\n1 1").contains("does not name the columns X and Y"));
        let two = "XYPoints=2\n0 0\n1 1\nXYPoints=2\n0 0\n1 1\n";
        assert!(message(two).contains("another header"));
        assert!(message("XYPoints=2\n0 0\n1 nan\n").contains("line 3"));
        let twice = PRR.replace("spline.end", "point.begin\n0 0\npoint.end\nspline.end");
        assert!(message(&twice).contains("a second point.begin"));
        let slices = "2 ! slices\n0.0 'a.prr'\n10.0 'b.prr'\n";
        assert!(message(slices).contains("one of 2 sections"));
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
