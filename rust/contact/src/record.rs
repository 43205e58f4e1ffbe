// SPDX-License-Identifier: MIT OR Apache-2.0
//! Arrays and counts as bytes for a file: a mark, version, length and checksum of what follows, then its parts.
//!
//! Little-endian throughout: counts and flags as u64, numbers as f64, arrays as a count and their entries.

use thiserror::Error;

const HEADER: usize = 24;

/// What is wrong with bytes that were to be a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct Damaged(pub &'static str);

/// A record being written.
pub struct Writer(Vec<u8>);

/// What is left of a record being read.
pub struct Reader<'a>(&'a [u8]);

impl Default for Writer {
    fn default() -> Self {
        Self(vec![0; HEADER])
    }
}

impl Writer {
    /// The record as bytes, with its header.
    pub fn finish(self, mark: [u8; 4], version: u32) -> Vec<u8> {
        let mut bytes = self.0;
        let (length, sum) = ((bytes.len() - HEADER) as u64, checksum(&bytes[HEADER..]));
        bytes[..4].copy_from_slice(&mark);
        bytes[4..8].copy_from_slice(&version.to_le_bytes());
        bytes[8..16].copy_from_slice(&length.to_le_bytes());
        bytes[16..24].copy_from_slice(&sum.to_le_bytes());
        bytes
    }

    /// Adds a count or a flag.
    pub fn count(&mut self, count: usize) {
        self.0.extend_from_slice(&(count as u64).to_le_bytes());
    }

    /// Adds counts with their number.
    pub fn counts(&mut self, counts: &[usize]) {
        self.count(counts.len());
        for count in counts {
            self.count(*count);
        }
    }

    /// Adds numbers with their number.
    pub fn array(&mut self, values: &[f64]) {
        self.count(values.len());
        self.0.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    }

    /// Adds a text with its length.
    pub fn text(&mut self, text: &str) {
        self.count(text.len());
        self.0.extend_from_slice(text.as_bytes());
    }

    /// Adds whether there is a value, and the value.
    pub fn option<T>(&mut self, value: Option<T>, write: impl FnOnce(&mut Self, T)) {
        self.count(usize::from(value.is_some()));
        if let Some(value) = value {
            write(self, value);
        }
    }
}

impl<'a> Reader<'a> {
    /// The parts of a record after its header.
    ///
    /// # Errors
    /// Bytes with another mark or version, cut short, or changed.
    pub fn open(bytes: &'a [u8], mark: [u8; 4], version: u32) -> Result<Self, Damaged> {
        Self::open_any(bytes, mark, &[version]).map(|(_, body)| body)
    }

    /// The same for a record of any of some versions, and the version that it is of.
    ///
    /// # Errors
    /// As [`Reader::open`].
    pub fn open_any(
        bytes: &'a [u8],
        mark: [u8; 4],
        versions: &[u32],
    ) -> Result<(u32, Self), Damaged> {
        if bytes.len() < HEADER || bytes[..4] != mark {
            return Err(Damaged("it does not begin as one"));
        }
        let mut header = Reader(&bytes[4..HEADER]);
        let found = header.take(4)?;
        let Some(&version) = versions.iter().find(|v| found == v.to_le_bytes()) else {
            return Err(Damaged("it is of another version"));
        };
        let (length, sum) = (header.word()?, header.word()?);
        let body = &bytes[HEADER..];
        if body.len() as u64 != length {
            return Err(Damaged("it is cut short or too long"));
        }
        if checksum(body) != sum {
            return Err(Damaged("its checksum is wrong"));
        }
        Ok((version, Self(body)))
    }

    /// Checks that nothing is left.
    ///
    /// # Errors
    /// Bytes that nobody read.
    pub fn close(self) -> Result<(), Damaged> {
        if self.0.is_empty() {
            Ok(())
        } else {
            Err(Damaged("it holds more than its parts"))
        }
    }

    fn take(&mut self, length: usize) -> Result<&'a [u8], Damaged> {
        let (head, tail) = self
            .0
            .split_at_checked(length)
            .ok_or(Damaged("a part is cut short"))?;
        self.0 = tail;
        Ok(head)
    }

    /// The next count or flag.
    ///
    /// # Errors
    /// A record that is cut short; so for all parts.
    pub fn word(&mut self) -> Result<u64, Damaged> {
        let mut word = [0; 8];
        word.copy_from_slice(self.take(8)?);
        Ok(u64::from_le_bytes(word))
    }

    /// The next count of things that are still to come.
    ///
    /// # Errors
    /// A count larger than what is left.
    pub fn count(&mut self) -> Result<usize, Damaged> {
        let count = self.word()?;
        usize::try_from(count)
            .ok()
            .filter(|c| *c <= self.0.len())
            .ok_or(Damaged("a count is larger than the whole"))
    }

    /// The next counts.
    ///
    /// # Errors
    /// As [`Reader::count`].
    pub fn counts(&mut self) -> Result<Vec<usize>, Damaged> {
        let count = self.count()?;
        let bytes = self.take(count.saturating_mul(8))?;
        let mut words = Reader(bytes);
        (0..count).map(|_| Ok(words.word()? as usize)).collect()
    }

    /// The next numbers.
    ///
    /// # Errors
    /// As [`Reader::count`].
    pub fn array(&mut self) -> Result<Vec<f64>, Damaged> {
        let count = self.count()?;
        let bytes = self.take(count.saturating_mul(8))?;
        Ok(bytes
            .chunks_exact(8)
            .map(|c| {
                let mut number = [0; 8];
                number.copy_from_slice(c);
                f64::from_le_bytes(number)
            })
            .collect())
    }

    /// The next numbers, as many as there must be.
    ///
    /// # Errors
    /// Another count.
    pub fn numbers<const N: usize>(&mut self) -> Result<[f64; N], Damaged> {
        self.array()?
            .try_into()
            .map_err(|_| Damaged("a part has more or fewer numbers than it must"))
    }

    /// The next text.
    ///
    /// # Errors
    /// Bytes that are no UTF-8.
    pub fn text(&mut self) -> Result<String, Damaged> {
        let length = self.count()?;
        String::from_utf8(self.take(length)?.to_vec()).map_err(|_| Damaged("a name is not text"))
    }

    /// The next value, if there is one.
    ///
    /// # Errors
    /// A flag that is none.
    pub fn option<T, E: From<Damaged>>(
        &mut self,
        read: impl FnOnce(&mut Self) -> Result<T, E>,
    ) -> Result<Option<T>, E> {
        match self.word()? {
            0 => Ok(None),
            1 => read(self).map(Some),
            _ => Err(Damaged("a flag is neither 0 nor 1").into()),
        }
    }
}

/// CRC-32: finds any two changed bits, and any run of 32.
fn checksum(bytes: &[u8]) -> u64 {
    u64::from(crc32fast::hash(bytes))
}
