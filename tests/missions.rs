//! The simulated missions are what they claim to be.

mod mission;

use mission::*;
use rexrov::guidance::Course;

#[test]
fn smoke() {
    let t = std::time::Instant::now();
    let m = fly(&Options::nominal(Course::BE3, 1));
    println!("{:?} {} {} {:?}", t.elapsed(), m.truth.len(), m.events.len(), m.truth.last());
    assert!(m.finished);
}
