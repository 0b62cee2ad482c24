//! `cargo run --release` writes the FMU.

fn main() -> std::process::ExitCode {
    fmu_kit::package::main(&depth_hold::REGISTRY)
}
