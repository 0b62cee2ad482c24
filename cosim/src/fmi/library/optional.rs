//! Functions that only some capabilities need. FMI demands them all, yet many libraries leave out
//! those that their flags deny: a missing one is found out when it is wanted.

use std::ffi::c_int;

use libloading::Library;

use super::{Bool, Component, FmuState};
use crate::fmi::status::RawStatus;

macro_rules! optional {
    ($($field:ident = $symbol:literal : fn($($argument:ty),*);)*) => {
        /// The functions that the library has of these.
        #[derive(Clone, Copy)]
        pub(in crate::fmi) struct Optional {
            $(pub $field: Option<unsafe extern "C" fn($($argument),*) -> RawStatus>,)*
        }

        impl Optional {
            pub(super) fn resolve(library: &Library) -> Self {
                Self {
                    $(
                        // SAFETY: FMI 2.0 fixes the type of the function of that name.
                        $field: unsafe {
                            library
                                .get::<unsafe extern "C" fn($($argument),*) -> RawStatus>($symbol)
                        }
                        .ok()
                        .map(|function| *function),
                    )*
                }
            }
        }
    };
}

optional! {
    serialized_size = "fmi2SerializedFMUstateSize": fn(Component, FmuState, *mut usize);
    serialize = "fmi2SerializeFMUstate": fn(Component, FmuState, *mut u8, usize);
    deserialize = "fmi2DeSerializeFMUstate": fn(Component, *const u8, usize, *mut FmuState);
    directional = "fmi2GetDirectionalDerivative": fn(
        Component, *const u32, usize, *const u32, usize, *const f64, *mut f64
    );
    input_derivatives = "fmi2SetRealInputDerivatives": fn(
        Component, *const u32, usize, *const c_int, *const f64
    );
    output_derivatives = "fmi2GetRealOutputDerivatives": fn(
        Component, *const u32, usize, *const c_int, *mut f64
    );
    real_status = "fmi2GetRealStatus": fn(Component, c_int, *mut f64);
    boolean_status = "fmi2GetBooleanStatus": fn(Component, c_int, *mut Bool);
}
