//! Evidence that holds: every file by its digest, the text that steers nothing, one code for one word.

use std::{collections::BTreeMap, fs};

use crate::hostile::{
    meshes::triangle,
    workshop::{PROGRAM, Workshop},
};

fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).expect("JSON")
}

#[test]
fn the_manifest_lists_every_file_that_was_opened_and_written() {
    let shop = Workshop::new();
    shop.write("program.mpf", PROGRAM.replace("X10\n", "SUB1\n"));
    shop.write("SUB1.SPF", "G1 X10\nM17\n");
    shop.write("machine/model.glb", triangle());
    shop.replace("machine/machine.toml", "up = [0, 0, 1]", "up = [0, 0, 1]\nmodel = \"model.glb\"");
    let output = shop.run();
    assert_eq!(output.code(), Some(3), "{}", output.text);
    let manifest = json(&shop.read("result/manifest.json"));
    let inputs: BTreeMap<&str, &str> = manifest["inputs"]
        .as_array()
        .expect("inputs")
        .iter()
        .map(|i| (i["path"].as_str().expect("path"), i["sha256"].as_str().expect("digest")))
        .collect();
    for path in ["scene.toml", "machine/machine.toml", "machine/model.glb", "tools.toml", "program.mpf", "SUB1.SPF"] {
        assert_eq!(inputs.get(path).map(|d| d.len()), Some(64), "{path}: {inputs:?}");
    }
    let files: Vec<&str> =
        manifest["files"].as_array().expect("files").iter().map(|f| f["name"].as_str().expect("name")).collect();
    for entry in fs::read_dir(shop.path().join("result")).expect("there").flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let output = files.contains(&name.as_str()) || name == "manifest.json" || name == "run.json";
        assert!(output, "{name} is not in the manifest: {files:?}");
    }
    let text = shop.read("result/manifest.json");
    assert!(
        !text.contains("--rerun") && !text.contains(&*shop.path().to_string_lossy()),
        "no call and no host: {text}"
    );
    assert!(json(&shop.read("result/run.json"))["command"].as_array().is_some_and(|c| c.len() > 3));
    // What decides a verdict without standing in the scene: a called subprogram, the shapes of the machine.
    for (name, bytes) in
        [("SUB1.SPF", b"G1 X12\nM17\n".to_vec()), ("machine/model.glb", [triangle(), vec![0; 4]].concat())]
    {
        let before = fs::read(shop.path().join(name)).expect("there");
        shop.write(name, bytes);
        let output = shop.call(&["verify", "result"]);
        assert_eq!(output.code(), Some(3), "{}", output.text);
        assert!(output.text.contains(&format!("({name})")), "{}", output.text);
        shop.write(name, before);
    }
    assert_eq!(shop.call(&["verify", "result"]).code(), Some(0));
}

#[test]
fn verify_says_what_is_not_as_it_was() {
    let shop = Workshop::new();
    assert_eq!(shop.run().code(), Some(3));
    let output = shop.call(&["verify", "result"]);
    assert_eq!(output.code(), Some(0), "{}", output.text);
    shop.replace("program.mpf", "X10", "X11");
    shop.write("result/notes.txt", "mine");
    let output = shop.call(&["verify", "result"]);
    assert_eq!(output.code(), Some(3), "{}", output.text);
    assert!(output.text.contains("input changed since the run: program (program.mpf)"), "{}", output.text);
    assert!(output.text.contains("not part of the run, not checked: notes.txt"), "{}", output.text);
    let verdict = shop.read("result/verdict.json");
    shop.write("result/verdict.json", verdict.replace("\"unchecked\"", "\"pass\""));
    let output = shop.call(&["verify", "result"]);
    assert_eq!(output.code(), Some(1), "{}", output.text);
    assert!(output.text.contains("changed since the run: verdict.json"), "{}", output.text);
    let output = shop.call(&["verify", "machine"]);
    assert_eq!(output.code(), Some(2), "no manifest: {}", output.text);
}

#[test]
fn verify_says_what_it_did_not_check() {
    let shop = Workshop::new();
    let expect = |arguments: &[&str], code: i32, words: &[&str]| {
        let expect = shop.call(arguments);
        assert_eq!(expect.code(), Some(code), "{arguments:?}: {}", expect.text);
        for word in words {
            assert!(expect.text.contains(word), "{arguments:?}, {word}: {}", expect.text);
        }
    };
    assert_eq!(shop.call(&["run", ".", "--output", "result", "--rerun", "file"]).code(), Some(3));
    let uncovered = "not checked, not covered by a digest: run.json";
    expect(&["verify", "result"], 0, &[uncovered, "not signed"]);
    // A recording is under a digest, whatever is done to it.
    let recording = shop.path().join("result/recording.rrd");
    let bytes = fs::read(&recording).expect("a recording");
    fs::write(&recording, "any bytes").expect("written");
    expect(&["verify", "result"], 1, &["changed since the run: recording.rrd"]);
    fs::remove_file(&recording).expect("gone");
    expect(&["verify", "result"], 1, &["changed since the run: recording.rrd"]);
    fs::write(&recording, bytes).expect("written");
    // run.json is under none, which is said; one that is gone is missed.
    let run = shop.read("result/run.json");
    shop.write("result/run.json", run.replace("wall_s", "wall_S"));
    expect(&["verify", "result"], 0, &[uncovered]);
    fs::remove_file(shop.path().join("result/run.json")).expect("gone");
    expect(&["verify", "result"], 1, &["changed since the run: run.json"]);
    // The manifest says where the scene is: another one in run.json leads nowhere.
    fs::create_dir(shop.path().join("old")).expect("made");
    for name in ["scene.toml", "program.mpf", "tools.toml"] {
        fs::copy(shop.path().join(name), shop.path().join("old").join(name)).expect("copied");
    }
    let folder = shop.path().display().to_string();
    shop.write("result/run.json", run.replace(&folder, &format!("{folder}/old")));
    shop.replace("program.mpf", "X10", "X11");
    expect(&["verify", "result"], 3, &["input changed since the run: program (program.mpf)", uncovered]);
    shop.replace("program.mpf", "X11", "X10");
    expect(&["verify", "result"], 0, &["inputs unchanged since the run"]);
    // A run folder that was carried elsewhere does not find its scene, and takes no other.
    fs::create_dir_all(shop.path().join("far/away")).expect("made");
    fs::rename(shop.path().join("result"), shop.path().join("far/away/result")).expect("moved");
    expect(&["verify", "far/away/result"], 3, &["(scene.toml): cannot be read"]);
    expect(&["verify", "far/away/result", "--scene", "."], 0, &["inputs unchanged since the run"]);
    fs::rename(shop.path().join("far/away/result"), shop.path().join("result")).expect("moved");
    // A signature that was not checked is reported.
    shop.write("result/manifest.sig", "of somebody");
    expect(&["verify", "result"], 0, &["signature not checked"]);
    fs::remove_file(shop.path().join("result/manifest.sig")).expect("gone");
    // A manifest that covers no verdict is none.
    let manifest = shop.read("result/manifest.json");
    let mut hollow = json(&manifest);
    hollow["files"] = serde_json::json!([]);
    shop.write("result/manifest.json", hollow.to_string());
    expect(&["verify", "result"], 2, &["it covers no verdict.json"]);
    let mut hollow = json(&manifest);
    hollow["inputs"] = serde_json::json!([]);
    shop.write("result/manifest.json", hollow.to_string());
    expect(&["verify", "result"], 2, &["names no scene among its inputs"]);
}

#[test]
fn a_forged_stock_is_found_by_the_next_setup() {
    let shop = Workshop::new();
    assert_eq!(shop.run().code(), Some(3));
    // A stock of another run, in order in itself.
    shop.write("program.mpf", PROGRAM.replace("X10", "X-10"));
    let other = shop.call(&["run", ".", "--output", "other", "--rerun", "off"]);
    assert_eq!(other.code(), Some(3), "{}", other.text);
    fs::copy(shop.path().join("other/stock.dexel"), shop.path().join("result/stock.dexel")).expect("forged");
    shop.replace("scene.toml", "box = { min_mm = [-20, -20, -20], max_mm = [20, 20, 0] }", "from_run = \"result\"");
    let output = shop.call(&["run", ".", "--output", "second", "--rerun", "off"]);
    assert_eq!(output.code(), Some(2), "{}", output.text);
    assert!(output.text.contains("is not as the run left it"), "{}", output.text);
}

#[test]
fn a_signature_says_who_vouches_for_a_run() {
    let shop = Workshop::new();
    assert_eq!(shop.run().code(), Some(3));
    // The first key of RFC 8032, and another one.
    let of_key =
        |begin: &str, middle: &str| format!("-----BEGIN {begin} KEY-----\n{middle}\n-----END {begin} KEY-----\n");
    shop.write("key.pem", of_key("PRIVATE", "MC4CAQAwBQYDK2VwBCIEIJ1hsZ3v/VpguoRK9JLsLMREScVpezJpGXA7rAMcrn9g"));
    shop.write("public.pem", of_key("PUBLIC", "MCowBQYDK2VwAyEA11qYAYKxCrfVS/7TyWQHOg7hcvPapiMlrwIaaPcHURo="));
    shop.write("other.pem", of_key("PUBLIC", "MCowBQYDK2VwAyEAPUAXw+hDiVqStwqnTRt+vJyYLM8uxJaMwM1V8Sr0Zgw="));
    let expect = |arguments: &[&str], code: i32, word: &str| {
        let expect = shop.call(arguments);
        assert_eq!(expect.code(), Some(code), "{arguments:?}: {}", expect.text);
        assert!(expect.text.contains(word), "{arguments:?}: {}", expect.text);
    };
    expect(&["verify", "result", "--public-key", "public.pem"], 1, "is not signed");
    expect(&["sign", "result", "--key", "public.pem"], 2, "is no private Ed25519 key in PEM");
    expect(&["sign", "result", "--key", "key.pem"], 0, "signed");
    expect(&["verify", "result"], 0, "files unchanged since the run");
    expect(&["verify", "result", "--public-key", "public.pem"], 0, "the manifest is signed with this key");
    expect(&["verify", "result", "--public-key", "other.pem"], 1, "not that of this key");
    expect(&["verify", "result", "--public-key", "key.pem"], 2, "is no public Ed25519 key in PEM");
    expect(
        &["verify", "result", "--public-key", "key.pem"],
        2,
        "help: `openssl pkey -in key.pem -pubout -out public.pem` extracts",
    );
    expect(
        &["sign", "result", "--key", "public.pem"],
        2,
        "help: create one with `openssl genpkey -algorithm ed25519 -out key.pem`",
    );
    for folder in ["machine", "nowhere"] {
        expect(&["sign", folder, "--key", "key.pem"], 2, "manifest.json cannot be read");
        expect(
            &["sign", folder, "--key", "key.pem"],
            2,
            "help: name a folder written by `proveout run` or `proveout compare`",
        );
    }
    expect(&["sign", "result", "--key", "nowhere.pem"], 2, "help: check path and permissions of the file");
    expect(&["verify", "result", "--public-key", "nowhere.pem"], 2, "help: check path and permissions of the file");
    // Whoever changes a file and its line in the manifest has no signature for it.
    let (verdict, manifest) = (shop.read("result/verdict.json"), shop.read("result/manifest.json"));
    shop.write("result/manifest.json", manifest.replacen("\"bytes\": 1", "\"bytes\": 2", 1));
    expect(&["verify", "result", "--public-key", "public.pem"], 1, "not that of this key");
    shop.write("result/manifest.json", &manifest);
    shop.write("result/verdict.json", verdict.replace("\"unchecked\"", "\"pass\""));
    expect(&["verify", "result", "--public-key", "public.pem"], 1, "changed since the run: verdict.json");
    expect(&["sign", "result", "--key", "key.pem"], 2, "changed since the run");
    expect(&["sign", "result", "--key", "key.pem"], 2, "help: `proveout verify` lists every changed file");
    // The next run is another one, and not signed.
    assert_eq!(shop.run().code(), Some(3));
    expect(&["verify", "result", "--public-key", "public.pem"], 1, "is not signed");
}

#[test]
fn text_of_others_steers_neither_terminal_nor_page() {
    let shop = Workshop::new();
    let escape = "\u{1b}]0;owned\u{7}\u{1b}[2J\u{202e}";
    shop.write("program.mpf", PROGRAM.replace("X10\n", &format!("MSG(\"{escape}\")\nX10 ;{escape}\n")));
    shop.replace("scene.toml", "[stock]", "description = \"a\\u001b[2J\\u202eb\"\n[stock]");
    let output = shop.run();
    assert_eq!(output.code(), Some(3), "{}", output.text);
    let page = shop.read("result/report.html");
    for text in [&output.text, &page] {
        assert!(!text.contains('\u{1b}') && !text.contains('\u{202e}') && !text.contains('\u{7}'));
    }
    assert!(page.contains("Content-Security-Policy") && page.contains("default-src &#x27;none&#x27;"));
    // A fault that shows the line, in a file whose name steers as well.
    let name = "a\u{1b}[31mb.mpf";
    shop.write(name, format!("G0 X1 {escape} QQQ=(\nM30\n"));
    let output = shop.call(&["nc", name]);
    assert_eq!(output.code(), Some(2), "{}", output.text);
    assert!(!output.text.contains('\u{1b}') && !output.text.contains('\u{202e}'), "{:?}", output.text);
}

#[test]
fn fail_and_unchecked_have_their_own_codes() {
    let shop = Workshop::new();
    let output = shop.run();
    assert_eq!(output.code(), Some(3), "no design part: {}", output.text);
    let verdict = json(&shop.read("result/verdict.json"));
    let gates = verdict["gates"].as_array().expect("gates");
    let unchecked: Vec<&str> =
        gates.iter().filter(|g| g["state"] == "unchecked").map(|g| g["name"].as_str().expect("name")).collect();
    let call = |gates: &[&str]| {
        let mut all = vec!["run", ".", "--output", "result", "--rerun", "off"];
        all.extend(gates.iter().flat_map(|g| ["--accept-unchecked", *g]));
        shop.call(&all)
    };
    let output = call(&unchecked);
    assert_eq!(output.code(), Some(0), "{}", output.text);
    assert!(output.text.contains("accepted by --accept-unchecked"), "{}", output.text);
    assert_eq!(json(&shop.read("result/verdict.json"))["verdict"], "unchecked", "the verdict stays");
    assert_eq!(call(&unchecked[1..]).code(), Some(3));
    assert_eq!(call(&["gogue"]).code(), Some(2));
    shop.write("program.mpf", PROGRAM.replace("G1 Z-2", "G0 Z-2"));
    assert_eq!(call(&unchecked).code(), Some(1), "a fail is never accepted");
}
