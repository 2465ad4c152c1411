//! The plugins inside this program.

use cosplat_core::plugin::Plugin;

/// Makes a plugin.
type Make = fn() -> Box<dyn Plugin>;

/// Plugins by name.
const PLUGINS: [(&str, Make); 9] = [
    ("mpm", || Box::new(cosplat_mpm::Mpm::<f32>::default())),
    ("mpm-f64", || Box::new(cosplat_mpm::Mpm::<f64>::default())),
    ("oscillator", || Box::new(cosplat_oscillator::Oscillator::default())),
    ("pbd", || Box::new(cosplat_pbd::Pbd::default())),
    ("rigid", || Box::new(cosplat_rigid::Rigid::default())),
    ("rigid-lite", || Box::new(cosplat_rigid_lite::RigidLite::default())),
    ("shape-matching", || Box::new(cosplat_shape_matching::ShapeMatching::default())),
    ("smoke", || Box::new(cosplat_smoke::Smoke::default())),
    ("sph", || Box::new(cosplat_sph::Sph::default())),
];

/// Their names.
pub(crate) fn names() -> impl Iterator<Item = &'static str> {
    PLUGINS.iter().map(|(name, _)| *name)
}

/// The plugin of that name, new.
pub(crate) fn make(name: &str) -> Option<Box<dyn Plugin>> {
    PLUGINS.iter().find(|(n, _)| *n == name).map(|(_, make)| make())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_plugin_goes_by_its_own_name() {
        for name in names() {
            assert_eq!(make(name).map(|p| p.describe().name).as_deref(), Some(name));
        }
    }
}
