//! Paths on their way to workers: the bits of their states, in memory that the workers read.
//!
//! A path comes back to the bit, so a look at it in a worker is that in any other process. Memory
//! may be written again while a worker still reads for a request that is over: the sum over what a
//! look needs tells.

use geometry::hash::splitmix64;
use geometry::motion::{MotionPath, STATE_WORDS, State};

/// Appends the states of a path.
pub fn write(path: &MotionPath, words: &mut Vec<u64>) {
    words.extend(path.states().iter().flat_map(State::to_bits));
}

/// The path of these words; `None` if they are none.
#[must_use]
pub fn read(words: &[u64]) -> Option<MotionPath> {
    let (states, []) = words.as_chunks::<STATE_WORDS>() else { return None };
    let states: Vec<State> = states.iter().copied().map(State::from_bits).collect();
    MotionPath::new(&states).ok()
}

/// A sum over words, which shows whether any of them changed.
#[must_use]
pub fn sum(words: &[u64]) -> u64 {
    words.iter().fold(words.len() as u64, |sum, word| splitmix64(sum ^ word))
}

#[cfg(test)]
mod tests {
    //! A path comes back as it was; other words are refused.
    use super::*;
    use geometry::motion::Orientation;

    #[test]
    fn a_path_comes_back_to_the_bit() {
        let state = |time_s: f64| State {
            time_s,
            position_m: [time_s.sin() * 3.0, -0.0, 1.0 / 3.0],
            orientation: Orientation::from_degrees(31.0 * time_s, 0.1, 7.0),
        };
        let path = MotionPath::new(&[state(0.0), state(0.3), state(1.7)]).unwrap();
        let mut words = vec![7];
        write(&path, &mut words);
        let back = read(&words[1..]).unwrap();
        assert_eq!(back, path);
        let bits = |path: &MotionPath, time_s: f64| {
            let pose = path.pose_at(time_s);
            let numbers = pose.rotation.into_iter().flatten().chain(pose.translation);
            numbers.map(f64::to_bits).collect::<Vec<_>>()
        };
        for step in 0..100 {
            let time_s = 0.017 * f64::from(step);
            assert_eq!(bits(&back, time_s), bits(&path, time_s));
        }
        assert_eq!(read(&words), None, "no whole number of states");
        assert_eq!(read(&words[1..1 + STATE_WORDS]), None, "one state is no path");
        let mut wrong = words[1..].to_vec();
        wrong[0] = f64::NAN.to_bits();
        assert_eq!(read(&wrong), None);
        assert_ne!(sum(&wrong), sum(&words[1..]));
    }
}
