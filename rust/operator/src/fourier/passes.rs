// SPDX-License-Identifier: MIT OR Apache-2.0
//! The passes of a product over memory: rows forward, columns forward, multiplied and back, rows back.
//!
//! Between the passes the spectra lie in blocks of [`BLOCK`] columns. A group of rows reads and writes one
//! stretch of each block, and a block of columns is one stretch of memory that is overwritten in place.

use rustfft::num_complex::Complex;

use super::buffers::{Scratch, room};
use super::chunks::{each_chunk, transform_work};
use super::{Kernel, Precision, Transform};
use crate::monitor::{Monitor, unmonitored};

/// Columns of the spectrum that are gathered, transformed and scattered together.
const BLOCK: usize = 8;

/// Rows that are transformed one after the other, so that they share stretches of the blocks.
const GROUP: usize = 8;

/// Spectra of fields between the passes: `[block of columns][field][row][column in block]`.
#[derive(Clone, Copy)]
pub(super) struct Layout {
    pub(super) columns: usize,
    pub(super) inputs: usize,
    pub(super) outputs: usize,
    /// Rows of each input, and of each output.
    pub(super) rows_in: usize,
    pub(super) rows_out: usize,
}

impl Layout {
    pub(super) fn len(self) -> usize {
        self.columns.div_ceil(BLOCK) * self.block()
    }

    fn block(self) -> usize {
        self.inputs.max(self.outputs) * self.field()
    }

    /// One row more than there are: strides of powers of two would crowd all blocks into a few cache lines.
    fn field(self) -> usize {
        (self.rows_in.max(self.rows_out) | 1) * BLOCK
    }
}

/// Some rows of one input from the `first` on, in all blocks.
struct Group<'a, T> {
    field: usize,
    first: usize,
    stretches: Vec<&'a mut [Complex<T>]>,
}

impl<'a, T> Group<'a, T> {
    fn all(layout: Layout, spectra: &'a mut [Complex<T>]) -> Vec<Self> {
        let numbers = (0..layout.inputs).flat_map(|field| {
            let firsts = (0..layout.rows_in).step_by(GROUP);
            firsts.map(move |first| (field, first))
        });
        let mut groups: Vec<Self> = numbers
            .map(|(field, first)| Self {
                field,
                first,
                stretches: Vec::with_capacity(layout.columns.div_ceil(BLOCK)),
            })
            .collect();
        for block in spectra.chunks_mut(layout.block()) {
            let stretches = block
                .chunks_mut(layout.field())
                .take(layout.inputs)
                .flat_map(|rows| rows[..layout.rows_in * BLOCK].chunks_mut(GROUP * BLOCK));
            for (group, stretch) in groups.iter_mut().zip(stretches) {
                group.stretches.push(stretch);
            }
        }
        groups
    }
}

/// Columns of one block, each contiguous.
pub(super) struct Columns<'a, T> {
    values: &'a mut [Complex<T>],
    len: usize,
}

impl<'a, T: Precision> Columns<'a, T> {
    /// Distance of columns: no power of two, which keeps them out of each other's cache lines.
    fn stride(len: usize) -> usize {
        len + BLOCK
    }

    fn new(buffer: &'a mut Vec<Complex<T>>, len: usize, fields: usize) -> Self {
        let values = room(buffer, fields * BLOCK * Self::stride(len));
        Self { values, len }
    }

    fn of(&mut self, field: usize) -> Columns<'_, T> {
        let size = BLOCK * Self::stride(self.len);
        Columns {
            values: &mut self.values[field * size..(field + 1) * size],
            len: self.len,
        }
    }

    /// One column of one field.
    fn at(&self, field: usize, c: usize) -> &[Complex<T>] {
        let from = (field * BLOCK + c) * Self::stride(self.len);
        &self.values[from..from + self.len]
    }

    pub(super) fn column_mut(&mut self, c: usize) -> &mut [Complex<T>] {
        let from = c * Self::stride(self.len);
        &mut self.values[from..from + self.len]
    }

    /// Takes row `k` of `rows` as the entries number `place(k)`.
    fn gather(&mut self, rows: &[Complex<T>], place: impl Fn(usize) -> usize) {
        let stride = Self::stride(self.len);
        for (k, row) in rows.as_chunks::<BLOCK>().0.iter().enumerate() {
            let at = place(k);
            for (c, v) in row.iter().enumerate() {
                self.values[c * stride + at] = *v;
            }
        }
    }

    /// Writes the first entries to the rows.
    fn scatter(&self, rows: &mut [Complex<T>]) {
        let stride = Self::stride(self.len);
        for (k, row) in rows.as_chunks_mut::<BLOCK>().0.iter_mut().enumerate() {
            for (c, v) in row.iter_mut().enumerate() {
                *v = self.values[c * stride + k];
            }
        }
    }
}

impl<T: Precision> Transform<T> {
    /// Transforms the rows that `fill` writes, by number of field and row, and lays out what `pick` leaves at
    /// the front of their spectra.
    pub(super) fn forward_rows(
        &self,
        layout: Layout,
        spectra: &mut [Complex<T>],
        fill: impl Fn(&mut [T], usize, usize) + Sync + Send,
        pick: impl Fn(&mut [Complex<T>]) + Sync + Send,
        cost: f64,
        monitor: Monitor<'_>,
    ) {
        let [mx, _] = self.padded;
        let nkx = self.waves_x();
        each_chunk(
            monitor,
            GROUP as f64 * (cost + transform_work(mx)),
            self.is_parallel(),
            &mut Group::all(layout, spectra),
            1,
            || T::pools(&self.buffers).scratch(),
            |scratch, _, groups| {
                let scratch: &mut Scratch<T> = scratch;
                let row = room(&mut scratch.row, mx);
                let spectrum = room(&mut scratch.spectrum, nkx.next_multiple_of(BLOCK));
                let work = room(&mut scratch.work, self.rows.get_scratch_len());
                for group in groups {
                    let rows = group.stretches.first().map_or(0, |s| s.len() / BLOCK);
                    for k in 0..rows {
                        fill(row, group.field, group.first + k);
                        let waves = &mut spectrum[..nkx];
                        let done = self.rows.process_with_scratch(row, waves, work);
                        debug_assert!(done.is_ok());
                        pick(waves);
                        let (parts, _) = spectrum.as_chunks::<BLOCK>();
                        for (stretch, part) in group.stretches.iter_mut().zip(parts) {
                            stretch.as_chunks_mut().0[k] = *part;
                        }
                    }
                }
            },
        );
    }

    /// Takes the rows of the one input as entries number `place(row)` of columns that are zero elsewhere, lets
    /// `complete` them, transforms them, and lets `keep` take each to its part of `values`, `size` of these a column.
    #[expect(
        clippy::too_many_arguments,
        reason = "what two kinds of kernels do in different ways"
    )]
    pub(super) fn kernel_columns<V: Send>(
        &self,
        layout: Layout,
        spectra: &[Complex<T>],
        place: impl Fn(usize) -> usize + Sync + Send,
        complete: impl Fn(&mut [Complex<T>]) + Sync + Send,
        values: &mut [V],
        size: usize,
        keep: impl Fn(&[Complex<T>], &mut [V]) + Sync + Send,
        monitor: Monitor<'_>,
    ) {
        let [_, my] = self.padded;
        each_chunk(
            monitor,
            BLOCK as f64 * transform_work(my),
            self.is_parallel(),
            values,
            BLOCK * size,
            || T::pools(&self.buffers).scratch(),
            |scratch, block, out| {
                let scratch: &mut Scratch<T> = scratch;
                let mut columns = Columns::new(&mut scratch.columns, my, 1);
                let work = room(&mut scratch.work, self.columns.get_inplace_scratch_len());
                columns.values.fill(Complex::default());
                let from = block * layout.block();
                columns.gather(&spectra[from..from + layout.rows_in * BLOCK], &place);
                for (c, out) in out.chunks_mut(size).enumerate() {
                    let column = columns.column_mut(c);
                    complete(column);
                    self.columns.process_with_scratch(column, work);
                    keep(column, out);
                }
            },
        );
    }

    /// Transforms the columns of the inputs, whose rows begin at `first`, multiplies them with the kernels,
    /// and overwrites them by the columns of the outputs, transformed back.
    pub(super) fn multiply_columns(
        &self,
        (kernels, factor): (&[&[Option<&Kernel>]], f64),
        layout: Layout,
        spectra: &mut [Complex<T>],
        first: usize,
        monitor: Monitor<'_>,
    ) {
        let [_, my] = self.padded;
        let loaded = first..first + layout.rows_in;
        let work_len = self
            .columns
            .get_inplace_scratch_len()
            .max(self.columns_back.get_inplace_scratch_len());
        each_chunk(
            monitor,
            (BLOCK * (layout.inputs + layout.outputs)) as f64 * transform_work(my),
            self.is_parallel(),
            spectra,
            layout.block(),
            || T::pools(&self.buffers).scratch(),
            |scratch, block, fields| {
                let scratch: &mut Scratch<T> = scratch;
                let mut columns = Columns::new(&mut scratch.columns, my, layout.inputs);
                let mut product = Columns::new(&mut scratch.product, my, 1);
                let work = room(&mut scratch.work, work_len);
                let width = BLOCK.min(layout.columns - block * BLOCK);
                for (input, rows) in fields
                    .chunks(layout.field())
                    .take(layout.inputs)
                    .enumerate()
                {
                    let mut columns = columns.of(input);
                    columns.gather(&rows[..layout.rows_in * BLOCK], |row| first + row);
                    for c in 0..width {
                        let column = columns.column_mut(c);
                        column[..loaded.start].fill(Complex::default());
                        column[loaded.end..].fill(Complex::default());
                        self.columns.process_with_scratch(column, work);
                    }
                }
                let place = (block, width);
                let column = |input: usize, c: usize| columns.at(input, c);
                let kernels = (kernels, factor);
                self.multiply_block(kernels, layout, place, column, &mut product, work, fields);
            },
        );
    }

    /// Overwrites a block of columns by the products of kernels with those of the inputs, transformed back.
    #[expect(
        clippy::too_many_arguments,
        reason = "what two kinds of products share"
    )]
    fn multiply_block<'c>(
        &self,
        (kernels, factor): (&[&[Option<&Kernel>]], f64),
        layout: Layout,
        (block, width): (usize, usize),
        column: impl Fn(usize, usize) -> &'c [Complex<T>],
        product: &mut Columns<'_, T>,
        work: &mut [Complex<T>],
        fields: &mut [Complex<T>],
    ) {
        for (kernels, rows) in kernels.iter().zip(fields.chunks_mut(layout.field())) {
            for c in 0..width {
                let product = product.column_mut(c);
                let mut is_first = true;
                for (input, kernel) in kernels.iter().enumerate() {
                    if let Some(kernel) = kernel {
                        kernel.multiply(
                            block * BLOCK + c,
                            column(input, c),
                            product,
                            (is_first, factor),
                        );
                        is_first = false;
                    }
                }
                if is_first {
                    product.fill(Complex::default());
                } else {
                    self.columns_back.process_with_scratch(product, work);
                }
            }
            product.scatter(&mut rows[..layout.rows_out * BLOCK]);
        }
    }

    /// The columns of the inputs, whose rows begin at `first`, transformed: `[input][wave along x][wave along y]`.
    pub(super) fn transformed_columns(
        &self,
        layout: Layout,
        spectra: &[Complex<T>],
        first: usize,
    ) -> Vec<Complex<T>> {
        let [_, my] = self.padded;
        let mut values = vec![Complex::default(); layout.inputs * layout.columns * my];
        let work_len = self.columns.get_inplace_scratch_len();
        each_chunk(
            &unmonitored,
            transform_work(my),
            self.is_parallel(),
            &mut values,
            my,
            || T::pools(&self.buffers).scratch(),
            |scratch, k, column| {
                let scratch: &mut Scratch<T> = scratch;
                let work = room(&mut scratch.work, work_len);
                let (input, kx) = (k / layout.columns, k % layout.columns);
                let from = kx / BLOCK * layout.block() + input * layout.field() + kx % BLOCK;
                for (j, value) in column[first..first + layout.rows_in].iter_mut().enumerate() {
                    *value = spectra[from + j * BLOCK];
                }
                self.columns.process_with_scratch(column, work);
            },
        );
        values
    }

    /// Writes the columns of the outputs, transformed back, from columns that [`Self::transformed_columns`] gave.
    pub(super) fn multiply_transformed(
        &self,
        (kernels, factor): (&[&[Option<&Kernel>]], f64),
        layout: Layout,
        transformed: &[Complex<T>],
        spectra: &mut [Complex<T>],
    ) {
        let [_, my] = self.padded;
        let work_len = self.columns_back.get_inplace_scratch_len();
        each_chunk(
            &unmonitored,
            (BLOCK * layout.outputs) as f64 * transform_work(my),
            self.is_parallel(),
            spectra,
            layout.block(),
            || T::pools(&self.buffers).scratch(),
            |scratch, block, fields| {
                let scratch: &mut Scratch<T> = scratch;
                let mut product = Columns::new(&mut scratch.product, my, 1);
                let work = room(&mut scratch.work, work_len);
                let width = BLOCK.min(layout.columns - block * BLOCK);
                let column = |input: usize, c: usize| {
                    let from = (input * layout.columns + block * BLOCK + c) * my;
                    &transformed[from..from + my]
                };
                let place = (block, width);
                let kernels = (kernels, factor);
                self.multiply_block(kernels, layout, place, column, &mut product, work, fields);
            },
        );
    }

    /// Transforms the rows of the outputs back and writes each to its target, or adds it, times `scale`.
    pub(super) fn inverse_rows(
        &self,
        layout: Layout,
        spectra: &[Complex<T>],
        (scale, adds): (f64, bool),
        outputs: &mut [&mut [f64]],
        monitor: Monitor<'_>,
    ) {
        let [nx, _] = self.target;
        let [mx, _] = self.padded;
        let nkx = layout.columns;
        for (output, y) in outputs.iter_mut().enumerate() {
            each_chunk(
                monitor,
                GROUP as f64 * transform_work(mx),
                self.is_parallel(),
                y,
                GROUP * nx,
                || T::pools(&self.buffers).scratch(),
                |scratch, group, y| {
                    let scratch: &mut Scratch<T> = scratch;
                    let row = room(&mut scratch.row, mx);
                    let spectrum = room(&mut scratch.spectrum, nkx.next_multiple_of(BLOCK));
                    let work = room(&mut scratch.work, self.rows_back.get_scratch_len());
                    for (k, y) in y.chunks_exact_mut(nx).enumerate() {
                        let from = output * layout.field() / BLOCK + group * GROUP + k;
                        let blocks = spectra.chunks_exact(layout.block());
                        let (parts, _) = spectrum.as_chunks_mut::<BLOCK>();
                        for (part, block) in parts.iter_mut().zip(blocks) {
                            *part = block.as_chunks().0[from];
                        }
                        let waves = &mut spectrum[..nkx];
                        // rounding leaves an imaginary part where a real field has none
                        waves[0].im = T::zero();
                        if mx.is_multiple_of(2) {
                            waves[nkx - 1].im = T::zero();
                        }
                        let done = self.rows_back.process_with_scratch(waves, row, work);
                        debug_assert!(done.is_ok());
                        if adds {
                            for (y, v) in y.iter_mut().zip(row.iter()) {
                                *y += scale * v.wide();
                            }
                        } else {
                            for (y, v) in y.iter_mut().zip(row.iter()) {
                                *y = scale * v.wide();
                            }
                        }
                    }
                },
            );
        }
    }
}
