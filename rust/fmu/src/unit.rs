// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_contact::record::{Damaged, Reader, Writer};
use mtb_words::Short;

use crate::contact::Contact;
use crate::variables::{Place, Variables};

const MARK: [u8; 4] = *b"MTBU";
const VERSION: u32 = 1;

/// A contact whose inputs are set and whose outputs are read by value reference, step by step.
pub(crate) struct Unit {
    /// Of the description and the contact.
    identifier: String,
    contact: Box<dyn Contact>,
    variables: Variables,
    /// Inputs as the description has them.
    starts: Vec<f64>,
    now: Moment,
}

/// Where a simulation is.
#[derive(Clone)]
struct Moment {
    inputs: Vec<f64>,
    /// Of the last step that was solved, at the inputs `solved`; NaN before.
    outputs: Vec<f64>,
    solved: Option<Vec<f64>>,
    is_initialising: bool,
    time: f64,
}

/// What is kept of a unit, to go back to.
pub(crate) struct Kept {
    now: Moment,
    memory: Vec<f64>,
}

impl Unit {
    pub(crate) fn new(
        identifier: String,
        contact: Box<dyn Contact>,
        variables: Variables,
        starts: Vec<f64>,
    ) -> Self {
        let now = Moment {
            inputs: starts.clone(),
            outputs: vec![f64::NAN; contact.outputs()],
            solved: None,
            is_initialising: true,
            time: 0.0,
        };
        Self {
            identifier,
            contact,
            variables,
            starts,
            now,
        }
    }

    /// The variables.
    pub(crate) fn variables(&self) -> &Variables {
        &self.variables
    }

    /// The time [s] up to which steps were solved.
    pub(crate) fn time(&self) -> f64 {
        self.now.time
    }

    /// Sets the time of the first step [s].
    ///
    /// # Errors
    /// A time that is not finite.
    pub(crate) fn start_at(&mut self, time: f64) -> Result<(), String> {
        if !time.is_finite() {
            return Err(format!(
                "the start time is {}: a finite number is needed",
                Short(time)
            ));
        }
        self.now.time = time;
        Ok(())
    }

    /// Solves the contact at the first inputs; from here on outputs are those of steps.
    ///
    /// # Errors
    /// What the contact refuses.
    pub(crate) fn end_initialisation(&mut self) -> Result<(), String> {
        self.settle()?;
        self.now.is_initialising = false;
        Ok(())
    }

    /// As just made.
    pub(crate) fn reset(&mut self) {
        self.contact.forget();
        self.now = Moment {
            inputs: self.starts.clone(),
            outputs: vec![f64::NAN; self.now.outputs.len()],
            solved: None,
            is_initialising: true,
            time: 0.0,
        };
    }

    /// Forgets the memory of steps, which may be half made.
    pub(crate) fn forget(&mut self) {
        self.contact.forget();
    }

    /// The numbers of some variables; outputs before the end of the initialisation are those of the inputs set so
    /// far.
    ///
    /// # Errors
    /// A value reference that is none, what the contact refuses.
    pub(crate) fn get(&mut self, references: &[u32]) -> Result<Vec<f64>, String> {
        let places = self.variables.places(references)?;
        let asks_output = places.iter().any(|p| matches!(p, Place::Output(_)));
        if asks_output && self.now.is_initialising {
            self.settle()?;
        }
        let number = |place: &Place| match place {
            Place::Input(k) => self.now.inputs[*k],
            Place::Output(k) => self.now.outputs[*k],
            Place::Time => self.now.time,
        };
        Ok(places.iter().map(number).collect())
    }

    /// Sets some inputs.
    ///
    /// # Errors
    /// A value reference that no input has, another count of numbers, numbers that are not finite; nothing is set
    /// then.
    pub(crate) fn set(&mut self, references: &[u32], values: &[f64]) -> Result<(), String> {
        let numbers = self.variables.inputs(references)?;
        check_count("values", values.len(), numbers.len())?;
        let pairs = || numbers.iter().zip(values);
        if let Some(((reference, _), &value)) = pairs().find(|(_, value)| !value.is_finite()) {
            return Err(format!(
                "value reference {reference} is {}: a finite number is needed",
                Short(value)
            ));
        }
        for ((_, number), value) in pairs() {
            self.now.inputs[*number] = *value;
        }
        Ok(())
    }

    /// Solves the contact at the inputs, which hold over the step.
    ///
    /// # Errors
    /// Times that make no sense, what the contact refuses; the outputs then stay those of the last step.
    pub(crate) fn advance(&mut self, time: f64, step: f64) -> Result<(), String> {
        if !time.is_finite() || !step.is_finite() || step < 0.0 {
            return Err(format!(
                "a step of {} s from {} s: finite numbers are needed, the step not below 0",
                Short(step),
                Short(time)
            ));
        }
        self.solve(step)?;
        self.now.time = time + step;
        Ok(())
    }

    /// Changes of some outputs of the last step along a `seed`, changes of some inputs.
    ///
    /// Before the end of the initialisation they are those at the inputs set so far.
    ///
    /// # Errors
    /// Value references that are none, another count of numbers, a step that has no derivatives.
    pub(crate) fn along(
        &mut self,
        outputs: &[u32],
        inputs: &[u32],
        seed: &[f64],
    ) -> Result<Vec<f64>, String> {
        let (rows, columns) = self.numbers(outputs, inputs)?;
        check_count("seed", seed.len(), columns.len())?;
        let derivatives = self.derivatives()?;
        let sum = |row: &usize| {
            let along = columns.iter().zip(seed);
            along
                .map(|(column, s)| derivatives[*row][*column] * s)
                .sum()
        };
        Ok(rows.iter().map(sum).collect())
    }

    /// Gradients by some inputs of the sum of some outputs of the last step with the weights `seed`.
    ///
    /// # Errors
    /// As of [`Unit::along`].
    pub(crate) fn gradient(
        &mut self,
        outputs: &[u32],
        inputs: &[u32],
        seed: &[f64],
    ) -> Result<Vec<f64>, String> {
        let (rows, columns) = self.numbers(outputs, inputs)?;
        check_count("seed", seed.len(), rows.len())?;
        let derivatives = self.derivatives()?;
        let sum = |column: &usize| {
            let weighed = rows.iter().zip(seed);
            weighed.map(|(row, s)| derivatives[*row][*column] * s).sum()
        };
        Ok(columns.iter().map(sum).collect())
    }

    /// Inputs, outputs and the memory of the last step.
    pub(crate) fn keep(&self) -> Kept {
        Kept {
            now: self.now.clone(),
            memory: self.contact.memory(),
        }
    }

    /// Goes back to what was kept.
    ///
    /// # Errors
    /// What was kept of another unit; nothing has changed then.
    pub(crate) fn go_back(&mut self, kept: &Kept) -> Result<(), String> {
        let other = || "the state is one of another unit".to_owned();
        if kept.now.inputs.len() != self.starts.len()
            || kept.now.outputs.len() != self.now.outputs.len()
        {
            return Err(other());
        }
        (self.contact.resume(&kept.memory)).map_err(|why| format!("{}: {why}", other()))?;
        self.now = kept.now.clone();
        Ok(())
    }

    /// What was kept as bytes, for another process and this unit.
    pub(crate) fn write(&self, kept: &Kept) -> Vec<u8> {
        let mut out = Writer::default();
        let now = &kept.now;
        out.text(&self.identifier);
        out.array(&now.inputs);
        out.array(&now.outputs);
        out.option(now.solved.as_deref(), Writer::array);
        out.count(usize::from(now.is_initialising));
        out.array(&[now.time]);
        out.array(&kept.memory);
        out.finish(MARK, VERSION)
    }

    /// What [`Unit::write`] wrote.
    ///
    /// # Errors
    /// Bytes that are none, damaged, or of another unit.
    pub(crate) fn read(&self, bytes: &[u8]) -> Result<Kept, String> {
        let damaged = |error: Damaged| format!("the bytes are no state of a unit: {error}");
        let mut body = Reader::open(bytes, MARK, VERSION).map_err(damaged)?;
        let mut parts = || -> Result<(String, Kept), Damaged> {
            let identifier = body.text()?;
            let (inputs, outputs) = (body.array()?, body.array()?);
            let solved = body.option(Reader::array)?;
            let is_initialising = body.word()? != 0;
            let [time] = body.numbers()?;
            let memory = body.array()?;
            let now = Moment {
                inputs,
                outputs,
                solved,
                is_initialising,
                time,
            };
            Ok((identifier, Kept { now, memory }))
        };
        let (identifier, kept) = parts().map_err(damaged)?;
        body.close().map_err(damaged)?;
        let count = self.starts.len();
        let is_whole = kept.now.inputs.len() == count
            && kept.now.outputs.len() == self.now.outputs.len()
            && kept.now.solved.as_ref().is_none_or(|s| s.len() == count);
        if identifier != self.identifier || !is_whole {
            return Err(format!("the bytes are a state of the unit {identifier:?}"));
        }
        Ok(kept)
    }
}

impl Unit {
    /// Solves the contact at the inputs, which hold over a duration [s].
    fn solve(&mut self, duration: f64) -> Result<(), String> {
        self.now.outputs = self.contact.solve(&self.now.inputs, duration)?;
        self.now.solved = Some(self.now.inputs.clone());
        Ok(())
    }

    /// Solves the contact at the beginning at the inputs, if they have changed.
    fn settle(&mut self) -> Result<(), String> {
        let bits = |values: &[f64]| -> Vec<u64> { values.iter().map(|v| v.to_bits()).collect() };
        match &self.now.solved {
            Some(solved) if bits(solved) == bits(&self.now.inputs) => Ok(()),
            _ => {
                // the inputs before were no step
                self.contact.forget();
                self.solve(0.0)
            }
        }
    }

    /// Derivatives of the outputs (rows) by the inputs (columns).
    fn derivatives(&mut self) -> Result<Vec<Vec<f64>>, String> {
        if self.now.is_initialising {
            self.settle()?;
        }
        if !self.contact.has_step() {
            // the step that the outputs are of, which a state has only the memory of
            let solved = self.now.solved.as_ref().unwrap_or(&self.now.inputs);
            if self.contact.follows_memory() && !self.now.is_initialising {
                return Err(
                    "the state was set since the last step: what sticks or rolls on has derivatives after a step from there"
                        .to_owned(),
                );
            }
            self.contact.solve(solved, 0.0)?;
        }
        self.contact.derivatives()
    }

    /// Which rows and columns of the derivatives some variables are.
    fn numbers(&self, outputs: &[u32], inputs: &[u32]) -> Result<(Vec<usize>, Vec<usize>), String> {
        let second = |pairs: Vec<(u32, usize)>| pairs.into_iter().map(|(_, k)| k).collect();
        let rows = second(self.variables.outputs(outputs)?);
        Ok((rows, second(self.variables.inputs(inputs)?)))
    }
}

fn check_count(name: &str, found: usize, wanted: usize) -> Result<(), String> {
    if found == wanted {
        return Ok(());
    }
    Err(format!(
        "{name} has {found} numbers: these variables have {wanted}"
    ))
}
