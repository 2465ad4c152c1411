//! Tests that belong to no single crate, one folder per question.
//!
//! * `tidy`: is the repository in order? Who may use what, how long a file is, whether the documents say what the code
//!   says.
//! * `simulation`: does the protocol hold when everything that can happen to a message happens, and does each of its
//!   checks matter?
//! * `e2e`: do real processes on the real bus do what is promised, also when one of them dies, freezes or lies? They are
//!   tests of the crate `cosplat`, because they run its program.
//! * `benches`: what does a coupling window cost?
//!
//! What a solver plugin must pass is a crate of its own, `cosplat-conformance`, so that foreign plugins can use it.
