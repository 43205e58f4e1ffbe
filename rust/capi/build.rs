// SPDX-License-Identifier: MIT OR Apache-2.0
//! The shared library bears its name with the version of its interface, so that programs find the one that
//! they were linked with.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let major = std::env::var("CARGO_PKG_VERSION_MAJOR").unwrap_or_default();
    match std::env::var("CARGO_CFG_TARGET_OS").as_deref() {
        Ok("linux") => println!("cargo:rustc-cdylib-link-arg=-Wl,-soname,libmtb_capi.so.{major}"),
        Ok("macos") => println!(
            "cargo:rustc-cdylib-link-arg=-Wl,-install_name,@rpath/libmtb_capi.{major}.dylib"
        ),
        _ => {}
    }
}
