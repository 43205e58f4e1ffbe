// SPDX-License-Identifier: MIT OR Apache-2.0
use crate::error::{Error, check};

/// Rows of numbers over rising speeds, linear between them; a single row holds at all speeds.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    speed: Vec<f64>,
    rows: Vec<Vec<f64>>,
}

impl Table {
    /// A row that holds at all speeds.
    pub fn constant(row: Vec<f64>) -> Self {
        Self {
            speed: vec![0.0],
            rows: vec![row],
        }
    }

    /// One row for each of the rising `speed` [m/s].
    ///
    /// # Errors
    /// Not as many rows as speeds; speeds that do not rise; rows of unlike length; numbers that are not finite.
    pub fn new(speed: Vec<f64>, rows: Vec<Vec<f64>>) -> Result<Self, Error> {
        check("speed", &speed, rows.len())?;
        if let Some(k) = (1..speed.len()).find(|&k| speed[k] <= speed[k - 1]) {
            return Err(Error::NotPositive {
                name: "step of speed",
                index: k,
                value: speed[k] - speed[k - 1],
            });
        }
        let table = Self { speed, rows };
        table.check("row", table.rows.first().map_or(0, Vec::len))?;
        Ok(table)
    }

    /// Speeds [m/s].
    pub fn speed(&self) -> &[f64] {
        &self.speed
    }

    /// Rows, one for each speed.
    pub fn rows(&self) -> &[Vec<f64>] {
        &self.rows
    }

    pub(crate) fn check(&self, name: &'static str, length: usize) -> Result<(), Error> {
        if self.rows.is_empty() {
            return Err(Error::Shape {
                name,
                expected: 1,
                found: 0,
            });
        }
        self.rows
            .iter()
            .try_for_each(|row| check(name, row, length))
    }

    /// The row at `speed`; `name` is what a message calls the quantity.
    ///
    /// # Errors
    /// A speed outside the table.
    pub fn at(&self, name: &'static str, speed: f64) -> Result<Vec<f64>, Error> {
        if let [row] = self.rows.as_slice() {
            return Ok(row.clone());
        }
        let (upper, weight) = self.between(name, speed)?;
        let row = self.rows[upper - 1].iter().zip(&self.rows[upper]);
        Ok(row.map(|(a, b)| (1.0 - weight) * a + weight * b).collect())
    }

    /// The entry of each column at a speed of its own.
    ///
    /// # Errors
    /// A speed outside the table.
    pub(crate) fn at_each(&self, name: &'static str, speeds: &[f64]) -> Result<Vec<f64>, Error> {
        if let [row] = self.rows.as_slice() {
            return Ok(row.clone());
        }
        let entries = speeds.iter().enumerate().map(|(column, &speed)| {
            let (upper, weight) = self.between(name, speed)?;
            let (a, b) = (self.rows[upper - 1][column], self.rows[upper][column]);
            Ok((1.0 - weight) * a + weight * b)
        });
        entries.collect()
    }

    /// Derivative [1/(m/s)] of the entry of each column by the speed, at one of its own inside the table: at one of the
    /// table on the side that the entry is taken from, the one below.
    pub(crate) fn slopes(&self, speeds: &[f64]) -> Vec<f64> {
        let slope = |(column, &speed): (usize, &f64)| {
            if self.rows.len() == 1 {
                return 0.0;
            }
            let high = self.upper(speed);
            let rise = self.rows[high][column] - self.rows[high - 1][column];
            rise / (self.speed[high] - self.speed[high - 1])
        };
        speeds.iter().enumerate().map(slope).collect()
    }

    /// The row above a speed inside the table, and its weight beside the one below.
    fn between(&self, name: &'static str, speed: f64) -> Result<(usize, f64), Error> {
        let (first, last) = (self.speed[0], self.speed[self.speed.len() - 1]);
        if !(first..=last).contains(&speed) {
            return Err(Error::OutsideTable {
                name,
                speed,
                first,
                last,
            });
        }
        let upper = self.upper(speed);
        let (low, high) = (self.speed[upper - 1], self.speed[upper]);
        Ok((upper, (speed - low) / (high - low)))
    }

    /// The same of all of them at one speed.
    pub(super) fn slope(&self, speed: f64) -> Vec<f64> {
        self.slopes(&vec![speed; self.rows[0].len()])
    }

    /// The first row beyond `speed`.
    fn upper(&self, speed: f64) -> usize {
        let beyond = self.speed.partition_point(|v| *v < speed).max(1);
        beyond.min(self.speed.len() - 1)
    }
}
