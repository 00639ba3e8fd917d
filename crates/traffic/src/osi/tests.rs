//! What is written is read: places, speeds, kinds, the ego. What cannot be used is refused with the
//! number of its message; no bytes make the reader panic.

use super::*;
use proptest::prelude::*;

fn vector(x: f64, y: f64) -> Vector {
    Vector { x: Some(x), y: Some(y), z: Some(0.75) }
}

fn object(id: u64, x: f64) -> MovingObject {
    MovingObject {
        id: Some(Identifier { value: Some(id) }),
        base: Some(Base {
            dimension: Some(Extent { length: Some(4.5), width: Some(1.8), height: Some(1.5) }),
            position: Some(vector(x, 2.0)),
            orientation: Some(Orientation { yaw: Some(0.0) }),
            velocity: Some(vector(10.0, 0.0)),
        }),
        kind: Some(2),
        vehicle: Some(Classification { kind: Some(4) }),
    }
}

/// One moment of the ego, 7, and of 8 in front of it.
fn truth(time_s: f64) -> GroundTruth {
    let seconds = time_s.floor();
    GroundTruth {
        timestamp: Some(Timestamp {
            seconds: Some(seconds as i64),
            nanos: Some(((time_s - seconds) * 1e9).round() as u32),
        }),
        host_vehicle_id: Some(Identifier { value: Some(7) }),
        stationary: Vec::new(),
        moving: [object(7, 10.0 * time_s), object(8, 10.0 * time_s + 20.0)]
            .iter()
            .map(Message::encode_to_vec)
            .collect(),
    }
}

fn framed(messages: &[Vec<u8>]) -> Vec<u8> {
    let framed = |bytes: &Vec<u8>| [&(bytes.len() as u32).to_le_bytes()[..], bytes].concat();
    messages.iter().flat_map(framed).collect()
}

fn trace(truths: &[GroundTruth]) -> Vec<u8> {
    framed(&truths.iter().map(Message::encode_to_vec).collect::<Vec<_>>())
}

fn refused(bytes: &[u8]) -> String {
    read("t.osi", bytes, &ReadOptions::default()).expect_err("refused").to_string()
}

/// The same moments with one of them changed.
fn changed(index: usize, change: impl FnOnce(&mut GroundTruth)) -> String {
    let mut truths = [0.0, 0.1, 0.2].map(truth);
    change(&mut truths[index]);
    refused(&trace(&truths))
}

fn with_object(change: impl FnOnce(&mut MovingObject)) -> String {
    changed(1, |truth| {
        let mut other = object(8, 21.0);
        change(&mut other);
        truth.moving[1] = other.encode_to_vec();
    })
}

#[test]
fn a_trace_is_read_with_its_ego_from_either_message() {
    let truths = [5.0, 5.1, 5.25].map(truth);
    let views: Vec<Vec<u8>> = truths
        .iter()
        .map(|truth| {
            let view = SensorView {
                timestamp: truth.timestamp,
                truth: Some(GroundTruth { host_vehicle_id: None, ..truth.clone() }),
                host_vehicle_id: truth.host_vehicle_id,
            };
            view.encode_to_vec()
        })
        .collect();
    for bytes in [trace(&truths), framed(&views)] {
        let recording = read("t.osi", &bytes, &ReadOptions::default()).expect("valid");
        let went: Vec<f64> = recording.ego.went.iter().map(|state| state.time_s).collect();
        for (found, right) in went.iter().zip([0.0, 0.1, 0.25]) {
            assert!((found - right).abs() < 1e-9, "{went:?}");
        }
        assert_eq!(recording.ego.start.speed_m_s, 10.0);
        let [other] = &recording.others[..] else { panic!("{:?}", recording.others) };
        assert_eq!((other.id.as_str(), other.kind.as_str()), ("8", "car"));
        assert!((other.track[2].place.at[0] - 72.5).abs() < 1e-9, "{other:?}");
        assert_eq!(other.outline.size(), [4.5, 1.8]);
        assert_eq!(recording.notes.len(), 1, "{:?}", recording.notes);
    }
    let asked = ReadOptions { ego: Some("8"), ..ReadOptions::default() };
    let recording = read("t.osi", &trace(&truths), &asked).expect("valid");
    assert_eq!(recording.others[0].id, "7");
    let without = ["8".to_owned()];
    let asked = ReadOptions { without: &without, ..ReadOptions::default() };
    assert_eq!(read("t.osi", &trace(&truths), &asked).expect("valid").others, []);
}

#[test]
fn who_goes_backwards_or_sideways_is_read_so() {
    let mut truths = [0.0, 0.1].map(truth);
    for truth in &mut truths {
        let mut other = object(8, 20.0);
        other.base.as_mut().expect("a base").velocity = Some(vector(-3.0, 0.3));
        truth.moving[1] = other.encode_to_vec();
    }
    let recording = read("t.osi", &trace(&truths), &ReadOptions::default()).expect("valid");
    let state = recording.others[0].track[0];
    assert!(state.speed_m_s < -3.0 && state.slip < 0.0, "{state:?}");
    let [x, y] = state.velocity_m_s();
    assert!((x + 3.0).abs() < 1e-9 && (y - 0.3).abs() < 1e-9, "{x} {y}");
}

#[test]
fn what_is_not_stated_is_found_or_noted() {
    let mut truths = [0.0, 0.1, 0.2].map(truth);
    for (index, truth) in truths.iter_mut().enumerate() {
        let mut other = object(8, 20.0 + index as f64);
        other.base.as_mut().expect("a base").velocity = None;
        other.vehicle = None;
        truth.moving[1] = other.encode_to_vec();
        // Its velocity says 10 m/s, its places 30.
        truth.moving.push(object(9, 60.0 + 3.0 * index as f64).encode_to_vec());
    }
    truths[1].moving.remove(2);
    let recording = read("t.osi", &trace(&truths), &ReadOptions::default()).expect("valid");
    assert!((recording.others[0].track[1].speed_m_s - 10.0).abs() < 1e-6, "{recording:?}");
    let notes = recording.notes.join("; ");
    for note in [
        "object 8: velocities are not stated",
        "8 a car (4.5 × 1.8 × 1.5 m)",
        "object 9 is missing in 1 moments",
        "object 9: its velocity does not fit its places, first after 0.20 s",
    ] {
        assert!(notes.contains(note), "{note}: {notes}");
    }
}

#[test]
fn what_stands_is_a_body_or_is_passed() {
    let mut first = truth(0.0);
    for (id, kind) in [(20, 4), (21, 2), (22, 11), (23, 0)] {
        let stationary = StationaryObject {
            id: Some(Identifier { value: Some(id) }),
            base: Some(StationaryBase {
                dimension: Some(Extent { length: Some(2.0), width: Some(1.0), height: Some(3.0) }),
                position: Some(vector(30.0, 9.0)),
                orientation: Some(Orientation { yaw: Some(0.5) }),
            }),
            classification: Some(Classification { kind: Some(kind) }),
        };
        first.stationary.push(stationary.encode_to_vec());
    }
    let bytes = trace(&[first, truth(0.1)]);
    let recording = read("t.osi", &bytes, &ReadOptions::default()).expect("valid");
    let kinds: Vec<(&str, &str)> = recording
        .others
        .iter()
        .filter(|other| other.is_static())
        .map(|other| (other.id.as_str(), other.kind.as_str()))
        .collect();
    assert_eq!(kinds, [("20", "pillar"), ("22", "roadBoundary"), ("23", "unknown")]);
    assert!(recording.notes.iter().any(|note| note.contains("1 × bridge")), "{recording:?}");
}

#[test]
fn what_cannot_be_used_is_refused_with_the_number_of_its_message() {
    let whole = trace(&[0.0, 0.1].map(truth));
    let one = trace(&[truth(0.0)]).len();
    for (found, right) in [
        (refused(&[]), "t.osi: it has no message of OSI"),
        (refused(&whole[..one + 3]), "t.osi: message 2: 3 bytes are left, where its length has 4"),
        (refused(&whole[..whole.len() - 1]), "t.osi: message 2: 2"),
        (refused(&u32::MAX.to_le_bytes()), "t.osi: message 1: it has 4294967295 bytes"),
        (refused(b"\x03\0\0\0\xff\xff\xff"), "t.osi: message 1: an osi3.GroundTruth cannot be"),
        (changed(1, |t| t.timestamp = None), "t.osi: message 2: it has no timestamp"),
        (
            changed(2, |t| t.timestamp = truth(0.05).timestamp),
            "t.osi: message 3: its time, 0.05 s, is before that of the one before it",
        ),
        (
            changed(1, |t| t.timestamp = Some(Timestamp { seconds: None, nanos: Some(1 << 31) })),
            "t.osi: message 2: its timestamp has 2147483648 ns",
        ),
        (
            changed(2, |t| t.host_vehicle_id = Some(Identifier { value: Some(8) })),
            "t.osi: message 3: the host vehicle is 8, before it was 7",
        ),
        (
            changed(1, |t| t.moving[1] = object(7, 0.0).encode_to_vec()),
            "t.osi: message 2: object \"7\" stands there twice",
        ),
        (
            changed(0, |t| t.moving[1] = vec![0xff]),
            "t.osi: message 1: moving object 2 of it cannot be read",
        ),
        (
            changed(1, |t| t.moving = vec![Vec::new(); OBJECTS_MAX + 1]),
            "t.osi: message 2: 20001 objects",
        ),
        (with_object(|o| o.id = None), "t.osi: message 2: moving object 2 of it has no id"),
        (
            with_object(|o| o.base = None),
            "t.osi: message 2: object \"8\": base.dimension.length is missing",
        ),
        (
            with_object(|o| {
                o.base.as_mut().expect("a base").position = Some(vector(f64::NAN, 0.0))
            }),
            "t.osi: message 2: object \"8\": x is NaN",
        ),
        (
            with_object(|o| o.base.as_mut().expect("a base").position = Some(vector(1e9, 0.0))),
            "t.osi: message 2: object \"8\" is at 1000000000, 0 m",
        ),
        (
            with_object(|o| {
                let base = o.base.as_mut().expect("a base");
                base.velocity = Some(vector(0.0, f64::INFINITY));
            }),
            "t.osi: message 2: object \"8\": its velocity in y is inf",
        ),
        (
            with_object(|o| o.base.as_mut().expect("a base").velocity = Some(vector(300.0, 0.0))),
            "t.osi: message 2: object \"8\": its speed is 300 m/s",
        ),
        (
            with_object(|o| {
                let base = o.base.as_mut().expect("a base");
                base.dimension =
                    Some(Extent { length: Some(4500.0), ..base.dimension.expect("a size") });
            }),
            "t.osi: message 2: object \"8\": its length is 4500 m",
        ),
    ] {
        assert!(found.starts_with(right), "{found}\n{right}");
    }
    let mut nobody = [0.0, 0.1].map(truth);
    nobody.iter_mut().for_each(|truth| truth.host_vehicle_id = None);
    assert!(refused(&trace(&nobody)).contains("no host_vehicle_id says which object is the ego"));
    let asked = ReadOptions { ego: Some("5"), ..ReadOptions::default() };
    let error = read("t.osi", &whole, &asked).expect_err("unknown");
    assert!(error.what.contains("no moving object \"5\""), "{error}");
    assert!(error.remedy.contains("Objects here: 7, 8"), "{}", error.remedy);
}

#[test]
fn a_moment_that_is_stated_again_replaces_the_first() {
    let mut again = truth(0.1);
    again.moving[1] = object(8, 99.0).encode_to_vec();
    let bytes = trace(&[truth(0.0), truth(0.1), again, truth(0.2)]);
    let recording = read("t.osi", &bytes, &ReadOptions::default()).expect("valid");
    let track = &recording.others[0].track;
    assert_eq!((track.len(), track[1].place.at[0]), (3, 99.0));
    assert!(recording.notes[0].starts_with("1 moments are stated again"), "{recording:?}");
}

proptest! {
    #[test]
    fn no_bytes_make_it_panic(
        bytes in prop::collection::vec(any::<u8>(), 0..300),
        at in 0_usize..200,
        is_whole in any::<bool>(),
    ) {
        let mut trace = trace(&[0.0, 0.1].map(truth));
        if is_whole {
            trace = framed(&[bytes]);
        } else {
            let at = at.min(trace.len());
            let end = (at + bytes.len().min(9)).min(trace.len());
            trace.splice(at..end, bytes.into_iter().take(9));
        }
        let _read = read("t.osi", &trace, &ReadOptions::default()).map(|recording| {
            assert!(recording.ego.went.windows(2).all(|two| two[0].time_s < two[1].time_s));
        });
    }
}

#[cfg(feature = "mcap")]
mod container {
    //! The same in MCAP: as written with any compression; damaged, cut, or of other messages.

    use super::*;
    use ::mcap::records::MessageHeader;
    use ::mcap::{Compression, WriteOptions};

    fn packed(schema: &str, messages: &[Vec<u8>], by: Option<Compression>) -> Vec<u8> {
        let mut bytes = std::io::Cursor::new(Vec::new());
        let mut writer =
            WriteOptions::new().compression(by).create(&mut bytes).expect("it is begun");
        let schema = writer.add_schema(schema, "protobuf", &[]).expect("a schema");
        let channel = writer
            .add_channel(schema, "truth", "protobuf", &std::collections::BTreeMap::new())
            .expect("a channel");
        for (index, data) in messages.iter().enumerate() {
            let header = MessageHeader {
                channel_id: channel,
                sequence: index as u32,
                log_time: index as u64,
                publish_time: index as u64,
            };
            writer.write_to_known_channel(&header, data).expect("it is written");
        }
        writer.finish().expect("it is closed");
        drop(writer);
        bytes.into_inner()
    }

    fn moments() -> Vec<Vec<u8>> {
        [0.0, 0.1, 0.2].map(|time_s| truth(time_s).encode_to_vec()).to_vec()
    }

    #[test]
    fn a_container_is_the_same_trace() {
        let plain = read("t.osi", &framed(&moments()), &ReadOptions::default()).expect("valid");
        for by in [None, Some(Compression::Zstd), Some(Compression::Lz4)] {
            let bytes = packed("osi3.GroundTruth", &moments(), by);
            let found = read_mcap("t.mcap", &bytes, &ReadOptions::default()).expect("valid");
            assert_eq!(found, plain);
        }
    }

    #[test]
    fn what_is_damaged_or_of_others_is_refused() {
        let refused = |bytes: &[u8]| {
            let error = read_mcap("t.mcap", bytes, &ReadOptions::default()).expect_err("refused");
            error.to_string()
        };
        let bytes = packed("osi3.GroundTruth", &moments(), Some(Compression::Zstd));
        assert!(refused(b"no container at all").contains("not readable as MCAP: Bad magic"));
        assert!(refused(&bytes[..bytes.len() / 2]).contains("not readable as MCAP"));
        let others = packed("osi3.SensorData", &moments(), None);
        let said = refused(&others);
        assert!(said.contains("no channel has osi3.GroundTruth or osi3.SensorView"), "{said}");
        let mut long = moments();
        long[1] = vec![0; MESSAGE_BYTES_MAX + 1_000];
        for by in [None, Some(Compression::Zstd)] {
            let said = refused(&packed("osi3.GroundTruth", &long, by));
            assert!(said.contains("bytes") || said.contains("limit"), "{said}");
        }
    }

    proptest! {
        #[test]
        fn no_bytes_make_it_panic(at in 0_usize..2_000, new in any::<[u8; 8]>()) {
            let mut bytes = packed("osi3.GroundTruth", &moments(), Some(Compression::Zstd));
            let at = at % (bytes.len() - new.len());
            bytes[at..at + new.len()].copy_from_slice(&new);
            drop(read_mcap("t.mcap", &bytes, &ReadOptions::default()));
        }
    }
}

/// Libraries of proto3 leave out fields that are 0.
#[test]
fn what_is_left_out_of_a_part_that_is_there_is_zero() {
    let mut truths = [0.0, 0.1, 0.2].map(truth);
    for (index, truth) in truths.iter_mut().enumerate() {
        let mut ego = object(0, 1.0 + index as f64);
        let base = ego.base.as_mut().expect("there");
        base.position = Some(Vector { y: None, ..base.position.expect("there") });
        base.orientation = Some(Orientation { yaw: None });
        ego.id = Some(Identifier { value: None });
        truth.host_vehicle_id = Some(Identifier { value: None });
        truth.moving[0] = ego.encode_to_vec();
    }
    let recording = read("t.osi", &trace(&truths), &ReadOptions::default()).expect("valid");
    let place = recording.ego.start.place;
    assert_eq!((place.at, place.yaw), ([1.0, 0.0], 0.0));
    assert_eq!(recording.others.len(), 1);
}
