//! From scenes and descriptors to plans: who takes part, what meets, who waits for whom, on which clock.

mod cast;
mod features;
mod frames;
mod interfaces;
mod run;
mod schedule;
mod threads;
mod window;
