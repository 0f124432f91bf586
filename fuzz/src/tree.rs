//! The repository's robots and folders, in which the fuzzed files are placed.

use std::cell::RefCell;
use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};
use std::rc::Rc;

use stiction::robot::{self, InertiaPolicy, Robot};
use stiction::scenario::{self, InertiaSpec, Run};

/// The repository's root folder.
pub fn root() -> &'static Path {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    if here.join("robots").is_dir() { here } else { here.parent().unwrap_or(here) }
}

/// Robots by file and inertia policy; `None` if the file is not a valid robot.
type Loaded = HashMap<(PathBuf, Option<InertiaPolicy>), Option<Rc<Robot>>>;

thread_local! {
    static LOADED: RefCell<Loaded> = RefCell::default();
}

/// The robot of a run, if it is one of the repository's; loaded once.
pub fn robot(run: &Run) -> Option<Rc<Robot>> {
    let policy = run.scenario.robot.inertia.map(|word| match word {
        InertiaSpec::Refuse => InertiaPolicy::Refuse,
        InertiaSpec::Repair => InertiaPolicy::Repair,
    });
    let path = plain(&run.resolve(&run.scenario.robot.model));
    let own = ["robots", "scenarios"].iter().any(|folder| path.starts_with(root().join(folder)));
    if !own || !path.is_file() {
        return None;
    }
    let load = || robot::load_with(&path, policy).ok().map(Rc::new);
    LOADED.with(|loaded| loaded.borrow_mut().entry((path.clone(), policy)).or_insert_with(load).clone())
}

/// The path without `.` and `..`.
fn plain(path: &Path) -> PathBuf {
    path.components().fold(PathBuf::new(), |mut plain, part| {
        match part {
            Component::CurDir => {}
            Component::ParentDir => {
                plain.pop();
            }
            part => plain.push(part),
        }
        plain
    })
}

/// The only run of a scenario placed in the repository's scenario folder.
pub fn run(text: &str) -> Run {
    let file = scenario::parse(&root().join("scenarios/fuzzed.toml"), text).expect("a sound scenario");
    let expansion = file.expansion(&[], 1).expect("no sweep");
    let mut only = None;
    expansion.check(&mut |run| only = Some(run)).expect("nothing wrong");
    only.expect("a run")
}
