//! Variables of one instance that are exchanged together.

use cosim_base::error::Result;
use cosim_import::{Instance, Kind, Scalar, Variable};

/// Variables that are set or read together, with one FMI call per type. A plan lists Reals first,
/// then Integers, then Booleans, then Strings ([`rank`]).
#[repr(C)]
pub(super) struct Group {
    reals: Vec<u32>,
    integers: Vec<u32>,
    booleans: Vec<u32>,
    strings: Vec<u32>,
    /// Buffers for the values that are not Reals.
    buffer: Vec<i32>,
}

/// Order of types within a group.
pub(super) fn rank(kind: &Kind) -> u8 {
    match kind {
        Kind::Real => 0,
        Kind::Integer | Kind::Enumeration(_) => 1,
        Kind::Boolean => 2,
        Kind::String => 3,
    }
}

impl Group {
    pub(super) fn new(variables: &[Variable], positions: &[usize]) -> Self {
        let of = |wanted: u8| -> Vec<u32> {
            let chosen = positions.iter().map(|&p| &variables[p]);
            chosen.filter(|v| rank(&v.kind) == wanted).map(|v| v.value_reference).collect()
        };
        let (reals, integers, booleans, strings) = (of(0), of(1), of(2), of(3));
        let buffer = vec![0; integers.len().max(booleans.len())];
        Self { reals, integers, booleans, strings, buffer }
    }

    /// The references of the Reals, which come first.
    pub(super) fn reals(&self) -> &[u32] {
        &self.reals
    }

    /// The values of Strings, which come last.
    pub(super) fn texts<'v>(&self, values: &'v mut [Scalar]) -> &'v mut [Scalar] {
        let first = values.len() - self.strings.len();
        &mut values[first..]
    }

    /// The references, if all are Reals.
    pub(super) fn only_reals(&self) -> Option<&[u32]> {
        let others = [&self.integers, &self.booleans, &self.strings];
        others.iter().all(|references| references.is_empty()).then_some(&self.reals)
    }

    #[inline(always)]
    pub(super) fn set(&mut self, instance: &mut Instance, values: &[Scalar]) -> Result<()> {
        let (reals, rest) = values.split_at(self.reals.len());
        if !reals.is_empty() {
            instance.set_real(&self.reals, Scalar::reals(reals))?;
        }
        if rest.is_empty() { Ok(()) } else { self.set_rest(instance, rest) }
    }

    fn set_rest(&mut self, instance: &mut Instance, rest: &[Scalar]) -> Result<()> {
        let (integers, rest) = rest.split_at(self.integers.len());
        let (booleans, strings) = rest.split_at(self.booleans.len());
        if !integers.is_empty() {
            let buffer = fill(&mut self.buffer, integers);
            instance.set_integer(&self.integers, buffer)?;
        }
        if !booleans.is_empty() {
            let buffer = fill(&mut self.buffer, booleans);
            instance.set_boolean(&self.booleans, buffer)?;
        }
        for (reference, text) in self.strings.iter().zip(strings) {
            instance.set_string(*reference, &text.as_text())?;
        }
        Ok(())
    }

    #[inline(always)]
    pub(super) fn get(&mut self, instance: &mut Instance, values: &mut [Scalar]) -> Result<()> {
        let (reals, rest) = values.split_at_mut(self.reals.len());
        if !reals.is_empty() {
            instance.get_real(&self.reals, Scalar::reals_mut(reals))?;
        }
        if rest.is_empty() { Ok(()) } else { self.get_rest(instance, rest) }
    }

    fn get_rest(&mut self, instance: &mut Instance, rest: &mut [Scalar]) -> Result<()> {
        let (integers, rest) = rest.split_at_mut(self.integers.len());
        let (booleans, strings) = rest.split_at_mut(self.booleans.len());
        if !integers.is_empty() {
            let buffer = &mut self.buffer[..integers.len()];
            instance.get_integer(&self.integers, buffer)?;
            integers
                .iter_mut()
                .zip(buffer)
                .for_each(|(to, from)| *to = Scalar::integer(i64::from(*from)));
        }
        if !booleans.is_empty() {
            let buffer = &mut self.buffer[..booleans.len()];
            instance.get_boolean(&self.booleans, buffer)?;
            // Any number except 0 is true in C.
            booleans
                .iter_mut()
                .zip(buffer)
                .for_each(|(to, from)| *to = Scalar::boolean(*from != 0));
        }
        for (reference, text) in self.strings.iter().zip(strings) {
            *text = Scalar::text(&instance.get_string(*reference)?);
        }
        Ok(())
    }
}

/// In the form of FMI 2.0.
fn fill<'b>(buffer: &'b mut [i32], values: &[Scalar]) -> &'b [i32] {
    let buffer = &mut buffer[..values.len()];
    buffer.iter_mut().zip(values).for_each(|(to, from)| *to = from.as_short_integer());
    buffer
}
