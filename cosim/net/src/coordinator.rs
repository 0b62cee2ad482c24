//! Drives groups of components in other processes as one system.
//!
//! Everything is computed in the same order as by the engine in one process (`layout` says why), so
//! the results are identical to the last bit. Every command is kept until a state that contains its
//! effect has been saved. A lost group is restarted as a new incarnation from that state, the same
//! commands are sent again, and each answer must be the same as the first time.

use super::dispatcher::Dispatcher;
use super::fabric::Fabric;
use super::group_handle::GroupHandle;
use super::layout::Layout;
use super::options::Options;
use super::setup::Setup;
use super::wire::{Body, Kind, LAST, Malformed, OPENING, RECORD, put_values};
use cosim_base::error::{Code, Error, Result};
use cosim_base::time::Time;
use cosim_core::master::{
    Change, Drive, EngineState, Plan, Report, Saved, Tally, UNSETTLED, passes,
};
use cosim_core::system::{Model, System};
use cosim_import::Scalar;

/// A system whose groups run in other processes.
pub(crate) struct Coordinator<'a> {
    pub(super) plan: Plan,
    pub(super) layout: Layout,
    dispatcher: Dispatcher<'a>,
    /// Which groups can save their state.
    can_save: Vec<bool>,
    warnings: Vec<String>,
    values: Vec<Scalar>,
    ends: Vec<Time>,
    start: Time,
    instants: u64,
}

impl<'a> Coordinator<'a> {
    /// Creates a coordinator for the groups of `layout`, each with its set-up.
    pub(crate) fn new(
        system: &System,
        plan: Plan,
        layout: Layout,
        setups: &[Setup],
        fabric: Box<dyn Fabric + 'a>,
        options: Options,
    ) -> Result<Self> {
        let can_save = layout.groups.iter().map(|group| can_save(system, &group.own)).collect();
        let name = |&component: &usize| system.components()[component].name.as_str();
        let groups = layout.groups.iter().zip(setups).map(|(group, setup)| {
            let names: Vec<&str> = group.own.iter().map(name).collect();
            let (body, tables) = super::setup::encode(setup)?;
            Ok((names.join(", "), GroupHandle::new(Kind::Setup, body, tables)))
        });
        let groups = groups.collect::<Result<Vec<_>>>()?;
        let start = system.start_time();
        Ok(Self {
            values: vec![Scalar::default(); plan.values],
            ends: plan.nodes.iter().map(|node| start + node.step.rounded()).collect(),
            start,
            plan,
            layout,
            dispatcher: Dispatcher::new(groups, fabric, options, start),
            can_save,
            warnings: Vec::new(),
            instants: 0,
        })
    }

    /// Adds warnings to the report at the end.
    pub(crate) fn warn(&mut self, warnings: Vec<String>) {
        self.warnings.extend(warnings);
    }

    /// Stops all groups that still run.
    pub(crate) fn end(&mut self) {
        self.dispatcher.end();
    }

    fn groups(&self) -> std::ops::Range<usize> {
        0..self.dispatcher.groups.len()
    }

    /// Begins a command to a group, with the held values that it is waiting for.
    fn command(&mut self, group: usize, kind: Kind, flags: u8) -> Vec<u8> {
        let handle = &mut self.dispatcher.groups[group];
        let opening = handle.opening.take();
        let flags = if opening.is_some() { flags | OPENING } else { flags };
        let mut message = handle.command(kind, flags, self.dispatcher.now);
        message.extend(opening.unwrap_or_default());
        message
    }

    /// Sends all groups the same command and reads all their outputs.
    fn send_all(&mut self, kind: Kind) -> Result<()> {
        for group in self.groups() {
            let message = self.command(group, kind, 0);
            self.dispatcher.send(group, message)?;
        }
        self.read_answers(|this, group, mut body| {
            let own = &this.layout.groups[group].own;
            read(&mut body, &this.plan, this.plan.outputs(own), &mut this.values)?;
            body.end()
        })
    }

    /// Reads the answer of every group that was sent a command.
    fn read_answers(
        &mut self,
        mut read: impl FnMut(&mut Self, usize, Body<'_>) -> Result<(), Malformed>,
    ) -> Result<()> {
        loop {
            let answers = self.dispatcher.answers()?;
            if answers.is_empty() {
                return Ok(());
            }
            for (group, answer) in answers {
                if let Err(why) = read(self, group, Body::after_header(&answer)) {
                    self.dispatcher.refuse(group, &why);
                }
            }
        }
    }

    /// One stretch of the sequence in initialization mode.
    fn exchange(&mut self, group: usize, number: usize) -> Result<()> {
        let mut message = self.command(group, Kind::Exchange, 0);
        message.extend((number as u32).to_le_bytes());
        let part = &self.layout.groups[group].stretches[number];
        put_values(&mut message, part.reads.iter().copied(), &self.plan.value_texts, &self.values);
        self.dispatcher.send(group, message)?;
        self.read_answers(|this, group, mut body| {
            let members = &this.layout.groups[group].stretches[number].members;
            read(&mut body, &this.plan, this.plan.outputs(members), &mut this.values)?;
            body.end()
        })
    }

    /// As in an ordinary run (`Engine::settle`), one stretch after another.
    fn settle(&mut self) -> Result<()> {
        let mut before = Vec::with_capacity(self.values.len());
        for _ in 0..passes(&self.plan) {
            before.clone_from(&self.values);
            for (group, number) in self.layout.order.clone() {
                self.exchange(group, number)?;
            }
            if before == self.values {
                return Ok(());
            }
        }
        if self.plan.loops.is_empty() {
            self.warnings.push(UNSETTLED.to_owned());
        }
        Ok(())
    }

    /// Stores the values that these groups hold from now on.
    fn keep_held(&mut self, groups: impl IntoIterator<Item = usize>) {
        for group in groups {
            let held = &self.layout.groups[group].held;
            let mut opening = Vec::new();
            put_values(&mut opening, held.iter().copied(), &self.plan.value_texts, &self.values);
            self.dispatcher.groups[group].opening = Some(opening);
        }
    }

    /// Computes one instant, level by level.
    fn instant(&mut self, now: Time, flags: u8) -> Result<()> {
        self.dispatcher.now = now;
        let mut stepped = vec![false; self.dispatcher.groups.len()];
        for level in 0..self.layout.levels {
            for group in self.groups() {
                if self.due(group, level).next().is_some() {
                    stepped[group] = true;
                    let last = (level + 1..self.layout.levels)
                        .all(|later| self.due(group, later).next().is_none());
                    self.send_step(group, level, if last { flags } else { flags & !RECORD })?;
                }
            }
            self.read_answers(|this, group, mut body| {
                let due: Vec<usize> = this.due(group, level).collect();
                read(&mut body, &this.plan, this.plan.outputs(&due), &mut this.values)?;
                if this.dispatcher.groups[group].recorded {
                    this.read_recorded(group, &mut body)?;
                }
                body.end()
            })?;
        }
        for (node, end) in self.plan.nodes.iter().zip(&mut self.ends) {
            if *end == now {
                *end = self.start + node.step.after(now - self.start);
            }
        }
        self.keep_held(self.groups().filter(|&group| stepped[group]));
        self.instants += 1;
        if self
            .dispatcher
            .options
            .save_every
            .is_some_and(|every| self.instants.is_multiple_of(every))
        {
            self.save_groups()?;
        }
        Ok(())
    }

    /// The components of a part whose steps end now.
    fn due(&self, group: usize, level: usize) -> impl Iterator<Item = usize> {
        let members = self.layout.groups[group].parts[level].members.iter().copied();
        members.filter(|&member| self.ends[member] == self.dispatcher.now)
    }

    fn send_step(&mut self, group: usize, level: usize, flags: u8) -> Result<()> {
        let mut message = self.command(group, Kind::Step, flags);
        message.extend((level as u32).to_le_bytes());
        let part = &self.layout.groups[group].parts[level];
        put_values(&mut message, part.reads.iter().copied(), &self.plan.value_texts, &self.values);
        self.dispatcher.groups[group].recorded = flags & RECORD != 0;
        self.dispatcher.send(group, message)
    }

    fn read_recorded(&mut self, group: usize, body: &mut Body<'_>) -> Result<(), Malformed> {
        let own = &self.layout.groups[group].own;
        read(body, &self.plan, self.plan.recorded(own), &mut self.values)
    }

    /// Saves the state of every group that can, and drops the commands before it.
    fn save_groups(&mut self) -> Result<()> {
        let able: Vec<usize> = self.groups().filter(|&group| self.can_save[group]).collect();
        for (group, state) in self.states(&able)? {
            self.rebase(group, state)?;
        }
        Ok(())
    }

    /// From now on, new incarnations of a group start from this state.
    fn rebase(&mut self, group: usize, state: (EngineState, Tally)) -> Result<()> {
        let setup = &self.dispatcher.groups[group].setup;
        let body = super::setup::with_state(setup, self.dispatcher.now, state)?;
        self.dispatcher.rebase(group, body);
        Ok(())
    }

    /// The states of some groups.
    fn states(&mut self, groups: &[usize]) -> Result<Vec<(usize, (EngineState, Tally))>> {
        for &group in groups {
            let message = self.command(group, Kind::Save, 0);
            self.dispatcher.send(group, message)?;
        }
        let mut states = Vec::with_capacity(groups.len());
        self.read_answers(|_, group, mut body| {
            let blob = body.blob()?;
            let state = postcard::from_bytes(blob).map_err(|e| Malformed::Body(e.to_string()))?;
            body.end()?;
            states.push((group, state));
            Ok(())
        })?;
        Ok(states)
    }
}

impl Drive for Coordinator<'_> {
    fn initialize(&mut self, stop: Time) -> Result<()> {
        let _ = stop;
        self.dispatcher.launch_all()?;
        self.send_all(Kind::Enter)?;
        self.settle()?;
        self.send_all(Kind::Exit)?;
        self.keep_held(self.groups());
        Ok(())
    }

    fn run_until(&mut self, limit: Time) -> Result<()> {
        while let Some(now) = self.ends.iter().min().copied().filter(|&now| now <= limit) {
            self.dispatcher.groups.iter_mut().for_each(|handle| handle.recorded = false);
            self.instant(now, if now == limit { RECORD } else { 0 })?;
        }
        Ok(())
    }

    fn conclude(&mut self, now: Time) -> Result<()> {
        for (node, end) in self.plan.nodes.iter().zip(&mut self.ends) {
            *end = if node.variable { now } else { *end };
        }
        self.dispatcher.groups.iter_mut().for_each(|handle| handle.recorded = false);
        self.instant(now, RECORD | LAST)
    }

    fn sample(&mut self, _now: Time, row: &mut [f64]) -> Result<()> {
        for group in self.groups() {
            let recorded = self.plan.recorded(&self.layout.groups[group].own).next().is_some();
            if recorded && !self.dispatcher.groups[group].recorded {
                let message = self.command(group, Kind::Sample, 0);
                self.dispatcher.send(group, message)?;
            }
        }
        self.read_answers(|this, group, mut body| {
            this.read_recorded(group, &mut body)?;
            body.end()
        })?;
        self.plan.row(&self.values, row);
        Ok(())
    }

    fn change(&mut self, component: usize, change: Change, _now: Time) -> Result<()> {
        let place = |own: &[usize]| own.iter().position(|&own| own == component);
        let places = self.layout.groups.iter().enumerate();
        let found = places.filter_map(|(group, of)| Some((group, place(&of.own)?))).next();
        let Some((group, position)) = found else {
            return Err(Error::new(Code::Protocol, format!("no group has component {component}")));
        };
        let mut message = self.command(group, Kind::Change, 0);
        let body = postcard::to_stdvec(&(position, change));
        message.extend(body.map_err(|why| unusable().why(why))?);
        self.dispatcher.send(group, message)?;
        self.read_answers(|_, _, body| body.end())
    }

    fn save(&mut self, _now: Time) -> Result<EngineState> {
        let groups: Vec<usize> = self.groups().collect();
        let inputs = vec![Scalar::default(); self.plan.inputs];
        let mut whole = EngineState {
            values: self.values.clone(),
            texts: self.plan.texts(&self.values, &inputs),
            inputs,
            ends: self.ends.clone(),
            trends: vec![Default::default(); self.plan.trends.len()],
            ramps: vec![Default::default(); self.plan.ramps.len()],
            step: None,
            components: vec![Saved::default(); self.plan.nodes.len()],
        };
        for (group, (mut state, _)) in self.states(&groups)? {
            for (place, &component) in self.layout.groups[group].own.iter().enumerate() {
                let node = &self.plan.nodes[component];
                let (values, inputs) = (node.recorded_slots.clone(), node.input_slots.clone());
                whole.values[values.clone()].copy_from_slice(&state.values[values]);
                whole.inputs[inputs.clone()].copy_from_slice(&state.inputs[inputs]);
                node.trends.iter().for_each(|&trend| whole.trends[trend] = state.trends[trend]);
                node.ramps.iter().for_each(|&ramp| whole.ramps[ramp] = state.ramps[ramp]);
                self.plan.texts_of(component).for_each(|text| {
                    whole.texts[text].clone_from(&state.texts[text]);
                });
                whole.components[component] = std::mem::take(&mut state.components[place]);
            }
        }
        Ok(whole)
    }

    fn resume(&mut self, state: &EngineState, time: Time, stop: Time) -> Result<()> {
        let _ = stop;
        state.check(&self.plan, self.start, time, false)?;
        self.dispatcher.now = time;
        self.values.clone_from(&state.values);
        self.plan.take_texts(&state.texts, &mut self.values, &mut []);
        self.ends.clone_from(&state.ends);
        for group in self.groups() {
            let own = &self.layout.groups[group].own;
            let part = EngineState {
                ends: own.iter().map(|&component| state.ends[component]).collect(),
                components: own.iter().map(|&c| state.components[c].clone()).collect(),
                ..state.clone()
            };
            self.rebase(group, (part, Tally::default()))?;
        }
        self.dispatcher.launch_all()
    }

    fn report(&mut self) -> Result<Report> {
        for group in self.groups() {
            let message = self.command(group, Kind::Finish, 0);
            self.dispatcher.send(group, message)?;
        }
        let mut whole = Report {
            components: vec![Default::default(); self.plan.nodes.len()],
            efforts: vec![Default::default(); self.plan.loops.len()],
            warnings: self.warnings.clone(),
            notes: Vec::new(),
        };
        self.read_answers(|this, group, body| {
            let report: Report = body.structure()?;
            let own = &this.layout.groups[group].own;
            let loops = this.plan.loops.iter().enumerate();
            let loops = loops.filter(|(_, found)| found.members.iter().all(|m| own.contains(m)));
            for ((position, _), effort) in loops.zip(report.efforts) {
                whole.efforts[position] = effort;
            }
            for (&component, report) in own.iter().zip(report.components) {
                whole.components[component] = report;
            }
            whole.warnings.extend(report.warnings);
            whole.notes.extend(report.notes);
            Ok(())
        })?;
        whole.notes.splice(0..0, self.dispatcher.notes.iter().cloned());
        Ok(whole)
    }
}

/// Whether all of these components can serialize their state.
fn can_save(system: &System, own: &[usize]) -> bool {
    own.iter().all(|&component| {
        let component = &system.components()[component];
        match &component.model {
            Model::Fmu(fmu) => {
                fmu.interface(component.interface).is_ok_and(|part| part.serialize_state)
            }
            Model::Signals(_) | Model::Function(_) => true,
        }
    })
}

fn read(
    body: &mut Body<'_>,
    plan: &Plan,
    slots: impl IntoIterator<Item = usize>,
    values: &mut [Scalar],
) -> Result<(), Malformed> {
    body.values(slots, &plan.value_texts, values)
}

fn unusable() -> Error {
    Error::new(Code::Protocol, "a state or a change cannot be serialized")
}
