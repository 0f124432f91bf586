//! A frame computed along its chain against the kinematics of the whole tree.

use super::numeric::assert_near;
use super::random_tree::samples;
use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use stiction::dynamics::chain::{self, FrameMotion};
use stiction::dynamics::{Workspace, jacobian, kinematics};
use stiction::robot::{LinkId, Mount};

fn numbers(m: &FrameMotion) -> Vec<f64> {
    let r = m.rotation.to_rotation_matrix().into_inner();
    [r.as_slice(), m.position.as_slice(), m.velocity.as_slice(), m.omega.as_slice()].concat()
}

#[test]
fn a_frame_along_its_chain_agrees_with_the_whole_tree_and_gives_back_the_root() {
    for (model, state, mut r) in samples() {
        let mut ws = Workspace::new(&model);
        kinematics::update(&model, &state, &mut ws);
        for link in 0..model.links.len() {
            let turn = UnitQuaternion::from_scaled_axis(r.vector(2.0));
            let pose = Isometry3::from_parts(Translation3::from(r.vector(0.3)), turn);
            let mount = Mount { link: LinkId(link), pose };
            let base = FrameMotion::of_base(&state);
            let seen = chain::from_root(&model, &mount, &state.joints, state.rates());
            let moving = seen.carried_by(&base);

            let point = ws.point(LinkId(link), &pose.translation.vector);
            let twist = jacobian::link_twist(&ws, LinkId(link), &point);
            let rotation = ws.links[link].rotation * turn.to_rotation_matrix().into_inner();
            let truth =
                [rotation.as_slice(), point.as_slice(), twist.linear.as_slice(), twist.angular.as_slice()].concat();
            // Rounding along chains of at most 30 links.
            assert_near("frame", &numbers(&moving), &truth, 1e-13);
            assert_near("root", &numbers(&seen.carries(&moving)), &numbers(&base), 1e-13);
        }
    }
}
