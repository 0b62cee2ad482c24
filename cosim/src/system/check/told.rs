//! Notes on units, gathered over all connections.

/// Connections without a unit at one end are told together; so many of them by name.
const SHOWN: usize = 3;

/// What is good to know of units, gathered over all connections.
#[derive(Default)]
pub(super) struct Told {
    /// Connections with a unit at one end only.
    pub missing: Vec<String>,
    /// Connections whose values are converted, and how.
    pub converted: Vec<String>,
}

impl Told {
    pub(super) fn tell(self, notes: &mut Vec<String>) {
        notes.extend(self.converted.into_iter().map(|text| format!("converted: {text}")));
        if self.missing.is_empty() {
            return;
        }
        let shown = self.missing.iter().take(SHOWN).cloned().collect::<Vec<_>>().join(", ");
        let rest = self.missing.len().saturating_sub(SHOWN);
        let rest = if rest > 0 { format!(" and {rest} more") } else { String::new() };
        notes.push(format!(
            "a unit is known at one end only, and the value is passed on as it is: {shown}{rest}"
        ));
    }
}
