//! The number orders as travel and numbers do.

use super::Due;
use geometry::rng::Rng;

const SPECIAL: [f32; 6] = [0.0, -0.0, f32::INFINITY, f32::NEG_INFINITY, f32::MIN_POSITIVE, -1e-40];

#[test]
fn the_order_is_that_of_travels_and_then_of_numbers() {
    let mut rng = Rng::new(1);
    let mut any = || {
        let travel = match rng.below(4) {
            0 => SPECIAL[rng.below(6) as usize],
            _ => f32::from_bits(rng.below(1 << 32) as u32),
        };
        let travel = if travel.is_nan() { 1.0 } else { travel };
        (travel, [rng.below(3) as u32, u32::MAX - rng.below(3) as u32])
    };
    for _ in 0..10_000 {
        let (p, q) = (any(), any());
        let order = p.0.total_cmp(&q.0).then(p.1.cmp(&q.1));
        let [due_p, due_q] = [p, q].map(|(travel, numbers)| Due::new(travel, numbers));
        assert_eq!(due_p.cmp(&due_q), order, "{p:?} {q:?}");
        assert_eq!((due_p.travel_m().to_bits(), due_p.numbers()), (p.0.to_bits(), p.1));
    }
}
