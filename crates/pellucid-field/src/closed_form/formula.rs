//! Fields that are one formula: it is written once, and every method follows.

/// The methods of `ScalarField` that follow from `fn formula<N: Number>(&self, p: [N; 3]) -> N`, or, for a field with
/// edges, from `fn formula<N: Number>(&self, p: [N; 3], seen: Footprint) -> N`.
macro_rules! value_and_gradient {
    (edges) => {
        fn value(&self, p: glam::DVec3) -> f64 {
            self.formula(p.to_array(), $crate::closed_form::footprint::Footprint::POINT)
        }

        fn gradient(&self, p: glam::DVec3) -> glam::DVec3 {
            let coordinates = $crate::closed_form::number::Dual::coordinates(p);
            self.formula(coordinates, $crate::closed_form::footprint::Footprint::POINT).gradient
        }

        fn seen(&self, p: glam::DVec3, voxel: f64) -> f64 {
            self.formula(p.to_array(), $crate::closed_form::footprint::Footprint(voxel))
        }
    };
    () => {
        fn value(&self, p: glam::DVec3) -> f64 {
            self.formula(p.to_array())
        }

        fn gradient(&self, p: glam::DVec3) -> glam::DVec3 {
            self.formula($crate::closed_form::number::Dual::coordinates(p)).gradient
        }
    };
}
pub(crate) use value_and_gradient;
