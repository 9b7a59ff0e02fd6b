//! The small worlds of `vestibule-testing`, for tests of crates that name this file.

#[path = "../../../vestibule-testing/src/records.rs"]
#[allow(dead_code, unreachable_pub, reason = "each test binary uses a part of it")]
mod made;

pub(crate) use made::*;
