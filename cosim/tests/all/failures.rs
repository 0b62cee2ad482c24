//! Many runs: nothing is left behind.

use cosim::Overrides;

use crate::models::Model;
use crate::ssd::Ssd;

fn open_files() -> usize {
    std::fs::read_dir("/proc/self/fd").unwrap().count()
}

#[test]
fn two_thousand_runs_leak_no_instance_and_no_file() {
    let ssd = Ssd::new().add("a", Model::Gain).add("b", Model::Integrator).connect("a.y", "b.u");
    let system = ssd.load(&Overrides::new()).unwrap();
    system.run(&mut []).unwrap();
    let before = open_files();
    for _ in 0..2000 {
        system.run(&mut []).unwrap();
    }
    // Other tests of this process open and close files meanwhile.
    assert!(open_files() < before + 100);
}
