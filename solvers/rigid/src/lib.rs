//! Rigid bodies with contact and friction.
