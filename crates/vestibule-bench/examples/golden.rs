//! The golden scenario for a second target: a library whose one function gives the hash.

/// The hash of the whole scenario; 0 when it could not be run.
#[unsafe(no_mangle)]
#[allow(unsafe_code, reason = "the name of a function that is called from outside")]
pub extern "C" fn golden() -> u64 {
    vestibule_bench::golden::whole(1).unwrap_or(0)
}
