// SPDX-License-Identifier: MIT OR Apache-2.0
//! The committed header is what the source says.

use std::path::Path;

#[test]
fn the_header_is_current() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(root.join("cbindgen.toml")).unwrap();
    let bindings = cbindgen::Builder::new()
        .with_config(config)
        .with_src(root.join("src/lib.rs"))
        .generate()
        .unwrap();
    let mut header = Vec::new();
    bindings.write(&mut header);
    // C of 1990 has no comma behind the last name of an enumeration, and no comments to the end of a line
    let header = String::from_utf8(header).unwrap().replace(",\n}", "\n}");
    let header: String = header
        .lines()
        .map(|line| match line.split_once("// ") {
            Some((before, name)) if before.starts_with("#endif") => {
                format!("{before}/* {name} */\n")
            }
            _ => format!("{line}\n"),
        })
        .collect();
    let path = root.join("include/mtb.h");
    if std::env::var_os("MTB_WRITE_HEADER").is_some() {
        std::fs::write(&path, &header).unwrap();
    }
    assert_eq!(
        std::fs::read_to_string(path).unwrap(),
        header,
        "run MTB_WRITE_HEADER=1 cargo test -p mtb-capi"
    );
}
