//! Bodies in files: their import options, and their true sizes (m).

/// A body in its file, and its expected properties.
pub(crate) struct Body {
    pub(crate) file: &'static str,
    pub(crate) flags: &'static [&'static str],
    pub(crate) triangles: u64,
    pub(crate) size: [f64; 3],
    pub(crate) looks: &'static str,
}

/// Of `tests/data`.
pub(crate) const SHIPPED: [Body; 2] = [
    Body {
        file: "hatchback.obj",
        flags: &["--unit", "inch", "--up", "z", "--forward", "-y", "--kind", "sedan"],
        triangles: 788,
        size: [4.00, 2.14, 1.57],
        looks: "a car",
    },
    Body {
        // COLLADA states unit and up axis.
        file: "jersey_barrier.dae",
        flags: &["--kind", "wall", "--build", "sah"],
        triangles: 430,
        size: [4.07, 0.81, 1.14],
        looks: "a wall or barrier",
    },
];

/// Third-party: vehicles and persons, each as its own kind.
pub(crate) const BODIES: [Body; 10] = [
    Body {
        file: "chrono_sedan/sedan_chassis_vis.obj",
        flags: &["--kind", "sedan"],
        triangles: 39_170,
        size: [4.89, 1.85, 1.47],
        looks: "a car",
    },
    Body {
        file: "chrono_nissan_patrol_suv/suv_chassis.obj",
        flags: &["--kind", "suv", "--build", "sah"],
        triangles: 23_002,
        size: [5.33, 2.24, 1.91],
        looks: "a car",
    },
    Body {
        file: "chrono_man10t_truck/MAN_10t_chassis.obj",
        flags: &["--kind", "truck"],
        triangles: 13_462,
        size: [9.72, 2.47, 2.59],
        looks: "a truck or bus",
    },
    Body {
        file: "openmaterial_human/human_example.gltf",
        flags: &["--up", "y", "--forward", "x", "--kind", "pedestrian"],
        triangles: 46_496,
        size: [0.37, 1.09, 1.78],
        looks: "a person",
    },
    Body {
        file: "makehuman_base/base.obj",
        flags: &[
            "--unit",
            "dm",
            "--up",
            "y",
            "--forward",
            "z",
            "--only",
            "body",
            "--kind",
            "pedestrian",
        ],
        triangles: 26_756,
        size: [0.42, 0.99, 1.67],
        looks: "a person",
    },
    Body {
        // Toy scale: 2.44 m long as it is, 2.09 m as a motorcycle.
        file: "kenney_trucks/vehicle-motorcycle.glb",
        flags: &["--unit", "0.86", "--kind", "motorcycle", "--leaf-size", "1"],
        triangles: 960,
        size: [2.09, 0.94, 1.09],
        looks: "a motorcycle or bicycle",
    },
    Body {
        file: "gazebo_hatchback/hatchback.obj",
        flags: &["--unit", "inch", "--up", "z", "--forward", "-y", "--kind", "sedan"],
        triangles: 788,
        size: [4.00, 2.14, 1.57],
        looks: "a car",
    },
    Body {
        file: "osrf_prius/hybrid_body.obj",
        flags: &["--unit", "cm", "--up", "z", "--forward", "-y", "--kind", "sedan"],
        triangles: 1_676,
        size: [4.62, 2.01, 1.39],
        looks: "a car",
    },
    Body {
        // COLLADA states unit and up axis.
        file: "gazebo_jersey_barrier/jersey_barrier.dae",
        flags: &["--kind", "wall"],
        triangles: 430,
        size: [4.07, 0.81, 1.14],
        looks: "a wall or barrier",
    },
    Body {
        // Toy scale: 2.9 m long as it is.
        file: "kenney_trucks/vehicle-truck-green.glb",
        flags: &["--unit", "2", "--kind", "truck"],
        triangles: 1_094,
        size: [5.81, 3.00, 2.80],
        looks: "a truck or bus",
    },
];

/// Bodies that do not look like their stated kind: wheels and the like, which have files of their
/// own, and a lamp post with an arm, in inches and at the scale of 3 that another file applies. And
/// a pick-up: COLLADA states unit and up axis. File, flags, size.
pub(crate) const ODD: [(&str, &str, [f64; 3]); 10] = [
    ("chrono_sedan/sedan_rim.obj", "--unit m", [0.41, 0.20, 0.41]),
    ("chrono_sedan/sedan_tire.obj", "--unit m", [0.68, 0.20, 0.68]),
    ("chrono_nissan_patrol_suv/suv_rim.obj", "--unit m", [0.51, 0.02, 0.51]),
    ("chrono_nissan_patrol_suv/suv_tire.obj", "--unit m", [0.88, 0.31, 0.88]),
    ("chrono_man10t_truck/MAN_rim.obj", "--unit m", [0.56, 0.30, 0.56]),
    ("chrono_man10t_truck/MAN_tire.obj", "--unit m", [1.26, 0.35, 1.26]),
    ("osrf_prius/wheel.obj", "--unit cm --forward -y", [0.61, 0.27, 0.61]),
    ("osrf_prius/steering_wheel.obj", "--unit cm --forward -y", [0.13, 0.36, 0.35]),
    ("gazebo_pickup/pickup.dae", "--forward y", [5.66, 2.47, 1.87]),
    ("gazebo_lamp_post/lamp_post.dae", "--unit 0.0762", [0.49, 3.18, 9.27]),
];
