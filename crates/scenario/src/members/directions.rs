//! In which directions, of all that is drawn, contacts change most.
//!
//! Thirty-two points of a sequence are spread far better in its first coordinates than in its
//! later ones, and in each coordinate better than in a sum of several. Whether two cars meet where
//! their ways cross depends on such a sum: both offsets and both speeds together say who is first.
//! So the first coordinates are laid along the directions in which contacts change most, found from
//! gradients at the scene as stated: the gradient principal components of Y. Xiao and X. Wang,
//! *Enhancing Quasi-Monte Carlo Simulation by Minimizing Effective Dimension for Derivative
//! Pricing*, Computational Economics 54, 2019. A rotation of independent normal variables gives
//! independent normal variables, so what is drawn has the distribution that is stated, whatever the
//! directions are.
//!
//! Two gradients are taken per candidate and motion of another party, at their nearest approach:
//! that of the distance by which they miss, weighted by how undecided it is whether they meet, and
//! that of the speed at which they close, weighted by how likely they meet.

use super::{EGO_NORMALS, Errors, OF_OTHER_NORMALS};
use crate::scenario::{Motion, Scenario};
use geometry::DVec2;

#[cfg(test)]
mod tests;

/// Most directions that are laid along coordinates.
const MOST: usize = 8;
/// Steps of the power iteration per direction. An inexact direction is as sound, a little worse.
const STEPS: usize = 12;
/// Directions that explain less than this share of the first are left out.
const LEAST_SHARE: f64 = 1e-3;
/// Times at which the distance of two bodies is looked at.
const TIMES: usize = 64;
/// Centres that miss each other by less are taken to meet (m): two cars side by side, or crossing.
const REACH_M: f64 = 2.5;
/// How much more harm there is per m/s of closing speed, roughly, where bodies surely meet.
const HARM_PER_M_S: f64 = 0.15;

/// An orthogonal transformation of the normal variables of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Directions {
    /// Householder vectors, each with 2 over its square; the last is applied first.
    reflections: Vec<(Vec<f64>, f64)>,
}

/// Where a motion is at one time.
#[derive(Clone, Copy)]
struct Place {
    position_m: DVec2,
    /// The body's x axis.
    forward: DVec2,
}

/// A motion at [`TIMES`] times.
struct Sampled<'s> {
    errors: &'s Errors,
    probability: f64,
    /// The number of the party among the others; `None`: the ego.
    other: Option<usize>,
    places: Vec<Place>,
}

/// The gradient of a quantity, in standard deviations of what is drawn, times the root of its
/// weight.
struct Gradient {
    /// By the ego's lateral offset, speed, longitudinal offset.
    ego: [f64; 3],
    /// Another party, by its number among those.
    other: usize,
    /// By its speed, lateral offset, longitudinal offset.
    of_other: [f64; 3],
}

impl Directions {
    /// The directions of a scene, most important first.
    pub(super) fn new(scenario: &Scenario) -> Self {
        let gradients = gradients(scenario);
        let count = EGO_NORMALS + OF_OTHER_NORMALS * (scenario.parties.len() - 1);
        let mut found: Vec<Vec<f64>> = Vec::new();
        let mut first = 0.0;
        while found.len() < MOST.min(count) {
            let Some((direction, strength)) = next_direction(&gradients, &found, count) else {
                break;
            };
            if found.is_empty() {
                first = strength;
            } else if strength < LEAST_SHARE * first {
                break;
            }
            found.push(direction);
        }
        let mut directions = Self::default();
        for (axis, direction) in found.iter().enumerate() {
            directions.add(axis, direction);
        }
        directions
    }

    /// Lays coordinate `axis` along a unit vector that is orthogonal to those before.
    fn add(&mut self, axis: usize, direction: &[f64]) {
        let mut turned = direction.to_vec();
        // Reflections are their own inverses: from outside inwards, as they were added.
        for (normal, scale) in &self.reflections {
            reflect(&mut turned, normal, *scale);
        }
        let mut normal = turned;
        for value in &mut normal {
            *value = -*value;
        }
        normal[axis] += 1.0;
        let square: f64 = normal.iter().map(|value| value * value).sum();
        if square > 1e-12 {
            self.reflections.push((normal, 2.0 / square));
        }
    }

    /// From coordinates along the directions to the normal variables of the scene.
    pub(super) fn apply(&self, normals: &mut [f64]) {
        for (normal, scale) in self.reflections.iter().rev() {
            reflect(normals, normal, *scale);
        }
    }
}

fn reflect(vector: &mut [f64], normal: &[f64], scale: f64) {
    let along: f64 = vector.iter().zip(normal).map(|(x, n)| x * n).sum();
    for (x, n) in vector.iter_mut().zip(normal) {
        *x -= scale * along * n;
    }
}

impl Gradient {
    fn dot(&self, vector: &[f64]) -> f64 {
        let first = EGO_NORMALS + OF_OTHER_NORMALS * self.other;
        let ego: f64 = self.ego.iter().zip(vector).map(|(g, x)| g * x).sum();
        let other: f64 = self.of_other.iter().zip(&vector[first..]).map(|(g, x)| g * x).sum();
        ego + other
    }

    fn add_to(&self, vector: &mut [f64], times: f64) {
        let first = EGO_NORMALS + OF_OTHER_NORMALS * self.other;
        for (x, g) in vector.iter_mut().zip(self.ego) {
            *x += times * g;
        }
        for (x, g) in vector[first..].iter_mut().zip(self.of_other) {
            *x += times * g;
        }
    }

    fn square(&self) -> f64 {
        self.ego.iter().chain(&self.of_other).map(|g| g * g).sum()
    }
}

/// The unit vector orthogonal to those found along which the gradients vary most, and how much.
fn next_direction(
    gradients: &[Gradient],
    found: &[Vec<f64>],
    count: usize,
) -> Option<(Vec<f64>, f64)> {
    let rest = |gradient: &Gradient| {
        let along = found.iter().map(|direction| gradient.dot(direction));
        gradient.square() - along.map(|x| x * x).sum::<f64>()
    };
    let strongest = gradients.iter().max_by(|a, b| rest(a).total_cmp(&rest(b)))?;
    let mut vector = vec![0.0; count];
    strongest.add_to(&mut vector, 1.0);
    unit(&mut vector, found)?;
    let mut strength = 0.0;
    for _ in 0..STEPS {
        let mut next = vec![0.0; count];
        for gradient in gradients {
            gradient.add_to(&mut next, gradient.dot(&vector));
        }
        strength = unit(&mut next, found)?;
        vector = next;
    }
    Some((vector, strength))
}

/// Makes a vector orthogonal to those found, and of length 1; `None`: nothing of it is left.
fn unit(vector: &mut [f64], found: &[Vec<f64>]) -> Option<f64> {
    let before = libm::sqrt(vector.iter().map(|x| x * x).sum());
    // Twice: once loses digits where little is left.
    for direction in found.iter().chain(found) {
        let along: f64 = vector.iter().zip(direction).map(|(x, d)| x * d).sum();
        for (x, d) in vector.iter_mut().zip(direction) {
            *x -= along * d;
        }
    }
    let length = libm::sqrt(vector.iter().map(|x| x * x).sum());
    if !(length > 1e-9 * before && length.is_normal()) {
        return None;
    }
    for x in vector {
        *x /= length;
    }
    Some(length)
}

fn gradients(scenario: &Scenario) -> Vec<Gradient> {
    let step_s = scenario.horizon_s / TIMES as f64;
    let sampled = |motion: &Motion, party: usize, probability: f64| Sampled {
        errors: &scenario.parties[party].errors,
        probability,
        other: (party != scenario.ego.0).then(|| party - usize::from(party > scenario.ego.0)),
        places: (0..=TIMES).map(|time| place(motion, time as f64 * step_s)).collect(),
    };
    let predicted: Vec<(usize, Sampled<'_>)> = scenario
        .parties
        .iter()
        .enumerate()
        .flat_map(|(party, stated)| stated.predictions.iter().map(move |of| (party, of)))
        .map(|(party, of)| (party, sampled(&of.motion, party, of.probability)))
        .collect();
    let mut gradients = Vec::new();
    for candidate in &scenario.candidates {
        let ego = sampled(&candidate.ego, scenario.ego.0, 1.0);
        for reaction in &candidate.reactions {
            let other = sampled(&reaction.motion, reaction.party.0, 1.0);
            approach(&ego, &other, step_s, &mut gradients);
        }
        let reacts = |party: usize| candidate.reactions.iter().any(|of| of.party.0 == party);
        for (_, other) in predicted.iter().filter(|(party, _)| !reacts(*party)) {
            approach(&ego, other, step_s, &mut gradients);
        }
    }
    gradients
}

fn place(motion: &Motion, time_s: f64) -> Place {
    let state = motion.path.state_at(time_s);
    let [x, y, _] = state.position_m;
    let rotation = state.orientation.rotation();
    let forward = DVec2::new(rotation[0][0], rotation[1][0]);
    Place { position_m: DVec2::new(x, y), forward }
}

/// Adds the gradients of two motions, at their nearest approach.
fn approach(ego: &Sampled<'_>, other: &Sampled<'_>, step_s: f64, gradients: &mut Vec<Gradient>) {
    let Some(number) = other.other else { return };
    let between = |time: usize| ego.places[time].position_m - other.places[time].position_m;
    let nearest = (0..=TIMES)
        .min_by(|a, b| between(*a).length_squared().total_cmp(&between(*b).length_squared()));
    let time = nearest.unwrap_or(0);
    let (before, after) = (time.saturating_sub(1), (time + 1).min(TIMES));
    let lasts_s = (after - before) as f64 * step_s;
    let [v_ego, v_other] = [ego, other]
        .map(|of| (of.places[after].position_m - of.places[before].position_m) / lasts_s);
    let closing = v_ego - v_other;
    let speed = closing.length();
    let late_s = if speed > 0.0 {
        (-between(time).dot(closing) / (speed * speed)).clamp(-step_s, step_s)
    } else {
        0.0
    };
    let apart = between(time) + closing * late_s;
    let time_s = (time as f64 * step_s + late_s).max(0.0);
    // Where two pass each other, they miss across their relative motion; where one comes to rest
    // before the other, along the line between them.
    let (across, along) = if speed > 0.5 {
        (closing.perp() / speed, closing / speed)
    } else if apart.length() > 0.0 {
        (apart / apart.length(), DVec2::ZERO)
    } else {
        return;
    };
    // What a standard deviation of lateral offset, speed and longitudinal offset moves.
    let moves = |of: &Sampled<'_>, velocity: DVec2| {
        let errors = of.errors;
        let forward = of.places[time].forward;
        let own = (1.0 - errors.correlation * errors.correlation).max(0.0).sqrt();
        let ahead = forward * errors.longitudinal_m;
        [
            forward.perp() * errors.lateral_m + ahead * errors.correlation,
            velocity * (errors.speed_share * time_s),
            ahead * own,
        ]
    };
    let [of_ego, [lateral, faster, ahead]] = [moves(ego, v_ego), moves(other, v_other)];
    let of_other = [faster, lateral, ahead];
    let missing = |weight: f64| Gradient {
        ego: of_ego.map(|of| of.dot(across) * weight),
        other: number,
        of_other: of_other.map(|of| -of.dot(across) * weight),
    };
    let deviation = libm::sqrt(missing(1.0).square());
    if !(deviation > 1e-6) {
        return;
    }
    let off = apart.dot(across).abs();
    let below = |x: f64| 0.5 * libm::erfc(-x * core::f64::consts::FRAC_1_SQRT_2);
    let meets = below((REACH_M - off) / deviation) - below((-REACH_M - off) / deviation);
    let share = other.probability * meets;
    if !(share > 1e-6) {
        return;
    }
    let energy = 1.0 + speed;
    let undecided = libm::sqrt(other.probability * (meets * (1.0 - meets) + 0.1 * meets));
    gradients.push(missing(energy * undecided / deviation));
    let faster = energy * libm::sqrt(share) * HARM_PER_M_S;
    let speeds = [(ego, v_ego), (other, v_other)]
        .map(|(of, velocity)| of.errors.speed_share * velocity.dot(along) * faster);
    gradients.push(Gradient {
        ego: [0.0, speeds[0], 0.0],
        other: number,
        of_other: [-speeds[1], 0.0, 0.0],
    });
}
