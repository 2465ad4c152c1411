//! The smallest legal foreign plugin lives in `examples/dummy.rs`; this library is empty on purpose.
