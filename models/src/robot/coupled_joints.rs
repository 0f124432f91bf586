//! Couplings of a model: `<mimic>` of URDF as conditions, and positions of following joints.

use super::closure::Coupling;
use super::model::{JointId, Model};
use super::notices::Notices;
use super::urdf::Mimic;
use crate::text::source::Source;

/// Greatest difference of homes that counts as none, rad or m.
const SAME: f64 = 1e-6;

/// Adds the couplings of mimic joints, `q = multiplier q_of + offset`. A joint that follows one that does
/// not move is held at its offset.
pub(super) fn add_mimics(model: &mut Model, mimics: &[Mimic], source: &Source, notices: &mut Notices) {
    for mimic in mimics {
        let Some(joint) = model.joint(&mimic.joint) else {
            let message = format!("<mimic> of joint `{}` is ignored: it is not one moving joint", mimic.joint);
            notices.warning(source, mimic.at, message);
            continue;
        };
        let compound = format!("{}/", mimic.of);
        if model.joints.iter().any(|other| other.name.starts_with(&compound)) {
            let message = format!(
                "joint `{}` mimics `{}`, which has several motions: `{0}` is independent",
                mimic.joint, mimic.of
            );
            notices.warning(source, mimic.at, message);
            continue;
        }
        let (leader, multiplier) = match model.joint(&mimic.of) {
            Some(leader) => (leader, mimic.multiplier),
            None => {
                let message = format!(
                    "joint `{}` mimics `{}`, which does not move: it is held at {}",
                    mimic.joint, mimic.of, mimic.offset
                );
                notices.info(source, mimic.at, message);
                (joint, 0.0)
            }
        };
        let coefficients = [mimic.offset, multiplier, 0.0, 0.0, 0.0];
        model.couplings.push(Coupling { joint, leader, coefficients });
    }
    sort(&mut model.couplings);
    keep_from_default_drives(model);
}

/// Puts each coupling behind those of the joints that it follows. Those of a ring stay out.
pub(super) fn sort(couplings: &mut Vec<Coupling>) {
    let mut rest = std::mem::take(couplings);
    while !rest.is_empty() {
        let waits = |c: &Coupling| c.leader != c.joint && rest.iter().any(|other| other.joint == c.leader);
        let (later, now): (Vec<Coupling>, Vec<Coupling>) = rest.iter().partition(|c| waits(c));
        if now.is_empty() {
            break;
        }
        couplings.extend(now);
        rest = later;
    }
}

/// Following joints have no drives but those that a file gives them.
fn keep_from_default_drives(model: &mut Model) {
    let Model { couplings, joints, .. } = model;
    couplings.iter().for_each(|coupling| joints[coupling.joint.0].drive_configured = true);
}

/// Sets the home of following joints to the positions that their couplings give them.
pub(super) fn set_homes(model: &mut Model) {
    let mut home = std::mem::take(&mut model.home);
    model.set_followers(&mut home);
    model.home = home;
}

/// As [`set_homes`], with a note of each home that a file gives but its coupling does not.
pub(super) fn replace_homes(model: &mut Model, source: &Source, at: usize, notices: &mut Notices) {
    let given = model.home.clone();
    set_homes(model);
    for coupling in &model.couplings {
        let (joint, leader) = (coupling.joint.0, coupling.leader.0);
        let (given, home) = (given[joint], model.home[joint]);
        if (given - home).abs() > SAME {
            let (name, of) = (&model.joints[joint].name, &model.joints[leader].name);
            let message = format!("joint `{name}` follows `{of}`: its home is {home}, not {given}");
            notices.info(source, at, message);
        }
    }
}

/// Notes homes of following joints outside their limits.
pub(super) fn note_homes(model: &Model, source: &Source, notices: &mut Notices) {
    for JointId(joint) in model.couplings.iter().map(|coupling| coupling.joint) {
        let (of, home) = (&model.joints[joint], model.home[joint]);
        if !(of.lower..=of.upper).contains(&home) {
            let at = source.text().find(&format!("\"{}\"", of.name)).unwrap_or(0);
            let message = format!("joint `{}` follows another one: its home, {home}, is outside its limits", of.name);
            notices.info(source, at, message);
        }
    }
}
