// SPDX-License-Identifier: MIT OR Apache-2.0
//! Contacts and wheels by number: a handle that was freed is an error, not a crash.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use mtb_contact::prepared::{Prepared, PreparedContact};
use mtb_contact::problem::Outcome;
use mtb_wheelset::{PreparedWheels, WheelStep};

use crate::Failure;

/// What one thread at a time steps.
pub(crate) trait Stepped: Send {
    /// Forgets what a fault inside a step may have spoilt.
    fn forget(&mut self);
}

/// Things of one kind by number.
pub(crate) struct Registry<T> {
    kept: Mutex<Option<HashMap<u64, Arc<Mutex<T>>>>>,
    /// What a message calls a thing.
    name: &'static str,
}

pub(crate) static CONTACTS: Registry<Contact> = Registry::new("contact");
pub(crate) static WHEELS: Registry<Wheels> = Registry::new("wheels");
/// Handles of all kinds are different numbers.
static NEXT: AtomicU64 = AtomicU64::new(1);

impl<T: Stepped> Registry<T> {
    const fn new(name: &'static str) -> Self {
        Self {
            kept: Mutex::new(None),
            name,
        }
    }

    fn with<R>(&self, work: impl FnOnce(&mut HashMap<u64, Arc<Mutex<T>>>) -> R) -> R {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        work(kept.get_or_insert_default())
    }

    pub(crate) fn insert(&self, thing: T) -> u64 {
        let handle = NEXT.fetch_add(1, Ordering::Relaxed);
        self.with(|kept| kept.insert(handle, Arc::new(Mutex::new(thing))));
        handle
    }

    pub(crate) fn get(&self, handle: u64) -> Result<Arc<Mutex<T>>, Failure> {
        self.with(|kept| kept.get(&handle).cloned())
            .ok_or_else(|| self.unknown(handle))
    }

    pub(crate) fn remove(&self, handle: u64) -> Result<(), Failure> {
        let removed = self.with(|kept| kept.remove(&handle));
        removed.map(|_| ()).ok_or_else(|| self.unknown(handle))
    }

    fn unknown(&self, handle: u64) -> Failure {
        Failure::argument(format!(
            "handle {handle} is no {}, or one that was freed",
            self.name
        ))
    }
}

/// The thing itself; after a fault inside a step without its memory.
pub(crate) fn lock<T: Stepped>(kept: &Mutex<T>) -> MutexGuard<'_, T> {
    kept.lock().unwrap_or_else(|poisoned| {
        let mut thing = poisoned.into_inner();
        thing.forget();
        kept.clear_poison();
        thing
    })
}

/// A prepared contact and the fields of its last step.
pub(crate) struct Contact {
    pub(crate) stepped: PreparedContact,
    pub(crate) last: Option<Last>,
    /// Of the magnet, in place of those with which it was prepared.
    pub(crate) ampere_turns: Option<f64>,
}

/// A solved step.
pub(crate) struct Last {
    pub(crate) out: Outcome,
    /// Of all motions; NaN of those that the pose took the place of.
    pub(crate) amplitudes: Vec<f64>,
}

impl Contact {
    pub(crate) fn new(prepared: Arc<Prepared>) -> Self {
        Self {
            stepped: PreparedContact::new(prepared),
            last: None,
            ampere_turns: None,
        }
    }

    pub(crate) fn prepared(&self) -> &Arc<Prepared> {
        self.stepped.prepared()
    }

    pub(crate) fn last(&self) -> Result<&Last, Failure> {
        self.last.as_ref().ok_or_else(no_step)
    }
}

impl Stepped for Contact {
    fn forget(&mut self) {
        *self = Self {
            ampere_turns: self.ampere_turns,
            ..Self::new(self.prepared().clone())
        };
    }
}

/// Prepared wheels and their last step.
pub(crate) struct Wheels {
    pub(crate) wheels: PreparedWheels,
    pub(crate) last: Option<WheelStep>,
}

impl Wheels {
    pub(crate) fn new(wheels: PreparedWheels) -> Self {
        Self { wheels, last: None }
    }

    pub(crate) fn last(&self) -> Result<&WheelStep, Failure> {
        self.last.as_ref().ok_or_else(no_step)
    }
}

impl Stepped for Wheels {
    fn forget(&mut self) {
        *self = Self::new(self.wheels.without_memory());
    }
}

pub(crate) fn no_step() -> Failure {
    Failure::argument("no step was solved yet")
}
