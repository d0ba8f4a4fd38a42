//! Links libhgros_c.so, which pkg-config finds.

use std::process::Command;

fn main() {
    println!("cargo:rerun-if-env-changed=PKG_CONFIG_PATH");
    let found = Command::new("pkg-config")
        .args(["--libs", "hgros_c"])
        .output()
        .expect("pkg-config cannot be run. Install it (Debian: pkg-config).");
    if !found.status.success() {
        panic!(
            "libhgros_c.so is not found. Add PREFIX/lib/pkgconfig to PKG_CONFIG_PATH. pkg-config says: {}",
            String::from_utf8_lossy(&found.stderr)
        );
    }
    for flag in String::from_utf8_lossy(&found.stdout).split_whitespace() {
        if let Some(folder) = flag.strip_prefix("-L") {
            println!("cargo:rustc-link-search=native={folder}");
        } else if let Some(library) = flag.strip_prefix("-l") {
            println!("cargo:rustc-link-lib=dylib={library}");
        }
    }
}
