//! Mesh files whose counts, nodes and indices are not what they say.

use crate::hostile::workshop::Workshop;

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
    refused("self.glb", &one(r#"[{"mesh":0,"children":[0]}]"#, GOOD), "of itself");
    refused("cycle.glb", &one(r#"[{"children":[1]},{"mesh":0,"children":[0]}]"#, GOOD), "of itself");
    // 2^40 paths: each node has its successor twice.
    let nodes: Vec<String> = (1..=40).map(|k| format!("{{\"children\":[{k},{k}]}}")).collect();
    refused("paths.glb", &one(&format!("[{},{{\"mesh\":0}}]", nodes.join(",")), GOOD), "a child of two nodes");
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
    refused("nan.stl", b"solid a\nfacet\nouter loop\nvertex 1 nan 0\n", "line 4: `nan` is not a finite number");
    refused("far.obj", b"v 1e30 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "the limit is 100000 mm");
    refused("none.obj", b"v 0 0 0\nf 1 2 3\n", "line 2");
    refused("back.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf -9223372036854775808 2 3\n", "line 4");
}

/// A tetrahedron next to the stock, as OBJ.
const CLAMP: &str = "v 60 60 10\nv 70 60 10\nv 60 70 10\nv 60 60 20\nv 65 60 10\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";

#[test]
fn triangles_without_area_are_named_and_change_nothing() {
    let shop = Workshop::new();
    let of_run = |obj: &str| {
        shop.scene("[[fixture]]\nname = \"clamp\"\nmesh = \"clamp.obj\"");
        shop.write("clamp.obj", obj);
        let output = shop.run();
        assert_ne!(output.code(), Some(2), "{}", output.text);
        let verdict: serde_json::Value = serde_json::from_str(&shop.read("result/verdict.json")).expect("JSON");
        let findings = verdict["findings"].as_array().expect("findings").clone();
        let (flat, rest): (Vec<_>, Vec<_>) = findings.into_iter().partition(|f| f["code"] == "setup-mesh-flat");
        (flat, rest, verdict["gates"].clone(), verdict["clearance"].clone())
    };
    let (flat, findings, gates, clearance) = of_run(CLAMP);
    assert!(flat.is_empty(), "{flat:?}");
    let (flat, rest, same_gates, same_clearance) = of_run(&format!("{CLAMP}f 2 2 3\nf 1 2 1\n"));
    assert_eq!((rest, same_gates, same_clearance), (findings, gates, clearance));
    let [output] = &flat[..] else { panic!("{flat:?}") };
    let words = "fixture clamp: 2 of the 6 triangles of clamp.obj have no area, the first is number 5 at (70.0000, 60.0000, 10.0000)";
    assert!(output["message"].as_str().is_some_and(|m| m.starts_with(words)), "{output}");
    shop.write("clamp.obj", "v 0 0 0\nv 1 0 0\nf 1 1 2\nf 2 2 1\n");
    shop.refused(&["scene.toml:21:8", "fixture clamp: each of the 2 triangles", "has no area"]);
    assert_eq!((&output["severity"], &output["bodies"]), (&"info".into(), &serde_json::json!(["clamp"])));
}

#[test]
fn a_mesh_that_is_not_there_is_reported_with_its_line() {
    let shop = Workshop::new();
    shop.scene("[[fixture]]\nname = \"clamp\"\nmesh = \"clamp.obj\"");
    shop.refused(&["scene.toml:21:8", "fixture clamp: cannot open", "clamp.obj", "put the file there"]);
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
        let output = shop.call(&["run", ".", "--nc", program, "--rerun", "off"]);
        assert_eq!(output.code(), Some(2), "{}", output.text);
    }
}
