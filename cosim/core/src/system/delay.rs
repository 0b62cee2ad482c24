//! How old a value is when its connection delivers it, and why.
//!
//! Two parts add up. A *late* value is from the start of the receiver's step although the end of
//! the step is computed with it; a *held* one comes from a source that steps less often than its
//! receiver, so the same value is read repeatedly between two steps of the source.

use super::{Algorithm, System};
use cosim_base::time::Time;

/// The delay of one connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Delay {
    /// How late the value is: zero, or one step of the receiver.
    pub late: Time,
    /// How much older it may be, because its source steps less often.
    pub held: Time,
    /// Why it is late or not.
    pub cause: Cause,
}

/// Why a connection delivers late or not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// The source steps first: the input gets the value at the end of the step.
    Fresh,
    /// Jacobi: every input holds the value at the start of the step.
    Jacobi,
    /// No output depends on the input directly.
    NoFeedThrough,
    /// The loop at this position of `Order::loops` is cut here.
    Cut(usize),
    /// The loop at this position of `Order::loops` is solved by iteration.
    Solved(usize),
}

impl System {
    /// The delay of each connection, in order.
    pub fn delays(&self) -> Vec<Delay> {
        (0..self.connections.len()).map(|connection| self.delay(connection)).collect()
    }

    fn delay(&self, connection: usize) -> Delay {
        let cause = self.cause(connection);
        let ends = &self.connections[connection];
        let source = self.components[ends.from.component].step;
        let receiver = self.components[ends.to.component].step;
        Delay {
            late: match cause {
                Cause::Fresh | Cause::Solved(_) => Time::ZERO,
                Cause::Jacobi | Cause::NoFeedThrough | Cause::Cut(_) => receiver.rounded(),
            },
            // Both count from the start, so they coincide at every common multiple.
            held: source.rounded() - source.gcd(receiver).rounded(),
            cause,
        }
    }

    fn cause(&self, connection: usize) -> Cause {
        if self.order.fresh[connection] {
            return Cause::Fresh;
        }
        if self.algorithm == Algorithm::Jacobi {
            return Cause::Jacobi;
        }
        match self.order.loops.iter().position(|l| l.held.contains(&connection)) {
            Some(found) if self.order.loops[found].solved => Cause::Solved(found),
            Some(found) => Cause::Cut(found),
            None => Cause::NoFeedThrough,
        }
    }

    /// A delay as text.
    pub fn explain(&self, connection: usize, delay: &Delay) -> String {
        let ends = &self.connections[connection];
        let name = |component: usize| self.components[component].name.as_str();
        let (from, to) = (name(ends.from.component), name(ends.to.component));
        let late = delay.late;
        let mut text = match delay.cause {
            Cause::Fresh => format!("no delay: '{from}' steps before '{to}'"),
            Cause::Jacobi => format!(
                "one step late ({late}) because Jacobi holds every input from the start of the step"
            ),
            Cause::NoFeedThrough => format!(
                "held from the start of the step ({late}) because no output of '{to}' depends on \
                 the input directly"
            ),
            Cause::Cut(found) => self.explain_cut(found, to, late),
            Cause::Solved(found) => {
                let members = self.members(&self.order.loops[found]);
                format!("no delay: the loop through {members} is solved at each step")
            }
        };
        if self.is_linear(connection) {
            text += "; linear during the step";
        }
        if delay.held > Time::ZERO {
            let step = self.components[ends.from.component].step;
            text += &format!("; up to {} older because '{from}' steps every {step}", delay.held);
        }
        text
    }

    fn explain_cut(&self, found: usize, to: &str, late: Time) -> String {
        let found = &self.order.loops[found];
        if found.members.len() == 1 {
            return format!("one step late ({late}) because '{to}' feeds itself");
        }
        format!(
            "one step late ({late}) because the loop through {} is cut here: '{to}' comes before \
             its source in the file",
            self.members(found)
        )
    }
}
