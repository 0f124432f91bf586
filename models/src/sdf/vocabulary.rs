//! Elements of SDFormat, those read and those without effect here, by the element that holds them.

/// Elements that one element may hold.
pub(super) struct Vocabulary {
    pub tag: &'static str,
    /// Elements that are read.
    pub read: &'static [&'static str],
    /// Elements of the format without effect here.
    pub ignored: &'static [&'static str],
}

const fn of(tag: &'static str, read: &'static [&'static str], ignored: &'static [&'static str]) -> Vocabulary {
    Vocabulary { tag, read, ignored }
}

pub(super) const VOCABULARY: &[Vocabulary] = &[
    of("sdf", &["model", "world"], &["light", "actor"]),
    of(
        "world",
        &["gravity", "model", "include", "frame"],
        &[
            "name",
            "audio",
            "wind",
            "magnetic_field",
            "atmosphere",
            "gui",
            "physics",
            "scene",
            "light",
            "actor",
            "plugin",
            "road",
            "spherical_coordinates",
            "state",
            "population",
            "joint",
        ],
    ),
    of("include", &["uri", "name", "pose", "static", "placement_frame"], &["plugin"]),
    of(
        "model",
        &["static", "pose", "frame", "link", "joint", "model", "include"],
        &["self_collide", "allow_auto_disable", "enable_wind", "plugin", "gripper"],
    ),
    of("frame", &["pose"], &[]),
    of(
        "link",
        &["pose", "inertial", "collision", "visual", "sensor"],
        &[
            "gravity",
            "enable_wind",
            "self_collide",
            "kinematic",
            "must_be_base_link",
            "velocity_decay",
            "projector",
            "audio_sink",
            "audio_source",
            "battery",
            "light",
            "particle_emitter",
        ],
    ),
    of("inertial", &["pose", "mass", "inertia"], &["density", "auto_inertia_params", "fluid_added_mass", "frame"]),
    of("inertia", &["ixx", "ixy", "ixz", "iyy", "iyz", "izz"], &[]),
    of(
        "collision",
        &["pose", "geometry", "surface"],
        &["laser_retro", "max_contacts", "density", "auto_inertia_params"],
    ),
    of(
        "visual",
        &["pose", "geometry", "material"],
        &["cast_shadows", "laser_retro", "transparency", "visibility_flags", "meta", "plugin"],
    ),
    of("surface", &["friction"], &["bounce", "contact", "soft_contact"]),
    of("friction", &["ode"], &["torsional", "bullet"]),
    of("ode", &["mu", "mu2"], &["fdir1", "slip1", "slip2"]),
    of("joint", &["pose", "parent", "child", "axis", "axis2", "sensor"], &["physics"]),
    of("axis", &["xyz", "use_parent_model_frame", "dynamics", "limit", "mimic"], &["initial_position"]),
    of("dynamics", &["damping", "friction", "spring_stiffness", "spring_reference"], &[]),
    of("limit", &["lower", "upper", "effort", "velocity"], &["stiffness", "dissipation"]),
    of("mimic", &["multiplier", "offset", "reference"], &[]),
];

/// Elements of joints whose type is not available.
pub(super) const OF_OTHER_JOINTS: &[&str] =
    &["gearbox_ratio", "gearbox_reference_body", "thread_pitch", "screw_thread_pitch"];
