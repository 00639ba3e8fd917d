//! A study of two small scenes, planned in a folder of its own.

use crate::support::{Place, trolley};
use columns::{ReadColumn, read};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::os::unix::fs::MetadataExt as _;
use std::path::PathBuf;
use study::{Plan, run_shard, status};

/// Two inputs, 3 speeds, 3 offsets and 2 errors: 36 scenes in 8 shards, 72 answers.
pub(crate) const SPEC: &str = r#"
schema = "trolley.study/1"
name = "Test"
policies = ["default", "worst-off-first"]
scenes_per_shard = 5

[[scenarios]]
files = ["*.scenario"]

[sweep]
speed = { from = 0.8, to = 1.2, count = 3 }
offset_m = { values = [-0.5, 0, 0.5] }
error_sigma = { values = [0, 1] }
"#;

pub(crate) const POLE: &str = r#"
schema = "trolley.scenario/2"
name = "Pole or pedestrian"
horizon_s = 3

[parties]
ego = { generate = { shape = "sedan", triangles = 600 } }

[parties.pole]
generate = { shape = "pole", triangles = 600 }
place = { position_m = [12, -1.5, 0] }

[parties.pedestrian]
generate = { shape = "pedestrian", triangles = 600 }
state = { position_m = [12, -1, 0], yaw_deg = 90, speed_m_s = 1 }

[[candidates]]
name = "straight on"
state = { position_m = [0, 0, 0], speed_m_s = 9 }

[[candidates]]
name = "swerve"
path = { states = [
  { t_s = 0, position_m = [0, 0, 0] },
  { t_s = 1, position_m = [9, -1.2, 0], yaw_deg = -7 },
  { t_s = 2, position_m = [18, -2.4, 0], yaw_deg = -7 },
] }
"#;

/// A folder with a specification and its scenarios, and a study planned in it.
pub(crate) struct Planned {
    pub(crate) place: Place,
    pub(crate) dir: PathBuf,
}

impl Planned {
    pub(crate) fn new(spec: &str, scenarios: &[(&str, &str)]) -> Self {
        let place = Place::new();
        for (name, text) in scenarios {
            place.write(name, text);
        }
        let spec = place.write("spec.toml", spec);
        let dir = place.path().join("study");
        study::plan(&spec, &dir).unwrap();
        Self { place, dir }
    }

    pub(crate) fn usual() -> Self {
        let faster = POLE.replace("speed_m_s = 9", "speed_m_s = 11");
        Self::new(SPEC, &[("a.scenario", POLE), ("b.scenario", &faster)])
    }

    /// All shards, one after the other, in this process.
    pub(crate) fn run_here(&self) -> String {
        for shard in 0..Plan::open(&self.dir).unwrap().shards() {
            run_shard(&self.dir, shard).unwrap();
        }
        self.rows()
    }

    /// The hash of all rows of a finished study.
    pub(crate) fn rows(&self) -> String {
        status(&self.dir).unwrap().rows_hash.expect("every shard is finished")
    }

    pub(crate) fn command(&self, args: &[&str]) -> std::process::Output {
        let mut command = trolley();
        command.arg("study").arg(args[0]).arg(&self.dir).args(&args[1..]);
        command.output().unwrap()
    }

    pub(crate) fn shard(&self, shard: u32) -> PathBuf {
        self.dir.join("shards").join(format!("{shard:06}"))
    }

    pub(crate) fn column(&self, shard: u32, name: &str) -> ReadColumn {
        let file = File::open(self.shard(shard).join("answers.parquet")).unwrap();
        let [column] = read(file, [name]).unwrap();
        column
    }

    /// Every file of every shard: who wrote a file anew gave it another inode.
    pub(crate) fn files(&self) -> BTreeMap<PathBuf, (u64, Vec<u8>)> {
        let shards =
            fs::read_dir(self.dir.join("shards")).unwrap().map(|entry| entry.unwrap().path());
        let files = shards.flat_map(|shard| fs::read_dir(shard).unwrap());
        files
            .map(|file| file.unwrap().path())
            .map(|path| (path.clone(), (path.metadata().unwrap().ino(), fs::read(&path).unwrap())))
            .collect()
    }
}
