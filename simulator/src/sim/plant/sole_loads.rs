//! Loads on the soles: of the floor, and of all else that touches the link of a sole.
//!
//! ```text
//! F_s = R f_s + sum +-R_c f_c,     M_s = R m_s + sum +-(R_c m_c) + (p_c - p_s) x (+-R_c f_c)
//! ```
//!
//! over the contacts c of the sole's link with terrain, objects and other links: R_c are the axes of a
//! contact, p_c its reference point, f_c and m_c its wrench, positive where the link is the first side.
//! R are the floor's axes, p_s is the centroid of the sole. A force-torque sensor above the foot measures
//! this sum. A link with several soles gives each contact to the sole whose centroid is nearest.

use super::Plant;
use crate::robot::LinkId;
use nalgebra::Vector3;

/// A contact of a sole's link that is not the sole on the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoleContact {
    /// Index of the sole.
    pub sole: usize,
    /// Index of the contact's polygon.
    pub polygon: usize,
    /// 1 where the link is the contact's first side, -1 where it is the second.
    pub sign: f64,
}

impl Plant {
    /// The contacts of the soles' links besides those of the soles with the floor.
    pub fn sole_contacts(&self) -> impl Iterator<Item = SoleContact> {
        let soles = self.model.soles.len();
        (soles..self.polygons.len()).flat_map(move |polygon| {
            let sides = self.reduced.bodies(polygon).zip([1.0, -1.0]);
            let of_robot = sides.filter(|(body, _)| body.mechanism == 0);
            of_robot.filter_map(move |(body, sign)| {
                self.sole_near(body.link, polygon).map(|sole| SoleContact { sole, polygon, sign })
            })
        })
    }

    /// The sole of a link that is nearest to a polygon.
    fn sole_near(&self, link: LinkId, polygon: usize) -> Option<usize> {
        let reference = &self.reduced.reference;
        let distance = |s: &usize| (reference[*s] - reference[polygon]).norm_squared();
        let soles = self.model.soles.iter().enumerate().filter(|(_, sole)| sole.link == link).map(|(s, _)| s);
        soles.min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }

    /// Force and moment about its reference point of the wrench on a polygon, world axes.
    pub fn polygon_load(&self, polygon: usize) -> (Vector3<f64>, Vector3<f64>) {
        self.load_of(&self.solution.wrench, polygon)
    }

    fn load_of(&self, wrenches: &[f64], polygon: usize) -> (Vector3<f64>, Vector3<f64>) {
        let w = &wrenches[6 * polygon..6 * polygon + 6];
        let axes = &self.reduced.axes[polygon];
        (axes * Vector3::new(w[0], w[1], w[2]), axes * Vector3::new(w[3], w[4], w[5]))
    }

    /// Forces on all soles, N, or impulses, N s, that these wrenches (6F) contain, floor axes.
    pub fn sole_forces(&self, wrenches: &[f64], forces: &mut Vec<Vector3<f64>>) {
        forces.clear();
        let soles = wrenches.chunks_exact(6).take(self.model.soles.len());
        forces.extend(soles.map(|w| Vector3::new(w[0], w[1], w[2])));
        for SoleContact { sole, polygon, sign } in self.sole_contacts() {
            forces[sole] += self.floor.rotation.tr_mul(&self.load_of(wrenches, polygon).0) * sign;
        }
    }
}
