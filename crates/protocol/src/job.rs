//! The work sent to a worker: a batch of jobs, with the tasks they belong to.
//!
//! A *task* is one question about one pose of one pair of bodies; a *job* is one pair
//! of nodes of it. A batch carries every task that its jobs name, so a worker keeps no state
//! between batches, and a new incarnation needs no history.
//!
//! ```text
//! words: [tasks | jobs << 32] [Task; tasks] [Job; jobs]
//! ```

use bytemuck::{Pod, Zeroable};

/// What to compute for a pair of bodies at one pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u32)]
pub enum WireQuestion {
    /// Is there any hit? The first one ends the job.
    Touches = 1,
    /// Which triangles are hit?
    Sets = 2,
    /// All intersecting pairs: count, hash, and supports of the contact.
    Pairs = 3,
    /// When do bodies on their ways first touch? The task is a [`WireLook`], and has one job.
    Look = 4,
}

impl WireQuestion {
    /// The question with this number.
    #[must_use]
    pub fn from_number(number: u32) -> Option<Self> {
        let all = [Self::Touches, Self::Sets, Self::Pairs, Self::Look];
        all.into_iter().find(|question| *question as u32 == number)
    }
}

/// A task in wire format: 160 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct WireTask {
    /// Number of body A in the model store.
    pub model_a: u32,
    /// Number of body B.
    pub model_b: u32,
    /// A [`WireQuestion`].
    pub question: u32,
    /// Number of the task within the request.
    pub task: u32,
    /// R of x_A = R x_B + t, row-major.
    pub rotation: [[f64; 3]; 3],
    /// t (m).
    pub translation: [f64; 3],
    /// Unit vector of the relative velocity, A's frame.
    pub u: [f64; 3],
    /// Unit vector upwards, A's frame.
    pub z: [f64; 3],
}

/// A task about bodies on their ways, in wire format: 160 bytes, as any task.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct WireLook {
    /// Number of body A in the model store.
    pub model_a: u32,
    /// Number of body B.
    pub model_b: u32,
    /// [`WireQuestion::Look`].
    pub question: u32,
    /// Number of the task within the request.
    pub task: u32,
    /// For each body, where its path begins in the memory of paths, and its length (words).
    pub paths: [[u32; 2]; 2],
    /// The sum over the words of A's path, then of B's.
    pub sums: [u64; 2],
    /// From when on (s).
    pub from_s: f64,
    /// Until when (s).
    pub end_s: f64,
    /// Contact that cannot be decided within this distance (m) counts.
    pub resolution_m: f64,
    /// 1: they have touched before, and may do so still.
    pub may_touch: u64,
    /// 0.
    pub reserved: [u64; 10],
}

impl WireLook {
    /// As a task.
    #[must_use]
    pub fn task(&self) -> WireTask {
        bytemuck::cast(*self)
    }

    /// A task as this, if it is one.
    #[must_use]
    pub fn of(task: &WireTask) -> Option<Self> {
        (task.question == WireQuestion::Look as u32).then(|| bytemuck::cast(*task))
    }
}

/// A job in wire format: 32 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct WireJob {
    /// Slot in the request's job table.
    pub job: u32,
    /// Index of its task within this batch.
    pub task: u32,
    /// Node of body A's tree.
    pub node_a: u32,
    /// Node of body B's tree.
    pub node_b: u32,
    /// Maximum number of box and triangle tests.
    pub budget: u64,
    /// Attempt, from 0.
    pub attempt: u32,
    /// 0.
    pub reserved: u32,
}

const TASK_WORDS: usize = size_of::<WireTask>() / 8;
const JOB_WORDS: usize = size_of::<WireJob>() / 8;
const _: () = assert!(size_of::<WireTask>() == 160 && size_of::<WireJob>() == 32);
const _: () = assert!(size_of::<WireLook>() == size_of::<WireTask>());

/// The number of words of a batch of this many tasks and jobs.
#[must_use]
pub const fn batch_words(tasks: usize, jobs: usize) -> usize {
    1 + tasks * TASK_WORDS + jobs * JOB_WORDS
}

/// Writes a batch to `words`, which is cleared first.
pub fn write_batch(words: &mut Vec<u64>, tasks: &[WireTask], jobs: &[WireJob]) {
    words.clear();
    words.push(tasks.len() as u64 | (jobs.len() as u64) << 32);
    words.extend_from_slice(bytemuck::cast_slice(tasks));
    words.extend_from_slice(bytemuck::cast_slice(jobs));
}

/// Reads a batch; `None` if the counts do not match the words, or a job names a task that is not in
/// the batch.
#[must_use]
pub fn read_batch(words: &[u64]) -> Option<(&[WireTask], &[WireJob])> {
    let (counts, rest) = words.split_first()?;
    let (tasks, jobs) = ((counts & 0xffff_ffff) as usize, (counts >> 32) as usize);
    let split = tasks.checked_mul(TASK_WORDS)?;
    if rest.len() != split.checked_add(jobs.checked_mul(JOB_WORDS)?)? {
        return None;
    }
    let (head, tail) = rest.split_at(split);
    let batch: (&[WireTask], &[WireJob]) =
        (bytemuck::try_cast_slice(head).ok()?, bytemuck::try_cast_slice(tail).ok()?);
    batch.1.iter().all(|job| (job.task as usize) < tasks).then_some(batch)
}

#[cfg(test)]
mod tests;
