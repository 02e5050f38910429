//! Forward kinematics of a URDF, written after its specification in matrices of its own: no code is shared
//! with the import.
//!
//! `T(parent, child) = Translate(xyz) Rz(yaw) Ry(pitch) Rx(roll) Motion(q)`, the axis in the frame of the
//! child (joint frame).

use std::collections::BTreeMap;

pub(crate) type M4 = [[f64; 4]; 4];

pub(crate) const ONE: M4 = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

pub(crate) fn times(a: &M4, b: &M4) -> M4 {
    let mut c = [[0.0; 4]; 4];
    for i in 0..4 {
        for j in 0..4 {
            c[i][j] = (0..4).map(|k| a[i][k] * b[k][j]).sum();
        }
    }
    c
}

/// Inverse of a rigid motion.
pub(crate) fn undone(a: &M4) -> M4 {
    let mut c = ONE;
    for i in 0..3 {
        for j in 0..3 {
            c[i][j] = a[j][i];
        }
        c[i][3] = -(0..3).map(|k| a[k][i] * a[k][3]).sum::<f64>();
    }
    c
}

fn about(axis: usize, angle: f64) -> M4 {
    let (s, c) = angle.sin_cos();
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut m = ONE;
    (m[i][i], m[i][j], m[j][i], m[j][j]) = (c, -s, s, c);
    m
}

/// Turn about a unit vector, by bringing the vector onto z and back: two angles, no formula of Rodrigues.
fn about_vector(v: [f64; 3], angle: f64) -> M4 {
    let yaw = v[1].atan2(v[0]);
    let pitch = v[0].hypot(v[1]).atan2(v[2]);
    let onto = times(&about(2, yaw), &about(1, pitch));
    times(&onto, &times(&about(2, angle), &undone(&onto)))
}

#[derive(Clone, Debug)]
pub(crate) struct OracleJoint {
    pub(crate) name: String,
    pub(crate) kind: String,
    pub(crate) parent: String,
    pub(crate) child: String,
    pub(crate) xyz: [f64; 3],
    pub(crate) rpy: [f64; 3],
    pub(crate) axis: [f64; 3],
    pub(crate) limit: [f64; 2],
}

/// Joints of a file by their tags, for files without comments in tags.
pub(crate) fn joints(text: &str) -> Vec<OracleJoint> {
    let document = roxmltree::Document::parse(text).expect("XML");
    let three = |text: Option<&str>, or: [f64; 3]| {
        text.map_or(or, |t| {
            let v: Vec<f64> = t.split_whitespace().map(|w| w.parse().expect("number")).collect();
            [v[0], v[1], v[2]]
        })
    };
    let all = document.descendants().filter(|n| n.has_tag_name("joint"));
    all.map(|n| {
        let of = |tag: &str, key: &str| {
            n.children().find(|c| c.has_tag_name(tag)).and_then(|c| c.attribute(key)).map(str::to_owned)
        };
        let number = |key: &str| of("limit", key).map_or(0.0, |t| t.parse().expect("number"));
        OracleJoint {
            name: n.attribute("name").expect("name").into(),
            kind: n.attribute("type").expect("type").into(),
            parent: of("parent", "link").expect("parent"),
            child: of("child", "link").expect("child"),
            xyz: three(of("origin", "xyz").as_deref(), [0.0; 3]),
            rpy: three(of("origin", "rpy").as_deref(), [0.0; 3]),
            axis: three(of("axis", "xyz").as_deref(), [1.0, 0.0, 0.0]),
            limit: [number("lower"), number("upper")],
        }
    })
    .collect()
}

/// Pose of a link in the root, meter; joints that are not named are at zero.
pub(crate) fn root_from_link(joints: &[OracleJoint], link: &str, q: &BTreeMap<String, f64>) -> M4 {
    let Some(j) = joints.iter().find(|j| j.child == link) else { return ONE };
    let mut place = ONE;
    (0..3).for_each(|k| place[k][3] = j.xyz[k]);
    let turn = times(&about(2, j.rpy[2]), &times(&about(1, j.rpy[1]), &about(0, j.rpy[0])));
    let value = q.get(&j.name).copied().unwrap_or(0.0);
    let length = j.axis.iter().map(|v| v * v).sum::<f64>().sqrt();
    let unit = j.axis.map(|v| v / length);
    let motion = match j.kind.as_str() {
        "prismatic" => {
            let mut m = ONE;
            (0..3).for_each(|k| m[k][3] = unit[k] * value);
            m
        }
        "fixed" => ONE,
        _ => about_vector(unit, value),
    };
    times(&root_from_link(joints, &j.parent, q), &times(&place, &times(&turn, &motion)))
}
