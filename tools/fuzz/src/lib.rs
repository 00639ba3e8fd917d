//! What is fuzzed: every parser of files and every decoder of messages, each as a function of
//! bytes.
//!
//! `cargo x fuzz` runs them with libFuzzer on stable Rust; the tests here run each over its corpus
//! and over mutated copies of it, as regression tests.

use body::file::Aligned;
use damage::{Criteria, Policy};
use mesh::import::{Format, ImportOptions, LengthUnit};
use protocol::public::{Ask, WireAnswer};
use protocol::{Boot, Head, Incarnation, Launch, chunk, job, result};
use std::sync::OnceLock;

/// A parser or decoder: it refuses or accepts, and returns.
pub type Target = fn(&[u8]);

/// All targets by name.
pub const TARGETS: &[(&str, Target)] = &[
    ("obj", |bytes| mesh(Format::Obj, bytes)),
    ("stl", |bytes| mesh(Format::Stl, bytes)),
    ("ply", |bytes| mesh(Format::Ply, bytes)),
    ("gltf", |bytes| mesh(Format::Gltf, bytes)),
    ("collada", |bytes| mesh(Format::Collada, bytes)),
    ("lsdyna", |bytes| mesh(Format::LsDyna, bytes)),
    ("traffic", |bytes| text(bytes, traffic)),
    ("trace", traces),
    ("settings", |bytes| text(bytes, settings)),
    ("model-file", model_file),
    ("record", record_files),
    ("wire", wire),
    ("ask", ask),
];

/// All whole words.
fn words_of(bytes: &[u8]) -> Vec<u64> {
    let mut words = vec![0; bytes.len() / 8];
    let room: &mut [u8] = bytemuck::cast_slice_mut(&mut words);
    room.copy_from_slice(&bytes[..room.len()]);
    words
}

fn text(bytes: &[u8], parse: impl FnOnce(&str)) {
    if let Ok(text) = core::str::from_utf8(bytes) {
        parse(text);
    }
}

/// A reader of others may panic, which the child process in which it runs turns into a message; so
/// only what it then does to memory and time is looked at here.
fn mesh(format: Format, bytes: &[u8]) {
    let unit = (format == Format::LsDyna).then_some(LengthUnit::METRE);
    let file = "fuzz".to_owned();
    let options = ImportOptions { file, unit, any_size: true, ..Default::default() };
    let mut nothing = |name: &str| Err(format!("{name}: no side files here"));
    let read = || drop(mesh::import::read(format, bytes, &mut nothing, &options));
    drop(std::panic::catch_unwind(core::panic::AssertUnwindSafe(read)));
}

/// A record, the head of a chain, and keys.
fn record_files(bytes: &[u8]) {
    drop(record::file::decode(bytes));
    drop(record::SignedStatement::parse(bytes));
    text(bytes, |text| {
        drop(record::SigningKey::from_pem(text));
        let _refused = record::VerifyingKey::from_pem(text);
    });
}

/// Whatever a person writes down, as everything that it could be.
fn settings(text: &str) {
    drop(scenario::Scenario::parse("fuzz", text));
    drop(damage::Policy::parse("fuzz", text));
    drop(damage::Curves::parse("fuzz", text));
    drop(traffic::Library::parse("fuzz", text));
    drop(service::Deployment::parse("fuzz", text));
}

/// Read, driven through, and written as a scenario, which is one then.
fn traffic(text: &str) {
    if let Ok(recording) = traffic::read("fuzz", text, &traffic::ReadOptions::default()) {
        driven(&recording);
    }
}

/// A trace of a simulator, in every form, with an ego that the file names.
fn traces(bytes: &[u8]) {
    use traffic::TraceForm;
    for form in [TraceForm::Osi, TraceForm::Mcap, TraceForm::Csv] {
        let read = traffic::read_trace("fuzz", bytes, form, &traffic::ReadOptions::default());
        if let Ok(recording) = read {
            driven(&recording);
        }
    }
}

fn driven(recording: &traffic::Recording) {
    let manoeuvres = traffic::Manoeuvres::default();
    let library = LIBRARY.get_or_init(|| {
        traffic::Library::parse("default", traffic::DEFAULT_LIBRARY).expect("it is shipped")
    });
    if let Ok((text, _)) = traffic::scenario_text("fuzz", recording, &manoeuvres, library) {
        scenario::ScenarioDraft::parse("fuzz", &text).expect("a scenario is written");
    }
}

static LIBRARY: OnceLock<traffic::Library> = OnceLock::new();

fn model_file(bytes: &[u8]) {
    let aligned = Aligned::copy_of(bytes);
    drop(body::file::view(aligned.bytes()));
    drop(body::file::quick_view(aligned.bytes()));
    drop(body::store::open(aligned.bytes()));
}

/// A header, then words: accepted or not, read as everything that it could be.
fn wire(bytes: &[u8]) {
    let (front, rest) = bytes.split_at(bytes.len().min(size_of::<Head>()));
    let words: Vec<u64> = words_of(rest);
    if let Ok(head) = bytemuck::try_pod_read_unaligned::<Head>(front) {
        let peer = Incarnation { worker: head.worker, inc: head.inc };
        let accepted = head.accept(Boot(head.boot), peer, words.len());
        let sealed = protocol::verify(&head, &words);
        // Whatever is said to be sound is sealed again to the same checksum.
        if let (Ok(_), Ok(())) = (accepted, sealed) {
            assert_eq!(protocol::seal(head, &words), head);
        }
        for hits in [head.hits, 0, u32::MAX] {
            let _last = result::read_last(&words, hits);
            let _hits = result::read_hits(&words, hits);
        }
    }
    let all: Vec<u64> = words_of(bytes);
    if let Some((tasks, jobs)) = job::read_batch(&all) {
        assert!(jobs.iter().all(|job| (job.task as usize) < tasks.len()));
    }
    let mut left = &all[..];
    while let Some((_, rest)) = chunk::read_piece(left) {
        assert!(rest.len() < left.len(), "it does not terminate");
        left = rest;
    }
    text(bytes, |text| drop(Launch::from_word(text)));
}

/// What a service has at hand: one small body under two numbers.
struct House {
    deployment: service::Deployment,
    store: Aligned,
    criteria: Criteria,
}

static HOUSE: OnceLock<House> = OnceLock::new();

impl House {
    fn new() -> Self {
        let text = "schema = \"trolley.deployment/1\"\ninstance = \"house\"\n\
            [[models]]\nid = 1\nname = \"a\"\nmodel = \"a\"\n\
            [[models]]\nid = 2\nname = \"b\"\nmodel = \"b\"\n";
        let body: &[u8] = include_bytes!("../corpus/model-file/box.bin");
        let files = [body, body];
        let mut store = vec![0; body::store::length(&files)];
        body::store::fill(&mut store, &files);
        let policy = include_str!("../config/policies/default.toml");
        Self {
            deployment: service::Deployment::parse("house", text).expect("it is sound"),
            store: Aligned::copy_of(&store),
            criteria: Criteria::with_policy(
                Policy::parse("policy", policy).expect("it is shipped"),
            )
            .expect("they are shipped"),
        }
    }
}

/// A planner's request against a service with two small bodies: answered or refused.
fn ask(bytes: &[u8]) {
    let (asked, answer) = answered(bytes);
    assert_eq!(answer.sequence, asked.sequence);
}

fn answered(bytes: &[u8]) -> (Box<Ask>, WireAnswer) {
    let mut asked: Box<Ask> = bytemuck::allocation::zeroed_box();
    let room = bytemuck::bytes_of_mut(&mut *asked);
    let length = bytes.len().min(room.len());
    room[..length].copy_from_slice(&bytes[..length]);
    let house = HOUSE.get_or_init(House::new);
    let bodies = body::store::open(house.store.bytes()).expect("it was made here");
    let criteria = house.criteria.clone();
    let answer = service::InProcess::new(&house.deployment, &bodies, criteria, 2).answer(&asked);
    (asked, answer)
}

#[cfg(test)]
mod tests {
    //! Runs every target on its corpus and on many mutated copies of it.
    use super::*;
    use std::path::Path;

    fn splitmix64(mut z: u64) -> u64 {
        z = z.wrapping_add(0x9e37_79b9_7f4a_7c15);
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// Bent copies of what is refused anyway would try little.
    #[test]
    fn the_request_of_the_corpus_is_ranked() {
        let (_, answer) = answered(include_bytes!("../corpus/ask/three.bin"));
        assert_eq!(answer.place_count, 3, "{}", answer.text());
    }

    /// Changes, drops, repeats or inserts a few bytes.
    fn bend(bytes: &[u8], seed: u64) -> Vec<u8> {
        let mut bent = bytes.to_vec();
        for step in 0..1 + splitmix64(seed) % 4 {
            let dice = splitmix64(seed ^ splitmix64(step + 1));
            let at = (dice >> 8) as usize % (bent.len() + 1);
            match dice % 5 {
                0 => bent.truncate(at),
                1 => bent.insert(at, (dice >> 40) as u8),
                2 if at < bent.len() => drop(bent.remove(at)),
                3 => {
                    let piece: Vec<u8> = bent[at..].iter().copied().take(16).collect();
                    bent.splice(at..at, piece);
                }
                _ if at < bent.len() => bent[at] ^= 1 << (dice >> 40 & 7),
                _ => {}
            }
        }
        bent
    }

    #[test]
    fn every_corpus_and_bent_copies_of_it_are_refused_or_accepted() {
        for (name, target) in TARGETS {
            let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(name);
            let mut seeds = 0;
            for entry in std::fs::read_dir(&folder).into_iter().flatten() {
                let bytes = std::fs::read(entry.unwrap().path()).unwrap();
                target(&bytes);
                for seed in 0..200 {
                    target(&bend(&bytes, seed));
                }
                seeds += 1;
            }
            assert!(seeds > 0, "{name} has no corpus");
        }
    }

    /// Every mesh below a folder, with the format that its name says.
    fn meshes(folder: &Path, into: &mut Vec<(Format, Vec<u8>)>) {
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                meshes(&path, into);
            } else {
                let bytes = std::fs::read(&path).unwrap();
                into.extend(
                    Format::detect(&path.to_string_lossy(), &bytes).ok().map(|f| (f, bytes)),
                );
            }
        }
    }

    #[test]
    #[ignore = "minutes: cargo test -r -p trolley-fuzz -- --ignored, under ulimit -v 2097152"]
    fn a_hundred_thousand_bent_copies_of_real_bodies_are_refused_or_accepted() {
        let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/models");
        let mut all = Vec::new();
        meshes(&data, &mut all);
        // Small ones oftener than large ones: the bytes are shared out evenly among the files.
        let share = |bytes: &[u8]| 1.0 / (bytes.len() as f64 + 20_000.0);
        let shares: f64 = all.iter().map(|(_, bytes)| share(bytes)).sum();
        let mut bent = 0_u64;
        for (format, bytes) in &all {
            let copies = (100_000.0 * share(bytes) / shares).ceil() as u64;
            for seed in 0..copies {
                mesh(*format, &bend(bytes, splitmix64(bent + seed)));
            }
            bent += copies;
        }
        println!("{bent} bent copies of {} files", all.len());
        assert!(all.is_empty() || bent >= 100_000);
    }
}
