//! Generates the messages from the `.proto` files of the installed package, or of the clone.

use std::path::{Path, PathBuf};

fn main() {
    let here = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets it"));
    let folder = ["../../proto", "../../../proto"]
        .map(|path| here.join(path))
        .into_iter()
        .find(|folder| folder.join("foxglove/Log.proto").exists())
        .expect("The .proto files are in share/hgros/proto, beside share/hgros/rust.");
    let mut files = protos_in(&folder, "foxglove");
    // Those with a small letter belong to the protocol and are not installed.
    files.extend(
        protos_in(&folder, "hgros")
            .into_iter()
            .filter(|file| !file["hgros/".len()..].starts_with(char::is_lowercase)),
    );
    hgros_build::generate(&[folder], &files);
}

fn protos_in(folder: &Path, package: &str) -> Vec<String> {
    let entries = std::fs::read_dir(folder.join(package)).expect("the package has a folder");
    let names = entries.map(|entry| {
        entry
            .expect("the folder can be read")
            .file_name()
            .into_string()
            .unwrap()
    });
    let mut files: Vec<_> = names
        .filter(|name| name.ends_with(".proto"))
        .map(|name| format!("{package}/{name}"))
        .collect();
    files.sort();
    files
}
