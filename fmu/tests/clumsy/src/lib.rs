//! A separate library with a component that panics on command: the tests of packaging load it to
//! check that the host survives, whatever linker was used.

pub mod component;

fmu_kit::export!(component::Clumsy);
