//! Memory over 10,000 runs in one process, each of which opens its FMU again: resident kilobytes,
//! open files and mappings after 1, 100, 1,000 and 10,000 of them.
//!
//! `cargo bench -p cosim --bench runs`; `tests/memory.rs` checks a bound with fewer runs.

#[path = "../tests/element/mod.rs"]
mod element;
#[path = "../tests/resources/mod.rs"]
mod resources;

use cosim::{Overrides, Recording, System};

fn main() {
    let folder = tempfile::TempDir::new().unwrap();
    let ssd = element::chain(&element::fmu(folder.path()), 3, 0.1, 1.0);
    println!("{:>10}{:>16}{:>12}{:>12}", "runs", "resident kB", "open files", "mappings");
    for run in 1..=10_000 {
        let system = System::load(&ssd, &Overrides::new()).unwrap();
        let mut recording = Recording::new();
        system.run(&mut [&mut recording]).unwrap();
        assert_eq!(recording.column("g2.y").unwrap().last(), Some(&1.0));
        drop((system, recording));
        if [1, 100, 1_000, 10_000].contains(&run) {
            let now = resources::of_this_process();
            println!("{run:>10}{:>16}{:>12}{:>12}", now.resident_kb, now.files, now.mappings);
        }
    }
}
