//! Notes on connections, collected over all of them.

use cosim_base::Warnings;

/// How many connections without a unit at one end are listed in their common note.
const SHOWN: usize = 3;

/// Notes on connections, collected over all of them.
#[derive(Default)]
pub(super) struct ConnectionNotes {
    /// Connections with a unit at one end only.
    pub missing: Vec<String>,
    /// Connections whose values are converted, and how.
    pub converted: Vec<String>,
    /// Connections to replaced components that lack the input.
    pub dropped: Vec<Dropped>,
}

/// A connection that is dropped.
pub(super) struct Dropped {
    pub place: String,
    pub from: String,
    /// Component and input.
    pub to: (String, String),
}

impl ConnectionNotes {
    pub(super) fn report(self, warnings: &mut Warnings, notes: &mut Vec<String>) {
        for all in self.dropped.chunk_by(|one, next| one.to.0 == next.to.0) {
            warnings.extend(all.first().map(|first| first.text(all)));
        }
        notes.extend(self.converted.into_iter().map(|text| format!("converted: {text}")));
        if self.missing.is_empty() {
            return;
        }
        let shown = self.missing.iter().take(SHOWN).cloned().collect::<Vec<_>>().join(", ");
        let rest = self.missing.len().saturating_sub(SHOWN);
        let rest = if rest > 0 { format!(" and {rest} more") } else { String::new() };
        notes.push(format!(
            "a unit is known at one end only, and the value is passed on unconverted: {shown}{rest}"
        ));
    }
}

impl Dropped {
    /// The text for this one and the others of the same component.
    fn text(&self, all: &[Dropped]) -> String {
        let Dropped { place, from, to: (component, input) } = self;
        let why = format!("the FMU put in place of '{component}' has no such input");
        let others = match all.len() {
            1 => String::new(),
            count => format!(", and {} more to '{component}'", count - 1),
        };
        format!("{place}: the connection {from} -> {component}.{input} is dropped{others}: {why}")
    }
}
