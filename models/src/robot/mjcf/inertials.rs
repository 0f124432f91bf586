//! Inertia of a body: `<inertial>`, or the sum of its geoms, by the settings of `<compiler>`.

use nalgebra::{Isometry3, Matrix3, SymmetricEigen, Vector3};

use super::bodies::Body;
use super::compiler::{Compiler, FromGeoms};
use super::document::{Document, Id};
use super::geoms::Geom;
use super::ignored::Ignored;
use super::orientation::orientation;
use super::view::View;
use crate::robot::inertia_repair::nearest_physical;
use crate::robot::rigid_inertia::{Flaw, RigidInertia, examine, moments_text};
use crate::robot::robot_error::RobotError;
use crate::robot::urdf::InertiaPolicy;

/// Greatest mass, kg: squares of greater ones could overflow.
const MAX_MASS: f64 = 1e12;
/// Greatest coordinate of a centre of mass, m.
const MAX_COORDINATE: f64 = 1e4;

/// Mass, centre and inertia of a body in its own frame, before `settotalmass`.
///
/// # Errors
/// Values that are not valid, an inertia that no body can have, a geom whose mass is needed and
/// not known.
pub(super) fn inertia(
    document: &Document,
    body: &Body,
    geoms: &[Geom],
    compiler: &Compiler,
    policy: InertiaPolicy,
    ignored: &mut Ignored,
) -> Result<RigidInertia, RobotError> {
    let empty = RigidInertia { mass: 0.0, com: Vector3::zeros(), tensor: Matrix3::zeros() };
    let (at, mut inertia) = match (body.inertial, compiler.from_geoms) {
        (Some(id), FromGeoms::Auto | FromGeoms::Never) => (id, explicit(document, id, compiler)?),
        (None, FromGeoms::Never) => (body.element, empty),
        (_, _) => {
            let mut sum = empty;
            for (geom, held) in geoms.iter().zip(&body.geoms) {
                let group = held.view.number("group")?.unwrap_or(0.0);
                if (compiler.groups[0]..=compiler.groups[1]).contains(&group)
                    && let Some(part) = geom.inertia.clone()?
                {
                    sum = sum.plus(&part);
                }
            }
            (body.element, sum)
        }
    };
    if inertia.mass == 0.0 {
        // MuJoCo takes the body's position in its parent, which counts with `boundmass`.
        inertia.com = body.pose.translation.vector;
    }
    bound(&mut inertia, compiler);
    let (moments, flaw) = examine(&inertia.tensor);
    let Some(flaw @ (Flaw::Negative | Flaw::Triangle)) = flaw else { return Ok(inertia) };
    if compiler.balance && flaw == Flaw::Triangle {
        inertia.tensor = Matrix3::identity() * (inertia.tensor.trace() / 3.0);
        ignored.note(at, "an inertia that no body can have becomes that of a ball (balanceinertia)");
    } else if policy == InertiaPolicy::Repair {
        inertia.tensor = nearest_physical(&inertia.tensor);
        let after = moments_text(examine(&inertia.tensor).0);
        let message = format!("inertia of body `{}` repaired: {} become {after}", body.name, moments_text(moments));
        ignored.warning(at, message);
    } else {
        let what = if flaw == Flaw::Negative { "is not positive definite" } else { "breaks the triangle inequality" };
        let fault = document.fault(at, format!("the inertia of body `{}` {what}", body.name));
        let expected = "principal moments above 0, the largest at most the sum of the others";
        let help = "inertia = \"repair\" in a scenario's [robot] or in the robot file, or inspect's --repair, takes \
                    the nearest physical tensor";
        return Err(fault.found(moments_text(moments)).expected(expected).help(help).invalid());
    }
    Ok(inertia)
}

/// Applies `boundmass` and `boundinertia`, the latter to the principal moments.
fn bound(inertia: &mut RigidInertia, compiler: &Compiler) {
    inertia.mass = inertia.mass.max(compiler.bound_mass);
    if compiler.bound_inertia > 0.0 {
        let eigen = SymmetricEigen::new(inertia.tensor);
        if eigen.eigenvalues.iter().any(|moment| *moment < compiler.bound_inertia) {
            let moments = eigen.eigenvalues.map(|moment| moment.max(compiler.bound_inertia));
            let tensor = eigen.eigenvectors * Matrix3::from_diagonal(&moments) * eigen.eigenvectors.transpose();
            inertia.tensor = 0.5 * (tensor + tensor.transpose());
        }
    }
}

/// `<inertial>`.
fn explicit(document: &Document, id: Id, compiler: &Compiler) -> Result<RigidInertia, RobotError> {
    let view = View::bare(document, id);
    let Some(mass) = view.number("mass")? else { return Err(view.missing("mass")) };
    if !(0.0..=MAX_MASS).contains(&mass) {
        return Err(view.fault("mass", format!("a mass in kg, not negative and at most {MAX_MASS:e}")).invalid());
    }
    let Some(position) = view.array::<3>("pos")? else { return Err(view.missing("pos")) };
    if position.iter().any(|x| x.abs() > MAX_COORDINATE) {
        return Err(view.fault("pos", format!("a position in m, at most {MAX_COORDINATE:e}")).invalid());
    }
    let rotation = orientation(&view, compiler)?;
    let mut tensor = Matrix3::from_diagonal(&Vector3::from(view.array::<3>("diaginertia")?.unwrap_or_default()));
    if let Some([xx, yy, zz, xy, xz, yz]) = view.array("fullinertia")? {
        let other = ["diaginertia", "quat", "axisangle", "euler", "xyaxes", "zaxis"].into_iter().find(|a| view.has(a));
        if let Some(other) = other {
            let message = format!("`fullinertia` and `{other}` exclude each other");
            return Err(document.attribute_fault(id, other, message).expected("one of them").invalid());
        }
        tensor = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    }
    let body = RigidInertia { mass, com: Vector3::zeros(), tensor };
    Ok(body.transformed(&Isometry3::from_parts(Vector3::from(position).into(), rotation)))
}
