//! Nothing allocates once the workspace exists. The test program's allocator counts per thread, so
//! that concurrent tests do not affect the count.

use super::numeric::GRAVITY;
use super::random_tree::{Random, state, tree};
use nalgebra::{Matrix3, Vector3};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use stiction::dynamics::{
    self, Reduced, Workspace, aba, body, factor, jacobian, kinematics, link_force, reduced, rnea,
};
use stiction::robot::{Base, LinkId};

thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
    static HELD: Cell<isize> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: every call is forwarded to the system allocator unchanged; the counter is a plain
// thread-local integer that never allocates.
#[allow(unsafe_code)] // An allocator cannot be written without.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.set(COUNT.get() + 1);
        HELD.set(HELD.get() + layout.size() as isize);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        HELD.set(HELD.get() - layout.size() as isize);
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        COUNT.set(COUNT.get() + 1);
        HELD.set(HELD.get() + size as isize - layout.size() as isize);
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Number of allocations and reallocations that `f` makes on this thread.
pub fn count(f: impl FnOnce()) -> usize {
    let before = COUNT.get();
    f();
    COUNT.get() - before
}

/// Net change of the bytes allocated by this thread while `f` runs.
pub fn balance(f: impl FnOnce()) -> isize {
    let before = HELD.get();
    f();
    HELD.get() - before
}

#[test]
fn the_counter_counts_allocations() {
    let mut list: Vec<u8> = Vec::new();
    assert_eq!(count(|| list = std::hint::black_box(Vec::with_capacity(10))), 1);
    assert_eq!(count(|| list.reserve(1000)), 1);
    assert_eq!(count(|| list.clear()), 0);
    assert_eq!(balance(|| drop(std::mem::take(&mut list))), -1000);
}

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
