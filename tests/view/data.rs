//! Tests of the encoded run, decoded independently and compared with the logged snapshots.

use crate::record::sample;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use serde_json::Value;
use stiction::log::{LogHeader, TopicGroups};
use stiction::sim::{Snapshot, SoleSnapshot};
use stiction::view::{DrawnRun, PackedRun, ViewError, pack};

const TICKS: usize = 120;

fn replay(topics: TopicGroups) -> Result<DrawnRun, ViewError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.mcap");
    sample::open_log(&path, TICKS, topics).finish().unwrap();
    DrawnRun::read(&path)
}

fn snapshots() -> Vec<Snapshot> {
    (0..TICKS).map(sample::snapshot).collect()
}

/// An independent decoder, written from the module documentation of `packed_run.rs`.
struct Page {
    head: Value,
    columns: Vec<u8>,
}

impl Page {
    fn of(packed: &PackedRun) -> Self {
        let bytes = &packed.0;
        let length = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
        let head = serde_json::from_slice(&bytes[4..4 + length]).unwrap();
        Self { head, columns: bytes[(4 + length).next_multiple_of(8)..].to_vec() }
    }

    fn bytes(&self, array: &Value, size: usize) -> Vec<&[u8]> {
        let (at, n) = (array["at"].as_u64().unwrap() as usize, array["n"].as_u64().unwrap() as usize);
        assert_eq!(at % 8, 0, "arrays of numbers begin at multiples of their size");
        self.columns[at..at + n * size].chunks(size).collect()
    }

    fn floats(&self, array: &Value) -> Vec<f32> {
        self.bytes(array, 4).into_iter().map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
    }

    fn indices(&self, array: &Value) -> Vec<usize> {
        self.bytes(array, 4).into_iter().map(|b| u32::from_le_bytes(b.try_into().unwrap()) as usize).collect()
    }

    fn times(&self) -> Vec<f64> {
        let array = &self.head["times"];
        self.bytes(array, 8).into_iter().map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect()
    }

    fn list(&self, lists: &Value, tick: usize) -> Vec<f32> {
        let starts = self.indices(&lists["starts"]);
        self.floats(&lists["numbers"])[starts[tick]..starts[tick + 1]].to_vec()
    }
}

/// Compares numbers as f32 to the last bit; NaN equals NaN.
#[track_caller]
fn assert_same_numbers(found: &[f32], expected: impl IntoIterator<Item = f64>) {
    let bits = |x: f32| if x.is_nan() { None } else { Some(x.to_bits()) };
    let expected: Vec<_> = expected.into_iter().map(|x| bits(x as f32)).collect();
    assert_eq!(found.iter().map(|x| bits(*x)).collect::<Vec<_>>(), expected);
}

fn each(vectors: impl IntoIterator<Item = Vector3<f64>>) -> Vec<f64> {
    vectors.into_iter().flat_map(|v| [v.x, v.y, v.z]).collect()
}

fn or_nan(v: Option<Vector3<f64>>) -> Vector3<f64> {
    v.unwrap_or(Vector3::repeat(f64::NAN))
}

#[test]
fn numbers_equal_those_of_the_log() {
    let page = Page::of(&pack(&replay(TopicGroups::ALL).unwrap(), None));
    let all = snapshots();
    let times: Vec<u64> = page.times().iter().map(|t| t.to_bits()).collect();
    assert_eq!(times, all.iter().map(|s| s.time.to_bits()).collect::<Vec<_>>());
    assert_same_numbers(&page.floats(&page.head["com"]), each(all.iter().map(|s| s.com)));
    assert_same_numbers(&page.floats(&page.head["cop"]), each(all.iter().map(|s| or_nan(s.centre_of_pressure))));
    assert_same_numbers(&page.floats(&page.head["stable"]), each(all.iter().map(|s| or_nan(s.stable_point))));
    assert!(all.iter().any(|s| s.centre_of_pressure.is_none()), "the sample has a flight");
    for (tick, s) in all.iter().enumerate() {
        assert_same_numbers(&page.list(&page.head["polygon"], tick), each(s.support_polygon.iter().copied()));
        assert_same_numbers(
            &page.list(&page.head["external"], tick),
            each(s.external.iter().flat_map(|(p, f)| [*p, *f])),
        );
    }
    let points = page.head["points"].as_array().unwrap();
    assert_eq!(points.iter().map(|p| p["name"].as_str().unwrap()).collect::<Vec<_>>(), ["goal", "now and then"]);
    for (k, point) in points.iter().enumerate() {
        assert_same_numbers(&page.floats(&point["position"]), each(all.iter().map(|s| or_nan(s.points[k].position))));
    }
    let nearest = &page.head["nearest"];
    let self_contacts: Vec<_> = all.iter().map(|s| s.self_contact.as_ref().unwrap()).collect();
    let of = |k: usize| self_contacts[k].nearest.as_ref();
    assert_same_numbers(&page.floats(&nearest["distance"]), (0..TICKS).map(|k| of(k).map_or(f64::INFINITY, |n| n.0)));
    assert_same_numbers(&page.floats(&nearest["first"]), each((0..TICKS).map(|k| or_nan(of(k).map(|n| n.2)))));
    assert_same_numbers(&page.floats(&nearest["second"]), each((0..TICKS).map(|k| or_nan(of(k).map(|n| n.3)))));
    assert!((0..TICKS).any(|k| of(k).is_some()));
    for (k, code) in page.indices(&nearest["pair"]).into_iter().enumerate() {
        let pair = of(k).map_or_else(|| "/".to_owned(), |n| self_contacts[k].pairs[n.1].join("/"));
        assert_eq!(nearest["pairs"][code], pair.as_str());
    }
    assert_eq!(nearest["margin"].as_f64(), Some(0.0), "the sample's scenario has no margin");
    let soles = page.head["soles"].as_array().unwrap();
    assert_eq!((soles.len(), soles[2]["states"].as_array().unwrap().len()), (3, 2), "two soles and a link");
    let of_link = |s: &Snapshot| s.links.first().map_or(Vector3::zeros(), |(_, link)| link.forces.iter().sum());
    assert_same_numbers(&page.floats(&soles[2]["force"]), each(all.iter().map(of_link)));
    for (tick, s) in all.iter().enumerate() {
        let point = |link: &SoleSnapshot, v: usize| {
            let (at, force) = (link.positions[v], link.forces[v]);
            [at.x, at.y, at.z, force.x, force.y, force.z, f64::from(u8::from(link.clamped[v]))]
        };
        let link = s.links.first().map(|(_, link)| link);
        let points = link.map_or(Vec::new(), |link| (0..link.forces.len()).flat_map(|v| point(link, v)).collect());
        assert_same_numbers(&page.list(&soles[2]["points"], tick), points);
    }
    assert!(soles[0]["points"].is_null() && all.iter().any(|s| !s.links.is_empty()));
    for (i, sole) in soles.iter().enumerate().take(2) {
        let states = sole["states"].as_array().unwrap();
        let codes = page.bytes(&sole["state"], 1);
        for (code, s) in codes.iter().zip(&all) {
            assert_eq!(states[usize::from(code[0])], s.soles[i].state.as_str());
        }
        assert_eq!(
            states.len(),
            if i == 0 { 3 } else { 1 },
            "one sole of the sample changes its state, the other does not"
        );
        assert_same_numbers(&page.floats(&sole["force"]), each(all.iter().map(|s| s.soles[i].forces.iter().sum())));
        for (v, vertex) in sole["vertices"].as_array().unwrap().iter().enumerate() {
            assert_same_numbers(&page.floats(&vertex["position"]), each(all.iter().map(|s| s.soles[i].positions[v])));
            assert_same_numbers(&page.floats(&vertex["force"]), each(all.iter().map(|s| s.soles[i].forces[v])));
            let clamped: Vec<u8> = all.iter().map(|s| u8::from(s.soles[i].clamped[v])).collect();
            assert_eq!(page.bytes(&vertex["clamped"], 1).concat(), clamped);
        }
    }
}

#[test]
fn frames_compose_to_the_logged_poses() {
    let page = Page::of(&pack(&replay(TopicGroups::ALL).unwrap(), None));
    let frames = page.head["frames"].as_array().unwrap();
    let model = sample::model();
    for (tick, s) in snapshots().iter().enumerate() {
        // Parents come before their children.
        let mut world = vec![("world".to_owned(), Isometry3::identity())];
        for frame in frames {
            let rows = page.floats(&frame["poses"]);
            let at = if frame["fixed"] == true { 0 } else { 7 * tick };
            let n: Vec<f64> = rows[at..at + 7].iter().map(|x| f64::from(*x)).collect();
            let turned = UnitQuaternion::from_quaternion(Quaternion::new(n[6], n[3], n[4], n[5]));
            let local = Isometry3::from_parts(Translation3::new(n[0], n[1], n[2]), turned);
            let parent = world.iter().find(|(name, _)| frame["parent"] == name.as_str()).unwrap().1;
            world.push((frame["name"].as_str().unwrap().to_owned(), parent * local));
        }
        let poses = sample::link_poses_of(s);
        for (link, expected) in model.links.iter().zip(&poses) {
            let found = world.iter().find(|(name, _)| *name == link.name).unwrap().1;
            // Three composed poses, each rounded to 6e-8 of numbers of a few metres.
            assert!((found.translation.vector - expected.translation.vector).norm() < 3e-6, "{} at {tick}", link.name);
            assert!(found.rotation.angle_to(&expected.rotation) < 3e-6, "{} at {tick}", link.name);
        }
        let plate = world.iter().find(|(name, _)| name == "tip").unwrap().1;
        let expected = poses[0] * Translation3::new(0.0, 0.1, 0.05);
        assert!((plate.translation.vector - expected.translation.vector).norm() < 3e-6, "a welded link at {tick}");
    }
    let fixed: Vec<_> = frames.iter().filter(|f| f["fixed"] == true).map(|f| f["name"].as_str().unwrap()).collect();
    assert_eq!(fixed, ["plate", "tip", "sole/left", "sole/toe"]);
}

#[test]
fn shapes_equal_those_of_the_robot() {
    let page = Page::of(&pack(&replay(TopicGroups::ALL).unwrap(), None));
    let shapes = page.head["shapes"].as_array().unwrap();
    let of = |frame: &str| shapes.iter().filter(|s| s["frame"] == frame).collect::<Vec<_>>();
    let trunk = of("trunk");
    assert_eq!(trunk.len(), 1);
    assert_eq!((&trunk[0]["kind"], &trunk[0]["size"]), (&"box".into(), &serde_json::json!([0.2, 0.3, 0.1])));
    assert_eq!(trunk[0]["pose"][2], 0.4);
    assert_eq!(trunk[0]["colour"], serde_json::json!([0.25, 0.5, 0.75, 1.0]));
    let shank = of("shank");
    let (points, triangles) = sample::mesh();
    assert_same_numbers(&page.floats(&shank[0]["points"]), points.iter().flat_map(|p| [p.x, p.y, p.z]));
    let indices: Vec<usize> = triangles.iter().flatten().map(|i| *i as usize).collect();
    assert_eq!(page.indices(&shank[0]["indices"]), indices);
    let kinds: Vec<_> = of("ball").iter().map(|s| s["kind"].as_str().unwrap().to_owned()).collect();
    // A capsule is a cylinder with a sphere at each end.
    assert_eq!(kinds, ["sphere", "sphere", "sphere", "cylinder", "cylinder"]);
    assert!(of("world").iter().any(|s| s["entity"] == "floor" && s["kind"] == "box"));
    assert!(of("world").iter().any(|s| s["entity"] == "floor" && s["line"] == "pairs"));
}

#[test]
fn a_rate_keeps_some_ticks_and_the_last() {
    let replay = replay(TopicGroups::ALL).unwrap();
    let period = replay.times[1] - replay.times[0];
    let kept = replay.thinned(Some(0.25 / period));
    assert_eq!(kept[..3], [0, 4, 8]);
    assert_eq!(*kept.last().unwrap(), TICKS - 1);
    assert_eq!(replay.thinned(Some(1e9)), replay.thinned(None));
    assert_eq!(replay.thinned(None).len(), TICKS);
    let page = Page::of(&pack(&replay, Some(0.25 / period)));
    assert_eq!(page.times(), kept.iter().map(|&i| replay.times[i]).collect::<Vec<_>>());
    assert_same_numbers(&page.floats(&page.head["com"]), each(kept.iter().map(|&i| sample::snapshot(i).com)));
    let moving = page.head["frames"].as_array().unwrap().iter().find(|f| f["fixed"] == false).unwrap();
    assert_eq!(page.floats(&moving["poses"]).len(), 7 * kept.len());
}

/// The sample has 200 ticks a second.
#[test]
fn frames_for_viewers_are_shown_with_the_series_at_their_instants() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.mcap");
    let header = LogHeader { viewer_rate: 50.0, ..sample::header(TopicGroups::ALL) };
    sample::open_log_with(&path, TICKS, &header).finish().unwrap();
    let drawn = DrawnRun::read(&path).unwrap();
    let shown: Vec<usize> = (0..TICKS).step_by(4).collect();
    assert_eq!(drawn.rows, shown);
    assert_eq!(drawn.run.times.len(), TICKS);
    let page = Page::of(&pack(&drawn, None));
    let all = snapshots();
    assert_eq!(page.times(), shown.iter().map(|&i| all[i].time).collect::<Vec<_>>());
    assert_same_numbers(&page.floats(&page.head["com"]), each(shown.iter().map(|&i| all[i].com)));
    let force = &page.head["soles"][0]["force"];
    assert_same_numbers(&page.floats(force), each(shown.iter().map(|&i| all[i].soles[0].forces.iter().sum())));
    // Every second of these, and the last.
    let half = Page::of(&pack(&drawn, Some(25.0)));
    let kept: Vec<usize> = shown.iter().step_by(2).copied().chain([*shown.last().unwrap()]).collect();
    assert_same_numbers(&half.floats(&half.head["com"]), each(kept.iter().map(|&i| all[i].com)));
    let moving = page.head["frames"].as_array().unwrap().iter().find(|f| f["fixed"] == false).unwrap();
    assert_eq!(page.floats(&moving["poses"]).len(), 7 * shown.len());
}

#[test]
fn missing_topics_are_null() {
    let page = Page::of(&pack(&replay(TopicGroups { scene: true, ..TopicGroups::NONE }).unwrap(), None));
    assert_eq!(page.times().len(), TICKS);
    for absent in ["com", "cop", "stable", "polygon", "external", "points", "soles"] {
        assert!(page.head[absent].is_null(), "{absent}");
    }
    let error = replay(TopicGroups { scene: false, ..TopicGroups::ALL }).unwrap_err();
    assert!(matches!(error, ViewError::NoScene { .. }), "{error}");
    assert!(error.to_string().contains("log.topics"), "{error}");
}
