//! Traces of ASAM OSI 3: messages `osi3.GroundTruth`, or `osi3.SensorView` with the ground truth
//! in it; one after the other, each behind its length (`.osi`), or in a container (`.mcap`).
//!
//! Read are the time, the host vehicle's id, and of moving and stationary objects the box, where it
//! is, how it moves and what it is (`osi_groundtruth.proto`, `osi_object.proto` and
//! `osi_common.proto` of ASAM OSI 3.8, whose numbers of fields do not change within 3). A box has
//! its origin in its middle.

mod kinds;
#[cfg(feature = "mcap")]
mod mcap;

use crate::ReadOptions;
use crate::error::{TrafficError, TrafficPlace};
use crate::outline::Placed;
use crate::recording::Recording;
use crate::trace::{Fault, Seen, Tracks, listed, whole};
use prost::Message;
use std::collections::BTreeMap;

/// Bytes of a message, at most. A map of many lanes in each message has some MB.
pub(crate) const MESSAGE_BYTES_MAX: usize = 16 << 20;
/// Objects of a message, at most.
const OBJECTS_MAX: usize = 20_000;

#[derive(Clone, Copy, PartialEq, Message)]
struct Identifier {
    #[prost(uint64, optional, tag = "1")]
    value: Option<u64>,
}

#[derive(Clone, Copy, PartialEq, Message)]
struct Timestamp {
    #[prost(int64, optional, tag = "1")]
    seconds: Option<i64>,
    #[prost(uint32, optional, tag = "2")]
    nanos: Option<u32>,
}

#[derive(Clone, Copy, PartialEq, Message)]
struct Vector {
    #[prost(double, optional, tag = "1")]
    x: Option<f64>,
    #[prost(double, optional, tag = "2")]
    y: Option<f64>,
    #[prost(double, optional, tag = "3")]
    z: Option<f64>,
}

#[derive(Clone, Copy, PartialEq, Message)]
struct Extent {
    #[prost(double, optional, tag = "1")]
    length: Option<f64>,
    #[prost(double, optional, tag = "2")]
    width: Option<f64>,
    #[prost(double, optional, tag = "3")]
    height: Option<f64>,
}

#[derive(Clone, Copy, PartialEq, Message)]
struct Orientation {
    #[prost(double, optional, tag = "3")]
    yaw: Option<f64>,
}

#[derive(Clone, Copy, PartialEq, Message)]
struct Base {
    #[prost(message, optional, tag = "1")]
    dimension: Option<Extent>,
    #[prost(message, optional, tag = "2")]
    position: Option<Vector>,
    #[prost(message, optional, tag = "3")]
    orientation: Option<Orientation>,
    #[prost(message, optional, tag = "4")]
    velocity: Option<Vector>,
}

#[derive(Clone, Copy, PartialEq, Message)]
struct Classification {
    #[prost(int32, optional, tag = "1")]
    kind: Option<i32>,
}

#[derive(Clone, Copy, PartialEq, Message)]
struct MovingObject {
    #[prost(message, optional, tag = "1")]
    id: Option<Identifier>,
    #[prost(message, optional, tag = "2")]
    base: Option<Base>,
    #[prost(int32, optional, tag = "3")]
    kind: Option<i32>,
    #[prost(message, optional, tag = "6")]
    vehicle: Option<Classification>,
}

/// `base` of a stationary object has no velocity: field 4 is its polygon.
#[derive(Clone, Copy, PartialEq, Message)]
struct StationaryBase {
    #[prost(message, optional, tag = "1")]
    dimension: Option<Extent>,
    #[prost(message, optional, tag = "2")]
    position: Option<Vector>,
    #[prost(message, optional, tag = "3")]
    orientation: Option<Orientation>,
}

#[derive(Clone, Copy, PartialEq, Message)]
struct StationaryObject {
    #[prost(message, optional, tag = "1")]
    id: Option<Identifier>,
    #[prost(message, optional, tag = "2")]
    base: Option<StationaryBase>,
    #[prost(message, optional, tag = "3")]
    classification: Option<Classification>,
}

/// Objects stay bytes until each is read, so that a message of many empty ones takes no more memory
/// than a few times its length.
#[derive(Clone, PartialEq, Message)]
struct GroundTruth {
    #[prost(message, optional, tag = "2")]
    timestamp: Option<Timestamp>,
    #[prost(message, optional, tag = "3")]
    host_vehicle_id: Option<Identifier>,
    #[prost(bytes = "vec", repeated, tag = "4")]
    stationary: Vec<Vec<u8>>,
    #[prost(bytes = "vec", repeated, tag = "5")]
    moving: Vec<Vec<u8>>,
}

#[derive(Clone, PartialEq, Message)]
struct SensorView {
    #[prost(message, optional, tag = "2")]
    timestamp: Option<Timestamp>,
    #[prost(message, optional, tag = "7")]
    truth: Option<GroundTruth>,
    #[prost(message, optional, tag = "8")]
    host_vehicle_id: Option<Identifier>,
}

/// Which message a trace consists of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    Truth,
    View,
}

/// Collects messages.
struct Reader<'f> {
    file: &'f str,
    /// `None` until the first message tells.
    form: Option<Form>,
    tracks: Tracks,
    /// Stationary objects of kinds that nobody hits, by kind: the most in a message.
    passed: BTreeMap<&'static str, usize>,
    host: Option<u64>,
    messages: u64,
}

/// Reads messages that each stand behind their length, four bytes, least first.
pub(crate) fn read(
    file: &str,
    bytes: &[u8],
    options: &ReadOptions<'_>,
) -> Result<Recording, TrafficError> {
    let mut reader = Reader::new(file);
    let mut rest = bytes;
    while !rest.is_empty() {
        let place = reader.next_place();
        let cut = |what: String| TrafficError {
            file: file.to_owned(),
            place,
            what,
            remedy: "the file is cut short, or no .osi trace; let the simulator close it"
                .to_owned(),
        };
        let Some((length, behind)) = rest.split_first_chunk::<4>() else {
            return Err(cut(format!("{} bytes are left, where its length has 4", rest.len())));
        };
        let length = u32::from_le_bytes(*length) as usize;
        if length > MESSAGE_BYTES_MAX {
            return Err(reader.fault(too_long(length)));
        }
        let Some((message, behind)) = behind.split_at_checked(length) else {
            return Err(cut(format!("{} of its {length} bytes are there", behind.len())));
        };
        reader.message(message)?;
        rest = behind;
    }
    reader.recording(options)
}

/// The same in a container.
#[cfg(feature = "mcap")]
pub(crate) fn read_mcap(
    file: &str,
    bytes: &[u8],
    options: &ReadOptions<'_>,
) -> Result<Recording, TrafficError> {
    mcap::read(file, bytes, options)
}

fn too_long(length: usize) -> Fault {
    (
        format!("it has {length} bytes"),
        format!(
            "at most {MESSAGE_BYTES_MAX} are read: is this the right file? Or write it without \
             lanes and sensor data"
        ),
    )
}

impl<'f> Reader<'f> {
    fn new(file: &'f str) -> Self {
        let (tracks, passed) = (Tracks::default(), BTreeMap::new());
        Self { file, form: None, tracks, passed, host: None, messages: 0 }
    }

    /// The message that comes next.
    fn next_place(&self) -> TrafficPlace {
        TrafficPlace::Message(self.messages + 1)
    }

    /// What is wrong with the message that comes next.
    fn fault(&self, (what, remedy): Fault) -> TrafficError {
        TrafficError { file: self.file.to_owned(), place: self.next_place(), what, remedy }
    }

    fn message(&mut self, bytes: &[u8]) -> Result<(), TrafficError> {
        self.take(bytes).map_err(|fault| self.fault(fault))?;
        self.messages += 1;
        Ok(())
    }

    fn take(&mut self, bytes: &[u8]) -> Result<(), Fault> {
        let form = match self.form {
            Some(form) => form,
            None => *self.form.insert(form_of(bytes)),
        };
        let (timestamp, host, truth) = match form {
            Form::Truth => {
                let mut truth = decoded::<GroundTruth>(bytes, "an osi3.GroundTruth")?;
                (truth.timestamp.take(), truth.host_vehicle_id.take(), truth)
            }
            Form::View => {
                let view = decoded::<SensorView>(bytes, "an osi3.SensorView")?;
                let Some(mut truth) = view.truth else {
                    let fault = "a SensorView without global_ground_truth".to_owned();
                    return Err((fault, "write the ground truth, too: only it is read".to_owned()));
                };
                let own = truth.timestamp.take();
                let host = view.host_vehicle_id.or(truth.host_vehicle_id.take());
                (view.timestamp.or(own), host, truth)
            }
        };
        let Some(Timestamp { seconds, nanos }) = timestamp else {
            let fault = "it has no timestamp".to_owned();
            return Err((fault, "the simulator must state one in each message".to_owned()));
        };
        let (seconds, nanos) = (seconds.unwrap_or(0), nanos.unwrap_or(0));
        if nanos >= 1_000_000_000 {
            let fault = format!("its timestamp has {nanos} ns, a second or more");
            return Err((fault, "seconds stand in a field of their own".to_owned()));
        }
        self.tracks.begin(seconds as f64 + f64::from(nanos) * 1e-9)?;
        if let Some(value) = host.map(|host| host.value.unwrap_or(0)) {
            let known = *self.host.get_or_insert(value);
            if known != value {
                let fault = format!("the host vehicle is {value}, before it was {known}");
                return Err((fault, "a scenario has one ego: split the trace".to_owned()));
            }
        }
        let objects = truth.moving.len() + truth.stationary.len();
        if objects > OBJECTS_MAX {
            let remedy = format!("at most {OBJECTS_MAX} are read: is this the right file?");
            return Err((format!("{objects} objects"), remedy));
        }
        for (index, bytes) in truth.moving.iter().enumerate() {
            let object: MovingObject =
                decoded(bytes, &format!("moving object {} of it", index + 1))?;
            let id = id_of(object.id.as_ref(), "moving", index)?;
            let base = object.base.unwrap_or_default();
            let vehicle = object.vehicle.and_then(|vehicle| vehicle.kind);
            let velocity = base
                .velocity
                .map(|velocity| [velocity.x.unwrap_or(0.0), velocity.y.unwrap_or(0.0)]);
            let placed = boxed(&id, base.dimension, base.position, base.orientation.as_ref())?;
            let (kind, is_guessed) = kinds::moving(object.kind, vehicle, placed.size_m);
            let velocity_m_s = velocity;
            self.tracks.add(&id, Seen { kind, is_guessed, velocity_m_s, ..placed })?;
        }
        let mut passed: BTreeMap<&'static str, usize> = BTreeMap::new();
        for (index, bytes) in truth.stationary.iter().enumerate() {
            let object: StationaryObject =
                decoded(bytes, &format!("stationary object {} of it", index + 1))?;
            let kind = object.classification.and_then(|classification| classification.kind);
            let kind = match kinds::stationary(kind) {
                Ok(kind) => kind,
                Err(name) => {
                    *passed.entry(name).or_default() += 1;
                    continue;
                }
            };
            let id = id_of(object.id.as_ref(), "stationary", index)?;
            let base = object.base.unwrap_or_default();
            let placed = boxed(&id, base.dimension, base.position, base.orientation.as_ref())?;
            self.tracks.add(&id, Seen { kind, is_fixed: true, ..placed })?;
        }
        for (name, count) in passed {
            let most = self.passed.entry(name).or_default();
            *most = count.max(*most);
        }
        Ok(())
    }

    fn recording(self, options: &ReadOptions<'_>) -> Result<Recording, TrafficError> {
        let Self { file, tracks, passed, host, messages, form } = self;
        if tracks.is_empty() {
            let remedy = "let the simulator write GroundTruth or SensorView".to_owned();
            return Err(whole(file, ("it has no message of OSI".to_owned(), remedy)));
        }
        let host = host.map(|host| host.to_string());
        let Some(ego) = options.ego.or(host.as_deref()) else {
            let fault = "no host_vehicle_id says which object is the ego".to_owned();
            let remedy = format!("name it: --ego ID; objects here: {}", tracks.known());
            return Err(whole(file, (fault, remedy)));
        };
        let name = match form {
            Some(Form::View) => "OSI SensorView",
            _ => "OSI GroundTruth",
        };
        let mut recording =
            tracks.recording(name, ego, options).map_err(|fault| whole(file, fault))?;
        let passed: Vec<String> =
            passed.into_iter().map(|(kind, count)| format!("{count} × {kind}")).collect();
        if !passed.is_empty() {
            recording.notes.push(format!(
                "left out, since nobody runs into them: {}",
                listed(passed.iter().map(String::as_str))
            ));
        }
        recording.notes.push(format!("{messages} messages; boxes of OSI leave mirrors out"));
        Ok(recording)
    }
}

fn decoded<M: Message + Default>(bytes: &[u8], what: &str) -> Result<M, Fault> {
    M::decode(bytes).map_err(|error| {
        let remedy = "the file is damaged, or no trace of OSI 3: is this the right file?";
        (format!("{what} cannot be read: {error}"), remedy.to_owned())
    })
}

/// A message that has a ground truth where a view has it, is a view: there a ground truth has
/// traffic lights, which have no moving objects in them.
fn form_of(bytes: &[u8]) -> Form {
    let view = SensorView::decode(bytes).ok().and_then(|view| view.truth);
    let has_objects = view.is_some_and(|truth| {
        truth.moving.iter().any(|bytes| {
            MovingObject::decode(&bytes[..]).is_ok_and(|object| {
                object.id.is_some() && object.base.is_some_and(|base| base.position.is_some())
            })
        })
    });
    if has_objects { Form::View } else { Form::Truth }
}

fn id_of(id: Option<&Identifier>, which: &str, index: usize) -> Result<String, Fault> {
    // Libraries of proto3 leave out what is 0.
    let id = id.map(|id| id.value.unwrap_or(0).to_string());
    id.ok_or_else(|| {
        let fault = format!("{which} object {} of it has no id", index + 1);
        (fault, "without ids nobody can be followed: the simulator must state them".to_owned())
    })
}

/// An object's box, at rest and of unknown kind.
fn boxed(
    id: &str,
    dimension: Option<Extent>,
    position: Option<Vector>,
    orientation: Option<&Orientation>,
) -> Result<Seen, Fault> {
    let need = |value: Option<f64>, name: &str| {
        value.ok_or_else(|| {
            let fault = format!("object {id:?}: base.{name} is missing");
            (fault, format!("the simulator must state it; or --without {id}"))
        })
    };
    // Libraries of proto3 leave out what is 0.
    let or_zero = |value: Option<f64>| Some(value.unwrap_or(0.0));
    let extent = dimension.unwrap_or_default();
    let length = need(extent.length, "dimension.length")?;
    let width = need(extent.width, "dimension.width")?;
    let height = need(extent.height, "dimension.height")?;
    let x = need(position.and_then(|at| or_zero(at.x)), "position")?;
    let y = need(position.and_then(|at| or_zero(at.y)), "position")?;
    let yaw = need(orientation.and_then(|o| or_zero(o.yaw)), "orientation")?;
    let z = position.and_then(|at| at.z);
    Ok(Seen {
        kind: "unknown",
        is_guessed: false,
        is_fixed: false,
        size_m: [length, width, height],
        place: Placed { at: [x, y], yaw },
        bottom_m: z.unwrap_or(0.5 * height) - 0.5 * height,
        velocity_m_s: None,
    })
}

#[cfg(test)]
mod tests;
