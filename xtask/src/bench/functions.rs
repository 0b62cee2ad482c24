//! The functions of the standard, each for each component, through the C interface.

use super::component::Component;
use super::timer::{repeat, rounds};
use super::{Bar, Row, row};
use anyhow::Result;
use fmu_kit::kernel::Group;
use rexrov_fmu::REGISTRY;
use std::hint::black_box;

const TIMES: u32 = 200;
/// Complete instance lifetimes in a round.
const LIVES: u32 = 5;

/// Measurements with a goal: ten values, states, lifetimes, one column of the Jacobian.
pub(super) fn bars() -> Result<Vec<Row>> {
    let mut rows = ten_values()?;
    rows.extend(column()?);
    for name in names() {
        let mut component = Component::stepping(name)?;
        component.save();
        let state = rounds(
            TIMES,
            [&mut repeat(|| {
                component.save();
                component.restore();
            })],
        );
        component.check()?;
        rows.push(row(format!("get + set state, {name}"), state.ns(0), "ns", Bar::AtMost(100.0)));
    }
    for name in names() {
        let us = life(name)? / 1e3;
        rows.push(row(format!("instantiate to initialized, {name}"), us, "us", Bar::AtMost(20.0)));
    }
    Ok(rows)
}

/// Nanoseconds of every function for every component.
pub(super) fn print() -> Result<()> {
    println!(
        "ns of a call; step over one sample period (RexROV: 10 ms), derivative: one column of \
         derivatives and outputs, life: instantiate to initialized and freed"
    );
    let heads = ["set all", "get all", "doStep", "derivative", "getState", "setState", "life"];
    println!("{:20}{}", "", heads.map(|head| format!("{head:>13}")).concat());
    names().try_for_each(line)
}

fn names() -> impl Iterator<Item = &'static str> {
    REGISTRY.entries().map(|entry| entry.info().name)
}

fn line(name: &str) -> Result<()> {
    let (setting, getting) = (Component::stepping(name)?, Component::stepping(name)?);
    let (stepping, h) = (Component::stepping(name)?, getting.period_s());
    let (mut saving, mut restoring) = (Component::stepping(name)?, Component::stepping(name)?);
    saving.save();
    restoring.save();
    let (inputs, outputs) = (setting.group(Group::Input), setting.group(Group::Output));
    let (mut u, mut y) = (vec![0.0; inputs.len()], vec![0.0; outputs.len()]);
    setting.get(&inputs, &mut u);
    let times = rounds(
        TIMES,
        [
            &mut repeat(|| setting.set(&inputs, black_box(&u))),
            &mut repeat(|| getting.get(&outputs, black_box(&mut y))),
            &mut repeat(|| stepping.step(h)),
            &mut repeat(|| saving.save()),
            &mut repeat(|| restoring.restore()),
        ],
    );
    [&setting, &getting, &stepping, &saving, &restoring].iter().try_for_each(|c| c.check())?;
    let states = setting.group(Group::State);
    let derivative = if states.is_empty() { "-".into() } else { format!("{:.0}", columns(name)?) };
    println!(
        "{name:20}{:>13}{:>13}{:>13.0}{derivative:>13}{:>13.0}{:>13.0}{:>13.0}",
        format!("{:.0} ({})", times.ns(0), u.len()),
        format!("{:.0} ({})", times.ns(1), y.len()),
        times.ns(2),
        times.ns(3),
        times.ns(4),
        life(name)?,
    );
    Ok(())
}

/// Nanoseconds from instantiation to the end of initialization, and of freeing.
fn life(name: &str) -> Result<f64> {
    let mut outcome = Ok(());
    let times = rounds(
        LIVES,
        [&mut repeat(|| {
            let lived = Component::stepping(name).and_then(|component| component.check());
            if outcome.is_ok() {
                outcome = lived;
            }
        })],
    );
    outcome.map(|()| times.ns(0))
}

/// Setting and getting ten values, in excess of copying them by their indices.
fn ten_values() -> Result<Vec<Row>> {
    let (setting, getting) = (Component::stepping("RexROV")?, Component::stepping("RexROV")?);
    let ten = |group| setting.group(group).into_iter().take(10).collect::<Vec<_>>();
    let (inputs, outputs) = (ten(Group::Input), ten(Group::Output));
    let (mut values, mut all) = ([0.5; 10], [0.0; 256]);
    let (u, mut y) = (values, [0.0; 10]);
    let times = rounds(
        TIMES,
        [
            &mut repeat(|| setting.set(&inputs, black_box(&u))),
            &mut repeat(|| getting.get(&outputs, black_box(&mut y))),
            &mut repeat(|| copy(black_box(&inputs), black_box(&mut values), black_box(&mut all))),
        ],
    );
    setting.check()?;
    getting.check()?;
    let bar = || Bar::AtMost(15.0);
    Ok(vec![
        row("setReal of 10 values beyond copying", times.beyond(0, 2), "ns", bar()),
        row("getReal of 10 values beyond copying", times.beyond(1, 2), "ns", bar()),
    ])
}

#[inline(never)]
fn copy(references: &[u32], values: &mut [f64; 10], all: &mut [f64; 256]) {
    for (reference, value) in references.iter().zip(values) {
        all[*reference as usize & 255] = *value;
    }
}

/// A column of the Jacobian of the vehicle over its right-hand side, both through the C interface.
fn column() -> Result<Vec<Row>> {
    let vehicle = Component::continuous("RexROV")?;
    let derivatives = vehicle.group(Group::Derivative);
    let knowns = [vehicle.group(Group::State), vehicle.group(Group::Input)].concat();
    let (mut x, mut dx, mut z) = ([0.0; 21], [0.0; 21], [0.0; 21]);
    vehicle.continuous_states(&mut x);
    x[7..].iter_mut().zip(1..).for_each(|(x, i)| *x = 0.1 * f64::from(i));
    vehicle.set(&knowns[21..], &[10.0; 25]);
    // Nothing is cached from one column to the next, so all columns of a point cost their sum.
    let mut ratios = Vec::with_capacity(knowns.len());
    for known in &knowns {
        let times = rounds(
            20,
            [
                &mut repeat(|| vehicle.column(&derivatives, *known, black_box(&mut z))),
                &mut repeat(|| vehicle.derivatives(black_box(&x), black_box(&mut dx))),
            ],
        );
        ratios.push(times.ratio(0, 1));
    }
    vehicle.check()?;
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    let dearest = ratios.iter().copied().fold(0.0, f64::max);
    let what = "directional derivative of a column over the right-hand side, RexROV, mean of 46";
    Ok(vec![
        row(what, mean, "", Bar::AtMost(1.0)),
        row("  the first column", ratios.first().copied().unwrap_or(f64::NAN), "", Bar::None),
        row("  the dearest column", dearest, "", Bar::None),
    ])
}

/// Nanoseconds of a column of derivatives and outputs, the mean over all columns.
fn columns(name: &str) -> Result<f64> {
    let component = Component::stepping(name)?;
    let both = |a, b| [component.group(a), component.group(b)].concat();
    let (unknowns, knowns) =
        (both(Group::Derivative, Group::Output), both(Group::State, Group::Input));
    let mut column = vec![0.0; unknowns.len()];
    let times = rounds(
        5,
        [&mut repeat(|| {
            for known in &knowns {
                component.column(&unknowns, *known, black_box(&mut column));
            }
        })],
    );
    component.check()?;
    Ok(times.ns(0) / knowns.len() as f64)
}
