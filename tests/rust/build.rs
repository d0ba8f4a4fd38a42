fn main() {
    hgros_build::generate(&["proto"], &["tests/robot.proto"]);
}
