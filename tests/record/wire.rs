//! Tests of the encoded messages, decoded only with the descriptors in the file.

use super::sample;
use mcap::MessageStream;
use prost::Message as _;
use prost_types::FileDescriptorSet;
use prost_types::field_descriptor_proto::Type;
use std::collections::{BTreeMap, BTreeSet};
use stiction::log::{TopicGroups, messages};
use stiction::sim::Snapshot;

/// Takes the first `n` bytes.
fn take<'a>(bytes: &mut &'a [u8], n: usize) -> &'a [u8] {
    let (head, tail) = bytes.split_at(n);
    *bytes = tail;
    head
}

/// Takes a number in groups of seven bits, lowest first.
fn varint(bytes: &mut &[u8]) -> u64 {
    let mut value = 0;
    for group in 0.. {
        let byte = take(bytes, 1)[0];
        value |= u64::from(byte & 0x7f) << (7 * group);
        if byte & 0x80 == 0 {
            break;
        }
    }
    value
}

fn double(bytes: &[u8]) -> String {
    format!("{:?}", f64::from_le_bytes(bytes.try_into().unwrap()))
}

/// Maps field names to values by the descriptor of `message`. Panics if bytes and descriptor
/// disagree.
fn read<'d>(set: &'d FileDescriptorSet, message: &str, mut bytes: &[u8]) -> BTreeMap<&'d str, Vec<String>> {
    const FIXED_64: u64 = 1;
    const DELIMITED: u64 = 2;
    let descriptor = set.file[0].message_type.iter().find(|m| m.name() == message).expect(message);
    let mut found: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    while !bytes.is_empty() {
        let tag = varint(&mut bytes);
        let field = descriptor.field.iter().find(|f| f.number() as u64 == tag >> 3).expect("a described field");
        let values = found.entry(field.name()).or_default();
        match (tag & 7, field.r#type()) {
            (FIXED_64, Type::Double) => values.push(double(take(&mut bytes, 8))),
            (DELIMITED, kind) => {
                let length = varint(&mut bytes) as usize;
                let body = take(&mut bytes, length);
                match kind {
                    // A delimited number is a packed list.
                    Type::Double => values.extend(body.chunks(8).map(double)),
                    Type::Bool => values.extend(body.iter().map(|b| (*b == 1).to_string())),
                    Type::String => values.push(String::from_utf8(body.to_vec()).unwrap()),
                    Type::Message => {
                        let inner = field.type_name().strip_prefix(".stiction.").unwrap();
                        values.push(format!("{:?}", read(set, inner, body)));
                    }
                    other => panic!("{}: {other:?} is not supported", field.name()),
                }
            }
            (wire, kind) => panic!("{} is {kind:?} on wire type {wire}", field.name()),
        }
    }
    found
}

/// The messages of a topic, decoded by their descriptor, and the number of described fields.
fn by_descriptor(bytes: &[u8], topic: &str) -> (Vec<BTreeMap<String, Vec<String>>>, usize) {
    let all: Vec<_> =
        MessageStream::new(bytes).unwrap().map(Result::unwrap).filter(|m| m.channel.topic == topic).collect();
    let schema = all[0].channel.schema.as_ref().unwrap();
    let set = FileDescriptorSet::decode(schema.data.as_ref()).unwrap();
    let name = schema.name.strip_prefix("stiction.").unwrap();
    let described = set.file[0].message_type.iter().find(|m| m.name() == name).unwrap().field.len();
    let owned = |m: &mcap::Message| read(&set, name, &m.data).into_iter().map(|(k, v)| (k.to_owned(), v)).collect();
    (all.iter().map(owned).collect(), described)
}

fn texts(values: &[f64]) -> Vec<String> {
    values.iter().map(|x| format!("{x:?}")).collect()
}

fn vector(v: Option<messages::Vector3>) -> Vec<String> {
    // Zeros are not encoded.
    let fields = |v: &messages::Vector3| {
        [("x", v.x), ("y", v.y), ("z", v.z)].into_iter().filter(|f| f.1 != 0.0).map(|(n, x)| (n, texts(&[x])))
    };
    v.iter().map(|v| format!("{:?}", fields(v).collect::<BTreeMap<_, _>>())).collect()
}

#[test]
fn each_described_field_is_on_the_wire() {
    let bytes = sample::log(6, TopicGroups::ALL);
    for topic in ["/state", "/contact", "/residual", "/events"] {
        let (messages, described) = by_descriptor(&bytes, topic);
        // Zeros and empty lists are not encoded, so no single message has every field.
        let seen: BTreeSet<&String> = messages.iter().flat_map(BTreeMap::keys).collect();
        assert_eq!(seen.len(), described, "{topic}: {seen:?}");
    }
}

#[test]
fn field_names_match_their_values() {
    let bytes = sample::log(6, TopicGroups::ALL);
    for (tick, found) in by_descriptor(&bytes, "/state").0.iter().enumerate() {
        let s = sample::snapshot(tick);
        assert_eq!(found["q"], texts(&s.q));
        assert_eq!(found["qd"], texts(&s.qd));
        assert_eq!(found["q_desired"], texts(&s.q_desired));
        assert_eq!(found["qd_desired"], texts(&s.qd_desired));
        assert_eq!(found["effort"], texts(&s.effort));
        assert_eq!(found["effort_desired"], texts(&s.effort_desired));
        for (name, v) in [
            ("base_position", s.base_pose.translation.vector),
            ("base_linear_velocity", s.base_linear_velocity),
            ("base_angular_velocity", s.base_angular_velocity),
            ("com", s.com),
            ("com_velocity", s.com_velocity),
        ] {
            assert_eq!(found[name], vector(Some(messages::Vector3 { x: v.x, y: v.y, z: v.z })), "{name}");
        }
        let r = s.base_pose.rotation;
        let quaternion = [("w", r.w), ("x", r.i), ("y", r.j), ("z", r.k)].map(|(k, v)| (k, texts(&[v])));
        assert_eq!(found["base_orientation"], [format!("{:?}", BTreeMap::from(quaternion))]);
    }
    for (tick, found) in by_descriptor(&bytes, "/residual").0.iter().enumerate() {
        let Snapshot { residual: r, energy: e, .. } = sample::snapshot(tick);
        for (name, value) in [
            ("penetration", r.penetration),
            ("tension", r.tension),
            ("signorini", r.signorini),
            ("cone_excess", r.cone_excess),
            ("dissipation_gap", r.dissipation_gap),
            ("creep_speed", r.creep_speed),
            ("resultant_gap", r.resultant_gap),
            ("energy_change", e.change),
            ("actuator_work", e.actuators),
            ("external_work", e.external),
            ("joint_loss", e.joint_loss),
            ("friction_loss", e.friction_loss),
            ("impact_loss", e.impact_loss),
            ("energy_error", e.change - e.actuators - e.external + e.joint_loss + e.friction_loss + e.impact_loss),
        ] {
            let seen: f64 = found[name][0].parse().unwrap();
            // The error may be summed in another order.
            assert!((seen - value).abs() <= 1e-15 * 6.0, "{name}: {seen} {value}");
        }
    }
    for (tick, found) in by_descriptor(&bytes, "/contact").0.iter().enumerate() {
        let sole = &sample::snapshot(tick).soles[0];
        for (name, value) in [("state", &sole.state), ("name", &"left".to_owned())] {
            assert!(found["soles"][0].contains(&format!("{name:?}: [{value:?}]")), "{}", found["soles"][0]);
        }
        let clamped: Vec<String> = sole.clamped.iter().map(ToString::to_string).collect();
        assert!(found["soles"][0].contains(&format!("\"clamped\": {clamped:?}")));
    }
}
