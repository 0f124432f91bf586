//! Messages of Foxglove's WebSocket protocol for streaming topics:
//! <https://github.com/foxglove/ws-protocol>, docs/spec.md.
//!
//! The server describes itself and its topics in JSON. A client subscribes to topics and numbers
//! its subscriptions; messages are binary frames that begin with this number. The server also
//! publishes the simulated time, which viewers use as their clock.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde::Deserialize;
use serde_json::{Value, json};

use crate::log::ChannelInfo;

/// First bytes of binary frames.
const MESSAGE_DATA: u8 = 1;
const TIME: u8 = 2;
/// Status level of a warning.
pub(super) const WARNING: u8 = 1;

/// Request of a client.
#[derive(Deserialize, Debug, PartialEq, Eq)]
#[serde(tag = "op", rename_all = "camelCase")]
pub enum Request {
    /// Subscribes to topics.
    Subscribe {
        /// The topics with the client's numbers.
        subscriptions: Vec<Subscription>,
    },
    /// Ends subscriptions.
    #[serde(rename_all = "camelCase")]
    Unsubscribe {
        /// The client's numbers.
        subscription_ids: Vec<u32>,
    },
    /// A request for capabilities that this server does not advertise.
    #[serde(other)]
    Other,
}

/// A client's number for a topic.
#[derive(Deserialize, Clone, Copy, Debug, PartialEq, Eq)]
#[serde(rename_all = "camelCase")]
pub struct Subscription {
    /// The client's number.
    pub id: u32,
    /// The server's number of the topic.
    pub channel_id: u32,
}

/// Parses a request of a client; none if it is invalid.
pub fn parse_request(text: &str) -> Option<Request> {
    serde_json::from_str(text).ok()
}

pub(super) fn server_info(session: u64) -> String {
    json!({
        "op": "serverInfo",
        "name": concat!("stiction ", env!("CARGO_PKG_VERSION")),
        "capabilities": ["time"],
        "supportedEncodings": [],
        "metadata": {},
        "sessionId": session.to_string(),
    })
    .to_string()
}

pub(super) fn advertise<'a>(channels: impl Iterator<Item = (u32, &'a ChannelInfo)>) -> String {
    let channels: Vec<Value> = channels
        .map(|(id, info)| {
            // Binary descriptions are base64 in JSON.
            let schema = match info.schema_encoding.as_str() {
                "protobuf" | "flatbuffer" => BASE64_STANDARD.encode(&info.schema),
                _ => String::from_utf8_lossy(&info.schema).into_owned(),
            };
            let mut channel = json!({
                "id": id,
                "topic": info.topic,
                "encoding": info.encoding,
                "schemaName": info.schema_name,
                "schemaEncoding": info.schema_encoding,
                "schema": schema,
            });
            if !info.metadata.is_empty() {
                channel["metadata"] = json!(info.metadata);
            }
            channel
        })
        .collect();
    json!({ "op": "advertise", "channels": channels }).to_string()
}

pub(super) fn unadvertise(channels: &[u32]) -> String {
    json!({ "op": "unadvertise", "channelIds": channels }).to_string()
}

pub(super) fn status(level: u8, message: &str) -> String {
    json!({ "op": "status", "level": level, "message": message }).to_string()
}

pub(super) fn message_data(subscription: u32, time: u64, payload: &[u8]) -> Vec<u8> {
    let mut out = Vec::with_capacity(13 + payload.len());
    out.push(MESSAGE_DATA);
    out.extend(subscription.to_le_bytes());
    out.extend(time.to_le_bytes());
    out.extend(payload);
    out
}

/// True if a binary frame is a message of a topic.
pub(super) fn is_message(frame: &[u8]) -> bool {
    frame.first() == Some(&MESSAGE_DATA)
}

pub(super) fn time(now: u64) -> Vec<u8> {
    [&[TIME][..], &now.to_le_bytes()].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Requests of the specification.
    #[test]
    fn requests_are_parsed() {
        let read = parse_request;
        let subscriptions = vec![Subscription { id: 0, channel_id: 3 }, Subscription { id: 1, channel_id: 5 }];
        let text = r#"{"op":"subscribe","subscriptions":[{"id":0,"channelId":3},{"id":1,"channelId":5}]}"#;
        assert_eq!(read(text), Some(Request::Subscribe { subscriptions }));
        let text = r#"{"op":"unsubscribe","subscriptionIds":[0,1]}"#;
        assert_eq!(read(text), Some(Request::Unsubscribe { subscription_ids: vec![0, 1] }));
        assert_eq!(read(r#"{"op":"getParameters","parameterNames":[]}"#), Some(Request::Other));
        assert_eq!(read(r#"{"op":"subscribe","subscriptions":[{"id":-1,"channelId":3}]}"#), None);
        assert_eq!(read("subscribe"), None);
        // The parser bounds the depth of nesting.
        assert_eq!(read(&"[".repeat(1 << 20)), None);
    }

    /// Every value of every byte of a request.
    #[test]
    fn changed_bytes_do_not_panic() {
        let text = r#"{"op":"subscribe","subscriptions":[{"id":0,"channelId":3}]}"#;
        let mut valid = 0;
        for at in 0..text.len() {
            for byte in 0..=255 {
                let mut changed = text.as_bytes().to_vec();
                changed[at] = byte;
                valid += usize::from(std::str::from_utf8(&changed).ok().and_then(parse_request).is_some());
            }
        }
        assert!(valid > text.len() && valid < 256 * text.len(), "{valid}");
    }
}
