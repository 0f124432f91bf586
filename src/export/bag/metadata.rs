//! `metadata.yaml` of a bag, version 5 of rosbag2's format: that of Humble, which later versions
//! read too.

use std::fmt::Write as _;

/// First line of the file.
pub(super) const HEAD: &str = "rosbag2_bagfile_information:";

/// Whether a topic's last message also reaches subscribers that come later.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Durability {
    /// Later subscribers receive the last message.
    TransientLocal,
    /// They do not.
    Volatile,
}

/// A topic of the bag.
#[derive(Clone, Debug)]
pub(super) struct TopicInfo {
    pub name: String,
    /// Type, such as `std_msgs/msg/String`.
    pub message: &'static str,
    pub durability: Durability,
    /// Number of its messages.
    pub count: u64,
}

/// What `metadata.yaml` states.
#[derive(Clone, Debug)]
pub(super) struct BagInfo {
    /// Name of the MCAP file.
    pub storage: String,
    /// Times of the first and the last message, ns.
    pub first: u64,
    pub last: u64,
    pub topics: Vec<TopicInfo>,
}

impl BagInfo {
    /// Number of messages.
    pub fn count(&self) -> u64 {
        self.topics.iter().map(|topic| topic.count).sum()
    }

    /// The text of `metadata.yaml`.
    pub fn file_text(&self) -> String {
        self.entries().lines().fold(format!("{HEAD}\n"), |text, line| text + "  " + line + "\n")
    }

    /// The entries alone, as rosbag2 repeats them inside the MCAP file.
    pub fn entries(&self) -> String {
        let Self { first, last, .. } = self;
        let (storage, duration, count) = (quoted(&self.storage), last - first, self.count());
        let mut text = format!(
            "version: 5\n\
             storage_identifier: mcap\n\
             duration:\n  nanoseconds: {duration}\n\
             starting_time:\n  nanoseconds_since_epoch: {first}\n\
             message_count: {count}\n\
             topics_with_message_count:\n"
        );
        for topic in &self.topics {
            // Writing to a string does not fail.
            let _ = write!(
                text,
                "  - topic_metadata:\n      name: {}\n      type: {}\n      serialization_format: cdr\n      \
                 offered_qos_profiles: {}\n    message_count: {}\n",
                quoted(&topic.name),
                topic.message,
                quoted(&qos_profiles(topic.durability)),
                topic.count
            );
        }
        // The chunks of the file are compressed, not the file or the messages.
        let _ = write!(
            text,
            "compression_format: \"\"\n\
             compression_mode: \"\"\n\
             relative_file_paths:\n  - {storage}\n\
             files:\n  - path: {storage}\n    starting_time:\n      nanoseconds_since_epoch: {first}\n    \
             duration:\n      nanoseconds: {duration}\n    message_count: {count}\n"
        );
        text
    }
}

/// The quality of service that a topic was offered with: a list of one profile, in the numbers of
/// `rmw`. Durations are unlimited.
pub(super) fn qos_profiles(durability: Durability) -> String {
    const UNLIMITED: &str = "    sec: 9223372036\n    nsec: 854775807\n";
    const KEEP_LAST: u8 = 1;
    const RELIABLE: u8 = 1;
    const AUTOMATIC: u8 = 1;
    let (depth, durability) = match durability {
        Durability::TransientLocal => (1, 1),
        Durability::Volatile => (10, 2),
    };
    format!(
        "- history: {KEEP_LAST}\n  depth: {depth}\n  reliability: {RELIABLE}\n  durability: {durability}\n  \
         deadline:\n{UNLIMITED}  lifespan:\n{UNLIMITED}  liveliness: {AUTOMATIC}\n  \
         liveliness_lease_duration:\n{UNLIMITED}  avoid_ros_namespace_conventions: false"
    )
}

/// A text as a double-quoted scalar of YAML.
fn quoted(text: &str) -> String {
    let mut out = String::from('"');
    for c in text.chars() {
        match c {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            '\n' => out.push_str("\\n"),
            // Line breaks and characters that YAML does not print.
            c if c.is_control() || matches!(c, '\u{2028}' | '\u{2029}' | '\u{feff}' | '\u{fffe}' | '\u{ffff}') => {
                let _ = write!(out, "\\u{:04x}", u32::from(c));
            }
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_quoted() {
        assert_eq!(quoted("a: #b"), r#""a: #b""#);
        assert_eq!(quoted("\"q\" \\ \n\t\u{85}\u{feff}é"), r#""\"q\" \\ \n\u0009\u0085\ufeffé""#);
    }

    #[test]
    fn the_file_indents_the_entries() {
        let topic = TopicInfo { name: "/tf".into(), message: "a/msg/B", durability: Durability::Volatile, count: 3 };
        let info = BagInfo { storage: "b_0.mcap".into(), first: 5, last: 12, topics: vec![topic] };
        let lines: Vec<String> = info.file_text().lines().map(str::to_owned).collect();
        assert_eq!(lines[..3], [HEAD, "  version: 5", "  storage_identifier: mcap"]);
        let inner: Vec<&str> = lines[1..].iter().map(|line| &line[2..]).collect();
        assert_eq!(inner, info.entries().lines().collect::<Vec<_>>());
        assert!(inner.contains(&"    message_count: 3") && inner.contains(&"message_count: 3"));
        assert!(inner.contains(&"  nanoseconds: 7") && inner.contains(&"  nanoseconds_since_epoch: 5"));
    }
}
