//! What Vestibule is measured by.
//!
//! * [`golden`] is a scenario whose outcome is known to the bit, whatever the machine, the build and the number of
//!   threads;
//! * [`crowd`] fills a world with walking bodies;
//! * [`figures`] measures a world of retail size. `cargo run --release -p vestibule-bench -- FOLDER` prints every
//!   figure of `docs/performance.md` with the machine it ran on.
//!
//! ```
//! let hash = vestibule_bench::golden::scenario(1, 50)?;
//! assert_eq!(hash, vestibule_bench::golden::scenario(2, 50)?);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![forbid(unsafe_code)]

pub mod crowd;
pub mod figures;
pub mod golden;
