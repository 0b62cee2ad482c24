//! States of a library whose component has the same description, so the same GUID, but a different
//! memory: another version of it.

use std::marker::PhantomData;
use std::ptr::null_mut;
use std::sync::LazyLock;

use fmu_kit::abi::{Library, Shelf};
use fmu_kit::kernel::{Deferred, Instance, Registry, Request, Status};
use fmu_kit::{Component, Fault, Info, NoStates, ParameterError, Resources, Time, Variables};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::components::{Components, fmi2};
use crate::driver::{CS, Fmu};

/// A version's memory of a level.
trait Memory: Clone + Default + Send + Serialize + DeserializeOwned + 'static {
    fn of(level: f64) -> Self;
    fn level(&self) -> f64;
}

impl Memory for [f64; 2] {
    fn of(level: f64) -> Self {
        [level, 0.0]
    }
    fn level(&self) -> f64 {
        self[0]
    }
}

impl Memory for [f64; 3] {
    fn of(level: f64) -> Self {
        [0.0, 0.0, level]
    }
    fn level(&self) -> f64 {
        self[2]
    }
}

/// The same number of bytes as two numbers: only the shape distinguishes them.
impl Memory for (f64, [u8; 8]) {
    fn of(level: f64) -> Self {
        (0.0, level.to_le_bytes())
    }
    fn level(&self) -> f64 {
        f64::from_le_bytes(self.1)
    }
}

#[derive(Clone, Copy, Debug, Default, Variables)]
struct Level {
    /// Level at the start
    level: f64,
}

#[derive(Clone, Copy, Debug, Default, Variables)]
struct Kept {
    /// Level kept
    kept: f64,
}

struct Keeper<M>(PhantomData<M>);

impl<M: Memory> Component for Keeper<M> {
    const INFO: Info =
        Info { sampled: true, ..Info::new("Keeper", "Keeps the level of the start") };
    type Parameters = ();
    type Inputs = Level;
    type Outputs = Kept;
    type States = NoStates;
    type Memory = M;

    fn new((): &(), _: &Resources) -> Result<Self, ParameterError> {
        Ok(Self(PhantomData))
    }

    fn initial(&self, _: Time, u: &Level) -> Result<(NoStates, M), Fault> {
        Ok(((), M::of(u.level)))
    }

    fn outputs(&self, _: f64, memory: &M, (): &NoStates, _: &Level) -> Kept {
        Kept { kept: memory.level() }
    }
}

fn library<M: Memory>() -> Registry {
    Registry::new("keepers", vec![Deferred::of::<Keeper<M>>()])
}

static VERSIONS: [LazyLock<Registry>; 3] = [
    LazyLock::new(library::<[f64; 2]>),
    LazyLock::new(library::<[f64; 3]>),
    LazyLock::new(library::<(f64, [u8; 8])>),
];

/// One of these versions, with its instances where the functions under test look for them.
struct Version<const N: usize>;

impl<const N: usize> Library for Version<N> {
    type Instance = Instance;

    fn instantiate(request: Request<'_>) -> Result<Instance, String> {
        VERSIONS[N].serve(request)
    }

    fn shelf() -> &'static Shelf<Instance> {
        Components::shelf()
    }
}

fn started(version: usize, level: f64) -> Fmu {
    let make = [Fmu::of::<Version<0>>, Fmu::of::<Version<1>>, Fmu::of::<Version<2>>][version];
    let mut fmu = make(&VERSIONS[version], "Keeper", CS);
    fmu.set("level", level);
    assert_eq!((fmu.setup(0.0), fmu.initialize()), (Status::Ok, Status::Ok));
    fmu
}

fn bytes(fmu: &Fmu) -> Vec<u8> {
    let (c, mut state, mut size) = (fmu.c, null_mut(), 0);
    unsafe {
        assert_eq!(fmi2::fmi2GetFMUstate(c, &raw mut state), Status::Ok);
        assert_eq!(fmi2::fmi2SerializedFMUstateSize(c, state, &raw mut size), Status::Ok);
        let mut bytes = vec![0_u8; size];
        let place = bytes.as_mut_ptr().cast();
        assert_eq!(fmi2::fmi2SerializeFMUstate(c, state, place, size), Status::Ok);
        bytes
    }
}

#[test]
fn a_state_of_another_shape_of_memory_is_refused_and_changes_nothing() {
    let guids = VERSIONS.each_ref().map(|version| version.named("Keeper").unwrap().guid());
    assert!(guids.iter().all(|guid| *guid == guids[0]), "the GUID cannot tell them apart");
    for (theirs, ours) in [(0, 1), (1, 0), (0, 2), (2, 0), (1, 2), (2, 1)] {
        let (other, mut own) = (bytes(&started(theirs, 5.0)), started(ours, 7.0));
        let (before, mut state) = (bytes(&own), null_mut());
        let mut read = |bytes: &[u8]| unsafe {
            let (place, size) = (bytes.as_ptr().cast(), bytes.len());
            fmi2::fmi2DeSerializeFMUstate(own.c, place, size, &raw mut state)
        };
        assert_eq!(read(&other), Status::Error, "{theirs} to {ours}");
        assert!(state.is_null());
        let line = own.line();
        assert!(line.starts_with("fmi2DeSerializeFMUstate: these"), "{line}");
        assert!(line.contains("another shape"), "{line}");
        assert_eq!(bytes(&own), before, "{theirs} to {ours}");
        assert_eq!((own.step(0.0, 0.1), own.get("kept")), (Status::Ok, 7.0));
        // Its own states are still accepted afterwards.
        let place = before.as_ptr().cast();
        unsafe {
            let size = before.len();
            let read = fmi2::fmi2DeSerializeFMUstate(own.c, place, size, &raw mut state);
            assert_eq!((read, fmi2::fmi2SetFMUstate(own.c, state)), (Status::Ok, Status::Ok));
        }
        assert_eq!(own.get("time"), 0.0);
        assert_eq!(own.log(), []);
    }
}
