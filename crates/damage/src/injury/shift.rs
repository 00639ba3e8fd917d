//! Curves with other odds, to see how much an outcome depends on them.

use super::{Curves, Victim};

impl Curves {
    /// These curves with the published odds of injury multiplied for some kinds of persons, at all
    /// levels and at both ends of the model range: each intercept rises by the logarithm of
    /// `times`. Who shares a curve with others and is not meant keeps it as it is.
    #[must_use]
    pub fn with_odds(&self, times: f64, is_meant: impl Fn(Victim) -> bool) -> Self {
        let mut shifted = self.clone();
        let mut curves = self.curves.to_vec();
        let mut copies: Vec<Option<usize>> = vec![None; self.curves.len()];
        for rung in shifted.rungs.iter_mut().filter(|rung| is_meant(rung.victim)) {
            let of_range = rung.low.curves.iter_mut().chain(&mut rung.high.curves);
            for number in of_range.chain([&mut rung.nominal]).chain(&mut rung.at_most) {
                let copy = copies[*number].unwrap_or_else(|| {
                    let mut curve = self.curves[*number].clone();
                    curve.a += libm::log(times);
                    curves.push(curve);
                    curves.len() - 1
                });
                copies[*number] = Some(copy);
                *number = copy;
            }
        }
        shifted.curves = curves.into();
        shifted
    }
}

#[cfg(test)]
mod tests {
    //! Odds change by the factor, of those meant alone.
    use super::*;
    use crate::injury::Speeds;

    #[test]
    fn odds_are_multiplied_for_those_meant_alone() {
        let curves = Curves::shipped().expect("sound");
        let is_meant = |victim: Victim| victim == Victim::Cyclist;
        let shifted = curves.with_odds(3.0, is_meant);
        let speeds = Speeds { delta_v: 6.0, normal: 8.0, closing: 9.0, front_m: 0.0 };
        for (before, after) in curves.rungs.iter().zip(&shifted.rungs) {
            let x = speeds.dose(before.x, 1.0);
            let odds = |p: f64| p / (1.0 - p);
            let [old, new] = [curves.nominal(before), shifted.nominal(after)]
                .map(|curve| odds(curve.published(x)));
            let times = if is_meant(before.victim) { 3.0 } else { 1.0 };
            assert!((new / old / times - 1.0).abs() < 1e-9, "{:?}: {old} {new}", before.victim);
            let [low, high] = [Curves::low, Curves::high]
                .map(|end| (end(&curves, before, &speeds), end(&shifted, after, &speeds)));
            let rises = |(old, new): (f64, f64)| if times > 1.0 { new > old } else { new == old };
            assert!(rises(low) && rises(high), "{:?}", before.victim);
        }
        assert_eq!(curves.with_odds(1.0, |_| false), curves);
    }
}
