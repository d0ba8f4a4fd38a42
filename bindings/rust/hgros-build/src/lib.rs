//! Generates Rust types from `.proto` files in a build script.
//!
//! In `build.rs`:
//!
//! ```no_run
//! hgros_build::generate(&["proto"], &["robot/battery.proto"]);
//! ```
//!
//! and in the program, where `robot` is the package in the file:
//!
//! ```ignore
//! include!(concat!(env!("OUT_DIR"), "/types.rs"));
//! use robot::Battery;
//! ```
//!
//! The messages are those of the crate `protobuf`, on which the program depends, and implement `hgros::Type`. `protoc`
//! must be in the `PATH`, or be named by the variable `PROTOC`.

use protobuf::descriptor::{DescriptorProto, FileDescriptorProto, FileDescriptorSet};
use protobuf::Message;
use std::collections::{BTreeMap, HashSet};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Writes the types of `files`, which are paths below one of the `folders`, and of the files that they import, to
/// `types.rs` in the build script's `OUT_DIR`. What fails stops the build with a sentence.
pub fn generate(folders: &[impl AsRef<Path>], files: &[impl AsRef<str>]) {
    let out_dir =
        PathBuf::from(std::env::var_os("OUT_DIR").expect("OUT_DIR is set in build scripts"));
    let set = describe(folders, files, &out_dir.join("all.desc"));
    let source = source_of(&set, &out_dir);
    write(&out_dir.join("types.rs"), source.as_bytes());
}

fn describe(
    folders: &[impl AsRef<Path>],
    files: &[impl AsRef<str>],
    output: &Path,
) -> FileDescriptorSet {
    let mut protoc = Command::new(std::env::var_os("PROTOC").unwrap_or_else(|| "protoc".into()));
    protoc
        .arg("--include_imports")
        .arg(format!("--descriptor_set_out={}", output.display()));
    for folder in folders {
        protoc.arg(format!("--proto_path={}", folder.as_ref().display()));
    }
    protoc.args(files.iter().map(AsRef::as_ref));
    let status = protoc
        .status()
        .expect("protoc cannot be run. Install it (Debian: protobuf-compiler).");
    assert!(status.success(), "protoc has failed; its message is above.");
    println!("cargo:rerun-if-env-changed=PROTOC");
    let bytes = std::fs::read(output).expect("protoc has written the description");
    let set = FileDescriptorSet::parse_from_bytes(&bytes)
        .expect("protoc has written a FileDescriptorSet");
    for file in set.get_file() {
        let place = folders
            .iter()
            .map(|folder| folder.as_ref().join(file.get_name()))
            .find(|path| path.exists());
        if let Some(path) = place {
            println!("cargo:rerun-if-changed={}", path.display());
        }
    }
    set
}

/// The crate `protobuf` has Google's own types.
fn is_google(file: &FileDescriptorProto) -> bool {
    file.get_name().starts_with("google/protobuf/")
}

/// One module per file, as protobuf-codegen wants it, and one per package that shows its types.
fn source_of(set: &FileDescriptorSet, out_dir: &Path) -> String {
    let files: Vec<&FileDescriptorProto> = set
        .get_file()
        .iter()
        .filter(|file| !is_google(file))
        .collect();
    let names: Vec<String> = files
        .iter()
        .map(|file| file.get_name().to_owned())
        .collect();
    let generated = protobuf_codegen::gen(
        set.get_file(),
        &names,
        &protobuf_codegen::Customize::default(),
    );
    let mut modules = String::new();
    let mut packages = Package::default();
    let mut seen = HashSet::new();
    for (file, generated) in files.iter().zip(generated) {
        let module = generated.name.trim_end_matches(".rs");
        assert!(
            seen.insert(module.to_owned()),
            "Two files are named like {}, but each becomes a module of that name. Rename one.",
            file.get_name()
        );
        write(
            &out_dir.join(format!("{module}.desc")),
            &description_of(set, file),
        );
        let code = String::from_utf8(generated.content).expect("generated code is UTF-8");
        writeln!(
            modules,
            "pub mod {module} {{\n{code}\n{}}}",
            impls_of(file, module)
        )
        .unwrap();
        packages
            .at(file.get_package())
            .files
            .push(module.to_owned());
    }
    let mut source = format!("#[doc(hidden)]\npub mod types_by_file {{\n{modules}}}\n");
    packages.write(0, &mut source);
    source
}

/// The file with all its imports, dependencies first.
fn description_of(set: &FileDescriptorSet, file: &FileDescriptorProto) -> Vec<u8> {
    let mut wanted = HashSet::from([file.get_name()]);
    // Each file comes after its imports, so those of a file are wanted before their turn comes.
    let mut files: Vec<_> = set
        .get_file()
        .iter()
        .rev()
        .filter(|file| {
            let is_wanted = wanted.contains(file.get_name());
            if is_wanted {
                wanted.extend(file.get_dependency().iter().map(String::as_str));
            }
            is_wanted
        })
        .cloned()
        .collect();
    files.reverse();
    let mut part = FileDescriptorSet::new();
    part.set_file(files.into());
    part.write_to_bytes()
        .expect("a part of a description can be written")
}

fn impls_of(file: &FileDescriptorProto, module: &str) -> String {
    let mut code = String::new();
    writeln!(code, "const DESCRIPTOR_SET: &[u8] = include_bytes!(concat!(env!(\"OUT_DIR\"), \"/{module}.desc\"));")
        .unwrap();
    for message in file.get_message_type() {
        add_impls(message, file.get_package(), "", &mut code);
    }
    code
}

fn add_impls(message: &DescriptorProto, scope: &str, rust_scope: &str, code: &mut String) {
    if message.get_options().get_map_entry() {
        return;
    }
    let name = [scope, message.get_name()].join(if scope.is_empty() { "" } else { "." });
    let rust_name = format!("{rust_scope}{}", message.get_name());
    writeln!(
        code,
        "impl ::hgros::Type for {rust_name} {{\n\
         const NAME: &'static str = \"{name}\";\n\
         const DESCRIPTOR_SET: &'static [u8] = DESCRIPTOR_SET;\n}}"
    )
    .unwrap();
    for nested in message.get_nested_type() {
        add_impls(nested, &name, &format!("{rust_name}_"), code);
    }
}

#[derive(Default)]
struct Package {
    files: Vec<String>,
    inner: BTreeMap<String, Package>,
}

impl Package {
    fn at(&mut self, name: &str) -> &mut Package {
        let parts = name.split('.').filter(|part| !part.is_empty());
        parts.fold(self, |package, part| {
            package.inner.entry(part.to_owned()).or_default()
        })
    }

    fn write(&self, depth: usize, source: &mut String) {
        let up = "super::".repeat(depth);
        for file in &self.files {
            writeln!(
                source,
                "pub use {}types_by_file::{file}::*;",
                if depth == 0 { "self::" } else { &up }
            )
            .unwrap();
        }
        for (name, package) in &self.inner {
            // Every file has a function of one name, which nobody uses from here.
            writeln!(
                source,
                "#[allow(unknown_lints, ambiguous_glob_reexports)]\npub mod r#{name} {{"
            )
            .unwrap();
            package.write(depth + 1, source);
            source.push_str("}\n");
        }
    }
}

fn write(path: &Path, bytes: &[u8]) {
    std::fs::write(path, bytes)
        .unwrap_or_else(|fault| panic!("{} cannot be written: {fault}", path.display()));
}
