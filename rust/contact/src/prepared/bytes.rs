//! A prepared contact as bytes: `MTBC`, version, length and checksum of what follows, then its parts in order.
//!
//! Little-endian throughout: counts and flags as u64, numbers as f64, arrays as a count and their entries.

use std::sync::Arc;

use super::{FreeMotion, Geometry, Means, Prepared, Table};
use crate::error::Error;
use crate::sliding::RigidMotion;
use crate::stepping::Influence;

const MAGIC: &[u8; 4] = b"MTBC";
const VERSION: u32 = 1;
const HEADER: usize = 24;

impl Prepared {
    /// The contact as bytes, for a file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = Writer(vec![0; HEADER]);
        let g = &self.geometry;
        out.array(&g.area);
        for field in [&g.points, &g.normal, &g.tangent_x, &g.tangent_y] {
            out.array(field);
        }
        for field in &g.mean_frame {
            out.array(field);
        }
        out.option(g.means.as_ref(), |out, means| {
            out.counts(&means.start);
            out.counts(&means.column);
            out.array(&means.share);
        });
        out.array(self.influence.normal());
        for block in self.influence.along() {
            out.option(block, Writer::array);
        }
        out.count(self.motions.len());
        for free in &self.motions {
            out.count(free.name.len());
            out.0.extend_from_slice(free.name.as_bytes());
            out.option(free.component, Writer::count);
            out.array(&free.motion.tangential_x);
            out.array(&free.motion.tangential_y);
            out.array(&free.motion.opening);
        }
        for table in [&self.friction, &self.loads] {
            out.array(table.speed());
            table.rows().iter().for_each(|row| out.array(row));
        }
        out.option(self.magnetic.as_ref(), |out, parts| {
            for part in parts {
                out.array(part);
            }
        });
        out.array(&self.sliding_direction);
        out.array(&self.reference_point);
        out.option(self.standstill_speed, |out, speed| out.array(&[speed]));
        let mut bytes = out.0;
        let (length, sum) = ((bytes.len() - HEADER) as u64, checksum(&bytes[HEADER..]));
        bytes[..4].copy_from_slice(MAGIC);
        bytes[4..8].copy_from_slice(&VERSION.to_le_bytes());
        bytes[8..16].copy_from_slice(&length.to_le_bytes());
        bytes[16..24].copy_from_slice(&sum.to_le_bytes());
        bytes
    }

    /// The contact that [`Prepared::to_bytes`] wrote.
    ///
    /// # Errors
    /// Bytes that are none, of another version, cut short, changed, or that do not fit together.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Error> {
        if bytes.len() < HEADER || &bytes[..4] != MAGIC {
            return Err(Error::Stored("it does not begin as one"));
        }
        let mut header = Reader(&bytes[4..HEADER]);
        if header.take(4)? != VERSION.to_le_bytes() {
            return Err(Error::Stored("it is of another version"));
        }
        let (length, sum) = (header.word()?, header.word()?);
        let body = &bytes[HEADER..];
        if body.len() as u64 != length {
            return Err(Error::Stored("it is cut short or too long"));
        }
        if checksum(body) != sum {
            return Err(Error::Stored("its checksum is wrong"));
        }
        let mut body = Reader(body);
        let area = body.array()?;
        let geometry = Geometry {
            points: body.array()?,
            normal: body.array()?,
            tangent_x: body.array()?,
            tangent_y: body.array()?,
            mean_frame: [body.array()?, body.array()?, body.array()?],
            means: body.option(|body| {
                Ok(Means {
                    start: body.counts()?,
                    column: body.counts()?,
                    share: body.array()?,
                })
            })?,
            area,
        };
        let normal = body.array()?;
        let along = [body.option(Reader::array)?, body.option(Reader::array)?];
        let influence = Influence::from_columns(geometry.points(), normal, along)?;
        let count = body.count()?;
        let motions: Result<Vec<FreeMotion>, Error> = (0..count).map(|_| body.motion()).collect();
        let prepared = Self {
            influence: Arc::new(influence),
            geometry,
            motions: motions?,
            friction: body.table()?,
            loads: body.table()?,
            magnetic: body.option(|body| Ok([body.array()?, body.array()?]))?,
            sliding_direction: body
                .array()?
                .try_into()
                .map_err(|_| Error::Stored("its sliding direction is none"))?,
            reference_point: body
                .array()?
                .try_into()
                .map_err(|_| Error::Stored("its reference point is none"))?,
            standstill_speed: body.option(Reader::array)?.and_then(|v| v.first().copied()),
        };
        if !body.0.is_empty() {
            return Err(Error::Stored("it holds more than its parts"));
        }
        prepared.check()?;
        Ok(prepared)
    }
}

struct Writer(Vec<u8>);

impl Writer {
    fn count(&mut self, count: usize) {
        self.0.extend_from_slice(&(count as u64).to_le_bytes());
    }

    fn counts(&mut self, counts: &[usize]) {
        self.count(counts.len());
        for count in counts {
            self.count(*count);
        }
    }

    fn array(&mut self, values: &[f64]) {
        self.count(values.len());
        self.0.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    }

    fn option<T>(&mut self, value: Option<T>, write: impl FnOnce(&mut Self, T)) {
        self.count(usize::from(value.is_some()));
        if let Some(value) = value {
            write(self, value);
        }
    }
}

struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn take(&mut self, length: usize) -> Result<&'a [u8], Error> {
        let (head, tail) = self
            .0
            .split_at_checked(length)
            .ok_or(Error::Stored("a part is cut short"))?;
        self.0 = tail;
        Ok(head)
    }

    fn word(&mut self) -> Result<u64, Error> {
        let mut word = [0; 8];
        word.copy_from_slice(self.take(8)?);
        Ok(u64::from_le_bytes(word))
    }

    fn count(&mut self) -> Result<usize, Error> {
        let count = self.word()?;
        usize::try_from(count)
            .ok()
            .filter(|c| *c <= self.0.len())
            .ok_or(Error::Stored("a count is larger than the whole"))
    }

    fn counts(&mut self) -> Result<Vec<usize>, Error> {
        let count = self.count()?;
        let bytes = self.take(count.saturating_mul(8))?;
        let mut words = Reader(bytes);
        (0..count).map(|_| Ok(words.word()? as usize)).collect()
    }

    fn array(&mut self) -> Result<Vec<f64>, Error> {
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

    fn option<T>(
        &mut self,
        read: impl FnOnce(&mut Self) -> Result<T, Error>,
    ) -> Result<Option<T>, Error> {
        match self.word()? {
            0 => Ok(None),
            1 => read(self).map(Some),
            _ => Err(Error::Stored("a flag is neither 0 nor 1")),
        }
    }

    fn table(&mut self) -> Result<Table, Error> {
        let speed = self.array()?;
        let rows: Result<Vec<Vec<f64>>, Error> = speed.iter().map(|_| self.array()).collect();
        Table::new(speed, rows?)
    }

    fn motion(&mut self) -> Result<FreeMotion, Error> {
        let length = self.count()?;
        let name = String::from_utf8(self.take(length)?.to_vec())
            .map_err(|_| Error::Stored("a name is not text"))?;
        let component = self.option(Self::word)?.map(|c| c as usize);
        if component.is_some_and(|c| c > 5) {
            return Err(Error::Stored("a motion has no such component"));
        }
        Ok(FreeMotion {
            name,
            component,
            motion: RigidMotion {
                tangential_x: self.array()?,
                tangential_y: self.array()?,
                opening: self.array()?,
                work: 0.0,
            },
        })
    }
}

/// 64-bit FNV-1a over eight bytes at a time; the last ones filled up with zeros.
fn checksum(bytes: &[u8]) -> u64 {
    bytes.chunks(8).fold(0xcbf2_9ce4_8422_2325, |sum, chunk| {
        let mut word = [0; 8];
        word[..chunk.len()].copy_from_slice(chunk);
        (sum ^ u64::from_le_bytes(word)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}
