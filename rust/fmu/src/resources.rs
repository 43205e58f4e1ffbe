// SPDX-License-Identifier: MIT OR Apache-2.0
use std::path::{Path, PathBuf};

use percent_encoding::percent_decode_str;

use crate::contact::FILES;
use crate::unit::Unit;
use crate::variables::Variables;

/// What the identifier of a unit begins with whose description fits this library.
const FITTING: &str = concat!("mtb-fmu-", env!("CARGO_PKG_VERSION"), "-");

/// The folder that a `file:` address names.
///
/// # Errors
/// Another address.
pub(crate) fn folder_of(address: &str) -> Result<PathBuf, String> {
    let bad = |why: &dyn std::fmt::Display| format!("resources {address:?}: {why}");
    let path = address
        .strip_prefix("file://")
        .or_else(|| address.strip_prefix("file:"))
        .ok_or_else(|| bad(&"a file: address is needed"))?;
    let path = percent_decode_str(path)
        .decode_utf8()
        .map_err(|error| bad(&error))?;
    let path = if cfg!(windows) {
        path.trim_start_matches('/')
    } else {
        path.strip_prefix("localhost").unwrap_or(&path)
    };
    Ok(PathBuf::from(path))
}

/// The unit of a folder of resources. `word` is what the standard calls the identifier of its description.
///
/// # Errors
/// A description of another version, files that are missing or damaged.
pub(crate) fn unit_in(folder: &Path, word: &str, identifier: &str) -> Result<Unit, String> {
    if !identifier.starts_with(FITTING) {
        return Err(format!(
            "the description's {word} is {identifier:?}: {FITTING}... is needed, as the version of mtb_rs that \
             built this library writes it"
        ));
    }
    let bad = |why: String| format!("resources {}: {why}", folder.display());
    let of = |name: &str, why: String| bad(format!("{name}: {why}"));
    let Some((name, read)) = FILES.iter().find(|(name, _)| folder.join(name).is_file()) else {
        let names = FILES.map(|(name, _)| name).join(" or ");
        return Err(bad(format!("{names} is needed")));
    };
    let bytes = std::fs::read(folder.join(name)).map_err(|error| of(name, error.to_string()))?;
    let contact = read(&bytes).map_err(|why| of(name, why))?;
    let lines = std::fs::read_to_string(folder.join("variables.txt"))
        .map_err(|error| of("variables.txt", error.to_string()))?;
    let (variables, starts) =
        Variables::read(&lines, &*contact).map_err(|why| of("variables.txt", why))?;
    Ok(Unit::new(identifier.to_owned(), contact, variables, starts))
}
