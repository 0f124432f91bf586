//! Nothing allocates once the workspace exists.

use super::numeric::GRAVITY;
use super::random_tree::{Random, state, tree};
use crate::support::counting::count;
use nalgebra::{Matrix3, Vector3};
use stiction::dynamics::{
    self, Reduced, Workspace, aba, body, factor, jacobian, kinematics, link_force, reduced, rnea,
};
use stiction::robot::{Base, LinkId};

#[test]
fn dynamics_allocates_nothing_after_the_workspace() {
    for base in [Base::Floating, Base::Fixed] {
        let model = tree(5, 29, base);
        let mut r = Random::new(5);
        let (mut a, b) = (state(&model, &mut r), state(&model, &mut r));
        let nv = model.nv();
        let (tau, mut x, mut vdot) = (r.list(nv, 1.0), vec![0.0; nv], vec![0.0; nv]);
        let wrench = r.list(6 * model.soles.len(), 1.0);
        let (mut frame, mut com) = (vec![0.0; 6 * nv], vec![0.0; 3 * nv]);
        let mut ws = Workspace::new(&model);
        let mut problem = Reduced::new(&model, &ws);
        let point = Vector3::new(0.1, 0.2, 0.3);
        let link = LinkId(model.links.len() - 1);

        let allocations = count(|| {
            a.copy_from(&b);
            a.displace(&tau);
            dynamics::prepare(&model, &a, &GRAVITY, &mut ws).unwrap();
            rnea::inverse_dynamics(&model, &mut ws, &tau, &GRAVITY, &mut x);
            aba::forward_dynamics(&model, &mut ws, &tau, &GRAVITY, &mut vdot).unwrap();
            factor::factorize_shifted(&mut ws, &[0.1; 64][..nv]).unwrap();
            factor::solve(&ws, &mut x);
            ws.mass.multiply(&tau, &mut x);
            reduced::assemble(&ws, &Matrix3::identity(), &tau, &mut problem);
            reduced::advance(&ws, &mut problem, 1.0, &wrench, &mut vdot);
            kinematics::accelerations(&mut ws, &vdot);
            link_force::accumulate(&ws, link, &point, &point, &point, &mut x);
            jacobian::frame(&ws, link, &point, &mut frame);
            jacobian::center_of_mass(&ws, &mut com);
            std::hint::black_box((jacobian::point_acceleration(&ws, link, &point), body::momentum(&ws)));
            std::hint::black_box((body::kinetic_energy(&model, &ws), body::potential_energy(&ws, &GRAVITY)));
        });
        assert_eq!(allocations, 0);
    }
}
