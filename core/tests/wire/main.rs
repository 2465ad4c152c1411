//! What is on the wire: bytes that never change, round trips, and bytes that are not what they say.

mod control;
mod frames;
mod golden;
mod hostile;
mod round_trip;
mod sample;
