//! Mesh files whose counts, nodes and indices are not what they say.

use crate::workshop::Workshop;

/// A glTF binary from its JSON and its binary chunk.
pub(crate) fn glb(json: &str, bin: &[u8]) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    while !json.len().is_multiple_of(4) {
        json.push(b' ');
    }
    let word = |n: usize| (n as u32).to_le_bytes();
    let mut file = b"glTF".to_vec();
    file.extend(word(2));
    file.extend(word(28 + json.len() + bin.len()));
    file.extend(word(json.len()));
    file.extend(b"JSON");
    file.extend(&json);
    file.extend(word(bin.len()));
    file.extend(b"BIN\0");
    file.extend(bin);
    file
}

fn refused(name: &str, bytes: &[u8], word: &str) {
    let shop = Workshop::new();
    shop.scene(&format!("[part]\nmesh = \"{name}\""));
    shop.write(name, bytes);
    shop.refused(&[name, word]);
}

/// One triangle; accessor and nodes as given.
fn one(nodes: &str, accessors: &str) -> Vec<u8> {
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":{nodes},
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],"accessors":{accessors},
        "bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":3}}],
        "buffers":[{{"byteLength":40}}]}}"#
    );
    glb(&json, &[0; 40])
}

/// A file in order: one triangle under the node 0.
pub(crate) fn triangle() -> Vec<u8> {
    one(r#"[{"mesh":0}]"#, GOOD)
}

const GOOD: &str = r#"[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},
    {"bufferView":1,"componentType":5121,"count":3,"type":"SCALAR"}]"#;

#[test]
fn nodes_are_visited_once() {
    refused("self.glb", &one(r#"[{"mesh":0,"children":[0]}]"#, GOOD), "below itself");
    refused("cycle.glb", &one(r#"[{"children":[1]},{"mesh":0,"children":[0]}]"#, GOOD), "below itself");
    // 2^40 paths: each node has its successor twice.
    let nodes: Vec<String> = (1..=40).map(|k| format!("{{\"children\":[{k},{k}]}}")).collect();
    refused("paths.glb", &one(&format!("[{},{{\"mesh\":0}}]", nodes.join(",")), GOOD), "below two nodes");
    refused("none.glb", &one(r#"[{"children":[7]}]"#, GOOD), "node 7 is not there");
}

#[test]
fn counts_are_held_against_the_bytes() {
    let count = |n: &str| GOOD.replacen("\"count\":3", &format!("\"count\":{n}"), 1);
    let node = r#"[{"mesh":0}]"#;
    refused("many.glb", &one(node, &count("3000000000")), "announces 3000000000 elements, and 3 are there");
    refused("most.glb", &one(node, &count("18446744073709551615")), "announces");
    let sparse = r#"[{"componentType":5126,"count":3000000000,"type":"VEC3","sparse":{"count":1,"indices":{"bufferView":1,
        "componentType":5121},"values":{"bufferView":0}}},{"bufferView":1,"componentType":5121,"count":3,"type":"SCALAR"}]"#;
    refused("sparse.glb", &one(node, sparse), "is sparse");
    let json = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":4294967295},"indices":1}]}]}"#;
    refused("index.glb", &glb(json, &[]), "accessor 4294967295 is not there");
}

#[test]
fn stl_and_obj_say_what_is_wrong() {
    let mut stl = vec![b' '; 80];
    stl.extend(u32::MAX.to_le_bytes());
    stl.extend([0; 50]);
    refused("short.stl", &stl, "announces 4294967295 facets, and 1 are there");
    refused("text.stl", b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0\n", "line 4");
    refused("nan.stl", b"solid a\nfacet\nouter loop\nvertex nan 0 0\n", "line 4");
    refused("far.obj", b"v 1e30 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "the limit is 100000 mm");
    refused("none.obj", b"v 0 0 0\nf 1 2 3\n", "line 2");
    refused("back.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf -9223372036854775808 2 3\n", "line 4");
}

#[cfg(unix)]
#[test]
fn pipes_devices_and_links_to_them_are_no_files() {
    let shop = Workshop::new();
    std::os::unix::fs::symlink("/dev/zero", shop.path().join("zero.stl")).expect("linked");
    let made = std::process::Command::new("mkfifo").arg(shop.path().join("pipe.stl")).status();
    assert!(made.is_ok_and(|s| s.success()), "mkfifo");
    for mesh in ["zero.stl", "pipe.stl"] {
        shop.scene(&format!("[part]\nmesh = \"{mesh}\""));
        shop.refused(&[mesh, "not a regular file"]);
    }
    shop.scene("");
    for (file, key) in [("scene.toml", "machine = \"machine\""), ("scene.toml", "tools = \"tools.toml\"")] {
        let name = key.split(' ').next().expect("a key");
        shop.scene("");
        shop.replace(file, key, &format!("{name} = \"pipe.stl\""));
        shop.refused(&["not a regular file"]);
    }
    shop.scene("");
    for program in ["/dev/zero", "pipe.stl"] {
        let told = shop.call(&["run", ".", "--nc", program, "--rerun", "off"]);
        assert_eq!(told.code(), Some(2), "{}", told.text);
    }
}
