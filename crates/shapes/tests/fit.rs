//! Sizes come out as stated, whatever went in.

use body::Shape;
use body::fit::{Fit, fitted};
use proptest::prelude::*;
use trolley_shapes::generate;

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-5 * b.max(1.0)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn a_fitted_body_has_the_stated_size_on_the_ground_around_the_origin(
        which in 0..Shape::ALL.len(), length in 0.2..20.0_f64, width in 0.2..5.0_f64,
        height in 0.2..5.0_f64, seed in 0..5_u64,
    ) {
        let mesh = generate(Shape::ALL[which], 600, seed).expect("a body");
        let was = mesh.size_m();
        let plan = fitted(mesh.clone(), Fit::Plan([length, width]));
        let size = plan.size_m();
        prop_assert!(near(size[0], length) && near(size[1], width) && near(size[2], was[2]));
        let whole = fitted(mesh.clone(), Fit::Whole([length, width, height])).size_m();
        prop_assert!(near(whole[2], height));
        let longest = fitted(mesh.clone(), Fit::Longest(length));
        let size = longest.size_m();
        prop_assert!(near(size[0].max(size[1]), length) && near(size[2], was[2]));
        prop_assert!(near(size[0] / size[1], was[0] / was[1]));
        let bounds = plan.bounds();
        prop_assert!(bounds.min[2] == 0.0 && (bounds.min[0] + bounds.max[0]).abs() < 1e-5);
        prop_assert_eq!(&plan.source_ids, &mesh.source_ids);
    }
}
