//! An explanation in words: the chain from contact to rank, to be checked with a pocket calculator.

use crate::text::wrap;
use trolley::explanation::{
    ContactChain, Curve, CurveUnit, Knob, Parameters, PersonChain, PlaneOrigin, PolicyStep,
    Reserve, Ride, Separation,
};
use trolley::{Explanation, Severity};

/// What the figures are made with; the same for all candidates.
const FORMULAS: &str = "\
Formulas: arms n along the normal and t to its left, from the centre of mass to the contact;
  K_nn = Σ(1 + t²/k²)/m, K_tt = Σ(1 + n²/k²)/m, K_nt = -Σ n t/(m k²), a fixed body adding 0;
  sticking: D = K_nn K_tt - K_nt², J_n = ((1+e) v_n K_tt - K_nt v_t) / D,
            J_t = (K_nn v_t - K_nt (1+e) v_n) / D;
  sliding, where |J_t| > μ J_n: J_n = (1+e) v_n / (K_nn ± μ K_nt), J_t = ± μ J_n, + for v_t > 0;
  along a long flat face: J_n = (1+e) v_n / Σ1/m, J_t = ± min(μ J_n, |v_t| / Σ1/m);
  |J| at most (1+e) |v| / Σ1/m; ΔV = √(J_n² + J_t²) / m;
  P(x) = 1/(1 + exp(-z)), z = a + b x + tall front, H = (P(x) - P(0)) / (1 - P(0)), risk R = p H.";

/// The whole explanation, in lines of `columns` characters at most: see [`wrap`].
#[must_use]
pub fn text(explanation: &Explanation, columns: usize) -> String {
    let mut lines = Vec::new();
    beginning(
        &mut lines,
        (&explanation.policy, &explanation.board, explanation.outcome),
        (&explanation.steps, explanation.persons, &explanation.parameters),
    );
    lines.push(format!(
        "A contact is heavy if the ego's ΔV is {} m/s or more: then it runs out, braked with {:.2} \
         m/s². A person's risk in several contacts is 1 - Π(1 - R).",
        explanation.heavy_from_m_s, explanation.run_out_m_s2
    ));
    if explanation.members > 0 {
        lines.push(format!(
            "Risks that are compared are means over {} members; contacts are those of the scene as \
             stated.",
            explanation.members
        ));
    }
    for (at, chain) in explanation.chains.iter().enumerate() {
        lines.push(String::new());
        lines.push(format!("{} {}", at + 1, chain.name));
        if chain.contacts.is_empty() && chain.open_from_s.is_none() && explanation.members == 0 {
            lines.push("  contact   none: everybody's risk is 0".to_owned());
        }
        for step in &chain.contacts {
            let kind = match step.severity {
                Severity::Light => "light",
                Severity::Heavy => "heavy",
            };
            let counts = if step.counts { "" } else { "; not in its harm: it may become heavy" };
            let other = &step.chain.other;
            lines.push(format!("  after {:.3} s: {other}, {kind}{counts}", step.time_s));
            contact(&mut lines, &step.chain);
            everybody(&mut lines, &step.chain);
        }
        lines.extend(chain.open_from_s.map(|from_s| {
            format!("  open      from {from_s:.3} s on: everybody may be harmed until R is 1")
        }));
        for person in chain.persons.iter().filter(|person| person.contacts.len() > 1) {
            let seat = person.seat.map_or(String::new(), |seat| format!(" {seat}"));
            let risks: Vec<String> =
                person.contacts.iter().map(|(_, risk)| format!("{risk:.5}")).collect();
            lines.push(format!(
                "  together  {}{seat}: {} make {:.5}",
                person.party,
                risks.join(" and "),
                person.risk.hi()
            ));
        }
        for person in chain.persons.iter().filter(|_| explanation.members > 0) {
            let seat = person.seat.map_or(String::new(), |seat| format!(" {seat}"));
            lines.push(format!("  mean      {}{seat}: R {:.5}", person.party, person.risk.hi()));
        }
        policy(&mut lines, (&chain.steps, chain.why.as_deref(), chain.separates.as_ref()));
    }
    sources(&mut lines, &explanation.curves);
    lines.push(String::new());
    stability(&mut lines, explanation);
    let lines = lines.iter().flat_map(|line| line.split('\n')).map(|line| wrap(line, columns));
    lines.collect::<Vec<_>>().join("\n")
}

/// What is compared, and with what it was computed.
fn beginning(
    lines: &mut Vec<String>,
    (policy, board, outcome): (&str, &str, &str),
    (steps, persons, parameters): (&[String], usize, &Parameters),
) {
    lines.extend([
        format!(
            "How the order came about: policy \"{}\" (board: {}), outcome {}, {} persons at stake.",
            policy, board, outcome, persons
        ),
        format!("Compared in turn: {}.", steps.join("; then ")),
        FORMULAS.to_owned(),
        format!(
            "Parameters \"{}\": e {} in {}–{}, μ {} in {}–{}; masses known to {} %, gyration to \
             {} %, speeds to {} %, normals to {}°.",
            parameters.name,
            parameters.restitution.nominal,
            parameters.restitution.low,
            parameters.restitution.high,
            parameters.friction.nominal,
            parameters.friction.low,
            parameters.friction.high,
            100.0 * parameters.mass_share,
            100.0 * parameters.gyration_share,
            100.0 * parameters.speed_share,
            parameters.normal_degrees
        ),
    ]);
}

/// Curves in use.
fn sources(lines: &mut Vec<String>, curves: &[Curve]) {
    lines.push(String::new());
    lines.push("Curves and their sources".to_owned());
    for curve in curves {
        let unit = curve.unit.name();
        let note = if curve.note.is_empty() { "" } else { "; " };
        lines.push(format!(
            "  {}: {}, a {}, b {} per {unit}, used up to {} {unit}: {} ({}); {}{note}{}",
            curve.id,
            curve.outcome.name(),
            curve.a,
            curve.b,
            curve.valid[1],
            curve.source,
            curve.year,
            curve.sample,
            curve.note
        ));
    }
}

/// A figure, or "–" for a body that is fixed to the ground.
fn pair(of: [f64; 2], masses: [Option<f64>; 2], decimals: usize) -> String {
    let figure = |i: usize| match masses[i] {
        Some(_) => format!("{:.decimals$}", of[i]),
        None => "–".to_owned(),
    };
    format!("{} / {}", figure(0), figure(1))
}

/// Everybody in a contact who may be harmed.
fn everybody(lines: &mut Vec<String>, chain: &ContactChain) {
    let mut left: Vec<&PersonChain> =
        chain.persons.iter().filter(|person| person.range.high() > 0.0).collect();
    while let Some(&first) = left.first() {
        // Who sits in one vehicle and fares alike stands on one line.
        let alike = |p: &&PersonChain| PersonChain { seat: first.seat, ..(**p).clone() } == *first;
        let (same, others): (Vec<_>, Vec<_>) = left.into_iter().partition(alike);
        persons(lines, &same, chain.probability);
        left = others;
    }
}

/// What the policy makes of a candidate, and why it comes before the next.
fn policy(
    lines: &mut Vec<String>,
    (steps, why, separates): (&[PolicyStep], Option<&str>, Option<&Separation>),
) {
    let steps = steps.iter().map(|step| {
        let value = step.value.hi();
        if step.step.ends_with("property damage") {
            format!("{} {:.1} kJ", step.step, value / 1000.0)
        } else {
            format!("{} {value:.5}", step.step)
        }
    });
    lines.push(format!("  policy    {}", steps.collect::<Vec<_>>().join("; ")));
    lines.extend(why.iter().map(|why| format!("  therefore {why}")));
    if let Some(who) = separates {
        let seat = who.seat.map_or(String::new(), |seat| format!(" {seat}"));
        lines.push(format!(
            "            the greatest difference is {}{seat}: {:.5} here, {:.5} there",
            who.party, who.here, who.there
        ));
    }
}

fn contact(lines: &mut Vec<String>, chain: &ContactChain) {
    let m = chain.mass_kg;
    let plane = match chain.origin {
        Some(PlaneOrigin::Chord) | None => "plane by outlines",
        Some(PlaneOrigin::Graze) => "outlines only graze: no impulse",
        Some(PlaneOrigin::WeakPart) => "only a weak part is hit: no impulse",
        Some(PlaneOrigin::Motion) => "plane across the motion",
    };
    let name_of = |p: usize| if p == 0 { "ego" } else { chain.other.as_str() };
    let face =
        chain.long_face_of.map_or(String::new(), |p| format!("; long face of {}", name_of(p)));
    let rides = [0, 1].into_iter().filter_map(|p| match chain.rides[p] {
        Ride::Level => None,
        Ride::Under => Some(format!("; {} goes under", name_of(p))),
        Ride::Over => Some(format!("; {} goes over", name_of(p))),
    });
    lines.push(format!(
        "  contact   {plane}{face}{}; closing at {:.3} m/s, normal {:.0}° from it: v_n {:.3}, v_t \
         {:.3} m/s",
        rides.collect::<String>(),
        chain.closing_m_s,
        chain.normal_degrees.unwrap_or(0.0),
        chain.normal_m_s,
        chain.tangential_m_s
    ));
    let pairs: Vec<String> =
        chain.poses.iter().map(|(travel, pairs)| format!("{pairs} at {travel:.3} m")).collect();
    let [width, span, height, depth] = chain.patch_m;
    lines.push(format!(
        "  triangles {} pairs: patch {width:.3} m across the normal, {span:.3} along it, \
         {height:.3} high; depth {depth:.3} m",
        pairs.join(", ")
    ));
    let [a, b] = chain.arms_m;
    lines.push(format!(
        "  bodies    m {} kg, k {} m, n {} m, t {} m (ego / {}); e {:.3}, μ {:.3}",
        pair(m.map(|m| m.unwrap_or(0.0)), m, 1),
        pair(chain.gyration_m, m, 3),
        pair([a[0], b[0]], m, 3),
        pair([a[1], b[1]], m, 3),
        chain.other,
        chain.surface[0],
        chain.surface[1]
    ));
    lines.push(format!(
        "  impact    J_n {:.1}, J_t {:.1} N s; ΔV {} m/s; yaw {} to {} °/s; {:.1} kJ lost; force \
         from {}°",
        chain.response.normal_n_s,
        chain.response.tangential_n_s,
        pair(chain.response.delta_v_m_s, m, 3),
        pair(chain.yaw_rad_s.map(|yaw| yaw[0].to_degrees()), m, 0),
        pair(chain.yaw_rad_s.map(|yaw| yaw[1].to_degrees()), m, 0),
        chain.response.energy_j / 1000.0,
        pair(chain.force_degrees, m, 0)
    ));
}

/// Persons of one party who fare alike.
fn persons(lines: &mut Vec<String>, alike: &[&PersonChain], probability: f64) {
    let Some(person) = alike.first() else { return };
    let seats: Vec<&str> = alike.iter().filter_map(|person| person.seat).collect();
    let seats = if seats.is_empty() { String::new() } else { format!(" {}", seats.join(" and ")) };
    lines.push(format!("  person    {}{seats}, as {}", person.party, person.victim));
    let x = match person.unit {
        CurveUnit::MetresPerSecond => format!("{:.3} m/s", person.x_m_s),
        unit => format!("{:.3} m/s = {:.3} {}", person.x_m_s, person.x_in_unit, unit.name()),
    };
    let given = if probability < 1.0 { format!("p {probability}, ") } else { String::new() };
    lines.push(format!(
        "            {} {x}; curve {}: P {:.5}, P(0) {:.5}, H {:.5}; {given}R {:.5}",
        person.x.name(),
        person.curve,
        person.published,
        person.at_rest,
        person.harm.hi(),
        person.risk
    ));
    if person.front_m > 0.0 {
        lines.push(format!(
            "            struck by a front whose edge is {:.2} m high",
            person.front_m
        ));
    }
    if !person.note.is_empty() {
        lines.push(format!("            note on the curve: {}", person.note));
    }
    lines.push(format!(
        "            range {:.5} to {:.5}: {}; {}",
        person.range.low(),
        person.range.high(),
        person.ends[0],
        person.ends[1]
    ));
}

fn stability(lines: &mut Vec<String>, explanation: &Explanation) {
    let stability = &explanation.stability;
    let name = |number: usize| explanation.names[number].as_str();
    lines.push(match stability.winner {
        Some(winner) => format!("What would flip the winner, \"{}\"", name(winner)),
        None => "What would let a candidate win: the policy lets none be chosen".to_owned(),
    });
    for margin in &stability.margins {
        let step = explanation.steps.get(margin.step).map_or("", String::as_str);
        let next = match margin.next {
            Some((who, value)) => format!("next is \"{}\" with {value:.5}", name(who)),
            None => "nobody else is left".to_owned(),
        };
        lines.push(format!("  {step}: {:.5}; {next}", margin.winner));
    }
    for reserve in &stability.reserves {
        let Some(at) = reserve.flips_at else { continue };
        let who = match reserve.winner {
            Some(who) => format!("\"{}\" wins", name(who)),
            None => "nobody wins".to_owned(),
        };
        lines.push(format!(
            "  {} is {}; from {} on ({}), {who}",
            knob(&reserve.knob),
            short(reserve.value),
            short(at),
            moved(reserve, at)
        ));
    }
    let firm = stability.reserves.iter().filter(|reserve| reserve.flips_at.is_none());
    let firm: Vec<String> = firm.map(|reserve| knob(&reserve.knob)).collect();
    if !firm.is_empty() {
        lines.push(format!("  nothing within the range of: {}", firm.join(", ")));
    }
}

fn knob(knob: &Knob) -> String {
    match knob {
        Knob::Weight { rule } => format!("weight of {}", rule.name()),
        Knob::Tolerance { level: Some(level) } => format!("tolerance of level {}", level + 1),
        Knob::Tolerance { level: None } => "tolerance".to_owned(),
        Knob::Accept { level } => format!("accepted risk of level {}", level + 1),
        Knob::Intercept { curve } => format!("intercept a of {curve}"),
        Knob::Slope { curve } => format!("slope b of {curve}"),
    }
}

/// How far a value moved, in the unit of its kind.
fn moved(reserve: &Reserve, at: f64) -> String {
    match &reserve.knob {
        Knob::Intercept { .. } => format!("odds × {}", short((at - reserve.value).exp())),
        Knob::Slope { .. } => format!("× {}", short(at / reserve.value)),
        _ => format!("{:+.5}", at - reserve.value),
    }
}

/// At most five decimals, without trailing zeros.
fn short(value: f64) -> String {
    let text = format!("{value:.5}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}
