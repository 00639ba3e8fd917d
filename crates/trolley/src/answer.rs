//! An answer: candidates in their places, their contacts, and what members and worlds say.

/// The answer of a [`Ranking`](crate::Ranking).
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// let answer = engine.rank(&scenario, &trolley::Limits::default())?.answer;
/// assert_eq!(answer.best(), answer.ranking.first());
/// assert!(answer.missing.is_empty(), "all work is done");
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use coordinator::Answer;
/// One contact of a candidate.
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/crossing.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// # let ranking = engine.rank(&scenario, &trolley::Limits::default())?;
/// let contacts = ranking.answer.ranking.iter().flat_map(|row| &row.contacts);
/// let first = |contact: &trolley::ContactRow| contact.time_s;
/// println!("the first of all after {} s", contacts.map(first).fold(f64::INFINITY, f64::min));
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use coordinator::ContactRow;
/// One candidate of an [`Answer`] in its place.
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/crossing.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// # let ranking = engine.rank(&scenario, &trolley::Limits::default())?;
/// let free = |row: &&trolley::CourseRow| row.touches_nobody();
/// println!("{} touch nobody", ranking.answer.ranking.iter().filter(free).count());
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use coordinator::CourseRow;
/// What members say of a [`CourseRow`]: how probable contact is, with whom, and how harm is spread.
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// let limits = trolley::Limits::default().with_members(4, Some(4))?;
/// let answer = engine.rank(&scenario, &limits)?.answer;
/// for expected in answer.ranking.iter().filter_map(|row| row.expected.as_ref()) {
///     println!("contact in {} % of the members", 100.0 * expected.contact);
///     assert!((0.0..=1.0).contains(&expected.contact));
/// }
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use coordinator::ExpectedRow;
/// What would have another candidate win, in a [`WorldsRow`].
///
/// ```
/// let flip = trolley::FlipRow { doubt: trolley::Doubt::Masses, lost: 0.1 };
/// println!("{} alone: lost in {} % of the worlds", flip.doubt.name(), 100.0 * flip.lost);
/// ```
pub use coordinator::FlipRow;
/// A candidate in one member of an [`ExpectedRow`].
///
/// ```
/// let member = trolley::MemberRow { harm: 0.1, first: None };
/// assert!(member.first.is_none(), "it meets nobody");
/// ```
pub use coordinator::MemberRow;
/// The members of an [`Answer`].
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// let limits = trolley::Limits::default().with_members(4, Some(8))?;
/// let answer = engine.rank(&scenario, &limits)?.answer;
/// let members = answer.members.expect("they were drawn");
/// println!("{} members, {} draws replaced", members.count, members.replaced);
/// assert!(members.count == 8 || members.lead.is_some_and(|lead| !lead.is_close()));
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use coordinator::MembersRow;
/// A party of an [`ExpectedRow`] that is met in some members.
///
/// ```
/// let met = trolley::MetRow { party: "pole".into(), probability: 0.25, from_s: 1.5 };
/// assert!(met.probability > 0.0);
/// ```
pub use coordinator::MetRow;
/// The worlds of an [`Answer`]: draws of what the model does not know, the same for all candidates.
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// let limits = trolley::Limits::default().with_members(2, Some(2))?;
/// let answer = engine.rank(&scenario, &limits)?.answer;
/// assert!(answer.worlds.is_some_and(|worlds| worlds.count == 200));
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use coordinator::WorldsRow;
/// How a contact changes the ego's motion.
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/crossing.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// # let ranking = engine.rank(&scenario, &trolley::Limits::default())?;
/// for contact in ranking.answer.ranking.iter().flat_map(|row| &row.contacts) {
///     match contact.severity {
///         trolley::Severity::Light => println!("drives on past {}", contact.party),
///         trolley::Severity::Heavy => println!("crashes into {}", contact.party),
///     }
/// }
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use damage::Severity;
/// How the leading measure of a candidate is spread over members.
///
/// ```
/// let spread = trolley::Spread { best: 0.9, ..Default::default() };
/// assert!(spread.best > 0.5 && spread.regret == 0.0);
/// ```
pub use damage::expected::Spread;
/// What the model does not know, as a [`FlipRow`] names it.
///
/// ```
/// assert_eq!(trolley::Doubt::Friction.name(), "friction");
/// ```
pub use damage::world::Doubt;
