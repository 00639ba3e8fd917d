//! A ranking as it is drawn: the scene over time, seen from above, and the bodies at each contact.

/// Two bodies at a contact of a [`PlanCourse`], and what is hit.
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// # let limits = trolley::Limits::default();
/// let mut scene = trolley::plan::PlanScene::default();
/// engine.rank_drawn(&scenario, &limits, &|_, _| {}, Some(&mut scene))?;
/// for at in scene.courses.iter().flat_map(|course| &course.scenes) {
///     println!("{} triangles of the ego are hit", at.hits[0].len());
/// }
/// # assert!(scene.courses.iter().any(|course| !course.scenes.is_empty()));
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use coordinator::ContactScene;
/// A contact of a [`PlanCourse`].
///
/// ```
/// let contact = trolley::plan::PlanContact { time_s: 1.5, ..Default::default() };
/// assert!(!contact.is_heavy);
/// ```
pub use coordinator::PlanContact;
/// A candidate of a [`PlanScene`] as it was followed.
///
/// ```
/// let course = trolley::plan::PlanCourse { name: "brake".into(), ..Default::default() };
/// assert!(course.contacts.is_empty());
/// ```
pub use coordinator::PlanCourse;
/// Where everybody goes in one member of a [`PlanScene`].
///
/// ```
/// let member = trolley::plan::PlanMember::default();
/// assert!(member.parties.is_empty() && member.courses.is_empty());
/// ```
pub use coordinator::PlanMember;
/// A candidate as it was followed in a [`PlanMember`].
///
/// ```
/// let course = trolley::plan::PlanMemberCourse::default();
/// assert!(course.ego.is_empty() && course.contacts.is_empty());
/// ```
pub use coordinator::PlanMemberCourse;
/// Where a [`PlanCourse`] comes nearest to a party that it does not meet.
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/crossing.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// # let limits = trolley::Limits::default();
/// let mut scene = trolley::plan::PlanScene::default();
/// engine.rank_drawn(&scenario, &limits, &|_, _| {}, Some(&mut scene))?;
/// for nearest in scene.courses.iter().filter_map(|course| course.nearest.as_ref()) {
///     println!("{:.2} m from {}", nearest.gap_m, scene.parties[nearest.party].name);
/// }
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use coordinator::PlanNearest;
/// A body of a [`PlanScene`], and where it may go.
///
/// ```
/// let party = trolley::plan::PlanParty { name: "bus".into(), ..Default::default() };
/// assert!(party.paths.is_empty());
/// ```
pub use coordinator::PlanParty;
/// A predicted path of a [`PlanParty`].
///
/// ```
/// let path = trolley::plan::PlanPath { probability: 0.3, track: Vec::new() };
/// assert!(path.probability < 1.0);
/// ```
pub use coordinator::PlanPath;
/// Where a body is at one time, of a [`PlanMember`].
///
/// ```
/// let [time_s, x_m, y_m] = trolley::plan::PlanPoint([0.5, 7.0, 0.0]).0;
/// assert_eq!((time_s, x_m, y_m), (0.5, 7.0, 0.0));
/// ```
pub use coordinator::PlanPoint;
/// A body at one time, of a [`PlanScene`].
///
/// ```
/// let [time_s, x_m, y_m, cos, sin] = trolley::plan::PlanSample([0.5, 7.0, 0.0, 1.0, 0.0]).0;
/// assert_eq!((time_s, x_m, y_m, cos, sin), (0.5, 7.0, 0.0, 1.0, 0.0));
/// ```
pub use coordinator::PlanSample;
/// A scene over time, seen from above: what a picture of a ranking is drawn from, and
/// what [`Engine::rank_drawn`](crate::Engine::rank_drawn) fills in. [`PlanParty`], [`PlanPath`],
/// [`PlanCourse`], [`PlanSample`], [`PlanContact`], [`PlanNearest`] and [`PlanMember`] are its
/// parts.
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/crossing.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// # let limits = trolley::Limits::default();
/// let mut scene = trolley::plan::PlanScene::default();
/// engine.rank_drawn(&scenario, &limits, &|_, _| {}, Some(&mut scene))?;
/// let at_start = |course: &trolley::plan::PlanCourse| course.ego[0].0[1..3] == [0.0, 0.0];
/// assert!(scene.courses.iter().all(at_start));
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use coordinator::PlanScene;
