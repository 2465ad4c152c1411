//! Tests of the solver through the plugin contract, in one program: the solver is generic, and each program compiles it anew.

#[cfg(test)]
mod books;
#[cfg(test)]
mod capture;
#[cfg(test)]
mod common;
#[cfg(test)]
mod conformance;
#[cfg(test)]
mod contact;
#[cfg(test)]
mod energy;
#[cfg(test)]
mod gauge;
#[cfg(test)]
mod incompressible;
#[cfg(test)]
mod liquid;
#[cfg(test)]
mod motion;
#[cfg(test)]
mod pair;
#[cfg(test)]
mod quarantine;
#[cfg(test)]
mod regions;
#[cfg(test)]
mod rigid;
#[cfg(test)]
mod sand;
#[cfg(test)]
mod several;
#[cfg(test)]
mod slope;
#[cfg(test)]
mod snow;
#[cfg(test)]
mod solid;
#[cfg(test)]
mod stiff;
#[cfg(test)]
mod terrain;
