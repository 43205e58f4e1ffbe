// SPDX-License-Identifier: MIT OR Apache-2.0
use std::collections::BTreeMap;
use std::ops::Range;

use crate::contact::Contact;

/// The variables that the description of a unit has, each with its numbers.
///
/// Numbers are counted through inputs, then outputs. The value reference of a variable is its first number.
#[derive(Debug)]
pub(crate) struct Variables {
    known: BTreeMap<u32, Variable>,
    /// How many inputs the contact has.
    inputs: usize,
}

/// A variable: its count of numbers, and what it is.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Variable {
    kind: Kind,
    size: usize,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Input,
    Output,
    Time,
}

/// Where a number is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Place {
    Input(usize),
    Output(usize),
    Time,
}

impl Variables {
    /// The variables, and the first inputs, by lines: `input`, value reference and first values; `output`, value
    /// reference and count; `time` and value reference.
    ///
    /// # Errors
    /// The line that is none.
    pub(crate) fn read(lines: &str, contact: &dyn Contact) -> Result<(Self, Vec<f64>), String> {
        let inputs = contact.inputs();
        let all = inputs + contact.outputs();
        let mut starts: Vec<f64> = (0..inputs).map(|k| contact.default(k)).collect();
        let mut known = BTreeMap::new();
        for line in lines.lines() {
            let taken = take(line, inputs, all, &mut starts, &mut known);
            taken.ok_or_else(|| format!("{line:?} is no variable of such a contact"))?;
        }
        Ok((Self { known, inputs }, starts))
    }

    /// Whether each variable is one number.
    pub(crate) fn are_scalar(&self) -> bool {
        self.known.values().all(|variable| variable.size == 1)
    }

    /// The places of all numbers of some variables.
    ///
    /// # Errors
    /// A value reference that no variable has.
    pub(crate) fn places(&self, references: &[u32]) -> Result<Vec<Place>, String> {
        let mut places = Vec::new();
        for &reference in references {
            let variable = self.at(reference)?;
            let first = reference as usize;
            places.extend(
                (first..first + variable.size).map(|number| match variable.kind {
                    Kind::Input => Place::Input(number),
                    Kind::Output => Place::Output(number - self.inputs),
                    Kind::Time => Place::Time,
                }),
            );
        }
        Ok(places)
    }

    /// The numbers of some inputs, with the value reference of each.
    ///
    /// # Errors
    /// A value reference that no input has.
    pub(crate) fn inputs(&self, references: &[u32]) -> Result<Vec<(u32, usize)>, String> {
        self.of(references, Kind::Input, "input")
    }

    /// The numbers of some outputs, counted from the first one, with the value reference of each.
    ///
    /// # Errors
    /// A value reference that no output has.
    pub(crate) fn outputs(&self, references: &[u32]) -> Result<Vec<(u32, usize)>, String> {
        let mut found = self.of(references, Kind::Output, "output")?;
        for (_, number) in &mut found {
            *number -= self.inputs;
        }
        Ok(found)
    }

    fn of(&self, references: &[u32], kind: Kind, word: &str) -> Result<Vec<(u32, usize)>, String> {
        let mut found = Vec::new();
        for &reference in references {
            let variable = self.at(reference)?;
            if variable.kind != kind {
                return Err(format!("value reference {reference} is no {word}"));
            }
            let first = reference as usize;
            found.extend((first..first + variable.size).map(|number| (reference, number)));
        }
        Ok(found)
    }

    fn at(&self, reference: u32) -> Result<Variable, String> {
        self.known.get(&reference).copied().ok_or_else(|| {
            let all: Vec<String> = self.known.keys().map(u32::to_string).collect();
            format!(
                "value reference {reference} is no variable of this unit: its description has {}",
                all.join(", ")
            )
        })
    }
}

/// Takes a line; `None` where it is none.
fn take(
    line: &str,
    inputs: usize,
    all: usize,
    starts: &mut [f64],
    known: &mut BTreeMap<u32, Variable>,
) -> Option<()> {
    let mut words = line.split(' ');
    let kind = words.next()?;
    let reference: u32 = words.next()?.parse().ok()?;
    let first = reference as usize;
    let within = |size: usize, range: Range<usize>| {
        let end = first.checked_add(size)?;
        (size > 0 && range.contains(&first) && end <= range.end).then_some(())
    };
    let (kind, size) = match kind {
        "input" => {
            let values: Option<Vec<f64>> = words.map(|word| word.parse().ok()).collect();
            let values = values.filter(|values| values.iter().all(|v| v.is_finite()))?;
            within(values.len(), 0..inputs)?;
            starts[first..first + values.len()].copy_from_slice(&values);
            (Kind::Input, values.len())
        }
        "output" => {
            let size = words.next()?.parse().ok()?;
            within(size, inputs..all)?;
            (Kind::Output, size)
        }
        "time" => {
            within(1, all..all + 1)?;
            (Kind::Time, 1)
        }
        _ => return None,
    };
    known.insert(reference, Variable { kind, size });
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three inputs and two outputs.
    struct Few;

    impl Contact for Few {
        fn inputs(&self) -> usize {
            3
        }
        fn outputs(&self) -> usize {
            2
        }
        fn default(&self, _: usize) -> f64 {
            -1.0
        }
        fn solve(&mut self, _: &[f64], _: f64) -> Result<Vec<f64>, String> {
            Err(String::new())
        }
        fn follows_memory(&self) -> bool {
            false
        }

        fn has_step(&self) -> bool {
            false
        }
        fn derivatives(&mut self) -> Result<Vec<Vec<f64>>, String> {
            Err(String::new())
        }
        fn memory(&self) -> Vec<f64> {
            Vec::new()
        }
        fn resume(&mut self, _: &[f64]) -> Result<(), String> {
            Ok(())
        }
        fn forget(&mut self) {}
    }

    #[test]
    fn arrays_are_many_numbers_of_one_reference() {
        let lines = "input 1 2.5 0.5\noutput 3 2\ntime 5\n";
        let (variables, starts) = Variables::read(lines, &Few).unwrap();
        assert_eq!(starts, [-1.0, 2.5, 0.5]);
        assert!(!variables.are_scalar());
        let places = [
            Place::Output(0),
            Place::Output(1),
            Place::Input(1),
            Place::Input(2),
            Place::Time,
        ];
        assert_eq!(variables.places(&[3, 1, 5]).unwrap(), places);
        assert_eq!(variables.inputs(&[1]).unwrap(), [(1, 1), (1, 2)]);
        assert_eq!(variables.outputs(&[3]).unwrap(), [(3, 0), (3, 1)]);
        assert_eq!(
            variables.places(&[2]).unwrap_err(),
            "value reference 2 is no variable of this unit: its description has 1, 3, 5"
        );
        assert_eq!(
            variables.inputs(&[5]).unwrap_err(),
            "value reference 5 is no input"
        );
    }

    #[test]
    fn lines_that_are_no_variables_are_refused() {
        for line in [
            "",
            "input",
            "input 1",
            "input 2 1.0 2.0",
            "input 3 1.0",
            "input 0 nan",
            "input 0 x",
            "input -1 1.0",
            "input 99999999999 1.0",
            "output 2 1",
            "output 3 0",
            "output 3 3",
            "output 4 18446744073709551615",
            "time 4",
            "else 0 1.0",
        ] {
            let lines = format!("output 3 1\n{line}\n");
            let refused = Variables::read(&lines, &Few).unwrap_err();
            assert_eq!(
                refused,
                format!("{line:?} is no variable of such a contact")
            );
        }
    }
}
