//! Contacts by number: a handle that was freed is an error, not a crash.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, LazyLock, Mutex, MutexGuard, PoisonError};

use mtb_contact::prepared::{Prepared, PreparedContact};

use crate::Failure;

static CONTACTS: LazyLock<Mutex<HashMap<u64, Arc<Contact>>>> = LazyLock::new(Mutex::default);
static NEXT: AtomicU64 = AtomicU64::new(1);

/// A contact that one thread at a time steps.
pub(crate) struct Contact(Mutex<Kept>);

/// A prepared contact and the fields of its last step.
pub(crate) struct Kept {
    contact: PreparedContact,
    last: Option<Last>,
}

/// Fields of a solved step.
pub(crate) struct Last {
    pub(crate) pressure: Vec<f64>,
    pub(crate) gap: Vec<f64>,
}

impl Contact {
    pub(crate) fn new(prepared: Arc<Prepared>) -> Self {
        Self(Mutex::new(Kept::new(prepared)))
    }

    /// The contact; after a fault inside a step, without the memory that it may have spoilt.
    pub(crate) fn lock(&self) -> MutexGuard<'_, Kept> {
        self.0.lock().unwrap_or_else(|poisoned| {
            let mut kept = poisoned.into_inner();
            *kept = Kept::new(kept.prepared().clone());
            self.0.clear_poison();
            kept
        })
    }
}

impl Kept {
    fn new(prepared: Arc<Prepared>) -> Self {
        Self {
            contact: PreparedContact::new(prepared),
            last: None,
        }
    }

    pub(crate) fn prepared(&self) -> &Arc<Prepared> {
        self.contact.prepared()
    }

    pub(crate) fn contact(&mut self) -> &mut PreparedContact {
        &mut self.contact
    }

    pub(crate) fn remember(&mut self, last: Last) {
        self.last = Some(last);
    }

    pub(crate) fn last(&self) -> Result<&Last, Failure> {
        self.last
            .as_ref()
            .ok_or_else(|| Failure::argument("no step was solved yet"))
    }
}

fn contacts() -> MutexGuard<'static, HashMap<u64, Arc<Contact>>> {
    CONTACTS.lock().unwrap_or_else(PoisonError::into_inner)
}

pub(crate) fn insert(contact: Contact) -> u64 {
    let handle = NEXT.fetch_add(1, Ordering::Relaxed);
    contacts().insert(handle, Arc::new(contact));
    handle
}

pub(crate) fn contact(handle: u64) -> Result<Arc<Contact>, Failure> {
    contacts()
        .get(&handle)
        .cloned()
        .ok_or_else(|| unknown(handle))
}

pub(crate) fn remove(handle: u64) -> Result<(), Failure> {
    let removed = contacts().remove(&handle);
    removed.map(|_| ()).ok_or_else(|| unknown(handle))
}

fn unknown(handle: u64) -> Failure {
    Failure::argument(format!(
        "handle {handle} is no contact, or one that was freed"
    ))
}
