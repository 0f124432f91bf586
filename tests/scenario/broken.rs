//! Broken scenarios: each is refused at its line and column with its message. All are in one long
//! table.

use stiction::scenario::{Severity, load};

use super::{SMALLEST, file, wrong};

/// A scenario with one error: text, its line and column, part of the message, part of the help.
struct Broken(&'static str, (usize, usize), &'static str, &'static str);

/// Each text follows the two lines of the smallest scenario, so it begins at line 3 inside
/// `[robot]`.
const BELOW_ROBOT: &[Broken] = &[
    // Keys.
    Broken("postur = { knee = 1 }", (3, 1), "unknown key `postur` in `robot`", "did you mean `posture`?"),
    Broken("base = { rp = [0, 0, 0] }", (3, 10), "unknown key `rp` in `robot.base`", "`rpy`"),
    Broken("[flor]\nheight = 1", (3, 2), "unknown key `flor`", "did you mean `floor`?"),
    Broken("[floor]\ncolour = 1", (4, 1), "unknown key `colour` in `floor`", "known here: `friction`, `height`"),
    Broken("[[task]]\ntype = \"posture\"\njoint = { knee = 1 }", (5, 1), "unknown key `joint` in `task.0`", "`joints`"),
    Broken("soles = [{ name = \"l\", polygon = [[0, 0, 0]] }]", (3, 10), "`robot.soles.0` lacks the key `link`", ""),
    Broken("[[task]]\ntype = \"posture\"", (3, 1), "`task.0` lacks the key `joints`", ""),
    Broken("[[task]]\nstart = 1", (3, 1), "`task.0` lacks the key `type`", "types: posture,"),
    // Types.
    Broken("[floor]\nheight = \"low\"", (4, 10), "`floor.height` must be a number, not the string \"low\"", ""),
    Broken("[floor]\nfriction = [1, 2]", (4, 12), "must be a number or `{ static, kinetic }`, not an array", ""),
    Broken("[floor]\nrpy = [0, 0]", (4, 7), "must be an array of length 3, not of length 2", ""),
    Broken("[floor]\nrpy = [0, 0, 0, 0]", (4, 7), "must be an array of length 3, not of length 4", ""),
    Broken("[floor]\nrpy = [0, \"30 dge\", 0]", (4, 11), "`floor.rpy.1` must be a finite number of radians", ""),
    Broken("posture = { knee = true }", (3, 20), "`robot.posture.knee` must be", ""),
    Broken("[task]\ntype = \"posture\"", (3, 1), "`task` must be an array of tables", "[[task]]"),
    Broken("[contact]\nmethod = 3", (4, 10), "must be \"exact\" or \"one-step\" or \"penalty\"", ""),
    Broken("[[force]]\ntype = 7", (4, 8), "`force.0.type` must be a string", ""),
    Broken(
        "[floor]\nfriction = { static = 1, kinetic = \"é\", x = 1 }",
        (4, 36),
        "`floor.friction.kinetic` must be",
        "",
    ),
    Broken("payload = 3", (3, 11), "`robot.payload` must be an array, not the number 3", ""),
    // Names of choices.
    Broken("[contact]\nmethod = \"exakt\"", (4, 10), "`contact.method` cannot be \"exakt\"", "did you mean `exact`?"),
    Broken("[log]\ntopics = [\"state\", \"scenes\"]", (4, 20), "`log.topics.1`", "did you mean `scene`?"),
    Broken("[[task]]\ntype = \"posutre\"", (4, 8), "unknown task type `posutre`", "did you mean `posture`?"),
    Broken("[[force]]\ntype = \"psh\"", (4, 8), "unknown force type `psh`", "did you mean `push`?"),
    Broken("[[expect]]\nmetric = \"final_bas_x\"\nmin = 0", (4, 10), "numeric column", "`final_base_x`"),
    Broken("[[expect]]\noutcome = \"falen\"", (4, 11), "`expect.0.outcome` cannot be", "did you mean `fallen`?"),
    Broken("[contact]\nforced = [{ sole = \"l\", state = \"flat\" }]", (4, 33), "`contact.forced.0.state`", "`face`"),
    // Ranges.
    Broken("[floor]\nfriction = -0.1", (4, 12), "`floor.friction` must be 0 or greater, not -0.1", ""),
    Broken("[floor]\nfriction = { static = 0.5, kinetic = 0.6 }", (4, 38), "greater than `static` = 0.5", ""),
    Broken(
        "[floor]\nfriction = { static = 0.5, kinetic = 0.5, viscous = -0.1 }",
        (4, 53),
        "`floor.friction.viscous` must be 0 or greater, not -0.1",
        "",
    ),
    Broken(
        "[floor]\nfriction = { static = 0.5, kinetic = 0.5, torsional = nan }",
        (4, 55),
        "every number must be finite",
        "",
    ),
    Broken(
        "[floor]\nfriction = { static = 0.5, kinetic = 0.5, rolling = \"1 mm\" }",
        (4, 53),
        "`floor.friction.rolling` must be",
        "",
    ),
    Broken(
        "[floor]\nfriction = { static = 0.5, kinetic = 0.5, roling = 0.1 }",
        (4, 43),
        "unknown key `roling`",
        "rolling",
    ),
    Broken("[contact]\ndistance_tolerance = 0", (4, 22), "must be greater than 0", ""),
    Broken("[contact]\nrestitution = 1.5", (4, 15), "must be between 0 and 1", ""),
    Broken("[contact.penalty]\nstiffness = 0", (4, 13), "`contact.penalty.stiffness` must be greater than 0", ""),
    Broken("[contact.penalty]\nstifness = 1", (4, 1), "unknown key `stifness` in `contact.penalty`", "`stiffness`"),
    Broken("[contact.exact]\nsearch = \"fast\"", (4, 10), "`contact.exact.search` cannot be \"fast\"", "`paper`"),
    Broken("[contact.lcp]\nfacets = 5", (4, 10), "`contact.lcp.facets` must be an even number from 4 to 64, not 5", ""),
    Broken("[contact.lcp]\nfacets = 2", (4, 10), "an even number from 4 to 64, not 2", ""),
    Broken("[contact.lcp]\nfacets = 66", (4, 10), "an even number from 4 to 64, not 66", ""),
    Broken("[contact.lcp]\nfacets = 8.5", (4, 10), "`contact.lcp.facets` must be a whole number", ""),
    Broken("[contact.lcp]\nfacet = 8", (4, 1), "unknown key `facet` in `contact.lcp`", "did you mean `facets`?"),
    Broken("[contact.ncp]\niterations = 0", (4, 14), "`contact.ncp.iterations` must be at least 1, not 0", ""),
    Broken("[contact.ncp]\ntolerance = 0", (4, 13), "`contact.ncp.tolerance` must be greater than 0", ""),
    Broken(
        "[contact]\nforced = [{ sole = \"l\", state = \"free\", from = 2, to = 1 }]",
        (4, 56),
        "after `from` = 2",
        "",
    ),
    Broken("[integrator]\nstep = -1e-3", (4, 8), "must be greater than 0, not -0.001", ""),
    Broken("[log]\nrate = -1", (4, 8), "must be 0 or greater", ""),
    Broken("[control]\nrate = 0", (4, 8), "must be greater than 0", ""),
    Broken("[floor]\nheight = nan", (4, 10), "every number must be finite", ""),
    Broken("[floor]\nrpy = [0, -inf, 0]", (4, 11), "every number must be finite", ""),
    Broken("[floor]\nheight = 1e999", (4, 10), "every number must be finite", ""),
    Broken("[[force]]\ntype = \"push\"\nlink = \"l\"\nforce = [1, 0, 0]\nduration = 0", (7, 12), "greater than 0", ""),
    Broken("payload = [{ link = \"l\", mass = 0 }]", (3, 33), "`robot.payload.0.mass` must be greater", ""),
    Broken(
        "payload = [{ link = \"l\", mass = 1, inertia = [1, 1, 3, 0, 0, 0] }]",
        (3, 46),
        "is not the inertia of a rigid body",
        "",
    ),
    // Inconsistent values.
    Broken("[[force]]\ntype = \"push\"\nlink = \"l\"", (3, 1), "`force.0` needs `force` or `moment`", ""),
    Broken("[[force]]\ntype = \"joint-friction\"", (3, 1), "`force.0` needs `all`", ""),
    Broken("[[expect]]\nmetric = \"steps\"", (3, 1), "`expect.0` needs `value` and `tolerance`", ""),
    Broken("[[expect]]\nmetric = \"steps\"\nvalue = 1", (3, 1), "lacks the key `tolerance`", ""),
    Broken("[[expect]]\nvalue = 1\ntolerance = 1", (3, 1), "lacks the key `metric`", ""),
    Broken("[[expect]]\nmetric = \"steps\"\nmin = 2\nmax = 1", (6, 7), "smaller than `min` = 2", ""),
    Broken("[[expect]]\nmetric = \"steps\"\nmin = 2\noutcome = \"fallen\"", (3, 1), "either `metric` or `outcome`", ""),
    Broken(
        "soles = [{ name = \"a\", link = \"l\", polygon = [[0,0,0]] }, { name = \"a\", link = \"m\", polygon = [[0,0,0]] }]",
        (3, 68),
        "the name of two soles",
        "",
    ),
    // Known, but not available.
    Broken("[sensors]\ngyroscope = { noise = -1 }", (4, 23), "must be 0 or greater, not -1", ""),
    Broken("[sensors]\ngyro = {}", (4, 1), "unknown key `gyro` in `sensors`", "`gyroscope`"),
    Broken("[sensors]\nsole_force = { delay = 11 }", (4, 24), "must be at most 10 s, not 11", ""),
    Broken("[control]\nkinematic = { threshold = 2 }", (4, 27), "between 0 and 1, not 2", ""),
    // Other forces.
    Broken("[[force]]\ntype = \"drag\"\nlink = \"a\"", (3, 1), "`force.0` needs `linear` or `quadratic`", ""),
    Broken(
        "[[force]]\ntype = \"drag\"\nlinear = 1\npoint = [0, 0, 0]",
        (6, 9),
        "`force.0.point` needs `link`: without it the drag acts on every link",
        "",
    ),
    Broken(
        "[[force]]\ntype = \"random-pushes\"\nlinks = [\"a\"]\nmagnitude = [1, 2]",
        (3, 1),
        "`force.0` needs either `number` or `rate`",
        "",
    ),
    Broken(
        "[[force]]\ntype = \"random-pushes\"\nlinks = []\nmagnitude = [1, 2]\nrate = 1",
        (5, 9),
        "`force.0.links` must name at least one link",
        "",
    ),
    Broken(
        "[[force]]\ntype = \"random-pushes\"\nlinks = [\"a\"]\nmagnitude = [3, 2]\nrate = 1",
        (6, 13),
        "`force.0.magnitude` must be [least, greatest], 0 or greater and in order, not [3, 2]",
        "",
    ),
    Broken(
        "[[force]]\ntype = \"random-pushes\"\nlinks = [\"a\"]\nmagnitude = [1, 2]\nrate = 1\nprofile = \"ramp\"",
        (8, 11),
        "`force.0.profile` cannot be \"ramp\", which has no end",
        "",
    ),
    Broken(
        "[[force]]\ntype = \"carried-object\"\nlink = \"a\"\nmass = 1\ninertia = [1, 1, 3, 0, 0, 0]",
        (7, 11),
        "`force.0.inertia` is not the inertia of a rigid body",
        "",
    ),
    // Terrain.
    Broken("[floor]\nplane = 0", (4, 9), "`floor.plane` must be", ""),
    Broken("[[object]]\ntype = \"ball\"", (4, 8), "unknown object type `ball`", ""),
    Broken(
        "[[object]]\ntype = \"sphere\"\nradius = 0\nmass = 1",
        (5, 10),
        "`object.0.radius` must be greater than 0, not 0",
        "",
    ),
    Broken(
        "[[object]]\ntype = \"cylinder\"\nradius = 1\nlength = -0.2\nmass = 1",
        (6, 10),
        "`object.0.length` must be greater than 0, not -0.2",
        "",
    ),
    Broken(
        "[[object]]\ntype = \"cylinder\"\nradius = 1e-9\nlength = 1\nmass = 1",
        (5, 10),
        "`object.0.radius` must be from 0.000001 to 1000000 m, not 0.000000001",
        "",
    ),
    Broken(
        "[[object]]\ntype = \"box\"\nsize = [1, 1, 1e7]\nmass = 1",
        (5, 15),
        "`object.0.size.2` must be from 0.000001 to 1000000 m, not 10000000",
        "",
    ),
    Broken(
        "[[object]]\ntype = \"box\"\nsize = [1, 1, 1]\nmass = 1e12",
        (6, 8),
        "`object.0.mass` must be from 0.000000001 to 1000000000 kg, not 1000000000000",
        "",
    ),
    Broken("[[object]]\ntype = \"model\"", (3, 1), "`object.0` lacks the key `model`", ""),
    Broken("[[object]]\ntype = \"model\"\nmodel = \"\"", (5, 9), "`object.0.model` must name a file", ""),
    Broken(
        "[[object]]\ntype = \"model\"\nmodel = \"a.urdf\"\nservo = [{ stiffness = 0 }]",
        (6, 24),
        "`object.0.servo.0.stiffness` must be greater than 0, not 0",
        "",
    ),
    Broken(
        "[[object]]\ntype = \"model\"\nmodel = \"a.urdf\"\nservo = [{ stiffness = 1, kd = 2 }]",
        (6, 27),
        "unknown key `kd` in `object.0.servo.0`",
        "`joints`, `stiffness`, `damping`",
    ),
    Broken(
        "[[object]]\ntype = \"model\"\nmodel = \"a.urdf\"\nposture = { hinge = \"30 grad\" }",
        (6, 21),
        "`object.0.posture.hinge`",
        "",
    ),
    Broken(
        "[[object]]\ntype = \"model\"\nmodel = \"a.urdf\"\nmass = 2",
        (6, 1),
        "unknown key `mass` in `object.0`",
        "",
    ),
    Broken(
        "[[object]]\ntype = \"mesh\"\nfile = \"broken.rs\"\nmass = 1",
        (5, 8),
        "`object.0.file` must name a file that ends in `.stl` or `.obj` or `.dae`, not \"broken.rs\"",
        "",
    ),
    Broken(
        "[[object]]\ntype = \"mesh\"\nfile = \"stone.obj\"\nmass = 1\nscale = -1",
        (7, 9),
        "`object.0.scale` must be greater than 0, not -1",
        "",
    ),
    Broken(
        "[[force]]\ntype = \"carried-object\"\nobject = \"a\"\nmass = 1",
        (5, 1),
        "unknown key `object` in `force.0`",
        "",
    ),
    Broken("[[force]]\ntype = \"push\"\nforce = [1, 0, 0]", (3, 1), "`force.0` needs `link` or `end_effector`", ""),
    Broken(
        "[[force]]\ntype = \"random-pushes\"\nmagnitude = [1, 2]\nrate = 1",
        (3, 1),
        "`force.0.links` must name at least one link",
        "",
    ),
    Broken(
        "self_contact = true\ncontact = \"soles\"",
        (3, 16),
        "`robot.self_contact` requires `robot.contact = \"bodies\"`",
        "",
    ),
    Broken("[[contact.pair]]\nfriction = 0.5", (3, 1), "`contact.pair.0` lacks the key `bodies`", ""),
    Broken("[[contact.pair]]\nbodies = [\"box\"]", (4, 10), "must be an array of length 2, not of length 1", ""),
    Broken(
        "[[contact.pair]]\nbodies = [\"a\", \"b\"]\nfriction = { static = 0.1, kinetic = 0.2 }",
        (5, 38),
        "`contact.pair.0.friction.kinetic` must not be greater",
        "",
    ),
    Broken("[[terrain]]\ntype = \"stair\"", (4, 8), "unknown terrain type `stair`", "did you mean `stairs`?"),
    Broken(
        "[[terrain]]\nsize = [1, 1, 1]",
        (3, 1),
        "`terrain.0` lacks the key `type`",
        "box, ramp, stairs, heightfield",
    ),
    Broken("[[terrain]]\ntype = \"box\"", (3, 1), "`terrain.0` lacks the key `size`", ""),
    Broken(
        "[[terrain]]\ntype = \"box\"\nsize = [1, 0, 1]",
        (5, 12),
        "`terrain.0.size.1` must be from 0.000001 to 1000000 m, not 0",
        "",
    ),
    Broken(
        "[[terrain]]\ntype = \"ramp\"\nsize = [1, 1, 1e7]",
        (5, 15),
        "`terrain.0.size.2` must be from 0.000001 to 1000000 m, not 10000000",
        "",
    ),
    Broken(
        "[[terrain]]\ntype = \"box\"\nsize = [1, 1, 1]\nposition = [0, -1e7, 0]",
        (6, 16),
        "`terrain.0.position.1` must be within 1000000 m, not -10000000",
        "",
    ),
    Broken(
        "[[terrain]]\ntype = \"box\"\nsize = [1, 1, 1]\nfriction = { static = 0.1, kinetic = 0.2 }",
        (6, 38),
        "`terrain.0.friction.kinetic` must not be greater than `static` = 0.1, not 0.2",
        "",
    ),
    Broken(
        "[[terrain]]\ntype = \"box\"\nsize = [1, 1, 1]\nname = \"\"",
        (6, 8),
        "`terrain.0.name` must not be empty",
        "",
    ),
    Broken(
        "[[terrain]]\ntype = \"box\"\nsize = [1, 1, 1]\nname = \"terrain.1\"\n[[terrain]]\ntype = \"box\"\nsize = [1, 1, 1]",
        (6, 8),
        "`terrain.0.name` \"terrain.1\" is the name of two entries",
        "",
    ),
    Broken(
        "[[terrain]]\ntype = \"stairs\"\nsteps = 1001\nrise = 0.1\nrun = 0.3\nwidth = 1",
        (5, 9),
        "`terrain.0.steps` must be at most 1000, not 1001",
        "",
    ),
    Broken(
        "[[terrain]]\ntype = \"stairs\"\nsteps = 0\nrise = 0.1\nrun = 0.3\nwidth = 1",
        (5, 9),
        "`terrain.0.steps` must be at least 1, not 0",
        "",
    ),
    Broken(
        "[[terrain]]\ntype = \"stairs\"\nsteps = 3\nrise = 0.1\nrun = 1e-9\nwidth = 1",
        (7, 7),
        "`terrain.0.run` must be from 0.000001 to 1000000 m, not 0.000000001",
        "",
    ),
    Broken(
        "[[terrain]]\ntype = \"stairs\"\nsteps = 3\nrise = 0.1\nrun = 0.3\nwidth = 1\nlanding = -1",
        (9, 11),
        "`terrain.0.landing` must be 0 or greater, not -1",
        "",
    ),
    Broken(
        "[[terrain]]\ntype = \"heightfield\"\nfile = \"h.txt\"\nspacing = 0.1",
        (5, 8),
        "`terrain.0.file` must name a file that ends in `.csv` or `.png`, not \"h.txt\"",
        "",
    ),
    Broken(
        "[[terrain]]\ntype = \"heightfield\"\nspacing = 1",
        (3, 1),
        "`terrain.0` needs either `file` or `heights`",
        "",
    ),
    Broken(
        "[[terrain]]\ntype = \"heightfield\"\nfile = \"h.csv\"",
        (3, 1),
        "`terrain.0` needs either `size` or `spacing`",
        "",
    ),
    Broken(
        "[[terrain]]\ntype = \"heightfield\"\nfile = \"h.csv\"\nspacing = 0.1\nheight = [0, 1]",
        (7, 10),
        "`terrain.0.height` has no meaning with a table",
        "",
    ),
    Broken(
        "[[terrain]]\ntype = \"heightfield\"\nfile = \"h.png\"\nspacing = 0.1\nheight = [0, 1]\nscale = 2",
        (8, 9),
        "`terrain.0.scale` has no meaning with a picture",
        "",
    ),
    Broken(
        "[[terrain]]\ntype = \"heightfield\"\nfile = \"h.png\"\nspacing = 0.1",
        (3, 1),
        "`terrain.0` needs `height` for a picture",
        "",
    ),
    Broken(
        "[[terrain]]\ntype = \"heightfield\"\nfile = \"h.png\"\nspacing = 0.1\nheight = [1, 1]",
        (7, 10),
        "`terrain.0.height` must be [height of black, height of white] in order, not [1, 1]",
        "",
    ),
    Broken(
        "[[terrain]]\ntype = \"mesh\"\nfile = \"m.ply\"",
        (5, 8),
        "`terrain.0.file` must name a file that ends in `.stl` or `.obj` or `.dae`, not \"m.ply\"",
        "",
    ),
    Broken(
        "[[terrain]]\ntype = \"mesh\"\nfile = \"m.stl\"\nas = \"hull\"",
        (6, 6),
        "`terrain.0.as` cannot be \"hull\"",
        "`convex`",
    ),
    Broken(
        "[[terrain]]\ntype = \"mesh\"\nfile = \"m.stl\"\nas = \"convex\"\ndepth = 0.1",
        (7, 9),
        "`terrain.0.depth` has no meaning with `as = \"convex\"`",
        "",
    ),
    Broken(
        "[[terrain]]\ntype = \"mesh\"\nfile = \"m.stl\"\nscale = 0",
        (6, 9),
        "`terrain.0.scale` must be greater than 0, not 0",
        "",
    ),
    Broken("[[terrain]]\ntype = \"mesh\"\nfile = \"none.stl\"", (5, 8), "cannot read scenarios/none.stl", ""),
    Broken("[[terrain]]\ntype = \"mesh\"\nfile = \"../src/x.stl\"", (5, 8), "cannot read scenarios/../src/x.stl", ""),
    Broken(
        "[[terrain]]\ntype = \"box\"\nsize = [1, 1, 1]\n[[event]]\nat = 1\nset = { \"terrain.0.position\" = [0, 0, 1] }",
        (8, 9),
        "`terrain.0.position` cannot change during a run",
        "",
    ),
    // Tasks that plan.
    Broken("[[task]]\ntype = \"squat\"", (3, 1), "`task.0` lacks the key `depth`", ""),
    Broken("[[task]]\ntype = \"squat\"\ndepth = 0.1\nperiod = 0", (6, 10), "must be greater than 0, not 0", ""),
    Broken("[[task]]\ntype = \"squat\"\ndepth = 0.1\nrepetitions = 0", (6, 15), "must be at least 1, not 0", ""),
    Broken("[[task]]\ntype = \"walk\"\nstep = 6", (5, 1), "unknown key `step` in `task.0`", "`steps`"),
    Broken("[[task]]\ntype = \"walk\"\nsteps = 2.5", (5, 9), "`task.0.steps` must be a whole number", ""),
    Broken(
        "[[task]]\ntype = \"walk\"\nstep_time = 0.5\ndouble_support = 0.5",
        (6, 18),
        "`task.0.double_support` must be less than `step_time` = 0.5, not 0.5",
        "",
    ),
    Broken("[[task]]\ntype = \"walk\"\ncom_height = -1", (5, 14), "must be greater than 0, not -1", ""),
    Broken(
        "[[task]]\ntype = \"balance\"\ncontrol = \"position\"\nposition = { leaning = -1 }",
        (6, 24),
        "must be 0 or greater, not -1",
        "",
    ),
    Broken(
        "[[task]]\ntype = \"balance\"\ncontrol = \"position\"\nposition = { mobility = { knee = -1 } }",
        (6, 34),
        "`task.0.position.mobility.knee` must be 0 or greater, not -1",
        "",
    ),
    // Springs.
    Broken("[[force]]\ntype = \"spring\"\nlink = \"a\"", (3, 1), "`force.0` lacks the key `stiffness`", ""),
    Broken(
        "[[force]]\ntype = \"spring\"\nlink = \"a\"\nstiffness = -1",
        (6, 13),
        "`force.0.stiffness` must be 0 or greater, not -1",
        "",
    ),
    Broken(
        "[[force]]\ntype = \"spring\"\nlink = \"a\"\nstiffness = 1\nanchor = { velocity = [0, 0, 0], sine = { amplitude = [1, 0, 0], frequency = 1 } }",
        (7, 10),
        "`force.0.anchor` must move in one way",
        "",
    ),
    Broken(
        "[[force]]\ntype = \"spring\"\nlink = \"a\"\nstiffness = 1\nanchor = { waypoints = [{ at = 1, position = [0, 0, 0] }, { at = 1, position = [1, 0, 0] }] }",
        (7, 66),
        "`force.0.anchor.waypoints.1.at` must be after the previous waypoint, at 1, not 1",
        "",
    ),
    Broken(
        "[[force]]\ntype = \"spring\"\nlink = \"a\"\nstiffness = 1\nanchor = { position = [0, 0, 0], waypoints = [{ at = 1, position = [0, 0, 0] }] }",
        (7, 23),
        "`force.0.anchor.position` has no meaning with `waypoints`",
        "",
    ),
    Broken("[self_collision]\nmethod = 5", (4, 10), "must be from 0 to 4, not 5", ""),
    Broken("[self_collision]\nrate = 0", (4, 8), "must be greater than 0", ""),
    Broken("[self_collision]\nmargin = -0.001", (4, 10), "must be 0 or greater, not -0.001", ""),
    Broken("[self_collision]\nmax_jerk = inf", (4, 12), "finite", ""),
    Broken("[self_collision]\nmetod = 1", (4, 1), "unknown key `metod`", "did you mean `method`?"),
    // Comparisons.
    Broken("[compare]", (3, 1), "`compare` needs `reference`, `truth` or `timing_repeats`", ""),
    Broken("[compare]\nreference = { a = 1 }", (4, 15), "unknown key `a`", "known here"),
    Broken("[compare]\nreferenc = {}", (4, 1), "unknown key `referenc` in `compare`", "did you mean `reference`?"),
    Broken("[compare]\nreference = 3", (4, 13), "`compare.reference` must be a table, not the number 3", ""),
    Broken("[compare]\nreference = { \"contact.metod\" = \"exact\" }", (4, 24), "unknown key `metod`", "`method`"),
    Broken(
        "[compare]\nreference = { \"contact.method\" = \"exakt\" }",
        (4, 34),
        "`contact.method` cannot be \"exakt\"",
        "did you mean `exact`?",
    ),
    Broken("[compare]\nreference = { \"integrator.step\" = -1 }", (4, 35), "must be greater than 0, not -1", ""),
    Broken("[compare]\nreference = { \"force.0.force\" = 1 }", (4, 16), "the file has no `force`", ""),
    Broken("[compare]\nreference = { \"log.rate\" = 1 }", (4, 15), "`log` cannot be set in a reference run", ""),
    Broken(
        "[compare]\nreference = { contact.method = \"exact\" }",
        (4, 15),
        "`contact` cannot be replaced as a whole in a reference",
        "\"contact.method\" = ...",
    ),
    Broken(
        "[compare]\nreference = { \"floor.friction\" = 1, \"floor.friction.static\" = 1 }",
        (4, 37),
        "`floor.friction.static` overlaps another key of the reference",
        "",
    ),
    Broken("[compare]\nreference = { \"a b\" = 1 }", (4, 15), "is not a dotted path", ""),
    Broken("[compare]\ntiming_repeats = 0", (4, 18), "`compare.timing_repeats` must be at least 1, not 0", ""),
    Broken("[compare]\ntiming_repeats = 1.5", (4, 18), "must be a whole number", ""),
    Broken("[compare]\ntruth = { final_base_q = 1 }", (4, 11), "cannot have the key `final_base_q`", "`final_base_"),
    Broken("[compare]\ntruth = { wall_s = 1 }", (4, 11), "no measured column of the summary", ""),
    Broken("[compare]\ntruth = { final_base_x = \"1\" }", (4, 26), "`compare.truth.final_base_x` must be a number", ""),
    Broken(
        "[[expect]]\nmetric = \"error_final_base_x\"\nmax = 1\n[compare]\ntruth = { final_base_y = 0 }",
        (4, 10),
        "`expect.0.metric` names `error_final_base_x`, which requires a truth",
        "",
    ),
    Broken(
        "[[expect]]\nmetric = \"error_position_rms_m\"\nmax = 1\n[compare]\ntiming_repeats = 1",
        (4, 10),
        "`expect.0.metric` names `error_position_rms_m`, which requires a reference run",
        "",
    ),
    Broken(
        "[sweep.grid]\n\"floor.rpy.0\" = [0.1, 0.2]",
        (4, 8),
        "there is no `floor.rpy.0`: the file has no `floor.rpy`",
        "",
    ),
    // Events.
    Broken("[[event]]\nat = 1", (3, 1), "`event.0` needs `set`, `end_tasks`, `save` or `restore`", ""),
    Broken("[[event]]\nat = 1\nend_tasks = [0]", (5, 14), "names task 0, but there are none", ""),
    Broken("[[event]]\nat = -1\nsave = \"a\"", (4, 6), "`event.0.at` must be 0 or greater, not -1", ""),
    Broken(
        "[[event]]\nat = 1\nset = { \"contact.method\" = \"ncp\" }",
        (5, 9),
        "`contact.method` cannot change during a run",
        "\"floor.friction\"",
    ),
    Broken("[[event]]\nat = 1\nset = { \"floor.frction\" = 1 }", (5, 9), "cannot change", "\"floor.friction\""),
    Broken(
        "[[event]]\nat = 1\nset = { floor.friction = 1 }",
        (5, 9),
        "`floor` cannot be set as a whole by an event",
        "\"floor.friction\" = ...",
    ),
    Broken("[[event]]\nat = 1\nset = { \"floor.friction\" = -1 }", (5, 28), "must be 0 or greater, not -1", ""),
    Broken(
        "[[event]]\nat = 1\nset = { \"floor.friction\" = 0.5 }\n[[event]]\nat = 2\nset = { \"floor.friction.kinetic\" = 1 }",
        (8, 25),
        "`floor.friction` is the number 0.5 and has no `kinetic`",
        "set the whole: \"floor.friction\" = ...",
    ),
    Broken(
        "[[event]]\nat = 1\nset = { \"floor.friction.kinetic\" = 0.1 }",
        (5, 9),
        "the file has no `floor.friction`",
        "set the whole: \"floor.friction\" = ...",
    ),
    Broken("[[event]]\nat = 1\nset = { \"gravity.2\" = -1 }", (5, 9), "the file has no `gravity`", "\"gravity\" = ..."),
    Broken(
        "[[event]]\nat = 1\nset = { \"robot.joint.a.friction.viscous\" = 1 }",
        (5, 9),
        "the file has no `robot.joint.a.friction`",
        "\"robot.joint.a.friction\" = ...",
    ),
    Broken("[[event]]\nat = 1\nsave = \"\"", (5, 8), "`event.0.save` must be a name", ""),
    Broken(
        "[[event]]\nat = 1\nset = { \"floor.friction\" = 0.5, \"floor.friction.kinetic\" = 0.2 }",
        (5, 33),
        "`floor.friction.kinetic` overlaps another key of the event",
        "",
    ),
    Broken("[[event]]\nat = 1\nset = { \"robot.joint.a.kq\" = 1 }", (5, 9), "cannot change", "kp"),
    Broken("[[event]]\nat = 1\nset = { \"robot.joint.a.kp\" = -1 }", (5, 30), "must be 0 or greater, not -1", ""),
    Broken("[[event]]\nat = 1\nset = { \"robot.joint.a.mode\" = \"force\" }", (5, 9), "cannot change", ""),
    Broken("[[event]]\nat = 1\nset = { \"force.0.force\" = [1, 0, 0] }", (5, 10), "the file has no `force`", ""),
    Broken("[[event]]\nat = 1\nset = { \"force.0.type\" = \"ramp\" }", (5, 9), "cannot change", ""),
    Broken(
        "[[event]]\nat = 1\nset = { \"robot.payload\" = [{ link = \"a\", mass = 0 }] }",
        (5, 49),
        "must be greater than 0, not 0",
        "",
    ),
    Broken("[[event]]\nat = 1\nrestore = \"a\"", (5, 11), "names `a`, which no earlier event saves", ""),
    Broken(
        "[[event]]\nat = 1\nrestore = \"a\"\n[[event]]\nat = 1\nsave = \"a\"",
        (5, 11),
        "names `a`, which no earlier event saves",
        "",
    ),
    // Patches of the floor.
    Broken("[floor]\npatches = [{ polygon = [], friction = 1 }]", (4, 24), "at least 3 corners, not 0", ""),
    Broken(
        "[floor]\npatches = [{ polygon = [[0, 0], [1], [1, 1]], friction = 1 }]",
        (4, 33),
        "`floor.patches.0.polygon.1` must be `[x, y]` or `[x, y, z]`, not an array of length 1",
        "",
    ),
    Broken(
        "[floor]\npatches = [{ polygon = [[0, 0], [1, 0, 0], [1, 1, 0, 0]], friction = 1 }]",
        (4, 44),
        "not an array of length 4",
        "",
    ),
    Broken(
        "[floor]\npatches = [{ polygon = [[0, 0], [1, 1], [1, 0], [0, 1]], friction = 1 }]",
        (4, 24),
        "crosses or touches itself: edge 0 (from corner 0 to 1) and edge 2",
        "",
    ),
    Broken(
        "[floor]\npatches = [{ polygon = [[0, 0], [1, 0], [1, 1], [1, 0]], friction = 1 }]",
        (4, 49),
        "`floor.patches.0.polygon.3` is the same point as corner 1",
        "",
    ),
    Broken(
        "[floor]\npatches = [{ polygon = [[0, 0], [1, nan], [1, 1]], friction = 1 }]",
        (4, 37),
        "every number must be finite",
        "",
    ),
    Broken(
        "[floor]\npatches = [{ polygon = [[0, 0], [1, 0], [1, 1]], friction = -1 }]",
        (4, 61),
        "must be 0 or greater, not -1",
        "",
    ),
    Broken(
        "[floor]\npatches = [{ polygon = [[0, 0], [1, 0], [1, 1]], friction = { static = 1, kinetic = 2 } }]",
        (4, 85),
        "greater than `static` = 1",
        "",
    ),
    Broken("[floor]\npatches = [{ polygon = [[0, 0], [1, 0], [1, 1]] }]", (4, 12), "lacks the key `friction`", ""),
    Broken(
        "[sweep]\nzip = [{ \"seed\" = [1, 2], \"duration\" = [1, 2, 3] }]",
        (4, 27),
        "`duration` has 3 values, but `seed` of the same table has 2",
        "`seed` is at scenarios/test.toml:4:10",
    ),
    Broken(
        "[sweep]\nzip = [{ \"seed\" = [1, 2] }, { \"duration\" = [1, 2, 3], \"seed\" = [1, 2, 3] }]",
        (4, 55),
        "`seed` is swept already by `seed` at scenarios/test.toml:4:10",
        "",
    ),
    Broken("[sweep]\ngrid = { \"seed\" = [1, 2] }\nzip = [{ \"seed\" = [1, 2] }]", (5, 10), "swept already", ""),
    Broken(
        "[sweep]\nzip = [{ \"seed\" = [1, 2], \"durtion\" = [1, 2] }]",
        (4, 28),
        "unknown key `durtion`",
        "`duration`",
    ),
    Broken("[sweep]\nzip = [{ \"seed\" = [1], \"expect.0.value\" = [1] }]", (4, 25), "the file has no `expect`", ""),
    Broken("[sweep]\nzip = [{}]", (4, 7), "at least one key in every table", ""),
    Broken("[sweep]\nzip = [{ \"seed\" = 3 }]", (4, 19), "an array of values", ""),
    Broken(
        "[sweep]\nzip = [{ \"seed\" = [1, 1], \"duration\" = [2, 2] }]",
        (4, 23),
        "the combination of values 1, 2 occurs twice",
        "",
    ),
    Broken("[sweep]\nzip = [{ \"sweep.repeat\" = [1, 2] }]", (4, 10), "cannot be swept", ""),
    Broken("[[expect]]\nmetric = \"error_joint_rms_rad\"\nmax = 1", (4, 10), "requires a reference run", ""),
    // Sweeps.
    Broken("[sweep]\ngrid = { \"contact.metod\" = [\"exact\"] }", (4, 19), "unknown key `metod`", "`method`"),
    Broken(
        "[sweep]\ngrid = { \"control.estimator\" = [\"truth\", \"inertal\"] }",
        (4, 42),
        "`control.estimator` cannot be \"inertal\"",
        "did you mean `inertial`?",
    ),
    Broken("[sweep]\ngrid = { \"floor.friction\" = [0.1, -1] }", (4, 35), "must be 0 or greater", ""),
    Broken("[sweep]\ngrid = { \"force.0.force\" = [[1, 0, 0]] }", (4, 11), "the file has no `force`", ""),
    Broken("[sweep]\ngrid = { \"floor.height.x\" = [1] }\n[floor]\nheight = 1", (4, 24), "has no `x`", ""),
    Broken("[sweep]\ngrid = { \"floor height\" = [1] }", (4, 10), "is not a dotted path", ""),
    Broken("[sweep]\ngrid = { \"seed\" = {linspce = [1, 2, 3] } }", (4, 19), "`linspce`", "did you mean `linspace`?"),
    Broken("[sweep]\ngrid = { \"seed\" = [] }", (4, 19), "at least one value", ""),
    Broken("[sweep]\ngrid = { \"seed\" = { step = [0, 1, -1] } }", (4, 19), "a step that leads from 0 to 1", ""),
    Broken("[sweep]\ngrid = { \"seed\" = { logspace = [0, 1, 3] } }", (4, 19), "ends of one sign", ""),
    Broken(
        "[sweep]\ngrid = { \"floor.height\" = { step = [0, 1, 1e-5] } }",
        (4, 1),
        "100001 runs, 10000 are allowed",
        "",
    ),
    Broken("[sweep]\ngrid = { \"seed\" = [1, 2, 1] }", (4, 26), "has the value 1 twice", ""),
    Broken(
        "[sweep]\ngrid = { \"floor.friction\" = [1], \"floor.friction.static\" = [1] }",
        (4, 34),
        "is swept already",
        "",
    ),
    Broken("[sweep]\nrepeat = 0", (4, 10), "must be at least 1", ""),
    // Claims.
    Broken("[claim]\nname = \"c\"", (3, 1), "`claim` must be an array of tables", "[[claim]]"),
    Broken("[[claim]]\nshare = { outcome = \"passed\" }\nat_least = 0.9", (3, 1), "`claim.0` lacks the key `name`", ""),
    Broken(
        "[[claim]]\nname = \" \"\nshare = { outcome = \"passed\" }\nat_least = 0.9",
        (4, 8),
        "must not be empty",
        "",
    ),
    Broken("[[claim]]\nname = \"c\"\nat_least = 0.9", (3, 1), "`claim.0` lacks the key `share` (or", ""),
    Broken(
        "[[claim]]\nname = \"c\"\nchange = \"impcts\"\nat_most = 0",
        (5, 10),
        "names no numeric column",
        "`impacts`",
    ),
    Broken(
        "[[claim]]\nname = \"c\"\nchange = \"impacts\"\nat_most = 0\nearly = true",
        (7, 9),
        "`claim.0.early` must not be given together with `change`",
        "",
    ),
    Broken(
        "[[claim]]\nname = \"c\"\nchange = \"impacts\"\nmetric = \"impacts\"\nat_most = 0",
        (6, 10),
        "`claim.0.metric` must not be given together with `change`",
        "",
    ),
    Broken(
        "[[claim]]\nname = \"c\"\nchange = \"impacts\"\nshare = { metric = \"impacts\", max = 1 }\nat_least = 0.5",
        (6, 20),
        "`claim.0.share.metric` must not be given: the limits are of the change of `impacts`",
        "",
    ),
    Broken(
        "[[claim]]\nname = \"c\"\nchange = \"impacts\"\nshare = { max = 1 }\nquantile = 0.5\nat_least = 0.5",
        (7, 12),
        "`claim.0.quantile` must not be given together with `share`",
        "",
    ),
    Broken(
        "[[claim]]\nname = \"c\"\nchange = \"impacts\"\nshare = { value = 1 }\nat_least = 0.5",
        (6, 9),
        "`claim.0.share` has `value` and lacks the key `tolerance`",
        "",
    ),
    Broken("[[claim]]\nname = \"c\"\nshare = { outcome = \"passed\" }", (3, 1), "lacks the key `at_least` (or", ""),
    Broken("[[claim]]\nname = \"c\"\nshar = 1", (5, 1), "unknown key `shar` in `claim.0`", "`share`"),
    Broken(
        "[[claim]]\nname = \"c\"\nshare = { outcome = \"pased\" }\nat_least = 0.9",
        (5, 21),
        "`claim.0.share.outcome` cannot be \"pased\"",
        "`passed`",
    ),
    Broken(
        "[[claim]]\nname = \"c\"\nshare = { metric = \"impcts\", max = 1 }\nat_least = 0.9",
        (5, 20),
        "numeric column of the summary: `impcts`",
        "`impacts`",
    ),
    Broken(
        "[[claim]]\nname = \"c\"\nshare = { metric = \"impacts\" }\nat_least = 0.9",
        (5, 9),
        "`claim.0.share` needs `value` and `tolerance`",
        "",
    ),
    Broken(
        "[[claim]]\nname = \"c\"\nshare = { metric = \"error_impacts\", max = 1 }\nat_least = 0.9",
        (5, 20),
        "requires a truth",
        "",
    ),
    Broken(
        "[[claim]]\nname = \"c\"\nshare = { outcome = \"passed\" }\nat_least = 99",
        (6, 12),
        "`claim.0.at_least` must be greater than 0 and less than 1, not 99",
        "",
    ),
    Broken(
        "[[claim]]\nname = \"c\"\nshare = { outcome = \"passed\" }\nat_least = 1",
        (6, 12),
        "no number of runs shows a share of exactly 1",
        "",
    ),
    Broken(
        "[[claim]]\nname = \"c\"\nshare = { outcome = \"passed\" }\nat_least = 0.9\nat_most = 0.95",
        (7, 11),
        "must not be given together with `at_least`",
        "",
    ),
    Broken(
        "[[claim]]\nname = \"c\"\nshare = { outcome = \"passed\" }\nat_least = 0.9\nconfidence = 95",
        (7, 14),
        "must be greater than 0.5 and less than 1, not 95",
        "",
    ),
    Broken(
        "[[claim]]\nname = \"c\"\nshare = { outcome = \"passed\" }\nquantile = 0.5\nat_least = 0.9",
        (6, 12),
        "must not be given together with `share`",
        "",
    ),
    Broken(
        "[[claim]]\nname = \"c\"\nmetric = \"impacts\"\nat_most = 3",
        (3, 1),
        "has `metric` and lacks the key `quantile`",
        "",
    ),
    Broken(
        "[[claim]]\nname = \"c\"\nquantile = 0.5\nat_most = 3",
        (3, 1),
        "has `quantile` and lacks the key `metric`",
        "",
    ),
    Broken(
        "[[claim]]\nname = \"c\"\nquantile = 1.5\nmetric = \"impacts\"\nat_most = 3",
        (5, 12),
        "`claim.0.quantile` must be greater than 0 and less than 1, not 1.5",
        "",
    ),
    Broken(
        "[[claim]]\nname = \"c\"\ndifference = \"impacts\"\nat_most = 3",
        (3, 1),
        "has `difference` and lacks the key `between`",
        "",
    ),
    Broken(
        "[[claim]]\nname = \"c\"\nquantile = 0.5\nmetric = \"impacts\"\nbetween = { seed = [1, 2] }\nat_most = 3",
        (7, 11),
        "requires `difference`",
        "",
    ),
    Broken(
        "[[claim]]\nname = \"c\"\ndifference = \"impacts\"\nbetween = { seed = [1, 2, 3] }\nat_most = 3",
        (6, 11),
        "must have two values of its key, not 3",
        "",
    ),
    Broken(
        "[[claim]]\nname = \"c\"\ndifference = \"impacts\"\nbetween = { seed = [1, 2], duration = [1, 2] }\nat_most = 3",
        (6, 11),
        "must have one key, not 2",
        "",
    ),
    Broken(
        "[[claim]]\nname = \"c\"\ndifference = \"impacts\"\nbetween = { seed = [1, 2] }\nat_most = 3",
        (6, 11),
        "names `seed`, which is not swept",
        "no `[sweep]` with keys",
    ),
    Broken(
        "[[claim]]\nname = \"c\"\ndifference = \"impacts\"\nbetween = { seed = [1, 3] }\nat_most = 3\n[sweep]\ngrid = { seed = [1, 2] }",
        (6, 11),
        "has the value 3, which `seed` does not take: 1, 2",
        "",
    ),
    Broken(
        "[[claim]]\nname = \"c\"\ndifference = \"impacts\"\nbetween = { seed = [2, 2] }\nat_most = 3\n[sweep]\ngrid = { seed = [1, 2] }",
        (6, 11),
        "has the same value twice",
        "",
    ),
    Broken(
        "[[claim]]\nname = \"c\"\ndifference = \"impacts\"\nbetween = { seed = [1, 2] }\nat_most = 3\nper = [\"seed\"]\n[sweep]\ngrid = { seed = [1, 2] }",
        (8, 8),
        "must not change together with `seed`",
        "",
    ),
    Broken(
        "[[claim]]\nname = \"c\"\nshare = { outcome = \"passed\" }\nat_least = 0.9\nper = [\"floor.frction\"]\n[sweep]\ngrid = { \"floor.friction\" = [0.1, 0.2] }",
        (7, 8),
        "`claim.0.per.0` names `floor.frction`, which is not swept",
        "`floor.friction`",
    ),
    Broken(
        "[[claim]]\nname = \"c\"\nshare = { outcome = \"passed\" }\nat_least = 0.9\n[[claim]]\nname = \"c\"\nshare = { outcome = \"passed\" }\nat_least = 0.8",
        (8, 8),
        "is the name of two claims: `c`",
        "",
    ),
    Broken(
        "[[claim]]\nname = \"c\"\nshare = { outcome = \"passed\" }\nat_least = 0.9\n[sweep]\ngrid = { \"claim.0.at_least\" = [0.1, 0.2] }",
        (8, 10),
        "cannot be swept: a claim is about all runs",
        "",
    ),
    // Lists of a sweep.
    Broken("[sweep]\nlist = { seed = 1 }", (4, 8), "`sweep.list` must be an array, not a table", ""),
    Broken("[sweep]\nlist = [3]", (4, 9), "`sweep.list.0` must be a table, not the number 3", ""),
    Broken(
        "[sweep]\nlist = [{ \"contact.metod\" = \"exact\" }]",
        (4, 20),
        "unknown key `metod` in `contact`",
        "`method`",
    ),
    Broken(
        "[sweep]\nlist = [{ seed = 1 }, { durtion = 2 }]",
        (4, 25),
        "unknown key `durtion`",
        "the file itself has no `durtion`",
    ),
    Broken(
        "[sweep]\nlist = [{ duration = \"long\" }]",
        (4, 22),
        "`duration` must be a number, not the string",
        "the file itself has no `duration`",
    ),
    Broken(
        "[sweep]\nlist = [{ \"floor.height\" = true }]\n[floor]\nheight = 2",
        (4, 28),
        "`floor.height` must be",
        "`floor.height` is at scenarios/test.toml:6:1",
    ),
    Broken(
        "[sweep]\nlist = [{ seed = 2.5 }]",
        (4, 18),
        "`seed` must be a whole number that is not negative, not the number 2.5",
        "",
    ),
    Broken(
        "[sweep]\nlist = [{ floor.friction = 0.1 }]",
        (4, 11),
        "`floor` would be replaced as a whole",
        "in quotes: \"floor.KEY\"",
    ),
    Broken(
        "[sweep]\nlist = [{ \"force.0.force\" = [1, 0, 0] }]",
        (4, 12),
        "the file has no `force`",
        "the file itself has no `force`",
    ),
    Broken(
        "[sweep]\nlist = [{ \"force.1.force\" = [1, 0, 0] }]\n[[force]]\ntype = \"push\"\nlink = \"l\"\nforce = [1, 0, 0]",
        (4, 18),
        "there is no `force.1`: `force` has 1 entry",
        "`force` is at scenarios/test.toml:5:3",
    ),
    Broken(
        "[sweep]\nlist = [{ \"force.0.force.3\" = 1 }]\n[[force]]\ntype = \"push\"\nlink = \"l\"\nforce = [1, 0, 0]",
        (4, 26),
        "there is no `force.0.force.3`",
        "`force.0.force` is at scenarios/test.toml:8:1",
    ),
    Broken("[sweep]\nlist = [{ \"sweep.repeat\" = 2 }]", (4, 11), "`sweep.repeat` cannot be swept", ""),
    Broken("[sweep]\nlist = [{ \"floor..height\" = 2 }]", (4, 11), "is not a dotted path", ""),
    Broken(
        "[sweep]\nlist = [{ duration = 1 }, { duration = 2 }, { duration = 1 }]",
        (4, 45),
        "table 2 of `list` gives the same values as one before it",
        "",
    ),
    Broken("[sweep]\nlist = [{}, {}]", (4, 13), "table 1 of `list` gives the same values", ""),
    Broken(
        "[sweep]\nlist = [{ \"floor.friction\" = 1, \"floor.friction.static\" = 1 }]",
        (4, 33),
        "`floor.friction.static` is swept already by `floor.friction` at scenarios/test.toml:4:11",
        "",
    ),
    Broken(
        "[sweep]\nlist = [{ seed = 1 }]\ngrid = { seed = [1, 2] }",
        (5, 10),
        "`seed` is swept already by `seed` at scenarios/test.toml:4:11",
        "",
    ),
    Broken(
        "[sweep]\nrepeat = 2\nlist = [{ seed = 1 }, { seed = 5 }]",
        (5, 11),
        "`seed` cannot be swept together with `repeat`",
        "",
    ),
    Broken("[sweep]\nlist = [{ \"contact.method\" = \"exactly\" }]", (4, 30), "`contact.method` cannot be", ""),
    // Random samples.
    Broken(
        "[sweep]\nrandom = 3",
        (4, 10),
        "`sweep.random` must be a table of `samples`, `sampling` and distributions by path, not the number 3",
        "",
    ),
    Broken(
        "[sweep]\nrandom = { duration = { uniform = [1, 2] } }",
        (4, 10),
        "`sweep.random` lacks the key `samples`",
        "",
    ),
    Broken(
        "[sweep]\nrandom = { samples = 4 }",
        (4, 10),
        "`sweep.random` must have at least one key to draw",
        "uniform",
    ),
    Broken(
        "[sweep]\nrandom = { samples = 0, duration = { uniform = [1, 2] } }",
        (4, 22),
        "`sweep.random.samples` must be at least 1, not 0",
        "",
    ),
    Broken(
        "[sweep]\nrandom = { samples = 2.5, duration = { uniform = [1, 2] } }",
        (4, 22),
        "`sweep.random.samples` must be a whole number",
        "",
    ),
    Broken(
        "[sweep]\nrandom = { sample = 4, duration = { uniform = [1, 2] } }",
        (4, 12),
        "unknown key `sample` in `sweep.random`",
        "did you mean `samples`?",
    ),
    Broken(
        "[sweep]\nrandom = { samples = 4, sampling = \"latin\", duration = { uniform = [1, 2] } }",
        (4, 36),
        "`sweep.random.sampling` cannot be \"latin\"",
        "`lhs`",
    ),
    Broken(
        "[sweep]\nrandom = { samples = 4, duration = [1, 2] }",
        (4, 36),
        "`sweep.random.duration` must be one of `{ uniform = [a, b] }`",
        "",
    ),
    Broken(
        "[sweep]\nrandom = { samples = 4, duration = { unifrom = [1, 2] } }",
        (4, 36),
        "`sweep.random.duration` cannot have the key `unifrom`",
        "did you mean `uniform`?",
    ),
    Broken(
        "[sweep]\nrandom = { samples = 4, floor.height = { uniform = [1, 2] } }",
        (4, 25),
        "`sweep.random.floor` cannot have the key `height`",
        "a path is written as one key in quotes",
    ),
    Broken(
        "[sweep]\nrandom = { samples = 4, duration = {} }",
        (4, 36),
        "must have one of the keys `uniform`, `log-uniform`, `normal`, `integer`, `choice`",
        "",
    ),
    Broken(
        "[sweep]\nrandom = { samples = 4, duration = { uniform = [1, 2], normal = [1, 2] } }",
        (4, 36),
        "must have only one of the keys",
        "",
    ),
    Broken(
        "[sweep]\nrandom = { samples = 4, duration = { uniform = [2, 1] } }",
        (4, 36),
        "must have ends of which the second is greater, not 2 and 1",
        "",
    ),
    Broken(
        "[sweep]\nrandom = { samples = 4, duration = { uniform = [1, 2, 3] } }",
        (4, 48),
        "`sweep.random.duration.uniform` must be an array of length 2, not of length 3",
        "",
    ),
    Broken(
        "[sweep]\nrandom = { samples = 4, duration = { log-uniform = [0, 1] } }",
        (4, 36),
        "must have ends above 0 of which the second is greater, not 0 and 1",
        "",
    ),
    Broken(
        "[sweep]\nrandom = { samples = 4, duration = { normal = [1, 0] } }",
        (4, 36),
        "must have a standard deviation greater than 0, not 0",
        "",
    ),
    Broken(
        "[sweep]\nrandom = { samples = 4, seed = { integer = [1, 1] } }",
        (4, 32),
        "must have whole ends of which the second is greater",
        "",
    ),
    Broken(
        "[sweep]\nrandom = { samples = 4, seed = { integer = [0.5, 3] } }",
        (4, 45),
        "`sweep.random.seed.integer.0` must be a whole number, not the number 0.5",
        "",
    ),
    Broken(
        "[sweep]\nrandom = { samples = 4, duration = { choice = [1] } }",
        (4, 36),
        "must have at least 2 values to choose from, not 1",
        "",
    ),
    Broken(
        "[sweep]\nrandom = { samples = 4, seed = { uniform = [1, 20] } }",
        (4, 32),
        "`seed` must be a whole number that is not negative, not the number",
        "the file itself has no `seed`",
    ),
    Broken(
        "[sweep]\nrandom = { samples = 4, \"contact.method\" = { uniform = [0, 1] } }\n[contact]\nmethod = \"exact\"",
        (4, 44),
        "`contact.method` must be",
        "`contact.method` is at scenarios/test.toml:6:1",
    ),
    Broken(
        "[sweep]\nrandom = { samples = 9, \"floor.friction\" = { normal = [0, 1] } }",
        (4, 44),
        "`floor.friction` must be 0 or greater, not -",
        "the file itself has no `floor`",
    ),
    Broken(
        "[sweep]\nrandom = { samples = 4, \"floor.hight\" = { uniform = [0, 1] } }",
        (4, 32),
        "unknown key `hight` in `floor`",
        "did you mean `height`?; the file itself has no `floor`",
    ),
    Broken(
        "[sweep]\nrandom = { samples = 4, \"force.0.force.0\" = { uniform = [0, 1] } }",
        (4, 26),
        "the file has no `force`",
        "",
    ),
    Broken(
        "[sweep]\nrandom = { samples = 4, \"schema\" = { integer = [1, 2] } }",
        (4, 25),
        "`schema` cannot be swept",
        "",
    ),
    Broken(
        "[sweep]\nrandom = { samples = 9, \"contact.method\" = { choice = [\"exact\", \"one-step\"] } }",
        (4, 56),
        "is drawn twice",
        "`grid`",
    ),
    Broken(
        "[sweep]\nrandom = { samples = 20000, duration = { uniform = [1, 2] } }",
        (4, 1),
        "the sweep has 20000 runs, 10000 are allowed",
        "--max-runs",
    ),
    Broken(
        "[sweep]\ngrid = { seed = [1, 2] }\nrandom = { samples = 4, seed = { integer = [1, 9] } }",
        (5, 25),
        "`seed` is swept already by `seed` at scenarios/test.toml:4:10",
        "",
    ),
    // Swept values that do not fit, and paths that do not exist.
    Broken(
        "[sweep]\ngrid = { \"floor.friction\" = [0.1, \"x\"] }\n[floor]\nfriction = 0.5",
        (4, 35),
        "`floor.friction` must be",
        "`floor.friction` is at scenarios/test.toml:6:1",
    ),
    Broken(
        "[sweep]\nzip = [{ \"floor.height\" = [1, \"x\"], seed = [1, 2] }]\n[floor]\nheight = 0.5",
        (4, 31),
        "`floor.height` must be",
        "`floor.height` is at scenarios/test.toml:6:1",
    ),
    // TOML syntax.
    Broken("base = { rpy = [0, 0, 0 }", (3, 25), "", ""),
    Broken("[floor]\nheight = 1\nheight = 2", (5, 1), "duplicate key", ""),
    Broken("seed == 1", (3, 7), "", ""),
];

#[test]
fn each_error_is_shown_at_its_position() {
    for Broken(text, (line, column), message, help) in BELOW_ROBOT {
        let found = wrong(&format!("{SMALLEST}{text}\n"), &[]);
        let shown = found.to_string();
        let first = found.iter().next().unwrap();
        let place = first.position.expect("a place");
        assert_eq!((place.line, place.column), (*line, *column), "{shown}");
        assert!(first.message.contains(message), "{message:?} in\n{shown}");
        assert!(first.help.as_deref().unwrap_or_default().contains(help), "{help:?} in\n{shown}");
        assert_eq!(first.severity, Severity::Error);
        // The printed message names the same position and quotes the line.
        assert!(shown.contains(&format!("scenarios/test.toml:{line}:{column}")), "{shown}");
        let offending = text.lines().nth(line - 3).unwrap();
        assert!(shown.contains(offending.trim_end()), "{shown}");
        assert!(shown.contains('^'), "{shown}");
    }
}

#[test]
fn top_level_values_are_shown_where_they_are() {
    let table: &[(&str, usize, &str)] = &[
        ("duration = 0", 12, "`duration` must be greater than 0"),
        ("duration = inf", 12, "finite"),
        ("seed = -1", 8, "`seed` must be a whole number that is not negative"),
        ("seed = 1.5", 8, "`seed` must be a whole number"),
        ("seed = 99999999999999999999", 8, "too large"),
        ("gravity = [0, 0, \"g\"]", 18, "`gravity.2` must be a number"),
        ("schema = 2", 10, "schema = 2 is not a file format this program reads"),
        ("schema = \"1\"", 10, "`schema` must be 1"),
        ("description = 3", 15, "`description` must be a string"),
        ("robots = 3", 1, "unknown key `robots`"),
    ];
    for (text, column, message) in table {
        let found = wrong(&format!("\n{text}\n{SMALLEST}"), &[]);
        let first = found.iter().next().unwrap();
        assert_eq!(first.location(), format!("scenarios/test.toml:2:{column}"), "{found}");
        assert!(first.message.contains(message), "{found}");
    }
}

#[test]
fn a_scenario_needs_a_robot() {
    let found = wrong("duration = 1\n", &[]);
    assert_eq!(found.len(), 1);
    assert!(found.to_string().contains("lacks the table `[robot]`"), "{found}");
    let found = wrong("[robot]\nposture = {}\n", &[]);
    assert!(found.to_string().contains("`robot` lacks the key `model`"), "{found}");
    let found = wrong("[robot]\nmodel = \"\"\n", &[]);
    assert!(found.to_string().contains("`robot.model` must name a file"), "{found}");
    assert!(wrong("", &[]).to_string().contains("[robot]"));
}

#[test]
fn errors_of_several_sections_are_reported_together() {
    let text = "duraton = 1\n[robot]\nmodel = \"b\"\n[floor]\nheigt = 1\n[[task]]\ntype = \"balence\"\n[[task]]\ntype = \"posture\"\njoints = 1\n[log]\nrate = -1\n";
    let lines: Vec<_> = wrong(text, &[]).iter().map(|d| d.position.unwrap().line).collect();
    assert_eq!(lines, [1, 5, 7, 10, 12]);
}

#[test]
fn syntax_errors_are_reported_together() {
    let found = file("a = = 1\n[robot]\nmodel = \n[floor\n").unwrap_err();
    let lines: Vec<_> = found.iter().map(|d| d.position.unwrap().line).collect();
    assert!(lines.contains(&1) && lines.contains(&3) && lines.contains(&4), "{found}");
}

#[test]
fn another_format_version_hides_everything_else() {
    let found = file("schema = 2\nfuture = 1\n").unwrap_err();
    assert_eq!(found.len(), 1, "{found}");
    assert_eq!(found.0[0].help.as_deref(), Some("it reads schema = 1"));
}

#[test]
fn columns_count_characters_as_printed() {
    let found = wrong(&format!("{SMALLEST}joint = {{ \"knié\" = {{ kp = -1 }} }}\n"), &[]);
    assert_eq!(found.0[0].location(), "scenarios/test.toml:3:27");
    assert!(found.to_string().contains("scenarios/test.toml:3:27"), "{found}");
}

#[test]
fn lines_may_end_as_on_windows() {
    let text = format!("{SMALLEST}[floor]\nheight = \"x\"\n").replace('\n', "\r\n");
    assert_eq!(wrong(&text, &[]).0[0].location(), "scenarios/test.toml:4:10");
}

#[test]
fn files_that_cannot_be_read() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("missing.toml");
    let found = load(&missing).unwrap_err();
    assert!(found.to_string().contains("missing.toml"), "{found}");
    assert_eq!(found.0[0].position, None);

    let latin = folder.path().join("latin.toml");
    std::fs::write(&latin, b"[robot]\nmodel = \"caf\xe9\"\n").unwrap();
    let found = load(&latin).unwrap_err();
    assert!(found.0[0].location().ends_with("latin.toml:2:13"), "{found}");
}
