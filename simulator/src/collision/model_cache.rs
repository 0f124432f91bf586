//! Shares collision models between equal robots: building one takes some 50 ms, and a batch has
//! many runs of one robot.

use std::collections::HashMap;
use std::sync::{Arc, LazyLock, Mutex, PoisonError, Weak};

use super::CollisionModel;
use crate::robot::{Geometry, Model, SelfCollision};

type Entry = Arc<Mutex<Option<Weak<CollisionModel>>>>;

static MODELS: LazyLock<Mutex<HashMap<[u8; 32], Entry>>> = LazyLock::new(Mutex::default);

/// The collision model of a robot: that of an earlier call with equal shapes, joints and settings
/// if it is still in use.
pub fn shared_model(model: &Model, settings: &SelfCollision) -> Arc<CollisionModel> {
    let entry = {
        let mut models = MODELS.lock().unwrap_or_else(PoisonError::into_inner);
        models.entry(hash(model, settings)).or_default().clone()
    };
    // Callers with this robot wait until it is built; callers with other robots do not.
    let mut entry = entry.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(found) = entry.as_ref().and_then(Weak::upgrade) {
        return found;
    }
    let built = Arc::new(CollisionModel::new(model, settings));
    *entry = Some(Arc::downgrade(&built));
    built
}

/// Hash of everything that a collision model depends on.
fn hash(model: &Model, settings: &SelfCollision) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    let mut numbers = |numbers: &[f64]| {
        hasher.update(&(numbers.len() as u64).to_le_bytes());
        numbers.iter().for_each(|x| {
            hasher.update(&x.to_bits().to_le_bytes());
        });
    };
    for link in &model.links {
        numbers(&link.name.bytes().map(f64::from).collect::<Vec<_>>());
        numbers(&[link.parent.map_or(-1.0, |p| p.0 as f64)]);
        numbers(link.rotation.as_slice());
        numbers(link.offset.as_slice());
        numbers(&[link.collisions.len() as f64]);
        for shape in &link.collisions {
            numbers(shape.pose.to_homogeneous().as_slice());
            match &shape.geometry {
                Geometry::Box(size) => numbers(&[0.0, size.x, size.y, size.z]),
                Geometry::Cylinder(radius, length) => numbers(&[1.0, *radius, *length]),
                Geometry::Capsule(radius, length) => numbers(&[2.0, *radius, *length]),
                Geometry::Sphere(radius) => numbers(&[3.0, *radius]),
                Geometry::Mesh(vertices, _) => vertices.iter().for_each(|v| numbers(v.coords.as_slice())),
            }
        }
    }
    for (joint, home) in model.joints.iter().zip(&model.home) {
        numbers(&[joint.kind as u8 as f64, joint.lower, joint.upper, *home]);
    }
    let pair = |pair: &[crate::robot::LinkId; 2]| [pair[0].0 as f64, pair[1].0 as f64];
    numbers(&[settings.resolution as f64]);
    let listed = settings.bodies.as_ref();
    numbers(&listed.map_or(vec![-1.0], |all| all.iter().map(|l| l.0 as f64).collect()));
    for pairs in [&settings.ignore, &settings.watch] {
        numbers(&pairs.iter().flat_map(pair).collect::<Vec<_>>());
    }
    *hasher.finalize().as_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_robots_share_a_model() {
        let robot = crate::robot::load(std::path::Path::new("../robots/block/block.toml")).expect("our own robot");
        let first = shared_model(&robot.model, &robot.self_collision);
        let mut heavier = robot.model.clone();
        heavier.links[0].mass += 1.0;
        assert!(Arc::ptr_eq(&first, &shared_model(&heavier, &robot.self_collision)));
        let finer = SelfCollision { resolution: 32, ..robot.self_collision.clone() };
        assert!(!Arc::ptr_eq(&first, &shared_model(&robot.model, &finer)));
        let mut moved = robot.model.clone();
        moved.links[0].collisions[0].pose.translation.x += 0.1;
        assert!(!Arc::ptr_eq(&first, &shared_model(&moved, &robot.self_collision)));
    }
}
