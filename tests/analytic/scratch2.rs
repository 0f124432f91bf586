use stiction::contact::{candidate::*, judge::*, problem::*, select::*, state::*};
use nalgebra::Vector3;
#[test]
fn scratch2() {
    let Ok(f) = std::env::var("PROB") else { return };
    let d: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(f).unwrap()).unwrap();
    let num = |x: &serde_json::Value| x.as_f64().unwrap();
    let v3 = |x: &serde_json::Value| Vector3::new(num(&x[0]), num(&x[1]), num(&x[2]));
    let soles = d["soles"].as_array().unwrap();
    let mut p = Problem::new(&soles.iter().map(|s| s.as_array().unwrap().len()).collect::<Vec<_>>());
    p.w = d["w"].as_array().unwrap().iter().map(num).collect();
    p.b = d["b"].as_array().unwrap().iter().map(num).collect();
    p.scale = 70.0;
    for (s, js) in p.soles.iter_mut().zip(soles) {
        for (v, j) in s.vertices.iter_mut().zip(js.as_array().unwrap()) {
            v.r = v3(&j["r"]); v.height = num(&j["h"]); v.velocity = v3(&j["v"]); v.bias = v3(&j["bias"]); v.mu_s = num(&j["mu_s"]); v.mu_k = num(&j["mu_k"]);
            v.moving = v.velocity.xy().norm() > 1e-7;
            v.moving &= v.velocity.z.abs() <= 1e-7 || v.velocity.xy().norm() > 0.1;
            if v.moving { v.direction = v.velocity.xy().normalize(); }
        }
        s.radius = s.vertices.iter().map(|v| v.r.norm()).fold(0.0, f64::max);
    }
    let mut prev = States::default();
    prev[0] = SoleState::fixed(Pattern::Vertex(1)); prev[1] = SoleState::fixed(Pattern::Vertex(1));
    let mut suspect = [0; MAX_SOLES]; suspect[1] = 2;
    let rules = Rules { tolerances: Tolerances::default(), previous: prev, suspect };
    let mut sel = Selector::new(&p); let mut sol = Solution::new(&p);
    for m0 in [Mode::Static, Mode::Sliding] { for m in [Mode::Static, Mode::Sliding] {
        let mut st = prev; st[1].mode = m; st[0].mode = m0;
        let v = sel.test(&mut p, &st, &rules, &mut sol);
        println!("{m0:?} {m:?} {:?} faults {:?} N {:?} t {:?} motion {:?}", v.levels, &v.faults[..2], sol.normal, sol.tangent, sol.motion);
        for s in 0..2 { println!("   margin {:?}", margin(&p, s, st[s], &sol)); for i in 0..4 { println!("    {:?} an {:?} moving {}", p.soles[s].vertices[i].direction.as_slice(), p.vertex_motion(&sol.motion, s, i).as_slice(), p.soles[s].vertices[i].moving); } }
    } }
}
