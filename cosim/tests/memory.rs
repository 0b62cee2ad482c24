//! Runs leave nothing behind: no memory, no file, no mapping. A process of its own, because it
//! checks the whole process.

mod element;
mod resources;

use cosim::{Overrides, Recording, System};

#[test]
fn runs_leave_nothing_behind() {
    let folder = tempfile::TempDir::new().unwrap();
    let ssd = element::chain(&element::fmu(folder.path()), 3, 0.1, 1.0);
    let run = || {
        let system = System::load(&ssd, &Overrides::new()).unwrap();
        let mut recording = Recording::new();
        system.run(&mut [&mut recording]).unwrap();
        assert_eq!(recording.column("g2.y").unwrap().last(), Some(&1.0));
    };
    (0..100).for_each(|_| run());
    let before = resources::of_this_process();
    (0..400).for_each(|_| run());
    let after = resources::of_this_process();
    // 400 runs that leak 1 kB each would be 400 kB.
    let grown = after.resident_kb.saturating_sub(before.resident_kb);
    assert!(grown < 200, "{grown} kB more");
    assert_eq!(after.files, before.files, "open files");
    assert!(
        after.mappings <= before.mappings,
        "{} mappings of {}",
        after.mappings,
        before.mappings
    );
}
