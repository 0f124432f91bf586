//! A client of a live run, written from RFC 6455 and Foxglove's specification only.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::{Value, json};

/// A connection to the server.
pub struct Viewer {
    line: BufReader<TcpStream>,
    /// Advertised topics by channel number.
    pub channels: BTreeMap<u64, Value>,
    /// Subscribed topics by subscription number.
    topics: BTreeMap<u32, String>,
}

/// A message of the server.
#[derive(Debug, PartialEq)]
pub enum ServerMessage {
    Text(Value),
    Time(u64),
    /// Topic, time in ns, bytes.
    Data(String, u64, Vec<u8>),
}

impl Viewer {
    /// Connects and reads the server's description.
    pub fn connect(port: u16, protocol: &str) -> Self {
        let (line, response) = Self::handshake(port, &format!("Host: 127.0.0.1:{port}\r\n"), protocol);
        assert!(response.starts_with("HTTP/1.1 101 "), "{response}");
        assert!(response.contains("s3pPLMBiTxaQ9kYGzzhZRbK+xOo=") && response.contains(protocol), "{response}");
        let mut viewer = Viewer { line, channels: BTreeMap::new(), topics: BTreeMap::new() };
        let Some(ServerMessage::Text(info)) = viewer.receive() else { panic!("no server info") };
        assert_eq!((&info["op"], &info["capabilities"]), (&json!("serverInfo"), &json!(["time"])));
        viewer
    }

    /// Sends a handshake with these fields, which include the host, and reads the response.
    pub fn handshake(port: u16, fields: &str, protocol: &str) -> (BufReader<TcpStream>, String) {
        let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
        let request = format!(
            "GET / HTTP/1.1\r\n{fields}Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n\
             Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: {protocol}\r\n\r\n"
        );
        // A test fails instead of waiting forever.
        stream.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
        stream.write_all(request.as_bytes()).unwrap();
        let mut line = BufReader::new(stream);
        let mut response = String::new();
        while !response.ends_with("\r\n\r\n") {
            assert_ne!(line.read_line(&mut response).unwrap(), 0, "{response}");
        }
        (line, response)
    }

    /// Subscribes to the selected topics once they are advertised.
    pub fn subscribe(&mut self, selected: impl Fn(&str) -> bool) {
        while self.channels.is_empty() {
            self.receive().unwrap();
        }
        let mut subscriptions = Vec::new();
        for (id, channel) in &self.channels {
            let (topic, number) = (channel["topic"].as_str().unwrap(), 1000 + *id as u32);
            if selected(topic) {
                self.topics.insert(number, topic.to_owned());
                subscriptions.push(json!({ "id": number, "channelId": id }));
            }
        }
        self.send(&json!({ "op": "subscribe", "subscriptions": subscriptions }));
    }

    pub fn unsubscribe(&mut self) {
        let ids: Vec<u32> = std::mem::take(&mut self.topics).into_keys().collect();
        self.send(&json!({ "op": "unsubscribe", "subscriptionIds": ids }));
    }

    /// Sends a text message. Its mask is fixed, as only proxies need a random one.
    pub fn send(&mut self, message: &Value) {
        let text = message.to_string().into_bytes();
        let mask = [1, 2, 3, 4];
        let mut frame = vec![0x81, 0x80 | 126];
        frame.extend((text.len() as u16).to_be_bytes());
        frame.extend(mask);
        frame.extend(text.iter().zip(mask.iter().cycle()).map(|(byte, mask)| byte ^ mask));
        self.line.get_mut().write_all(&frame).unwrap();
    }

    /// Receives the next message; none once the server has closed the connection.
    pub fn receive(&mut self) -> Option<ServerMessage> {
        let (code, bytes) = self.frame()?;
        let number = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
        Some(match (code, bytes.first()) {
            (1, _) => {
                let text: Value = serde_json::from_slice(&bytes).unwrap();
                match text["op"].as_str() {
                    Some("advertise") => {
                        let all = text["channels"].as_array().unwrap().iter().cloned();
                        self.channels.extend(all.map(|channel| (channel["id"].as_u64().unwrap(), channel)));
                    }
                    Some("unadvertise") => {
                        let removed = text["channelIds"].as_array().unwrap().iter();
                        removed.for_each(|id| assert!(self.channels.remove(&id.as_u64().unwrap()).is_some()));
                    }
                    _ => {}
                }
                ServerMessage::Text(text)
            }
            (2, Some(1)) => {
                let subscription = u32::from_le_bytes(bytes[1..5].try_into().unwrap());
                ServerMessage::Data(self.topics[&subscription].clone(), number(5), bytes[13..].to_vec())
            }
            (2, Some(2)) => ServerMessage::Time(number(1)),
            (8, _) => return None,
            _ => panic!("frame {code}: {bytes:?}"),
        })
    }

    fn frame(&mut self) -> Option<(u8, Vec<u8>)> {
        let mut start = [0; 2];
        match self.line.read_exact(&mut start) {
            Err(error) if error.kind() == ErrorKind::WouldBlock => panic!("no message in time"),
            read => read.ok()?,
        }
        assert_eq!(start[0] & 0xf0, 0x80, "a complete frame without reserved bits");
        let more = match start[1] {
            126 => 2,
            127 => 8,
            short => return Some((start[0] & 15, self.take(short.into()))),
        };
        let length = self.take(more).iter().fold(0, |all, byte| all << 8 | usize::from(*byte));
        Some((start[0] & 15, self.take(length)))
    }

    fn take(&mut self, length: usize) -> Vec<u8> {
        let mut bytes = vec![0; length];
        self.line.read_exact(&mut bytes).unwrap();
        bytes
    }

    /// Receives all messages until the connection closes, by topic.
    pub fn messages(&mut self) -> BTreeMap<String, Vec<(u64, Vec<u8>)>> {
        let mut all: BTreeMap<String, Vec<_>> = BTreeMap::new();
        while let Some(message) = self.receive() {
            if let ServerMessage::Data(topic, time, bytes) = message {
                all.entry(topic).or_default().push((time, bytes));
            }
        }
        all
    }

    /// The advertised topics, described as in a log: schema, encodings, metadata.
    pub fn topics(&self) -> BTreeMap<String, Topic> {
        let text = |value: &Value| value.as_str().unwrap().to_owned();
        let all = self.channels.values().map(|c| {
            let schema = match text(&c["schemaEncoding"]).as_str() {
                "protobuf" => BASE64_STANDARD.decode(text(&c["schema"])).unwrap(),
                _ => text(&c["schema"]).into_bytes(),
            };
            let metadata = serde_json::from_value(c["metadata"].clone()).unwrap_or_default();
            let topic = Topic {
                schema_name: text(&c["schemaName"]),
                schema_encoding: text(&c["schemaEncoding"]),
                schema,
                encoding: text(&c["encoding"]),
                metadata,
            };
            (text(&c["topic"]), topic)
        });
        all.collect()
    }
}

/// Description of a topic.
#[derive(Debug, PartialEq)]
pub struct Topic {
    pub schema_name: String,
    pub schema_encoding: String,
    pub schema: Vec<u8>,
    pub encoding: String,
    pub metadata: BTreeMap<String, String>,
}
