// SPDX-License-Identifier: MIT OR Apache-2.0
//! Gives the shared library the name by which programs ask for it (SONAME), and that name a link beside it.

use std::env::var;
use std::path::{Path, PathBuf};

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    if var("CARGO_CFG_TARGET_OS").as_deref() != Ok("linux") {
        return;
    }
    let part = |name: &str| var(format!("CARGO_PKG_VERSION_{name}")).unwrap_or_default();
    // before 1.0 the second number is that of what does not fit any more
    let version = match part("MAJOR") {
        zero if zero == "0" => format!("0.{}", part("MINOR")),
        major => major,
    };
    let name = format!("libmtb_capi.so.{version}");
    println!("cargo:rustc-cdylib-link-arg=-Wl,-soname,{name}");
    // programs that are linked to what cargo built find it there, where cargo keeps artifacts and builds together
    let out = PathBuf::from(var("OUT_DIR").unwrap_or_default());
    if let Some(artifacts) = out.ancestors().nth(3) {
        link(&artifacts.join(name));
    }
}

#[cfg(unix)]
fn link(path: &Path) {
    // where it stands already, or cannot be, an installed library still has its own
    let _ = std::os::unix::fs::symlink("libmtb_capi.so", path);
}

#[cfg(not(unix))]
fn link(_path: &Path) {}
