//! The program offers FMUs its own `_exit`, which knows that only an FMU can call it.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let linux = std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|system| system == "linux");
    if linux && std::env::var_os("CARGO_FEATURE_DISTRIBUTED").is_some() {
        // Zig's linker exports all symbols or none.
        let linker = std::env::var("RUSTC_LINKER").unwrap_or_default();
        if linker.contains("zigcc") {
            println!("cargo::rustc-link-arg-bin=cosim=-rdynamic");
            return;
        }
        for symbol in ["_exit", "_Exit"] {
            println!("cargo::rustc-link-arg-bin=cosim=-Wl,--export-dynamic-symbol={symbol}");
        }
    }
}
