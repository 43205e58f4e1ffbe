// SPDX-License-Identifier: MIT OR Apache-2.0
//! Tables of a few columns as people write them: the one reader of such text.

use crate::Error;

/// Metres per unit of length, by the names that headings have for it.
pub const LENGTHS: &[(&str, f64)] = &[
    ("m", 1.0),
    ("metre", 1.0),
    ("metres", 1.0),
    ("meter", 1.0),
    ("meters", 1.0),
    ("cm", 1e-2),
    ("mm", 1e-3),
    ("millimetre", 1e-3),
    ("millimetres", 1e-3),
    ("millimeter", 1e-3),
    ("millimeters", 1e-3),
    ("um", 1e-6),
    ("µm", 1e-6),
    ("μm", 1e-6),
    ("micron", 1e-6),
    ("microns", 1e-6),
    ("in", 0.0254),
    ("inch", 0.0254),
    ("inches", 0.0254),
    ("ft", 0.3048),
    ("feet", 0.3048),
];

/// A column that a table must have.
#[derive(Clone, Copy, Debug)]
pub struct Column<'a> {
    /// What headings call it, in lower case; the first one stands in messages.
    pub names: &'a [&'a str],
    /// SI units per unit of the column, by the names of the units; the first one stands in messages.
    pub units: &'a [(&'a str, f64)],
    /// Whether it may have any name, as the only column besides the other ones.
    pub is_other: bool,
}

/// Columns as they stand in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Columns<const N: usize> {
    /// Numbers row by row, in their own units.
    pub rows: Vec<[f64; N]>,
    /// The line of each row, counted from 1.
    pub lines: Vec<usize>,
    /// SI units per unit of each column, where the heading says so.
    pub units: [Option<f64>; N],
    /// Whether a heading names the columns.
    pub is_named: bool,
}

/// A heading, and where it stands.
struct Heading<'a, const N: usize> {
    line: usize,
    text: &'a str,
    is_comment: bool,
    count: usize,
    /// Place of each column, if the heading names them.
    places: Option<[usize; N]>,
    units: [Option<f64>; N],
}

/// Reads columns, parted by blanks, commas or semicolons, from numbered lines; `#`, `!`, `%` and `//` begin
/// comments. Between semicolons or tabs numbers may have decimal commas; exponents may be those of Fortran (1.5D-03). A `%` where a unit would stand, as in `[%]`, is the unit.
///
/// A heading, which may be a comment, gives the order of the columns and their units: `y [mm]`, `y (mm)`,
/// `y/mm`, `y_mm`, or a second line of units alone. Without one the columns are the wanted ones in their
/// order, and there are no others.
///
/// # Errors
/// [`Error::Unreadable`], with the line: what is no number, decimal commas, columns without a name, headings
/// that do not name the columns, units that are not known.
pub fn read_columns<'a, const N: usize>(
    lines: impl Iterator<Item = (usize, &'a str)>,
    wanted: &[Column<'_>; N],
) -> Result<Columns<N>, Error> {
    let (mut rows, mut at) = (Vec::new(), Vec::new());
    let mut heading: Option<Heading<'a, N>> = None;
    for (number, whole) in lines {
        let whole = whole.trim_start_matches('\u{feff}');
        let line = content(whole);
        if line.is_empty() {
            let bare = whole.trim_start_matches(['#', '!', '%', '/', ' ', '\t']);
            if rows.is_empty() {
                // blanks part a percent sign that begins a line of units from the next one
                let is_units = heading
                    .as_mut()
                    .is_some_and(|h| h.takes_units(whole.trim(), wanted));
                if !is_units {
                    heading = with_comment(heading, number, bare.trim_end(), wanted);
                }
            }
            continue;
        }
        let pointed = with_decimal_points(line);
        let line = pointed.as_deref().unwrap_or(line);
        if has_decimal_commas(line) {
            let reason = format!(
                "{line:?} has decimal commas: write decimal points (1.5), or semicolons or tabs between the columns"
            );
            return Err(unreadable(number, reason));
        }
        let cells = cells(line);
        if rows.is_empty() && cells.iter().all(|c| number_of(c).is_none()) {
            if line.contains('=') {
                let reason = format!(
                    "{line:?} belongs to a header, which is not read: keep the columns {} alone, and save them as text",
                    named(wanted)
                );
                return Err(unreadable(number, reason));
            }
            let is_units = heading
                .as_mut()
                .is_some_and(|h| h.takes_units(line, wanted));
            if !is_units {
                if heading.as_ref().is_some_and(|h| !h.is_comment) {
                    return Err(not_numbers(number, line, wanted));
                }
                heading = Some(Heading::read(number, content(whole), false, wanted)?);
            }
            continue;
        }
        // a remark that looks like a heading
        let heading_here = heading
            .as_ref()
            .filter(|h| !h.is_comment || h.count == cells.len());
        let places = places(number, line, cells.len(), heading_here, wanted)?;
        let mut row = [0.0; N];
        for (value, place) in row.iter_mut().zip(places) {
            let found = cells.get(place).and_then(|c| number_of(c));
            *value = found
                .filter(|v| v.is_finite())
                .ok_or_else(|| not_numbers(number, line, wanted))?;
        }
        rows.push(row);
        at.push(number + 1);
    }
    let is_named = heading.as_ref().is_some_and(|h| h.places.is_some());
    let units = heading.map_or([None; N], |h| h.units);
    Ok(Columns {
        rows,
        lines: at,
        units,
        is_named,
    })
}

/// The heading after a comment: a comment is one if it names the columns, or their units.
fn with_comment<'a, const N: usize>(
    heading: Option<Heading<'a, N>>,
    line: usize,
    text: &'a str,
    wanted: &[Column<'_>; N],
) -> Option<Heading<'a, N>> {
    let mut heading = heading;
    if heading
        .as_mut()
        .is_some_and(|h| h.takes_units(text, wanted))
    {
        return heading;
    }
    match Heading::read(line, text, true, wanted) {
        Ok(found) if found.places.is_some() => Some(found),
        _ => heading,
    }
}

/// Which cells of a row are the wanted columns.
fn places<const N: usize>(
    number: usize,
    line: &str,
    count: usize,
    heading: Option<&Heading<'_, N>>,
    wanted: &[Column<'_>; N],
) -> Result<[usize; N], Error> {
    let names = named(wanted);
    match heading {
        Some(Heading {
            places: Some(places),
            count: named,
            ..
        }) if *named == count => Ok(*places),
        Some(Heading {
            places: Some(_),
            count: named,
            line: at,
            ..
        }) => {
            let reason = format!(
                "{line:?} has {count} columns: the heading in line {} names {named}",
                at + 1
            );
            Err(unreadable(number, reason))
        }
        _ if count != N => {
            let words: Vec<&str> = wanted.iter().map(|c| c.names[0]).collect();
            let has = if count == 1 { "column" } else { "columns" };
            let reason = format!(
                "{line:?} has {count} {has}: {} are needed, {names}, or a heading that names them, such as \"{}\"",
                COUNTS.get(N).unwrap_or(&"more"),
                words.join(",")
            );
            Err(unreadable(number, reason))
        }
        Some(unnamed) => {
            let reason = format!(
                "the heading {:?} does not name the columns {names}: name them, or put # before what is no heading",
                unnamed.text
            );
            Err(unreadable(unnamed.line, reason))
        }
        None => Ok(std::array::from_fn(|k| k)),
    }
}

impl<'a, const N: usize> Heading<'a, N> {
    fn read(
        line: usize,
        text: &'a str,
        is_comment: bool,
        wanted: &[Column<'_>; N],
    ) -> Result<Self, Error> {
        let cells = heading_cells(text);
        let mut found = wanted.map(|column| {
            let mut at = (0..cells.len()).filter(|&k| has_name(&cells[k], column.names));
            at.next().filter(|_| at.next().is_none())
        });
        let missing: Vec<usize> = (0..N).filter(|&k| found[k].is_none()).collect();
        if let [other] = missing[..]
            && wanted[other].is_other
            && cells.len() == N
        {
            found[other] = (0..N).find(|&k| !found.contains(&Some(k)));
        }
        let is_clear = (0..N).all(|k| found[k].is_some() && !found[..k].contains(&found[k]));
        let places = is_clear.then(|| found.map(Option::unwrap_or_default));
        let mut units = [None; N];
        if let Some(places) = places {
            for ((unit, column), place) in units.iter_mut().zip(wanted).zip(places) {
                *unit = unit_of(&cells[place], column.units)
                    .map_err(|reason| unreadable(line, reason))?;
            }
        }
        let count = cells.len();
        Ok(Self {
            line,
            text,
            is_comment,
            count,
            places,
            units,
        })
    }

    /// Takes up a line that says nothing but the units of the columns.
    fn takes_units(&mut self, line: &str, wanted: &[Column<'_>; N]) -> bool {
        let cells = cells(line);
        let Some(places) = self
            .places
            .filter(|_| cells.len() == self.count && self.units == [None; N])
        else {
            return false;
        };
        let named: [Option<f64>; N] = std::array::from_fn(|k| {
            let bare = cells[places[k]].trim_matches(['[', ']', '(', ')', ' ']);
            known(bare, wanted[k].units)
        });
        if named.iter().all(Option::is_some) {
            self.units = named;
            return true;
        }
        false
    }
}

/// What parts the cells of a line: semicolons, commas or blanks, the first of them that it has.
fn separator(line: &str) -> Option<char> {
    [';', ','].into_iter().find(|&c| line.contains(c))
}

/// A cell without blanks and quotes around it.
fn bare(cell: &str) -> &str {
    cell.trim().trim_matches(['"', '\'']).trim()
}

/// The number of a cell, be it with the exponent of Fortran as in 1.5D-03.
pub(crate) fn number_of(cell: &str) -> Option<f64> {
    cell.parse().ok().or_else(|| {
        let (digits, exponent) = cell.split_once(['d', 'D'])?;
        format!("{digits}e{exponent}").parse().ok()
    })
}

/// The cells of a line; empty ones count, but for those at its end.
fn cells(line: &str) -> Vec<&str> {
    let mut found: Vec<&str> = match separator(line) {
        Some(sign) => line.split(sign).map(bare).collect(),
        None => line.split_whitespace().map(bare).collect(),
    };
    while found.last().is_some_and(|cell| cell.is_empty()) {
        found.pop();
    }
    found
}

/// The cells of a heading: units in brackets or behind a stroke belong to the word before them.
fn heading_cells(text: &str) -> Vec<String> {
    if separator(text).is_some() || text.contains('\t') {
        let parted = text.replace('\t', if text.contains(';') { ";" } else { "," });
        return cells(&parted).into_iter().map(String::from).collect();
    }
    let mut found: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match found.last_mut() {
            Some(last) if word.starts_with(['[', '(', '/']) || last.ends_with('/') => {
                last.push(' ');
                last.push_str(word);
            }
            _ => found.push(bare(word).to_string()),
        }
    }
    found
}

/// Whether one of the words of a heading's cell, units in brackets left out, is one of `names`.
fn has_name(cell: &str, names: &[&str]) -> bool {
    let name = cell.split(['[', '(']).next().unwrap_or_default();
    name.split(|c: char| !c.is_alphabetic())
        .any(|word| names.contains(&word.to_lowercase().as_str()))
}

/// The unit that a heading's cell states; an error for one that is not known.
fn unit_of(cell: &str, units: &[(&str, f64)]) -> Result<Option<f64>, String> {
    let mut stated = None;
    if let Some((_, rest)) = cell.split_once('[') {
        stated = Some(rest.split(']').next().unwrap_or_default());
    } else if let Some((_, rest)) = cell.split_once('(') {
        stated = Some(rest.split(')').next().unwrap_or_default());
    }
    if stated.is_none() {
        let after = cell
            .char_indices()
            .filter(|(_, c)| " _-/".contains(*c))
            .map(|(k, c)| {
                let rest = cell[k + c.len_utf8()..].trim_start_matches(['/', ' ', '_']);
                rest.strip_prefix("in ").unwrap_or(rest)
            });
        // a sign needs nothing before it
        let sign = cell.find(['%', '‰']).map(|k| &cell[k..]);
        if let Some(found) = after.chain(sign).find_map(|rest| known(rest, units)) {
            return Ok(Some(found));
        }
        stated = sign
            .or_else(|| cell.split_once('/').map(|(_, rest)| rest))
            .or_else(|| cell.split_once(" in ").map(|(_, rest)| rest));
    }
    let Some(stated) = stated.map(bare).filter(|unit| !unit.is_empty()) else {
        return Ok(None);
    };
    known(stated, units).map(Some).ok_or_else(|| {
        let names: Vec<&str> = units.iter().map(|(name, _)| *name).collect();
        format!(
            "{cell:?} states a unit that is not known: known are {}",
            names.join(", ")
        )
    })
}

fn known(name: &str, units: &[(&str, f64)]) -> Option<f64> {
    let lower = name.trim().to_lowercase();
    let exact = units.iter().find(|(unit, _)| *unit == name.trim());
    let found = exact.or_else(|| units.iter().find(|(unit, _)| unit.to_lowercase() == lower));
    found.map(|&(_, factor)| factor)
}

/// A line without its comment.
pub(crate) fn content(line: &str) -> &str {
    let percent = line
        .match_indices('%')
        .map(|(at, _)| at)
        .find(|&at| !is_unit(line, at));
    let end = line
        .find(['#', '!'])
        .into_iter()
        .chain(line.find("//"))
        .chain(percent)
        .min()
        .unwrap_or(line.len());
    line[..end].trim()
}

/// Whether the percent sign at a place of a line stands where a unit does: in brackets, behind a stroke, a
/// letter or a digit, or as the last of a cell.
fn is_unit(line: &str, at: usize) -> bool {
    let (before, after) = (&line[..at], line[at + 1..].trim_start());
    let is_last = after.starts_with([',', ';', '"']);
    match before.trim_end().chars().last() {
        None => is_last,
        Some('[' | '(' | '/' | '_') => true,
        Some(_) => {
            is_last
                || after.is_empty()
                || after.starts_with([']', ')'])
                || (before.ends_with(char::is_alphanumeric)
                    && !line[at + 1..].starts_with(char::is_alphanumeric))
        }
    }
}

/// A line of numbers such as 1,5 between semicolons or tabs, with decimal points.
fn with_decimal_points(line: &str) -> Option<String> {
    let between = [';', '\t'].into_iter().find(|&c| line.contains(c))?;
    if !line.contains(',') || line.contains('.') {
        return None;
    }
    let pointed = line.replace(',', ".");
    let are_numbers = pointed
        .split(between)
        .map(bare)
        .all(|cell| cell.is_empty() || number_of(cell).is_some());
    are_numbers.then_some(pointed)
}

/// Whether numbers such as 1,5 stand between blanks or semicolons.
fn has_decimal_commas(line: &str) -> bool {
    let parts = || {
        line.split(|c: char| c.is_whitespace() || c == ';')
            .filter(|w| !w.is_empty())
    };
    let is_one = |part: &str| {
        part.split_once(',').is_some_and(|(whole, rest)| {
            number_of(whole).is_some()
                && rest.starts_with(|c: char| c.is_ascii_digit())
                && number_of(rest).is_some()
        })
    };
    parts().count() > 1 && parts().any(is_one)
}

/// Counts in words.
const COUNTS: [&str; 4] = ["none", "one", "two", "three"];

/// The columns by name, for messages.
fn named<const N: usize>(wanted: &[Column<'_>; N]) -> String {
    let names: Vec<&str> = wanted.iter().map(|c| c.names[0]).collect();
    match names.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} and {last}", rest.join(", ")),
        _ => names.concat(),
    }
}

fn not_numbers<const N: usize>(line: usize, text: &str, wanted: &[Column<'_>; N]) -> Error {
    let mut reason = format!(
        "{text:?} is not {} finite numbers, {}",
        COUNTS.get(N).unwrap_or(&"the"),
        named(wanted)
    );
    if text.contains(['%', '‰']) {
        reason.push_str(": a percent sign belongs to the heading, such as [%], not to the numbers");
    }
    unreadable(line, reason)
}

pub(crate) fn unreadable(line: usize, reason: String) -> Error {
    Error::Unreadable {
        line: line + 1,
        reason,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPEEDS: &[(&str, f64)] = &[("m/s", 1.0), ("km/h", 1.0 / 3.6)];
    const TABLE: [Column<'_>; 2] = [
        Column {
            names: &["velocity", "v"],
            units: SPEEDS,
            is_other: false,
        },
        Column {
            names: &["value"],
            units: &[("-", 1.0), ("MPa", 1e6)],
            is_other: true,
        },
    ];

    fn read(text: &str) -> Columns<2> {
        read_columns(text.lines().enumerate(), &TABLE).unwrap()
    }

    #[test]
    fn headings_give_order_and_units() {
        let rows = vec![[0.0, 0.1], [10.0, 0.2]];
        for text in [
            "0,0.1\n10,0.2",
            "v mu\n0 0.1\n10 0.2",
            "value,velocity\n0.1,0\n0.2,10",
            "mu;v\n0.1;0\n\n0.2;10\n",
            "\u{feff}\"mu\",\"sliding velocity\"\r\n\"0.1\",\"0\"\r\n0.2,10\r\n",
            "# of 2026, wet\n# value, velocity\n0.1,0\n0.2,10",
            "day,value,velocity\n1,0.1,0\n1,0.2,10",
            "velocity,value,\n0,0.1,\n10,0.2,",
        ] {
            let found = read(text);
            assert_eq!(
                (found.rows, found.units),
                (rows.clone(), [None; 2]),
                "{text}"
            );
        }
        for heading in [
            "v [km/h],value",
            "v (km/h) value",
            "v / km/h, value",
            "v_km/h;value",
            "v in km/h;value",
            "velocity KM/H,value [ - ]",
            "v,value\n[km/h],[-]",
            "# v value\n# km/h -",
        ] {
            let found = read(&format!("{heading}\n0 0.1\n10 0.2"));
            assert_eq!(
                (found.rows, found.units[0]),
                (rows.clone(), Some(1.0 / 3.6)),
                "{heading}"
            );
        }
    }

    const SHARES: [Column<'_>; 2] = [
        TABLE[0],
        Column {
            names: &["value"],
            units: &[("-", 1.0), ("%", 1e-2), ("percent", 1e-2), ("‰", 1e-3)],
            is_other: true,
        },
    ];

    #[test]
    fn a_percent_sign_where_a_unit_stands_is_one() {
        for (text, factor) in [
            ("v [km/h],value [%]\n0,35", 1e-2),
            ("v [km/h];value (%)\n0;35", 1e-2),
            ("v [km/h],value [ % ] % in rain\n0,35", 1e-2),
            ("value [%],v [km/h]\n35,0", 1e-2),
            ("v [km/h] value [%]\n0 35", 1e-2),
            ("# v [km/h], value [%]\n0,35", 1e-2),
            ("% v [km/h], value [%]\n0,35", 1e-2),
            ("v [km/h],value/%\n0,35", 1e-2),
            ("v_km/h,value_%\n0,35", 1e-2),
            ("v km/h,value %\n0,35", 1e-2),
            ("value%,v km/h\n35,0", 1e-2),
            ("v in km/h,friction in %\n0,35", 1e-2),
            ("v,value\n[km/h],[%]\n0,35", 1e-2),
            ("v,value\nkm/h,%\n0,35", 1e-2),
            ("value,v\n%,km/h\n35,0", 1e-2),
            ("value v\n% km/h\n35 0", 1e-2),
            ("v [km/h],value [percent]\n0,35", 1e-2),
            ("v [km/h],value percent\n0,35", 1e-2),
            ("v [km/h],value [‰]\n0,35", 1e-3),
            ("v [km/h],value ‰\n0,35", 1e-3),
            ("v [km/h],value [-] % 35 % wet\n0,35 % wet", 1.0),
        ] {
            let found = read_columns(text.lines().enumerate(), &SHARES).unwrap();
            assert_eq!(found.units, [Some(1.0 / 3.6), Some(factor)], "{text}");
            assert_eq!(found.rows, [[0.0, 35.0]], "{text}");
        }
        for text in ["v,value\n0,35%\n", "v;value\n0;35 %\n", "v value\n0 35% \n"] {
            let error = read_columns(text.lines().enumerate(), &SHARES).unwrap_err();
            let message = error.to_string();
            assert!(message.contains("belongs to the heading"), "{message}");
        }
        for text in ["v,value [% of 3]\n0,35", "v in furlongs,value\n0,35"] {
            let error = read_columns(text.lines().enumerate(), &SHARES).unwrap_err();
            assert!(error.to_string().contains("not known"), "{text}: {error}");
        }
    }

    #[test]
    fn three_columns_are_read_as_two_are() {
        let wanted = ["x", "y", "value"].map(|name| (name, [name]));
        let wanted = wanted.each_ref().map(|(name, names)| Column {
            names: names.as_slice(),
            units: &[("m", 1.0), ("mm", 1e-3)],
            is_other: *name == "value",
        });
        for text in [
            "1,2,3\n4,5,6",
            "x,y,value\n1,2,3\n4,5,6",
            "pull,y,x\n3,2,1\n6,5,4",
            "x p y\n# of 2026\n1 3 2\n4 6 5",
        ] {
            let found = read_columns(text.lines().enumerate(), &wanted).unwrap();
            assert_eq!(found.rows, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], "{text}");
            assert_eq!(found.lines[1], text.lines().count());
        }
        let error = read_columns("1,2".lines().enumerate(), &wanted).unwrap_err();
        let message = error.to_string();
        assert!(
            message.contains("three are needed, x, y and value"),
            "{message}"
        );
    }

    #[test]
    fn what_a_heading_does_not_say_is_refused_at_its_line() {
        for (text, at, message) in [
            (
                "a,b\n0,1\n",
                1,
                "does not name the columns velocity and value",
            ),
            ("v,velocity\n0,1\n", 1, "does not name"),
            ("v [furlong],value\n0,1\n", 1, "known are m/s, km/h"),
            ("v/knots,value\n0,1\n", 1, "known are m/s, km/h"),
            ("a,v,value\n0,1\n", 2, "the heading in line 1 names 3"),
            ("v,value\n0,,1\n", 2, "has 3 columns"),
            (
                "v,value\n,1\n",
                2,
                "is not two finite numbers, velocity and value",
            ),
            ("v,value\n0,1\nx,y\n", 3, "is not two finite numbers"),
            (
                "v;value\n0;0,3 0\n",
                2,
                "has decimal commas: write decimal points",
            ),
        ] {
            let error = read_columns(text.lines().enumerate(), &TABLE).unwrap_err();
            let Error::Unreadable { line, reason } = error else {
                unreachable!("{error}")
            };
            assert!(
                line == at && reason.contains(message),
                "{text}: {line} {reason}"
            );
        }
    }
}
