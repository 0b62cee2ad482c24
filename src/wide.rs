//! Functions that are also compiled for 256-bit vectors, for processors that support them.
//!
//! Each element of a result comes from the same operations in the same order at any width, and none
//! is fused, so all processors give the same bits.

/// Defines a function that is compiled twice, for any processor and for wide vectors. A condition on
/// its constants says for which of them wide vectors are worth the check of the processor.
macro_rules! for_any_width {
    (
        $(if $worth:expr;)?
        $(#[$attribute:meta])*
        fn $name:ident $(<$(const $n:ident: usize),+>)? ($($arg:ident: $of:ty),* $(,)?)
        $(-> $result:ty)? $body:block
    ) => {
        $(#[$attribute])*
        #[allow(unsafe_code, reason = "code for wide vectors is called where the processor has them")]
        pub(super) fn $name $(<$(const $n: usize),+>)? ($($arg: $of),*) $(-> $result)? {
            #[inline(always)]
            fn narrow $(<$(const $n: usize),+>)? ($($arg: $of),*) $(-> $result)? $body

            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2")]
                fn wide $(<$(const $n: usize),+>)? ($($arg: $of),*) $(-> $result)? {
                    narrow $(::<$($n),+>)? ($($arg),*)
                }

                if true $(&& $worth)? && std::arch::is_x86_feature_detected!("avx2") {
                    // SAFETY: the processor supports the features that `wide` is compiled for.
                    return unsafe { wide $(::<$($n),+>)? ($($arg),*) };
                }
            }
            narrow $(::<$($n),+>)? ($($arg),*)
        }
    };
}
pub(crate) use for_any_width;
