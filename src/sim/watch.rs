//! Event functions of the contact states in force: positive while the states stay true.
//!
//! | watched | event when it reaches zero |
//! |---|---|
//! | height of an unclamped vertex above the floor | touch-down |
//! | the same vertex while it lies within the tolerance band: room below and approach speed | entering the floor |
//! | normal margin of a clamped pattern | lift-off, or the centre of pressure leaves it |
//! | friction margin of a static pattern or a pivot | slip onset |
//! | sliding velocity along the reference direction | stick, or turning round |
//! | height of a vertex over a compliant floor, or its depth | entering or leaving it |
//! | distance of a sliding vertex to the border of its zone | other friction |

use super::simulation::Simulation;
use crate::contact::methods::penalty;
use crate::contact::model::state::{MAX_SOLES, Mode, SoleState};
use crate::contact::search::judge::{CLEAR, SUSPECT_FRICTION, SUSPECT_NORMAL, TOUCHING, margin};
use nalgebra::Vector2;

/// Most event functions watched at once.
pub const MAX_WATCHED: usize = 512;

#[derive(Clone, Copy, Debug)]
enum Item {
    Height(usize, usize),
    /// With the depth to which it may go: d, or twice where it is already.
    Band(usize, usize, f64),
    /// Of a compliant floor, and whether the vertex is in it.
    Surface(usize, usize, bool),
    Normal(usize),
    Friction(usize),
    /// With the speed at which it may go backwards.
    Slide(usize, usize, f64),
    Border(usize, usize, Vector2<f64>),
}

/// The functions watched during one step.
pub struct Watch {
    items: Vec<Item>,
    /// Functions negative from the start, because no valid state was found: not watched, asked again after the step.
    overlooked: Vec<usize>,
}

impl Watch {
    /// Room for all that can be watched.
    pub fn new() -> Self {
        Watch { items: Vec::with_capacity(MAX_WATCHED), overlooked: Vec::with_capacity(MAX_WATCHED) }
    }

    /// Chooses what to watch from the states and the vertices at the start of a step.
    pub fn begin(&mut self, sim: &Simulation) {
        self.items.clear();
        self.overlooked.clear();
        let p = &sim.plant.problem;
        if sim.plant.is_compliant() {
            for (s, sole) in p.soles.iter().enumerate() {
                let item = |(i, v)| Item::Surface(s, i, penalty::is_inside(v));
                self.items.extend(sole.vertices.iter().enumerate().map(item));
            }
            return;
        }
        for (s, sole) in p.soles.iter().enumerate() {
            let state = sim.plant.states[s];
            let k = sole.vertices.len();
            // An imposed state ends by the clock.
            let asked = !sim.is_imposed(s);
            for (i, v) in sole.vertices.iter().enumerate() {
                if !state.clamps(i, k) {
                    let depth = sim.tolerances.distance.max(-2.0 * v.height);
                    let item = if v.height > TOUCHING { Item::Height(s, i) } else { Item::Band(s, i, depth) };
                    self.items.extend(asked.then_some(item));
                } else if state.is_dynamic() && state.mode != Mode::Pivoting(i as u8) {
                    self.items.push(Item::Slide(s, i, 0.0));
                    if !sim.plant.floor.patches.is_empty() {
                        self.items.push(Item::Border(s, i, sim.plant.seen_from_above(s, i)));
                    }
                }
            }
            if asked && state != SoleState::FREE {
                self.items.push(Item::Normal(s));
                if state.mode != Mode::Sliding {
                    self.items.push(Item::Friction(s));
                }
            }
        }
    }

    /// Values at the plant's present evaluation.
    pub fn values(&self, sim: &mut Simulation, out: &mut Vec<f64>) {
        out.resize(self.items.len(), 0.0);
        self.fill(sim, out);
    }

    /// Stops watching what is negative already at the start of the step, and returns whether there is any. A vertex that
    /// slides backwards slower than `rest`, m/s, is watched until it reaches that speed: it has just been chosen to slip,
    /// from a speed of zero but for rounding, and choosing again would only put it back to rest.
    pub fn overlook(&mut self, start: &mut [f64], rest: f64) -> bool {
        for (i, (item, g)) in self.items.iter_mut().zip(start).enumerate().filter(|(_, (_, g))| **g < 0.0) {
            match item {
                Item::Slide(_, _, allowed) if *g > -rest => {
                    *allowed = rest;
                    *g += rest;
                }
                _ => {
                    self.overlooked.push(i);
                    *g = 1.0;
                }
            }
        }
        !self.overlooked.is_empty()
    }

    /// As [`values`](Self::values), into a slice of the right length.
    pub fn fill(&self, sim: &mut Simulation, out: &mut [f64]) {
        let tol = sim.tolerances;
        let plant = &mut sim.plant;
        plant.share_forces();
        let p = &plant.problem;
        let mut margins = [None; MAX_SOLES];
        let mut of = |s: usize| *margins[s].get_or_insert_with(|| margin(p, &plant.states, s, &plant.solution));
        for (item, g) in self.items.iter().zip(out.iter_mut()) {
            *g = match *item {
                Item::Height(s, i) => p.soles[s].vertices[i].height,
                Item::Band(s, i, depth) => {
                    let v = &p.soles[s].vertices[i];
                    (v.height + depth).min(v.velocity.z + tol.velocity)
                }
                Item::Surface(s, i, inside) => {
                    let height = p.soles[s].vertices[i].height;
                    penalty::SURFACE + if inside { -height } else { height }
                }
                Item::Normal(s) => of(s).normal,
                Item::Friction(s) => of(s).friction,
                Item::Slide(s, i, allowed) => {
                    p.soles[s].vertices[i].velocity.xy().dot(&plant.directions[s][i]) + allowed
                }
                Item::Border(s, i, _) => plant.border(s, i),
            };
        }
        self.overlooked.iter().for_each(|&i| out[i] = 1.0);
    }

    /// Has a sliding vertex gone over a border and back within the step that ends at the plant's present evaluation? Then
    /// returns the part of the step after which it is likely to be beyond the border.
    pub fn passed_over(&self, sim: &Simulation, values: &[f64]) -> Option<f64> {
        let plant = &sim.plant;
        let part = self.items.iter().zip(values).filter_map(|(item, g)| match item {
            Item::Border(s, i, from) if *g >= 0.0 => {
                plant.floor.strays(plant.zone(*s, *i), from, &plant.seen_from_above(*s, *i))
            }
            _ => None,
        });
        part.min_by(f64::total_cmp)
    }

    /// Marks the soles whose load reached its limit, from values of which some are negative.
    pub fn suspects(&self, values: &[f64], suspect: &mut [u8; MAX_SOLES]) {
        suspect.fill(0);
        let fired = |kind: fn(&Item) -> bool| self.items.iter().zip(values).any(|(item, g)| kind(item) && *g < 0.0);
        // Several soles may reach their limit together, and rounding decides which of them is seen to.
        let normal = if fired(|i| matches!(i, Item::Normal(_))) { CLEAR } else { 0.0 };
        let friction = if fired(|i| matches!(i, Item::Friction(_))) { CLEAR } else { 0.0 };
        for (item, g) in self.items.iter().zip(values) {
            match *item {
                Item::Normal(s) if *g < normal => suspect[s] |= SUSPECT_NORMAL,
                Item::Friction(s) if *g < friction => suspect[s] |= SUSPECT_FRICTION,
                _ => {}
            }
        }
    }

    /// Has an unclamped vertex in the tolerance band begun to accelerate into the floor by more than a_t?
    pub fn tolerated_too_much(&self, sim: &Simulation) -> bool {
        let tol = &sim.tolerances;
        let p = &sim.plant.problem;
        p.soles.iter().enumerate().any(|(s, sole)| {
            let k = sole.vertices.len();
            sole.vertices.iter().enumerate().any(|(i, v)| {
                !sim.is_imposed(s)
                    && !sim.plant.states[s].clamps(i, k)
                    && v.height <= tol.distance
                    && v.velocity.z.abs() <= tol.velocity
                    && p.vertex_motion(&sim.plant.solution.motion, s, i).z < -tol.acceleration
            })
        })
    }
}
