//! Reads recordings, whole or cut off, by the schemas in the file.

#![allow(dead_code, reason = "every test uses its part")]

use std::collections::{BTreeMap, HashMap};

use mcap::read::{LinearReader, Options};
use mcap::records::Record;
use prost_reflect::{DescriptorPool, DynamicMessage, MessageDescriptor, ReflectMessage, Value};

/// A message as it is in the file.
pub struct Message {
    pub topic: String,
    pub log_time: u64,
    pub publish_time: u64,
    pub sequence: u32,
    pub content: DynamicMessage,
}

/// A recording.
#[derive(Default)]
pub struct File {
    pub messages: Vec<Message>,
    pub metadata: BTreeMap<String, BTreeMap<String, String>>,
    pub attachments: BTreeMap<String, Vec<u8>>,
    /// The schema of each topic.
    pub schemas: BTreeMap<String, MessageDescriptor>,
    /// Whether the file ends as it should.
    pub is_whole: bool,
    pub chunks: usize,
    /// The earliest and the latest `log_time` of each chunk.
    pub spans: Vec<(u64, u64)>,
}

fn schema(name: &str, data: &[u8]) -> MessageDescriptor {
    DescriptorPool::decode(data).unwrap().get_message_by_name(name).unwrap()
}

/// Reads all that is whole.
pub fn read(bytes: &[u8]) -> File {
    let mut file = File::default();
    let (mut schemas, mut channels) = (HashMap::new(), HashMap::new());
    for record in LinearReader::new_with_options(bytes, Options::IgnoreEndMagic.into()).unwrap() {
        match record {
            Ok(Record::Chunk { header, data }) => {
                file.chunks += 1;
                file.spans.push((header.message_start_time, header.message_end_time));
                for record in mcap::read::ChunkReader::new(header, &data).unwrap() {
                    file.take(record.unwrap(), &mut schemas, &mut channels);
                }
            }
            Ok(Record::Footer(_)) => file.is_whole = true,
            Ok(record) => file.take(record, &mut schemas, &mut channels),
            Err(_) => break,
        }
    }
    file
}

impl File {
    fn take(
        &mut self,
        record: Record<'_>,
        schemas: &mut HashMap<u16, MessageDescriptor>,
        channels: &mut HashMap<u16, (String, u16)>,
    ) {
        match record {
            Record::Schema { header, data } => {
                assert_eq!(header.encoding, "protobuf");
                schemas.insert(header.id, schema(&header.name, &data));
            }
            Record::Channel(channel) => {
                assert_eq!(channel.message_encoding, "protobuf");
                self.schemas.insert(channel.topic.clone(), schemas[&channel.schema_id].clone());
                channels.insert(channel.id, (channel.topic, channel.schema_id));
            }
            Record::Message { header, data } => {
                let (topic, schema) = channels[&header.channel_id].clone();
                let content = DynamicMessage::decode(schemas[&schema].clone(), &data[..]).unwrap();
                let (log_time, publish_time, sequence) =
                    (header.log_time, header.publish_time, header.sequence);
                self.messages.push(Message { topic, log_time, publish_time, sequence, content });
            }
            Record::Metadata(metadata) => {
                self.metadata.insert(metadata.name, metadata.metadata);
            }
            Record::Attachment { header, data, .. } => {
                self.attachments.insert(header.name, data.into_owned());
            }
            _ => {}
        }
    }

    /// The messages of a topic.
    pub fn of<'a>(&'a self, topic: &'a str) -> impl Iterator<Item = &'a Message> {
        self.messages.iter().filter(move |message| message.topic == topic)
    }

    /// The events of a site: what, and why.
    pub fn events(&self, side: u8) -> Vec<(String, Option<String>)> {
        let events = self.messages.iter().filter(|message| message.topic == format!("/site{side}/event"));
        events
            .map(|message| {
                let word = |name: &str| {
                    value(&message.content, name).map(|value| value.as_str().unwrap().to_owned())
                };
                (word("event").unwrap(), word("cause"))
            })
            .collect()
    }
}

/// The value of a field, with dots between the levels; `None` if it is not there.
pub fn value(message: &DynamicMessage, path: &str) -> Option<Value> {
    let (name, rest) = path.split_once('.').map_or((path, None), |(name, rest)| (name, Some(rest)));
    let field = message.descriptor().get_field_by_name(name).unwrap_or_else(|| panic!("no field {path}"));
    if field.supports_presence() && !message.has_field(&field) {
        return None;
    }
    let found = message.get_field(&field).into_owned();
    match rest {
        None => Some(found),
        Some(rest) => value(found.as_message().unwrap(), rest),
    }
}

pub fn number(message: &DynamicMessage, path: &str) -> Option<f64> {
    value(message, path).map(|value| value.as_f64().unwrap())
}

pub fn whole(message: &DynamicMessage, path: &str) -> Option<u64> {
    value(message, path).map(|value| value.as_u64().unwrap())
}

pub fn word(message: &DynamicMessage, path: &str) -> Option<String> {
    value(message, path).map(|value| value.as_str().unwrap().to_owned())
}

/// Both axes of a pair.
pub fn pair(message: &DynamicMessage, path: &str) -> Option<[f64; 2]> {
    value(message, path)?;
    Some(["x", "y"].map(|axis| number(message, &format!("{path}.{axis}")).unwrap()))
}
