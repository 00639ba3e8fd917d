//! Messages in an MCAP container, whose schemas say what they are. Chunks may be compressed; how
//! much comes out of them is bounded before it is taken.

use super::{Form, MESSAGE_BYTES_MAX, Reader, too_long};
use crate::ReadOptions;
use crate::error::TrafficError;
use crate::recording::Recording;
use crate::trace::{Fault, listed, whole};
use ::mcap::records::Record;
use ::mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use ::mcap::{McapError, parse_record};
use std::collections::{BTreeMap, BTreeSet};

/// Bytes of all records together, at most: what a small compressed file may grow to.
const CONTENT_BYTES_MAX: u64 = 1 << 30;
/// Schemas and channels, at most.
const CHANNELS_MAX: usize = 1_000;
/// Bytes that are handed on at once.
const STEP: usize = 1 << 16;

pub(super) fn read(
    file: &str,
    bytes: &[u8],
    options: &ReadOptions<'_>,
) -> Result<Recording, TrafficError> {
    let limits = LinearReaderOptions::default()
        .with_record_length_limit(MESSAGE_BYTES_MAX + 64)
        .with_validate_chunk_crcs(true);
    let mut container = LinearReader::new_with_options(limits);
    let (mut rest, mut content) = (bytes, 0_u64);
    let mut reader = Reader::new(file);
    let mut topics = Topics::default();
    let failed = |error: &McapError, reader: &Reader<'_>| match error {
        McapError::RecordTooLarge { len, .. } => reader.fault(too_long(*len as usize)),
        other => reader.fault(refused(other)),
    };
    while let Some(event) = container.next_event() {
        match event.map_err(|error| failed(&error, &reader))? {
            LinearReadEvent::ReadRequest(need) => {
                let taken = need.min(STEP).min(rest.len());
                let (part, behind) = rest.split_at(taken);
                container.insert(taken).copy_from_slice(part);
                container.notify_read(taken);
                rest = behind;
            }
            LinearReadEvent::Record { opcode, data } => {
                content += data.len() as u64;
                if content > CONTENT_BYTES_MAX {
                    let fault = format!("unpacked, it has more than {CONTENT_BYTES_MAX} bytes");
                    let remedy = "is this the right file? Split the recording".to_owned();
                    return Err(whole(file, (fault, remedy)));
                }
                let record = parse_record(opcode, data).map_err(|error| failed(&error, &reader))?;
                topics.take(record, &mut reader)?;
            }
        }
    }
    if reader.messages == 0 && !topics.seen.is_empty() {
        let seen = listed(topics.seen.iter().map(String::as_str));
        let fault = "no channel has osi3.GroundTruth or osi3.SensorView".to_owned();
        return Err(whole(file, (fault, format!("channels here: {seen}"))));
    }
    let mut recording = reader.recording(options)?;
    if !topics.left_out.is_empty() {
        let left_out = listed(topics.left_out.iter().map(String::as_str));
        recording.notes.push(format!("one channel is read; left out: {left_out}"));
    }
    Ok(recording)
}

/// What the channels of a container carry.
#[derive(Default)]
struct Topics {
    schemas: BTreeMap<u16, String>,
    forms: BTreeMap<u16, (Form, String)>,
    /// Every channel in words.
    seen: Vec<String>,
    /// The channel that is read.
    chosen: Option<u16>,
    /// Others that say where everybody is.
    left_out: BTreeSet<String>,
}

impl Topics {
    fn take(&mut self, record: Record<'_>, reader: &mut Reader<'_>) -> Result<(), TrafficError> {
        match record {
            Record::Schema { header, .. } => {
                self.schemas.insert(header.id, header.name);
            }
            Record::Channel(channel) => {
                let name = self.schemas.get(&channel.schema_id).map_or("?", String::as_str);
                let form = match name.rsplit('.').next() {
                    Some("GroundTruth") => Some(Form::Truth),
                    Some("SensorView") => Some(Form::View),
                    _ => None,
                };
                let words = format!("{} ({name})", channel.topic);
                if let Some(form) = form {
                    self.forms.insert(channel.id, (form, words.clone()));
                }
                if !self.seen.contains(&words) {
                    self.seen.push(words);
                }
                if self.schemas.len().max(self.seen.len()) > CHANNELS_MAX {
                    let fault = format!("more than {CHANNELS_MAX} channels");
                    return Err(reader.fault((fault, "is this the right file?".to_owned())));
                }
            }
            Record::Message { header, data } => {
                let Some((form, words)) = self.forms.get(&header.channel_id) else {
                    return Ok(());
                };
                let chosen = *self.chosen.get_or_insert(header.channel_id);
                // Both may come from one simulator; then they say the same.
                if chosen != header.channel_id {
                    self.left_out.insert(words.clone());
                    return Ok(());
                }
                reader.form = Some(*form);
                reader.message(&data)?;
            }
            _ => {}
        }
        Ok(())
    }
}

fn refused(error: &McapError) -> Fault {
    let remedy = match error {
        McapError::BadMagic => "is this the right file? It does not begin as MCAP does",
        McapError::UnexpectedEof => "the file is cut short: let the simulator close it",
        McapError::UnsupportedCompression(_) => "write it with zstd, lz4 or uncompressed",
        _ => "the file is damaged; write it again",
    };
    (format!("not readable as MCAP: {error}"), remedy.to_owned())
}
