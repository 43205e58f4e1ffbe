// SPDX-License-Identifier: MIT OR Apache-2.0
//! Digest of the code of `tetra`, for whatever keeps its results.

use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};
use std::path::Path;
use std::{fs, io};

fn main() -> io::Result<()> {
    let folder = Path::new("src/tetra");
    println!("cargo::rerun-if-changed={}", folder.display());
    let mut files = fs::read_dir(folder)?
        .map(|entry| entry.map(|e| e.path()))
        .collect::<io::Result<Vec<_>>>()?;
    files.sort();
    let mut digest = DefaultHasher::new();
    for file in files {
        fs::read(file)?.hash(&mut digest);
    }
    println!("cargo::rustc-env=MTB_TETRA_DIGEST={:016x}", digest.finish());
    Ok(())
}
