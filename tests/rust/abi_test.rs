//! The declarations of hgros-sys are those of the header, which tests/c/abi.txt lists.

use std::collections::HashSet;

const HEADER: &str = include_str!("../c/abi.txt");

#[test]
fn declarations_are_those_of_the_header() {
    let header: HashSet<&str> = HEADER.lines().collect();
    for line in hgros_sys::abi() {
        assert!(header.contains(line.as_str()), "the header does not have: {line}");
    }
}

#[test]
fn no_field_of_a_struct_is_missing() {
    let declared = hgros_sys::abi();
    let structs: Vec<&str> =
        declared.iter().filter_map(|line| line.strip_prefix("struct ")?.split(' ').next()).collect();
    assert!(structs.contains(&"hgros_subscribe_options"));
    let fields = HEADER.lines().filter(|line| line.strip_prefix("field ").is_some());
    for line in fields {
        let of = line["field ".len()..].split('.').next().unwrap();
        assert!(!structs.contains(&of) || declared.iter().any(|one| one == line), "hgros-sys lacks: {line}");
    }
}
