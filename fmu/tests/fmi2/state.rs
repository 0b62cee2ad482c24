//! Saved states: complete, portable, and rejected if they are invalid.

use std::ptr::null_mut;

use fmu_kit::abi::types::*;
use fmu_kit::kernel::Status;

use crate::components::{REGISTRY, fmi2};
use crate::driver::{CS, Fmu, ME};

fn get(fmu: &Fmu, state: &mut fmi2FMUstate) -> Status {
    unsafe { fmi2::fmi2GetFMUstate(fmu.c, state) }
}

fn set(fmu: &Fmu, state: fmi2FMUstate) -> Status {
    unsafe { fmi2::fmi2SetFMUstate(fmu.c, state) }
}

fn serialize(fmu: &Fmu, state: fmi2FMUstate) -> Vec<u8> {
    let mut size = 0;
    unsafe {
        assert_eq!(fmi2::fmi2SerializedFMUstateSize(fmu.c, state, &raw mut size), Status::Ok);
        let mut bytes = vec![0_u8; size];
        let place = bytes.as_mut_ptr().cast();
        assert_eq!(fmi2::fmi2SerializeFMUstate(fmu.c, state, place, size), Status::Ok);
        bytes
    }
}

fn deserialize(fmu: &Fmu, bytes: &[u8], state: &mut fmi2FMUstate) -> Status {
    unsafe { fmi2::fmi2DeSerializeFMUstate(fmu.c, bytes.as_ptr().cast(), bytes.len(), state) }
}

/// Components with an input to change and parameters that differ from the defaults.
const SUBJECTS: [(&str, &str); 4] =
    [("Spring", "force"), ("Noise", "signal"), ("Ball", ""), ("Pendulum", "torque")];

fn started(name: &'static str) -> Fmu {
    let mut fmu = Fmu::new(name, CS);
    match name {
        "Spring" => {
            fmu.set("mass", 1.7);
            fmu.set_string("label", c"a name");
            fmu.set_integer("integrator.method", 2);
        }
        "Noise" => _ = fmu.set_integer("seed", 77),
        "Pendulum" => _ = fmu.set_integer("integrator.method", 2),
        _ => {}
    }
    fmu.setup(0.25);
    fmu.initialize();
    fmu
}

/// Every Real's bits after each of some steps with changing inputs.
fn run(fmu: &mut Fmu, input: &str, from: u32, to: u32) -> Vec<u64> {
    let mut bits = Vec::new();
    for k in from..to {
        let t = 0.25 + f64::from(k) * 0.07;
        if !input.is_empty() {
            fmu.set(input, t.sin());
            let (vr, order, slope) = (fmu.reference(input), 1, t.cos());
            unsafe {
                let (vr, order, slope) = (&raw const vr, &raw const order, &raw const slope);
                fmi2::fmi2SetRealInputDerivatives(fmu.c, vr, 1, order, slope);
            }
        }
        assert_eq!(fmu.step(t, 0.07), Status::Ok);
        for variable in REGISTRY.named(fmu.name).unwrap().table().variables() {
            if matches!(variable.start, fmu_kit::Start::Real(_)) {
                bits.push(fmu.get(&variable.name).to_bits());
            }
        }
    }
    bits
}

#[test]
fn a_restored_state_goes_on_bit_for_bit_here_and_elsewhere() {
    for (name, input) in SUBJECTS {
        let (mut fmu, mut state, mut copy) = (started(name), null_mut(), null_mut());
        run(&mut fmu, input, 0, 20);
        assert_eq!(get(&fmu, &mut state), Status::Ok);
        let first = run(&mut fmu, input, 20, 60);
        assert_eq!(set(&fmu, state), Status::Ok);
        assert_eq!(run(&mut fmu, input, 20, 60), first, "{name}");
        let mut other = Fmu::new(name, CS);
        assert_eq!(set(&other, state), Status::Ok);
        assert_eq!(run(&mut other, input, 20, 60), first, "{name} elsewhere");
        let bytes = serialize(&fmu, state);
        let mut third = Fmu::started(name, CS);
        assert_eq!(deserialize(&third, &bytes, &mut copy), Status::Ok);
        fmu.free();
        assert_eq!(set(&third, copy), Status::Ok);
        assert_eq!(run(&mut third, input, 20, 60), first, "{name} from bytes");
        assert_eq!(serialize(&third, copy), bytes, "{name}");
    }
}

#[test]
fn a_state_is_saved_in_every_phase_and_restored_with_it() {
    let (mut fmu, mut start, mut state) = (Fmu::new("Noise", ME), null_mut(), null_mut());
    assert_eq!(get(&fmu, &mut start), Status::Ok);
    fmu.setup(0.0);
    fmu.initialize();
    assert_eq!(unsafe { fmi2::fmi2EnterContinuousTimeMode(fmu.c) }, Status::Ok);
    assert_eq!(get(&fmu, &mut state), Status::Ok);
    assert_eq!(set(&fmu, start), Status::Ok);
    fmu.set_integer("seed", 5);
    assert_eq!((fmu.setup(3.0), fmu.initialize()), (Status::Ok, Status::Ok));
    assert_eq!(set(&fmu, state), Status::Ok);
    assert_eq!(fmu.get("time"), 0.0);
    assert_eq!(unsafe { fmi2::fmi2SetTime(fmu.c, 0.1) }, Status::Ok);
}

#[test]
fn getting_again_overwrites_and_freeing_ends_a_state() {
    let (mut fmu, mut state) = (Fmu::started("Spring", CS), null_mut());
    assert_eq!(get(&fmu, &mut state), Status::Ok);
    let handle = state;
    fmu.step(0.0, 0.1);
    let there = fmu.get("position");
    assert_eq!((get(&fmu, &mut state), state), (Status::Ok, handle));
    fmu.step(0.1, 0.1);
    assert_eq!((set(&fmu, state), fmu.get("position")), (Status::Ok, there));
    unsafe {
        assert_eq!(fmi2::fmi2FreeFMUstate(fmu.c, &raw mut state), Status::Ok);
        assert!(state.is_null());
        assert_eq!(fmi2::fmi2FreeFMUstate(fmu.c, &raw mut state), Status::Ok);
        assert_eq!(fmi2::fmi2FreeFMUstate(fmu.c, null_mut()), Status::Ok);
        assert_eq!(fmu.log(), []);
        let mut stale = handle;
        assert_eq!(fmi2::fmi2FreeFMUstate(fmu.c, &raw mut stale), Status::Error);
        assert_eq!(fmi2::fmi2GetFMUstate(fmu.c, &raw mut stale), Status::Error);
        let mut component = fmu.c;
        assert_eq!(fmi2::fmi2FreeFMUstate(fmu.c, &raw mut component), Status::Error);
    }
    for bad in [handle, null_mut(), fmu.c] {
        assert_eq!(set(&fmu, bad), Status::Error);
    }
    assert_eq!(fmu.log().len(), 6);
}

#[test]
fn states_go_with_the_instance_they_were_made_from() {
    let (fmu, other) = (Fmu::started("Spring", CS), Fmu::started("Spring", CS));
    let mut states = [null_mut(); 20];
    for state in &mut states {
        assert_eq!(get(&fmu, state), Status::Ok);
    }
    assert_eq!(set(&other, states[7]), Status::Ok);
    fmu.free();
    for state in states {
        assert_eq!(set(&other, state), Status::Error);
    }
}

#[test]
fn foreign_states_are_refused_with_one_line() {
    let (spring, mut noise, mut me) =
        (Fmu::started("Spring", CS), Fmu::started("Noise", CS), Fmu::started("Spring", ME));
    let (mut state, mut none) = (null_mut(), null_mut());
    get(&spring, &mut state);
    let bytes = serialize(&spring, state);
    assert_eq!(set(&noise, state), Status::Error);
    assert!(noise.line().contains("GUID"));
    assert_eq!(deserialize(&noise, &bytes, &mut none), Status::Error);
    assert!(noise.line().contains("GUID"));
    assert_eq!(set(&me, state), Status::Error);
    assert_eq!(deserialize(&me, &bytes, &mut none), Status::Error);
    assert_eq!(me.log().len(), 2);
    assert!(none.is_null());
}

#[test]
fn cut_and_altered_bytes_are_refused_with_one_line() {
    let (mut fmu, mut state) = (started("Noise"), null_mut());
    run(&mut fmu, "signal", 0, 10);
    get(&fmu, &mut state);
    let bytes = serialize(&fmu, state);
    let mut refused = |bytes: &[u8], what: &str| {
        let mut none = null_mut();
        assert_eq!(deserialize(&fmu, bytes, &mut none), Status::Error, "{what}");
        assert!(fmu.line().starts_with("fmi2DeSerializeFMUstate: these"), "{what}");
        assert!(none.is_null());
    };
    for length in 0..bytes.len() {
        refused(&bytes[..length], &format!("cut to {length}"));
    }
    for index in 0..bytes.len() {
        let mut altered = bytes.clone();
        altered[index] ^= 1 << (index % 8);
        refused(&altered, &format!("altered at {index}"));
    }
    refused(&[&bytes[..], &[0]].concat(), "longer");
}

#[test]
fn a_wrong_size_is_refused() {
    let (mut fmu, mut state) = (Fmu::started("Spring", CS), null_mut());
    get(&fmu, &mut state);
    let mut bytes = [0; 8];
    let status = unsafe { fmi2::fmi2SerializeFMUstate(fmu.c, state, bytes.as_mut_ptr(), 8) };
    assert_eq!(status, Status::Error);
    assert!(fmu.line().contains("size = 8"));
}

/// Tells a second process of this test where the state is.
const FILE: &str = "FMU_KIT_TEST_STATE";

#[test]
fn a_state_goes_on_in_another_process() {
    let rest = |fmu: &mut Fmu| run(fmu, "signal", 20, 40);
    let mut fmu = started("Noise");
    if let Ok(path) = std::env::var(FILE) {
        let (bytes, mut state) = (std::fs::read(&path).unwrap(), null_mut());
        assert_eq!(deserialize(&fmu, &bytes, &mut state), Status::Ok);
        assert_eq!(set(&fmu, state), Status::Ok);
        std::fs::write(path, format!("{:?}", rest(&mut fmu))).unwrap();
        return;
    }
    run(&mut fmu, "signal", 0, 20);
    let mut state = null_mut();
    get(&fmu, &mut state);
    let path = std::env::temp_dir().join(format!("fmu-kit-state-{}", std::process::id()));
    std::fs::write(&path, serialize(&fmu, state)).unwrap();
    let child = std::process::Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "state::a_state_goes_on_in_another_process"])
        .env(FILE, &path)
        .output()
        .unwrap();
    assert!(child.status.success(), "{child:?}");
    let there = std::fs::read_to_string(&path).unwrap();
    std::fs::remove_file(&path).unwrap();
    assert_eq!(there, format!("{:?}", rest(&mut fmu)));
}

#[test]
fn reset_is_bit_for_bit_a_fresh_instance() {
    for (name, input) in SUBJECTS {
        let (mut used, mut fresh) = (started(name), Fmu::new(name, CS));
        run(&mut used, input, 0, 20);
        assert_eq!(unsafe { fmi2::fmi2Reset(used.c) }, Status::Ok);
        let bytes = [&used, &fresh].map(|fmu| {
            let mut state = null_mut();
            assert_eq!(get(fmu, &mut state), Status::Ok);
            serialize(fmu, state)
        });
        assert_eq!(bytes[0], bytes[1], "{name}");
        for fmu in [&mut used, &mut fresh] {
            fmu.setup(0.25);
            fmu.initialize();
        }
        assert_eq!(run(&mut used, input, 0, 20), run(&mut fresh, input, 0, 20), "{name}");
    }
}

#[test]
fn many_instances_on_many_threads_do_not_know_of_each_other() {
    let alone = run(&mut started("Noise"), "signal", 0, 50);
    std::thread::scope(|scope| {
        for _ in 0..8 {
            scope.spawn(|| {
                for _ in 0..20 {
                    assert_eq!(run(&mut started("Noise"), "signal", 0, 50), alone);
                }
            });
        }
    });
}
