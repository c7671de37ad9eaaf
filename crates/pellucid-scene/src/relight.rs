//! A scene in the light of a look.

use pellucid_optics::{LightModel, Shadows};

use crate::{LightPath, Look, Scene};

impl Look {
    /// Makes the settings of a scene its own. Nothing else remembers it: a scene that is saved holds the settings.
    pub fn apply(self, scene: &mut Scene) {
        scene.lighting = self.lighting();
        scene.image.background = self.background();
        scene.technique.light_by(self, &mut scene.lighting);
        // The others follow light through the volume by themselves, or not at all.
        let needs = scene.technique.needs();
        if !needs.shadows {
            scene.lighting.shadows = Shadows::default();
        }
        if needs.light.is_followed() {
            scene.lighting.model = LightModel::default();
        }
        for entry in &mut scene.volumes {
            entry.shading = Some(self != Self::Cloud);
            entry.material = self.material();
            // Functions of the data's values, the same for all of them.
            entry.scattering = self.scattering(needs.light == LightPath::Scatters);
        }
    }
}
