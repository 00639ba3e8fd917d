//! Known answers of SplitMix64, and what a sum of terms can and cannot distinguish.

use super::*;

#[test]
fn is_the_published_generator() {
    // The first outputs of `splitmix64.c` for seed 1234567; its state moves by a fixed increment.
    let state = |steps: u64| 1_234_567_u64.wrapping_add(steps.wrapping_mul(0x9E37_79B9_7F4A_7C15));
    let known: [u64; 5] = [
        6_457_827_717_110_365_317,
        3_203_168_211_198_807_973,
        9_817_491_932_198_370_423,
        4_593_380_528_125_082_431,
        16_408_922_859_458_223_821,
    ];
    for (steps, output) in (0..).zip(known) {
        assert_eq!(splitmix64(state(steps)), output);
    }
}

#[test]
fn a_pair_is_not_its_mirror_image() {
    assert_ne!(pair_term(1, 2), pair_term(2, 1));
    assert_eq!(pair_term(1, 2), splitmix64(0x0000_0001_0000_0002));
}
