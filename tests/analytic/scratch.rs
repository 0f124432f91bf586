use super::support::simulation;
use std::sync::atomic::AtomicBool;
use stiction::sim::*;
struct Print;
impl Observer for Print {
    fn snapshot(&mut self, s: &Snapshot) -> Result<(), String> {
        if std::env::var("SNAP").is_ok() {
            println!("t {:.4} base {:?} rpy {:?} v {:?} states {:?}", s.time, s.base_pose.translation.vector.as_slice(), s.base_pose.rotation.euler_angles(), s.base_linear_velocity.as_slice(), s.soles.iter().map(|x| x.state.as_str()).collect::<Vec<_>>());
        }
        Ok(())
    }
    fn event(&mut self, e: &SimEvent) -> Result<(), String> {
        println!("{:.12} {} {} {}", e.time, e.kind, e.subject, e.message);
        Ok(())
    }
}
#[test]
fn scratch() {
    let Ok(f) = std::env::var("SCN") else { return };
    let text = std::fs::read_to_string(f).unwrap();
    let mut sim = simulation(&text);
    let t = std::time::Instant::now();
    let (o, m) = sim.run(&mut Print, &AtomicBool::new(false));
    println!("{o:?} {m} {:?} wall {:?}", sim.metrics(), t.elapsed());
}
