//! The driver's plan for each component: random inputs, the same for all platforms.

use super::{Options, clumsy::Clumsy};
use crate::package::{platform::Platform, stimulus};
use anyhow::Result;
use fmu_kit::{
    Start,
    kernel::{Entry, Group, Table, Variable},
};
use std::{fs, path::Path};

/// Communication step, s.
const STEP_S: f64 = 0.05;
/// Steps that are made twice, before a saved state and after it is restored.
const REPEATED: u32 = 100;
/// How far random inputs are from those of the reference run, as a fraction of the variable's
/// magnitude.
const SPREAD: f64 = 0.3;

/// Writes the plans and the list of jobs.
pub(super) fn lay_out(platform: &Platform, folder: &Path, options: &Options) -> Result<()> {
    let mut jobs = String::new();
    let mut job = |kind: &str, package: &str, entry: &Entry| -> Result<()> {
        let name = entry.info().name;
        fs::write(folder.join(format!("{name}.plan")), plan(entry.table(), options))?;
        let library = platform.library(package);
        jobs += &format!("{kind}\t./{library}\t{}\t{name}.plan\t{name}.txt\n", entry.guid());
        Ok(())
    };
    for entry in rexrov_fmu::REGISTRY.entries() {
        job("steps", "rexrov-fmu", entry)?;
    }
    job("panic", "clumsy", &Entry::of::<Clumsy>())?;
    fs::write(folder.join("jobs.txt"), jobs)?;
    Ok(())
}

/// The bytes of a plan, as `Plan` of the driver reads them.
fn plan(table: &Table, options: &Options) -> Vec<u8> {
    let references = |wanted: &dyn Fn(&Variable) -> bool| -> Vec<u32> {
        table.variables().iter().filter(|v| wanted(v)).map(|v| v.reference).collect()
    };
    let inputs: Vec<_> = table.group(Group::Input).map(|(_, variable)| variable).collect();
    let kinds = [
        references(&|v| v.group == Group::Input),
        references(&|v| v.group == Group::Output),
        references(&|v| matches!(v.start, Start::Real(_))),
        references(&|v| matches!(v.start, Start::Integer(_) | Start::Enumeration { .. })),
        references(&|v| matches!(v.start, Start::Boolean(_))),
    ];
    let counts = kinds.iter().map(|kind| kind.len() as u32).chain([
        table.layout().states.len() as u32,
        table.indicators().len() as u32,
        options.steps,
        options.steps / 2,
        REPEATED,
    ]);
    let mut bytes: Vec<u8> = counts.flat_map(u32::to_le_bytes).collect();
    bytes.extend(kinds.iter().flatten().flat_map(|reference| reference.to_le_bytes()));
    let mut random = Random(options.seed);
    for k in 0..options.steps {
        let time = f64::from(k) * STEP_S;
        let step = f64::from(k + 1) * STEP_S - time;
        let values = inputs.iter().map(|input| value(input, time, &mut random));
        let row = [time, step].into_iter().chain(values);
        bytes.extend(row.flat_map(f64::to_le_bytes));
    }
    bytes
}

/// The value of an input at a time: about the same as in the reference run, within its bounds.
fn value(input: &Variable, time: f64, random: &mut Random) -> f64 {
    let Start::Real(start) = input.start else { return 0.0 };
    let usual = stimulus::value(&input.name, time);
    let draw = random.next();
    // Valid in nine of ten steps, stamped now.
    match input.name.rsplit('.').next() {
        Some("valid") => return f64::from(draw > -0.8),
        Some("stamp") => return usual.unwrap_or(start),
        _ => (),
    }
    let magnitude = input.nominal.unwrap_or(1.0).max(1e-3);
    let value = usual.unwrap_or(start) + SPREAD * magnitude * draw;
    value.max(input.min.unwrap_or(f64::MIN)).min(input.max.unwrap_or(f64::MAX))
}

/// SplitMix64: numbers from -1 to 1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}
