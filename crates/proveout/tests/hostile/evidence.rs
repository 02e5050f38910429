//! Evidence that holds: every file by its digest, the same bytes from anywhere, text that steers nothing, one code for one word.

use std::{collections::BTreeMap, fs, path::Path};

use crate::workshop::{PROGRAM, Workshop, proveout};

fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).expect("JSON")
}

#[test]
fn the_manifest_lists_every_file_that_was_opened_and_written() {
    let shop = Workshop::new();
    shop.write("program.mpf", PROGRAM.replace("X10\n", "SUB1\n"));
    shop.write("SUB1.SPF", "G1 X10\nM17\n");
    let told = shop.run();
    assert_eq!(told.code(), Some(3), "{}", told.text);
    let manifest = json(&shop.read("result/manifest.json"));
    let inputs: BTreeMap<&str, &str> = manifest["inputs"]
        .as_array()
        .expect("inputs")
        .iter()
        .map(|i| (i["path"].as_str().expect("path"), i["sha256"].as_str().expect("digest")))
        .collect();
    for path in ["scene.toml", "machine/machine.toml", "tools.toml", "program.mpf", "SUB1.SPF"] {
        assert_eq!(inputs.get(path).map(|d| d.len()), Some(64), "{path}: {inputs:?}");
    }
    let files: Vec<&str> =
        manifest["files"].as_array().expect("files").iter().map(|f| f["name"].as_str().expect("name")).collect();
    for entry in fs::read_dir(shop.path().join("result")).expect("there").flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let told = files.contains(&name.as_str()) || name == "manifest.json" || name == "run.json";
        assert!(told, "{name} is not in the manifest: {files:?}");
    }
    let text = shop.read("result/manifest.json");
    assert!(
        !text.contains("--rerun") && !text.contains(&*shop.path().to_string_lossy()),
        "no call and no host: {text}"
    );
    assert!(json(&shop.read("result/run.json"))["command"].as_array().is_some_and(|c| c.len() > 3));
}

#[test]
fn verify_says_what_is_not_as_it_was() {
    let shop = Workshop::new();
    assert_eq!(shop.run().code(), Some(3));
    let told = shop.call(&["verify", "result"]);
    assert_eq!(told.code(), Some(0), "{}", told.text);
    shop.replace("program.mpf", "X10", "X11");
    shop.write("result/notes.txt", "mine");
    let told = shop.call(&["verify", "result"]);
    assert_eq!(told.code(), Some(3), "{}", told.text);
    assert!(told.text.contains("input changed since the run: program (program.mpf)"), "{}", told.text);
    assert!(told.text.contains("not of the run: notes.txt"), "{}", told.text);
    let verdict = shop.read("result/verdict.json");
    shop.write("result/verdict.json", verdict.replace("\"unchecked\"", "\"pass\""));
    let told = shop.call(&["verify", "result"]);
    assert_eq!(told.code(), Some(1), "{}", told.text);
    assert!(told.text.contains("changed since the run: verdict.json"), "{}", told.text);
    let told = shop.call(&["verify", "machine"]);
    assert_eq!(told.code(), Some(2), "no manifest: {}", told.text);
}

#[test]
fn a_forged_stock_is_found_by_the_next_setup() {
    let shop = Workshop::new();
    assert_eq!(shop.run().code(), Some(3));
    // A stock of another run, in order in itself.
    shop.write("program.mpf", PROGRAM.replace("X10", "X-10"));
    let other = shop.call(&["run", ".", "--out", "other", "--rerun", "off"]);
    assert_eq!(other.code(), Some(3), "{}", other.text);
    fs::copy(shop.path().join("other/stock.dexel"), shop.path().join("result/stock.dexel")).expect("forged");
    shop.replace("scene.toml", "box = { min_mm = [-20, -20, -20], max_mm = [20, 20, 0] }", "from_run = \"result\"");
    let told = shop.call(&["run", ".", "--out", "second", "--rerun", "off"]);
    assert_eq!(told.code(), Some(2), "{}", told.text);
    assert!(told.text.contains("is not as the run left it"), "{}", told.text);
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
    let told = |arguments: &[&str], code: i32, word: &str| {
        let told = shop.call(arguments);
        assert_eq!(told.code(), Some(code), "{arguments:?}: {}", told.text);
        assert!(told.text.contains(word), "{arguments:?}: {}", told.text);
    };
    told(&["verify", "result", "--public-key", "public.pem"], 1, "is not signed");
    told(&["sign", "result", "--key", "public.pem"], 2, "is no private Ed25519 key in PEM");
    told(&["sign", "result", "--key", "key.pem"], 0, "signed");
    told(&["verify", "result"], 0, "files are as the run wrote them");
    told(&["verify", "result", "--public-key", "public.pem"], 0, "the manifest is signed with this key");
    told(&["verify", "result", "--public-key", "other.pem"], 1, "not that of this key");
    told(&["verify", "result", "--public-key", "key.pem"], 2, "is no public Ed25519 key in PEM");
    // Whoever changes a file and its line in the manifest has no signature for it.
    let (verdict, manifest) = (shop.read("result/verdict.json"), shop.read("result/manifest.json"));
    shop.write("result/manifest.json", manifest.replacen("\"bytes\": 1", "\"bytes\": 2", 1));
    told(&["verify", "result", "--public-key", "public.pem"], 1, "not that of this key");
    shop.write("result/manifest.json", &manifest);
    shop.write("result/verdict.json", verdict.replace("\"unchecked\"", "\"pass\""));
    told(&["verify", "result", "--public-key", "public.pem"], 1, "changed since the run: verdict.json");
    told(&["sign", "result", "--key", "key.pem"], 2, "is not as the run wrote it");
    // The next run is another one, and not signed.
    assert_eq!(shop.run().code(), Some(3));
    told(&["verify", "result", "--public-key", "public.pem"], 1, "is not signed");
}

/// All files below a folder but those that may differ.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder).expect("there").flatten();
    entries
        .map(|e| (e.file_name().to_string_lossy().into_owned(), e.path()))
        .filter(|(name, path)| path.is_file() && name != "run.json")
        .map(|(name, path)| (name, fs::read(path).expect("read")))
        .collect()
}

#[test]
fn the_same_bytes_come_from_everywhere_and_with_any_number_of_threads() {
    let shop = Workshop::new();
    // Findings with places, and a subprogram.
    shop.write("program.mpf", PROGRAM.replace("X10\n", "SUB1\nG0 X-15\n"));
    shop.write("SUB1.SPF", "G1 X10\nM17\n");
    let elsewhere = shop.path().join("machine");
    let scene = shop.path().display().to_string();
    let out = |name: &str| shop.path().join(name).display().to_string();
    let calls: [(&Path, &str, &str, &str); 4] = [
        (shop.path(), ".", "a", "1"),
        (&elsewhere, "..", "b", "2"),
        (&elsewhere, &scene, "c", "7"),
        (shop.path(), "scene.toml", "d", "1"),
    ];
    let mut first = None;
    for (folder, scene, name, threads) in calls {
        let told = proveout(folder, &["run", scene, "--out", &out(name), "--rerun", "off", "--threads", threads]);
        assert_eq!(told.code(), Some(1), "a rapid in material: {}", told.text);
        let found = files(&shop.path().join(name));
        let first = first.get_or_insert_with(|| found.clone());
        assert_eq!(first.keys().collect::<Vec<_>>(), found.keys().collect::<Vec<_>>());
        for (file, bytes) in &found {
            assert!(
                first[file] == *bytes,
                "{file} of {scene} from {} with {threads} threads differs",
                folder.display()
            );
        }
    }
}

#[test]
fn a_comparison_has_the_same_bytes_from_everywhere_and_with_any_number_of_threads() {
    let shop = Workshop::new();
    shop.write("other.mpf", PROGRAM.replace("F500", "F800"));
    shop.scene("[[program]]\nname = \"other\"\nfile = \"other.mpf\"\n\n[compare]\nbaseline = \"main\"\n");
    let elsewhere = shop.path().join("machine");
    let scene = shop.path().display().to_string();
    let out = |name: &str| shop.path().join(name).display().to_string();
    let mut first: Option<[BTreeMap<String, Vec<u8>>; 3]> = None;
    for (folder, scene, name, threads) in
        [(shop.path(), ".", "a", "1"), (&*elsewhere, "..", "b", "2"), (&*elsewhere, &scene, "c", "7")]
    {
        let call = ["compare", scene, "--out", &out(name), "--rerun", "off", "--threads", threads];
        let told = proveout(folder, &call);
        assert_eq!(told.code(), Some(3), "no design part: {}", told.text);
        let place = shop.path().join(name);
        let found = [files(&place), files(&place.join("main")), files(&place.join("other"))];
        assert!(found[0].contains_key("compare.json") && found.iter().all(|files| files.len() > 2), "{found:?}");
        let first = first.get_or_insert_with(|| found.clone());
        for (first, found) in first.iter().zip(&found) {
            assert_eq!(first.keys().collect::<Vec<_>>(), found.keys().collect::<Vec<_>>());
            for (file, bytes) in found {
                assert!(first[file] == *bytes, "{file} with {threads} threads from {} differs", folder.display());
            }
        }
    }
    // What a script tolerates is named gate by gate.
    let call = |more: &[&str]| {
        let mut all = vec!["compare", ".", "--out", "d", "--rerun", "off", "--threads", "1"];
        all.extend(more);
        shop.call(&all)
    };
    let verdict = json(&shop.read("a/compare.json"));
    let gates = verdict["programs"]["main"]["gates"].as_array().expect("gates");
    let open = gates.iter().filter(|g| g["state"] == "unchecked").map(|g| g["name"].as_str().expect("name"));
    let accepted: Vec<&str> = open.flat_map(|name| ["--accept-unchecked", name]).collect();
    assert!(accepted.len() >= 4, "two gates at least: {accepted:?}");
    assert_eq!(call(&accepted[2..]).code(), Some(3), "one of them is not accepted");
    let told = call(&accepted);
    assert_eq!(told.code(), Some(0), "{}", told.text);
    assert!(told.text.contains("unchecked, and accepted by the call"), "{}", told.text);
    assert_eq!(json(&shop.read("d/compare.json"))["verdict"], "unchecked", "the verdict stays");
}

#[test]
fn text_of_others_steers_neither_terminal_nor_page() {
    let shop = Workshop::new();
    let escape = "\u{1b}]0;owned\u{7}\u{1b}[2J\u{202e}";
    shop.write("program.mpf", PROGRAM.replace("X10\n", &format!("MSG(\"{escape}\")\nX10 ;{escape}\n")));
    shop.replace("scene.toml", "[stock]", "description = \"a\\u001b[2J\\u202eb\"\n[stock]");
    let told = shop.run();
    assert_eq!(told.code(), Some(3), "{}", told.text);
    let page = shop.read("result/report.html");
    for text in [&told.text, &page] {
        assert!(!text.contains('\u{1b}') && !text.contains('\u{202e}') && !text.contains('\u{7}'));
    }
    assert!(page.contains("Content-Security-Policy") && page.contains("default-src &#x27;none&#x27;"));
    // A fault that shows the line, in a file whose name steers as well.
    let name = "a\u{1b}[31mb.mpf";
    shop.write(name, format!("G0 X1 {escape} QQQ=(\nM30\n"));
    let told = shop.call(&["nc", name]);
    assert_eq!(told.code(), Some(2), "{}", told.text);
    assert!(!told.text.contains('\u{1b}') && !told.text.contains('\u{202e}'), "{:?}", told.text);
}

#[test]
fn fail_and_unchecked_have_their_own_codes() {
    let shop = Workshop::new();
    let told = shop.run();
    assert_eq!(told.code(), Some(3), "no design part: {}", told.text);
    let verdict = json(&shop.read("result/verdict.json"));
    let gates = verdict["gates"].as_array().expect("gates");
    let unchecked: Vec<&str> =
        gates.iter().filter(|g| g["state"] == "unchecked").map(|g| g["name"].as_str().expect("name")).collect();
    let call = |gates: &[&str]| {
        let mut all = vec!["run", ".", "--out", "result", "--rerun", "off"];
        all.extend(gates.iter().flat_map(|g| ["--accept-unchecked", *g]));
        shop.call(&all)
    };
    let told = call(&unchecked);
    assert_eq!(told.code(), Some(0), "{}", told.text);
    assert!(told.text.contains("accepted by the call"), "{}", told.text);
    assert_eq!(json(&shop.read("result/verdict.json"))["verdict"], "unchecked", "the verdict stays");
    assert_eq!(call(&unchecked[1..]).code(), Some(3));
    assert_eq!(call(&["gogue"]).code(), Some(2));
    shop.write("program.mpf", PROGRAM.replace("G1 Z-2", "G0 Z-2"));
    assert_eq!(call(&unchecked).code(), Some(1), "a fail is never accepted");
}
