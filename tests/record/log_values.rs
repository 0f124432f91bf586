//! Tests of the values in `log.mcap`, decoded from its messages.

use super::sample::{self, URDF};
use foxglove::messages::{FrameTransforms, Log, Pose, Quaternion, SceneEntity, SceneUpdate, Vector3 as LogVector};
use mcap::MessageStream;
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use stiction::log::{LogWriter, TopicGroups, messages, ros};
use stiction::robot::Base;
use stiction::sim::{Observer, Snapshot, SoleSnapshot};

const TICKS: usize = 6;

/// All messages of one topic, encoded.
fn raw(topic: &str) -> Vec<Vec<u8>> {
    let bytes = sample::log(TICKS, TopicGroups::ALL);
    let messages = MessageStream::new(&bytes).unwrap().map(Result::unwrap);
    messages.filter(|m| m.channel.topic == topic).map(|m| m.data.into_owned()).collect()
}

fn protobuf<M: prost::Message + Default>(topic: &str) -> Vec<M> {
    raw(topic).iter().map(|b| M::decode(b.as_slice()).unwrap()).collect()
}

fn snapshots() -> impl Iterator<Item = Snapshot> {
    (0..TICKS).map(sample::snapshot)
}

fn message_of(v: &Vector3<f64>) -> messages::Vector3 {
    messages::Vector3 { x: v.x, y: v.y, z: v.z }
}

fn messages_of(v: &[Vector3<f64>]) -> Vec<messages::Vector3> {
    v.iter().map(message_of).collect()
}

fn vector(v: Option<LogVector>) -> Vector3<f64> {
    v.map(|v| Vector3::new(v.x, v.y, v.z)).unwrap()
}

fn rotation(q: Option<Quaternion>) -> UnitQuaternion<f64> {
    let q = q.unwrap();
    // Not normalised, so that a wrong norm fails.
    UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(q.w, q.x, q.y, q.z))
}

fn isometry(p: Option<Pose>) -> Isometry3<f64> {
    let p = p.unwrap();
    Isometry3::from_parts(Translation3::from(vector(p.position)), rotation(p.orientation))
}

#[test]
fn state_equals_the_snapshot_to_the_last_bit() {
    for (found, s) in protobuf::<messages::State>("/state").iter().zip(snapshots()) {
        let r = s.base_pose.rotation;
        let expected = messages::State {
            time: s.time,
            base_position: Some(message_of(&s.base_pose.translation.vector)),
            base_orientation: Some(messages::Quaternion { w: r.w, x: r.i, y: r.j, z: r.k }),
            base_linear_velocity: Some(message_of(&s.base_linear_velocity)),
            base_angular_velocity: Some(message_of(&s.base_angular_velocity)),
            q: s.q,
            qd: s.qd,
            q_desired: s.q_desired,
            qd_desired: s.qd_desired,
            effort: s.effort,
            effort_desired: s.effort_desired,
            com: Some(message_of(&s.com)),
            com_velocity: Some(message_of(&s.com_velocity)),
            cop: s.centre_of_pressure.as_ref().map(message_of),
            stable_point: s.stable_point.as_ref().map(message_of),
            support_polygon: messages_of(&s.support_polygon),
            points: (s.points.iter())
                .map(|p| messages::Point { name: p.name.clone(), position: p.position.as_ref().map(message_of) })
                .collect(),
            external: s
                .external
                .iter()
                .map(|(p, f)| messages::Force { point: Some(message_of(p)), force: Some(message_of(f)) })
                .collect(),
        };
        assert_eq!(found, &expected);
    }
}

#[test]
fn contact_equals_the_soles_to_the_last_bit() {
    let names = sample::model().soles.into_iter().map(|s| s.name).collect::<Vec<_>>();
    for (found, s) in protobuf::<messages::Contact>("/contact").iter().zip(snapshots()) {
        let message = |(sole, name): (&SoleSnapshot, &String)| {
            // Summed by hand, in the order of the vertices.
            let force = sole.forces.iter().fold(Vector3::zeros(), |sum, f| sum + f);
            messages::Sole {
                name: name.clone(),
                state: sole.state.clone(),
                clamped: sole.clamped.clone(),
                positions: messages_of(&sole.positions),
                velocities: messages_of(&sole.velocities),
                forces: messages_of(&sole.forces),
                force: Some(message_of(&force)),
            }
        };
        let soles = s.soles.iter().zip(&names).map(message).collect();
        let links = s.links.iter().map(|(name, link)| message((link, name))).collect();
        assert_eq!(found, &messages::Contact { time: s.time, soles, links });
    }
}

#[test]
fn events_are_on_the_topics_events_and_log() {
    let events = protobuf::<messages::Event>("/events");
    let log = protobuf::<Log>("/log");
    assert_eq!((events.len(), log.len()), (4, 4));
    for (tick, (event, log)) in events.iter().zip(&log).enumerate() {
        let e = sample::event(tick);
        assert_eq!(
            (event.time, event.kind.as_str(), &event.subject, &event.message),
            (e.time, e.kind.as_str(), &e.subject, &e.message)
        );
        assert_eq!(log.message, if tick == 2 { "jam left" } else { &e.message });
        let ns = u64::from(log.timestamp.unwrap().sec()) * 1_000_000_000 + u64::from(log.timestamp.unwrap().nsec());
        assert_eq!(ns, (e.time * 1e9).round() as u64);
    }
    let levels: Vec<&str> = log.iter().map(|l| l.level().as_str_name()).collect();
    assert_eq!(levels, ["INFO", "INFO", "WARNING", "ERROR"]);
}

#[test]
fn joint_states_and_robot_description_are_cdr() {
    let joint_states = raw("/joint_states");
    assert_eq!(joint_states.len(), TICKS);
    for (bytes, s) in joint_states.iter().zip(snapshots()) {
        let expected = ros::JointState {
            header: ros::Header {
                stamp: ros::Time { sec: 0, nanosec: (s.time * 1e9).round() as u32 },
                frame_id: String::new(),
            },
            name: vec!["hip".into(), "ankle".into()],
            position: s.q,
            velocity: s.qd,
            effort: s.effort,
        };
        assert_eq!(cdr::deserialize::<ros::JointState>(bytes).unwrap(), expected);
    }
    let description: ros::Text = cdr::deserialize(&raw("/robot_description")[0]).unwrap();
    assert_eq!(description.data, URDF);
}

/// Composes the transforms from `frame` up to the world.
fn to_world(tf: &FrameTransforms, frame: &str) -> Isometry3<f64> {
    let mut pose = Isometry3::identity();
    let mut frame = frame.to_owned();
    while frame != "world" {
        let t = tf.transforms.iter().find(|t| t.child_frame_id == frame).expect("a parent up to the world");
        pose = Isometry3::from_parts(Translation3::from(vector(t.translation)), rotation(t.rotation)) * pose;
        frame.clone_from(&t.parent_frame_id);
    }
    pose
}

fn distance(a: &Isometry3<f64>, b: &Isometry3<f64>) -> f64 {
    (a.to_homogeneous() - b.to_homogeneous()).amax()
}

#[test]
fn frames_compose_to_the_links_poses() {
    let model = sample::model();
    let all = protobuf::<FrameTransforms>("/tf");
    for (tf, s) in all.iter().zip(snapshots()) {
        let children: Vec<&str> = tf.transforms.iter().map(|t| t.child_frame_id.as_str()).collect();
        assert_eq!(children, ["trunk", "shank", "ball", "plate", "tip", "sole/left", "sole/toe"]);
        for (link, pose) in model.links.iter().zip(&sample::link_poses_of(&s)) {
            // Error: three products of poses of size 1, a few units of 1e-16 each.
            assert!(distance(&to_world(tf, &link.name), pose) < 1e-14, "{}", link.name);
        }
        // Vertices and welds are given in the internal frame.
        let poses = sample::link_poses_of(&s);
        let internal = |link: usize| poses[link] * model.links[link].urdf_frame.inverse();
        for weld in &model.links[0].merged {
            assert!(distance(&to_world(tf, &weld.name), &(internal(0) * weld.pose)) < 1e-14, "{}", weld.name);
        }
        let parents: Vec<&str> = tf.transforms.iter().map(|t| t.parent_frame_id.as_str()).collect();
        assert_eq!(parents, ["world", "trunk", "shank", "trunk", "plate", "shank", "ball"], "as in the URDF");
        let heel = internal(1) * Point3::new(0.0, 0.0, -0.2);
        assert!((to_world(tf, "sole/left").translation.vector - heel.coords).norm() < 1e-14);
        for t in &tf.transforms {
            let stamp = t.timestamp.unwrap();
            assert_eq!((stamp.sec(), stamp.nsec()), (0, (s.time * 1e9).round() as u32));
        }
    }
}

#[test]
fn the_root_frame_is_map_if_a_link_is_called_world() {
    let mut model = sample::model();
    model.base = Base::Fixed;
    model.links[0].name = "world".into();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.mcap");
    let mut log = LogWriter::create(&path, &model, &sample::header(TopicGroups::ALL)).unwrap();
    log.snapshot(&sample::snapshot(0)).unwrap();
    log.finish().unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let message = MessageStream::new(&bytes).unwrap().map(Result::unwrap).find(|m| m.channel.topic == "/tf").unwrap();
    let tf = <FrameTransforms as prost::Message>::decode(message.data.as_ref()).unwrap();
    // Viewers do not draw a frame that is its own parent.
    let first = &tf.transforms[0];
    assert_eq!((first.parent_frame_id.as_str(), first.child_frame_id.as_str()), ("map", "world"));
}

fn entity<'a>(scene: &'a SceneUpdate, id: &str) -> &'a SceneEntity {
    scene.entities.iter().find(|e| e.id == id).expect(id)
}

#[test]
fn the_scene_draws_each_shape_in_its_links_urdf_frame() {
    let scene = &protobuf::<SceneUpdate>("/scene")[0];
    let model = sample::model();
    let trunk = entity(scene, "link/trunk");
    assert_eq!((trunk.frame_id.as_str(), trunk.frame_locked, trunk.lifetime), ("trunk", true, None));
    let cube = trunk.cubes[0];
    assert_eq!(vector(cube.size), Vector3::new(0.2, 0.3, 0.1));
    assert!(distance(&isometry(cube.pose), &model.links[0].visuals[0].pose) < 1e-15);
    let colour = cube.color.unwrap();
    assert_eq!([colour.r, colour.g, colour.b, colour.a], [0.25, 0.5, 0.75, 1.0]);

    let mesh = &entity(scene, "link/shank").triangles[0];
    let (points, triangles) = sample::mesh();
    assert!(distance(&isometry(mesh.pose), &Isometry3::identity()) < 1e-15, "inverse of a pose times itself");
    let found: Vec<[f64; 3]> = mesh.points.iter().map(|p| [p.x, p.y, p.z]).collect();
    assert_eq!(found, points.iter().map(|p| [p.x, p.y, p.z]).collect::<Vec<_>>());
    assert_eq!(mesh.indices, triangles.concat());

    let ball = entity(scene, "link/ball");
    assert_eq!((ball.spheres.len(), ball.cylinders.len()), (3, 2), "a sphere, a capsule of three, a cylinder");
    assert_eq!(vector(ball.spheres[0].size), Vector3::repeat(0.06));
    assert_eq!(vector(ball.cylinders[1].size), Vector3::new(0.04, 0.04, 0.2));
    let frame = model.links[2].urdf_frame;
    for (sphere, z) in ball.spheres[1..].iter().zip([-0.1, 0.1]) {
        // In the internal frame, the ends of the capsule are those of the model.
        let end = frame * Point3::from(isometry(sphere.pose).translation.vector);
        assert!((end.coords - Vector3::new(0.1, 0.0, z)).norm() < 1e-15);
    }
}

#[test]
fn the_upper_face_of_the_slab_is_the_floor() {
    let scene = &protobuf::<SceneUpdate>("/scene")[0];
    let floor = entity(scene, "floor");
    assert_eq!(floor.frame_id, "world");
    let slab = floor.cubes[0];
    let top = isometry(slab.pose) * Translation3::new(0.0, 0.0, 0.5 * slab.size.unwrap().z);
    assert!(distance(&top, &sample::header(TopicGroups::ALL).floor.unwrap()) < 1e-15);
    assert!(floor.lines[0].points.iter().all(|p| p.z == 0.0 && p.x.abs() <= 5.0 && p.y.abs() <= 5.0));
}

#[test]
fn patches_are_outlined() {
    let scene = &protobuf::<SceneUpdate>("/scene")[0];
    let drawn = &entity(scene, "floor/patch-0").lines[0];
    assert_eq!(drawn.r#type(), foxglove::messages::line_primitive::Type::LineLoop);
    assert_eq!(isometry(drawn.pose), Isometry3::identity());
    let points: Vec<_> = drawn.points.iter().map(|p| Vector3::new(p.x, p.y, p.z)).collect();
    assert_eq!(points, sample::PATCHES[0]);
}

#[test]
fn markers_show_forces_clamped_vertices_and_balance() {
    let model = sample::model();
    // An arrow of half a metre represents the weight.
    let metres_per_newton = 0.5 / (model.mass() * 9.806_65);
    let mut any_link = false;
    for (scene, s) in protobuf::<SceneUpdate>("/scene/contact").iter().zip(snapshots()) {
        // Links have an entity once one has touched.
        any_link |= !s.links.is_empty();
        assert_eq!(scene.entities.len(), 5 + usize::from(any_link));
        let nothing = SoleSnapshot::default();
        let link = any_link.then(|| (s.links.first().map_or(&nothing, |(_, link)| link), "links"));
        for (sole, name) in s.soles.iter().zip(["left", "toe"]).chain(link) {
            let drawn = entity(scene, &format!("contact/{name}"));
            let clamped: Vec<_> = sole.positions.iter().zip(&sole.clamped).filter(|(_, c)| **c).collect();
            assert_eq!(drawn.spheres.len(), clamped.len());
            for (ball, (at, _)) in drawn.spheres.iter().zip(clamped) {
                assert_eq!(isometry(ball.pose).translation.vector, *at);
            }
            let pushing: Vec<_> = sole.positions.iter().zip(&sole.forces).filter(|(_, f)| f.norm() > 0.0).collect();
            assert_eq!(drawn.arrows.len(), pushing.len());
            for (arrow, (at, force)) in drawn.arrows.iter().zip(pushing) {
                let pose = isometry(arrow.pose);
                assert_eq!(pose.translation.vector, *at);
                let length = arrow.shaft_length + arrow.head_length;
                // Error: single precision, 6e-8 of each number, of which the rotation doubles two.
                assert!(
                    (pose.rotation * Vector3::x() * length / metres_per_newton - force).norm() < 5e-7 * force.norm()
                );
            }
        }
        assert!(any_link || s.time == 0.0);
        assert_eq!(entity(scene, "external").arrows.len(), s.external.len());
        let balance = entity(scene, "balance");
        let points = [s.centre_of_pressure, s.stable_point];
        assert_eq!(balance.spheres.len(), 1 + points.iter().flatten().count());
        let expected: Vec<_> = s.points.iter().filter_map(|p| p.position).collect();
        let drawn = entity(scene, "points").spheres.iter().map(|ball| isometry(ball.pose).translation.vector);
        assert_eq!(drawn.collect::<Vec<_>>(), expected);
        let polygon = balance.lines.first().map_or(0, |l| l.points.len());
        assert_eq!(polygon, s.support_polygon.len());
    }
}

#[test]
fn colours_distinguish_static_from_sliding() {
    let colours: Vec<_> = protobuf::<SceneUpdate>("/scene/contact")
        .iter()
        .map(|scene| entity(scene, "contact/left").spheres.first().map(|s| s.color.unwrap()))
        .collect();
    let [Some(fixed), Some(sliding), None] = colours[..3] else { panic!("static, dynamic, free: {colours:?}") };
    assert!(fixed.g > fixed.r && sliding.r > sliding.g);
}

/// Ground that is a robot of a scene with objects has no centre of mass.
#[test]
fn a_robot_without_mass_has_no_ball_at_its_centre() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.mcap");
    let snapshot = Snapshot { com: Vector3::repeat(f64::NAN), ..sample::snapshot(0) };
    let mut log = LogWriter::create(&path, &sample::model(), &sample::header(TopicGroups::ALL)).unwrap();
    log.snapshot(&snapshot).unwrap();
    log.finish().unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let mut messages = MessageStream::new(&bytes).unwrap().map(Result::unwrap);
    let scene = messages.find(|m| m.channel.topic == "/scene/contact").unwrap();
    let scene = <SceneUpdate as prost::Message>::decode(scene.data.as_ref()).unwrap();
    let others = [snapshot.centre_of_pressure, snapshot.stable_point];
    assert_eq!(entity(&scene, "balance").spheres.len(), others.iter().flatten().count());
}
