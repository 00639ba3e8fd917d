//! What an [`Explanation`](crate::Explanation) is made of.
//!
//! ```
//! # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
//! # let mut engine = trolley::Engine::builder().in_process().build()?;
//! # let limits = trolley::Limits::default().with_explanation();
//! # let explanation = engine.rank(&scenario, &limits)?.explanation;
//! # let Some(explanation) = explanation else { unreachable!() };
//! let best: &trolley::explanation::CourseChain = &explanation.chains[0];
//! for person in best.contacts.iter().flat_map(|contact| &contact.chain.persons) {
//!     println!("{}: risk {:.3} by curve {}", person.party, person.risk, person.curve);
//! }
//! # Ok::<(), trolley::Failure>(())
//! ```

/// The chain from speeds to risks in a [`ContactStep`].
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/crossing.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// # let limits = trolley::Limits::default().with_explanation();
/// # let explanation = engine.rank(&scenario, &limits)?.explanation;
/// # let Some(explanation) = explanation else { unreachable!() };
/// for contact in explanation.chains.iter().flat_map(|chain| &chain.contacts) {
///     println!("{}: {} m/s along the normal", contact.chain.other, contact.chain.normal_m_s);
///     assert!(contact.chain.normal_m_s >= 0.0, "they do not part");
/// }
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use coordinator::ContactChain;

/// One candidate in an [`Explanation`](crate::Explanation).
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/crossing.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// # let limits = trolley::Limits::default().with_explanation();
/// # let explanation = engine.rank(&scenario, &limits)?.explanation;
/// # let Some(explanation) = explanation else { unreachable!() };
/// let best = &explanation.chains[0];
/// println!("{} meets {} parties", best.name, best.contacts.len());
/// assert_eq!(best.steps.len(), explanation.steps.len());
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use coordinator::CourseChain;

/// One contact in a [`CourseChain`].
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/crossing.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// # let limits = trolley::Limits::default().with_explanation();
/// # let explanation = engine.rank(&scenario, &limits)?.explanation;
/// # let Some(explanation) = explanation else { unreachable!() };
/// for contact in explanation.chains.iter().flat_map(|chain| &chain.contacts) {
///     println!("after {} s: {}", contact.time_s, contact.chain.other);
///     assert!(contact.counts, "all is known");
/// }
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use coordinator::ContactStep;

/// The risk of one person in all contacts of a [`CourseChain`].
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/crossing.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// # let limits = trolley::Limits::default().with_explanation();
/// # let explanation = engine.rank(&scenario, &limits)?.explanation;
/// # let Some(explanation) = explanation else { unreachable!() };
/// for person in explanation.chains.iter().flat_map(|chain| &chain.persons) {
///     println!("{}: {:?} make {:.4}", person.party, person.contacts, person.risk.hi());
/// }
/// # assert!(explanation.chains.iter().any(|chain| !chain.persons.is_empty()));
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use coordinator::CombinedRisk;

/// The chain of one person in a [`ContactChain`].
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// # let limits = trolley::Limits::default().with_explanation();
/// # let explanation = engine.rank(&scenario, &limits)?.explanation;
/// # let Some(explanation) = explanation else { unreachable!() };
/// let contacts = explanation.chains.iter().flat_map(|chain| &chain.contacts);
/// for person in contacts.flat_map(|contact| &contact.chain.persons) {
///     println!("{}: {:.1} m/s gives risk {:.3}", person.party, person.x_m_s, person.risk);
///     assert!((0.0..=1.0).contains(&person.risk));
/// }
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use coordinator::PersonChain;

/// A step of the policy in a [`CourseChain`].
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// # let limits = trolley::Limits::default().with_explanation();
/// # let explanation = engine.rank(&scenario, &limits)?.explanation;
/// # let Some(explanation) = explanation else { unreachable!() };
/// for step in &explanation.chains[0].steps {
///     println!("{}: {:.4}", step.step, step.value.lo());
/// }
/// assert_eq!(explanation.chains[0].steps.len(), explanation.steps.len());
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use coordinator::PolicyStep;

/// What separates a candidate from the next one, in a [`CourseChain`].
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// # let limits = trolley::Limits::default().with_explanation();
/// # let explanation = engine.rank(&scenario, &limits)?.explanation;
/// # let Some(explanation) = explanation else { unreachable!() };
/// for chain in &explanation.chains {
///     if let Some(person) = &chain.separates {
///         println!("{}: {:.3}, then {:.3}", person.party, person.here, person.there);
///     }
/// }
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use coordinator::Separation;

/// The number that a [`Reserve`] is about.
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// # let limits = trolley::Limits::default().with_explanation();
/// # let explanation = engine.rank(&scenario, &limits)?.explanation;
/// # let Some(explanation) = explanation else { unreachable!() };
/// use trolley::explanation::Knob;
///
/// let reserves = &explanation.stability.reserves;
/// assert!(reserves.iter().any(|reserve| matches!(reserve.knob, Knob::Slope { .. })));
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use damage::Knob;

/// A margin of the winner, in [`Stability`].
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// # let limits = trolley::Limits::default().with_explanation();
/// # let explanation = engine.rank(&scenario, &limits)?.explanation;
/// # let Some(explanation) = explanation else { unreachable!() };
/// for margin in &explanation.stability.margins {
///     let next = margin.next.map(|(_, figure)| figure);
///     println!("step {}: {:.4}, the next has {next:?}", margin.step, margin.winner);
///     assert!(next.is_none_or(|next| margin.winner <= next));
/// }
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use damage::Margin;

/// How far a number may move, in [`Stability`].
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// # let limits = trolley::Limits::default().with_explanation();
/// # let explanation = engine.rank(&scenario, &limits)?.explanation;
/// # let Some(explanation) = explanation else { unreachable!() };
/// for reserve in &explanation.stability.reserves {
///     if let (Some(value), Some(winner)) = (reserve.flips_at, reserve.winner) {
///         println!("{:?} at {value} makes {} win", reserve.knob, explanation.names[winner]);
///     }
/// }
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use damage::Reserve;

/// How firmly the winner of an [`Explanation`](crate::Explanation) stands.
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// # let limits = trolley::Limits::default().with_explanation();
/// # let explanation = engine.rank(&scenario, &limits)?.explanation;
/// # let Some(explanation) = explanation else { unreachable!() };
/// let stability = &explanation.stability;
/// let flips = stability.reserves.iter().filter(|reserve| reserve.flips_at.is_some());
/// let winner = stability.winner.map_or("nobody", |winner| &explanation.names[winner]);
/// println!("{winner} wins, unless one of {} numbers changes", flips.count());
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use damage::Stability;

/// The unit of the curve of a [`PersonChain`].
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// # let limits = trolley::Limits::default().with_explanation();
/// # let explanation = engine.rank(&scenario, &limits)?.explanation;
/// # let Some(explanation) = explanation else { unreachable!() };
/// use trolley::explanation::CurveUnit;
///
/// let contacts = explanation.chains.iter().flat_map(|chain| &chain.contacts);
/// for person in contacts.flat_map(|contact| &contact.chain.persons) {
///     assert!(person.unit != CurveUnit::MetresPerSecond || person.x_in_unit == person.x_m_s);
/// }
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use damage::curve::CurveUnit;

/// A curve in use, with its source.
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// # let limits = trolley::Limits::default().with_explanation();
/// # let explanation = engine.rank(&scenario, &limits)?.explanation;
/// # let Some(explanation) = explanation else { unreachable!() };
/// for curve in &explanation.curves {
///     println!("{}: {} ({})", curve.id, curve.source, curve.year);
/// }
/// # assert!(!explanation.curves.is_empty());
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use damage::curve::Curve;

/// The parameters of contact and dynamics.
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// # let limits = trolley::Limits::default().with_explanation();
/// # let explanation = engine.rank(&scenario, &limits)?.explanation;
/// # let Some(explanation) = explanation else { unreachable!() };
/// let restitution = &explanation.parameters.restitution;
/// assert!(restitution.low <= restitution.nominal && restitution.nominal <= restitution.high);
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use damage::Parameters;

/// What makes the plane of a contact.
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// # let limits = trolley::Limits::default().with_explanation();
/// # let explanation = engine.rank(&scenario, &limits)?.explanation;
/// # let Some(explanation) = explanation else { unreachable!() };
/// use trolley::explanation::PlaneOrigin;
///
/// for contact in explanation.chains.iter().flat_map(|chain| &chain.contacts) {
///     let exchanges = contact.chain.origin == Some(PlaneOrigin::Chord);
///     assert!(exchanges || contact.chain.response.delta_v_m_s[0] >= 0.0);
/// }
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use damage::plane::PlaneOrigin;

/// How a party is met in height.
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// # let limits = trolley::Limits::default().with_explanation();
/// # let explanation = engine.rank(&scenario, &limits)?.explanation;
/// # let Some(explanation) = explanation else { unreachable!() };
/// use trolley::explanation::Ride;
///
/// let mut contacts = explanation.chains.iter().flat_map(|chain| &chain.contacts);
/// let is_under = contacts.any(|contact| contact.chain.rides.contains(&Ride::Under));
/// println!("underride: {is_under}");
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use damage::plane::Ride;
