//! Which calls are accepted in which state: those of the standard's table and two more, because
//! importers make them: values are read right after instantiation, and event mode is entered twice.

use fmu_standard::{Call, Phase};

/// Whether a function may be called in this state.
#[inline]
#[must_use]
pub const fn accepts(phase: Phase, call: Call) -> bool {
    phase.allows(call)
        || match phase {
            Phase::Instantiated => {
                matches!(
                    call,
                    Call::GetReal | Call::GetInteger | Call::GetBoolean | Call::GetString
                )
            }
            Phase::Event => matches!(call, Call::EnterEventMode),
            _ => false,
        }
}
