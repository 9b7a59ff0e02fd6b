//! Measurements of a world of retail size.
