//! Files of texture: written and read back, files of another program, and files that are nonsense.

use std::{io::Write as _, path::Path};

use proptest::prelude::*;
use proveout_surface::texture::{
    HeightMap, Profile,
    file::{Measured, SdfForm, read_measured, read_measured_bytes, sdf_bytes, write_sdf, write_x3p, x3p_bytes},
};

/// Numbers in [0, 1) by a fixed rule.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

fn map() -> HeightMap {
    let mut n = Numbers(5);
    HeightMap::new(37, 23, 0.005, 0.0031, (0..37 * 23).map(|_| 0.004 * (n.next() - 0.5)).collect()).expect("a map")
}

fn profile() -> Profile {
    let mut n = Numbers(9);
    Profile::new(0.0005, (0..501).map(|_| 0.002 * (n.next() - 0.5)).collect()).expect("a profile")
}

fn read(bytes: &[u8]) -> Measured {
    read_measured_bytes(Path::new("x"), bytes).unwrap_or_else(|e| panic!("{e}; {}", e.help)).measured
}

/// The error text of bytes that are refused: line, message, remedy.
fn refused(bytes: &[u8]) -> (usize, String, String) {
    let e = read_measured_bytes(Path::new("x"), bytes).expect_err("refused");
    (e.line, e.message, e.help)
}

fn alike(a: &[f64], b: &[f64], what: &str) {
    assert_eq!(a.len(), b.len(), "{what}");
    for (k, (x, y)) in a.iter().zip(b).enumerate() {
        assert!((x - y).abs() <= 1e-15 * x.abs().max(1e-3), "{what}, height {k}: {x} and {y}");
    }
}

#[test]
fn maps_and_profiles_come_back_as_they_were_written() {
    let (map, profile) = (map(), profile());
    for (what, bytes) in [
        ("binary SDF", sdf_bytes(&map, SdfForm::Binary)),
        ("text SDF", sdf_bytes(&map, SdfForm::Text)),
        ("X3P", x3p_bytes(&map)),
    ] {
        let Measured::Map(back) = read(&bytes.expect("written")) else { panic!("{what}: no map") };
        assert_eq!((back.columns(), back.rows()), (37, 23), "{what}");
        alike(&[back.step_x(), back.step_y()], &[0.005, 0.0031], what);
        alike(back.heights(), map.heights(), what);
    }
    for (what, bytes) in [
        ("binary SDF", sdf_bytes(&profile, SdfForm::Binary)),
        ("text SDF", sdf_bytes(&profile, SdfForm::Text)),
        ("X3P", x3p_bytes(&profile)),
    ] {
        let Measured::Profile(back) = read(&bytes.expect("written")) else { panic!("{what}: no profile") };
        alike(&[back.step()], &[0.0005], what);
        alike(back.heights(), profile.heights(), what);
    }
    // Same map, same bytes.
    assert_eq!(x3p_bytes(&map).expect("written"), x3p_bytes(&map).expect("written"));
}

#[test]
fn files_are_written_where_they_are_asked_for() {
    let folder = tempfile::tempdir().expect("a folder");
    let map = map();
    let (sdf, x3p) = (folder.path().join("map.sdf"), folder.path().join("map.x3p"));
    write_sdf(&sdf, &map, SdfForm::Binary).expect("written");
    write_x3p(&x3p, &map).expect("written");
    for path in [&sdf, &x3p] {
        assert!(matches!(read_measured(path).expect("read").measured, Measured::Map(_)));
    }
    let e = write_sdf(&folder.path().join("no/where.sdf"), &map, SdfForm::Text).expect_err("no folder");
    assert!(e.message.contains("cannot be written"), "{e}");
    let long = Profile::new(0.001, vec![0.0; 70_000]).expect("a profile");
    let e = write_sdf(&sdf, &long, SdfForm::Binary).expect_err("too long");
    assert!(e.message.contains("70000 x 1") && e.message.contains("65535") && e.help.contains("X3P"), "{e}");
    let e = read_measured(&folder.path().join("nowhere.sdf")).expect_err("no file");
    assert!(e.message.contains("cannot be read"), "{e}");
    assert!(read_measured(folder.path()).expect_err("a folder").message.contains("folder"));
}

#[test]
fn files_of_another_program_are_read() {
    // Made by surfalize 0.19.2: patch 0 of 12 x 9 points; reference/texture.py.
    let mut n = Numbers(1);
    let want: Vec<f64> = (0..12 * 9)
        .map(|k| {
            let (x, y) = (f64::from(k % 12) * 4.0, f64::from(k / 12) * 5.0);
            let (u, v) = (0.4_f64.cos() * x + 0.4_f64.sin() * y, -0.4_f64.sin() * x + 0.4_f64.cos() * y);
            let ridge = (std::f64::consts::PI * u / 60.0).sin().abs();
            1e-3 * (2.0 * ridge + 0.5 * (std::f64::consts::TAU * v / 410.0).sin() + 0.3 * (n.next() - 0.5))
        })
        .collect();
    let files: [(&str, &[u8], f64); 3] = [
        ("x3p", include_bytes!("reference/surfalize.x3p"), 1e-15),
        ("binary sdf", include_bytes!("reference/surfalize.sdf"), 1e-15),
        // Ten digits after the point, of um.
        ("text sdf", include_bytes!("reference/surfalize-text.sdf"), 1e-13),
    ];
    for (what, bytes, bound) in files {
        let Measured::Map(map) = read(bytes) else { panic!("{what}: no map") };
        assert_eq!((map.columns(), map.rows()), (12, 9), "{what}");
        assert!((map.step_x() - 0.004).abs() < 1e-15 && (map.step_y() - 0.005).abs() < 1e-15, "{what}");
        for (k, (a, b)) in map.heights().iter().zip(&want).enumerate() {
            assert!((a - b).abs() < bound, "{what}, height {k}: {a} and {b}");
        }
    }
}

/// A softgauge with its checksum.
fn smd(heights: &str, points: usize, step: &str) -> Vec<u8> {
    let mut text = format!(
        "ISO 5436 - 2000\0gauge\r\nPRF\x000\0made\r\nCX\0I\0{points}\0mm\x001.0E+000\0D\0{step}\r\nCZ\0A\0{points}\0um\x001.0E+000\0D\r\n\
         \x03\r\nDATE\x0022-11-2026\r\n\x03\r\n{heights}\r\n\x03\r\n"
    )
    .into_bytes();
    let sum: u64 = text.iter().map(|b| u64::from(*b)).sum();
    text.extend_from_slice(format!("{}\r\n\x03\x1a", sum % 65_535).as_bytes());
    text
}

#[test]
fn softgauges_are_read() {
    let file = read_measured_bytes(Path::new("x"), &smd("1.5\r\n-0.25\r\n1e-3", 3, "5.0E-004")).expect("read");
    assert_eq!((file.format, file.remarks.len()), ("SMD (ISO 5436-2)", 0), "{:?}", file.remarks);
    let Measured::Profile(p) = file.measured else { panic!("no profile") };
    alike(&[p.step()], &[0.0005], "step");
    alike(p.heights(), &[0.0015, -0.000_25, 0.000_001], "heights");
    // Blanks in place of NUL.
    let blanks: Vec<u8> = smd("1.5\r\n2", 2, "0.001").iter().map(|b| if *b == 0 { b' ' } else { *b }).collect();
    let file = read_measured_bytes(Path::new("x"), &blanks).expect("read");
    assert!(file.remarks[0].starts_with("the checksum is"), "{:?}", file.remarks);
    // The text of the softgauges of NPL.
    let npl = b"aNPL-V1.0\r\nManuFacID = Softgauges\r\nCreateDate = 210520051200\r\nModDate = 210520051200\r\nNumPoints = 3\r\n\
        NumProfiles = 1\r\nXscale = 2.5E-07\r\nYscale = 0\r\nZscale = 1E-06\r\nZresolution = -1\r\nCompression = 0\r\n\
        DataType = 7\r\nCheckType = 0\r\n*\r\n-0.296539\r\n-0.270753\r\n0.5\r\n*\r\n*\r\n";
    let Measured::Profile(p) = read(npl) else { panic!("no profile") };
    alike(&[p.step()], &[0.000_25], "step");
    alike(p.heights(), &[-0.000_296_539, -0.000_270_753, 0.0005], "heights");
}

#[test]
fn wrong_softgauges_are_refused_with_their_line() {
    for (bytes, line, words) in [
        (smd("1.5\r\nhigh\r\n2", 3, "0.001"), 9, "\"high\": no number"),
        (smd("1.5\r\nBAD\r\n2", 3, "0.001"), 9, "height 2 is BAD: it was not measured"),
        (smd("1.5\r\n2", 3, "0.001"), 0, "2 heights, 3 in the header"),
        (smd("1.5\r\n2\r\n3\r\n4", 3, "0.001"), 11, "more heights than the 3"),
        (smd("1\r\n2 3", 3, "0.001"), 9, "two values on a line"),
        (smd("1\r\n2", 2, "0"), 3, "a step of 0 mm is not a spacing"),
        (smd("1\r\n2", 2, "nan"), 3, "the step of CX is \"nan\""),
        (smd("1", 1, "0.001"), 3, "\"1\" points on axis CX"),
        (changed(&smd("1\r\n2", 2, "0.001"), "\0um\0", "\0ft\0"), 4, "unit \"ft\" of axis CZ"),
        (changed(&smd("1\r\n2", 2, "0.001"), "CX\0I", "CX\0A"), 3, "axis CX is of type \"A\""),
        (changed(&smd("1\r\n2", 2, "0.001"), "CZ\0A", "CY\0A"), 4, "an axis CY makes an area"),
        (b"\x03\x03".to_vec(), 0, "2 ends of record"),
    ] {
        let (at, message, help) = refused(&bytes);
        assert!(message.contains(words) && !help.is_empty(), "{message}");
        assert_eq!(at, line, "{message}");
    }
}

fn changed(bytes: &[u8], from: &str, to: &str) -> Vec<u8> {
    let text: String = bytes.iter().map(|b| char::from(*b)).collect();
    assert!(text.contains(from), "{from}");
    text.replacen(from, to, 1).chars().map(|c| c as u8).collect()
}

#[test]
fn wrong_surface_data_files_are_refused_with_their_place() {
    let text = sdf_bytes(&map(), SdfForm::Text).expect("written");
    let binary = sdf_bytes(&map(), SdfForm::Binary).expect("written");
    for (from, to, line, words) in [
        ("NumPoints = 37", "NumPoints = 38", 0, "851 heights for 38 x 23"),
        ("NumPoints = 37", "NumPoints = many", 5, "many of numpoints is not a number"),
        ("NumPoints = 37", "NumPoints = 1e9", 0, "1000000000 x 23 heights"),
        ("NumPoints = 37", "NumDots = 37", 5, "unknown key \"numdots\""),
        ("NumProfiles = 23\r\n", "", 0, "the header has no numprofiles"),
        ("NumProfiles = 23", "NumProfiles = 0", 0, "37 x 0 heights"),
        ("Xscale = ", "Xscale = -", 0, "is not a spacing"),
        ("Zscale = 1e-6", "Zscale = 0", 0, "a z scale of 0"),
        ("Compression = 0", "Compression = 1", 0, "compression 1 is not read"),
        ("CheckType = 0", "CheckType = 2", 0, "check type 2 is not read"),
        ("*\r\n", "*\r\nBAD ", 15, "height 1 is BAD"),
        ("*\r\n", "*\r\nx ", 15, "height 1 is \"x\": no number"),
        ("*\r\n", "*\r\n0 ", 121, "more heights than 37 x 23"),
        ("*\r\n", "nothing\r\n", 14, "\"nothing\" is not a line of the header"),
    ] {
        let (at, message, help) = refused(&changed(&text, from, to));
        assert!(message.contains(words) && !help.is_empty(), "{to}: {message}");
        assert_eq!(at, line, "{to}: {message}");
    }
    let mut missing = binary.clone();
    missing[81 + 8 * 40..81 + 8 * 41].copy_from_slice(&f64::MIN.to_le_bytes());
    assert!(refused(&missing).1.contains("height 41 (point 4 of profile 2) is missing"));
    assert!(refused(&binary[..200]).1.contains("the file is cut off"));
    assert!(refused(&binary[..40]).1.contains("shorter than the header"));
    let mut kind = binary.clone();
    kind[79] = 9;
    assert!(refused(&kind).1.contains("data type 9"));
    assert!(refused(&changed(&binary, "bISO-1.0", "bISO-9.0")).1.contains("bISO-9.0"));
    assert!(refused(b"solid block").1.contains("no file of texture"));
    assert!(refused(b"").1.contains("0 bytes"));
}

#[test]
fn binary_types_of_the_standard_are_read() {
    let header = sdf_bytes(&Profile::new(0.001, vec![0.0; 2]).expect("a profile"), SdfForm::Binary).expect("written");
    for (kind, data) in [
        (0_u8, vec![3, 5]),
        (1, [3_u16, 5].iter().flat_map(|v| v.to_le_bytes()).collect()),
        (2, [3_u32, 5].iter().flat_map(|v| v.to_le_bytes()).collect()),
        (3, [3_f32, 5.0].iter().flat_map(|v| v.to_le_bytes()).collect()),
        (4, vec![3, 5]),
        (5, [3_i16, 5].iter().flat_map(|v| v.to_le_bytes()).collect()),
        (6, [3_i32, 5].iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>()),
    ] {
        let mut bytes = header[..81].to_vec();
        bytes[79] = kind;
        bytes.extend_from_slice(&data);
        let Measured::Profile(p) = read(&bytes) else { panic!("no profile") };
        alike(p.heights(), &[0.003, 0.005], &format!("type {kind}"));
    }
    // 32-bit counts of ISO-2.0.
    let mut wide = b"bISO-2.0".to_vec();
    wide.extend_from_slice(&header[8..42]);
    wide.extend_from_slice(&2_u32.to_le_bytes());
    wide.extend_from_slice(&1_u32.to_le_bytes());
    wide.extend_from_slice(&header[46..]);
    assert!(matches!(read(&wide), Measured::Profile(_)));
}

#[test]
fn damaged_archives_are_refused() {
    let good = x3p_bytes(&map()).expect("written");
    // Every byte of the archive that is changed is reported, or changes nothing that is read.
    let Measured::Map(want) = read(&good) else { panic!("no map") };
    let mut refused = 0;
    for k in (0..good.len()).step_by(7) {
        let mut bytes = good.clone();
        bytes[k] ^= 0x20;
        match read_measured_bytes(Path::new("x"), &bytes) {
            Err(_) => refused += 1,
            Ok(file) => {
                let Measured::Map(map) = file.measured else { panic!("no map") };
                assert_eq!(map.heights(), want.heights(), "byte {k}");
            }
        }
    }
    assert!(refused * 10 > good.len() / 7 * 9, "{refused} of {}", good.len() / 7);
    for length in (0..good.len()).step_by(97) {
        assert!(read_measured_bytes(Path::new("x"), &good[..length]).is_err(), "{length} bytes");
    }
}

fn cases() -> u32 {
    std::env::var("PROVEOUT_FUZZ_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(200)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(), ..ProptestConfig::default() })]

    /// Corners: empty files, bytes after each magic word, texts of the words of the formats in any order,
    /// one byte changed or a length cut off of good files.
    #[test]
    fn no_bytes_make_it_panic(
        magic in prop::sample::select(vec!["", "PK\x03\x04", "aISO-1.0\n", "bISO-1.0", "bISO-2.0", "aNPL-V1.0\n", "ISO 5436 - 2000\n"]),
        noise in prop::collection::vec(any::<u8>(), 0..300),
        words in prop::collection::vec(prop::sample::select(vec![
            "CX I 3 mm 1 D 0.001\n", "CZ A 3 um 1 D\n", "\x03\n", "1\n", "-2e308\n", "BAD ", "*\n", "NumPoints = 3\n", "NumProfiles = 1\n",
            "NumPoints = 99999999999999999999\n", "Xscale = 1e-6\n", "Yscale = 1e-320\n", "Zscale = 1e300\n", "0.5 ", "\0", "= \n", "1e400 ",
        ]), 0..40),
        (kind, at, bit) in (0..4_usize, any::<prop::sample::Index>(), 0..8_u8),
    ) {
        let mut bytes = magic.as_bytes().to_vec();
        bytes.extend_from_slice(&noise);
        let _ = read_measured_bytes(Path::new("x"), &bytes);
        let text = format!("{magic}{}", words.concat());
        let _ = read_measured_bytes(Path::new("x"), text.as_bytes());
        let good = match kind {
            0 => sdf_bytes(&profile(), SdfForm::Binary),
            1 => sdf_bytes(&profile(), SdfForm::Text),
            2 => x3p_bytes(&profile()),
            _ => Ok(smd("1\r\n2\r\n3", 3, "0.001")),
        }.expect("written");
        let place = at.index(good.len());
        let mut changed = good.clone();
        changed[place] ^= 1 << bit;
        let _ = read_measured_bytes(Path::new("x"), &changed);
        let _ = read_measured_bytes(Path::new("x"), &good[..place]);
    }
}

/// What a person does with a run's map: write it, read it elsewhere. With the folder of an installed
/// surfalize's `python` in `PROVEOUT_SURFALIZE`, the files are read there, too.
#[test]
fn another_program_reads_what_is_written() {
    let Some(python) = std::env::var_os("PROVEOUT_SURFALIZE") else {
        // Past the capture of the harness.
        writeln!(std::io::stderr(), "LEFT OUT: reading by surfalize; set PROVEOUT_SURFALIZE to the python that has it")
            .ok();
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let map = map();
    let names = ["b.sdf", "a.sdf", "m.x3p"].map(|n| folder.path().join(n));
    write_sdf(&names[0], &map, SdfForm::Binary).expect("written");
    write_sdf(&names[1], &map, SdfForm::Text).expect("written");
    write_x3p(&names[2], &map).expect("written");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/texture.py");
    let output = std::process::Command::new(python).arg(script).args(&names).output().expect("the package runs");
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{printed}{}", String::from_utf8_lossy(&output.stderr));
    let sa = 1e3 * map.parameters().sa;
    for line in printed.lines() {
        assert!(line.contains("37 x 23"), "{line}");
        let word = line.split("Sa ").nth(1).and_then(|w| w.split(' ').next()).expect("Sa");
        let got: f64 = word.trim_start_matches("np.float64(").trim_end_matches(')').parse().expect("a number");
        assert!((got - sa).abs() < 1e-12 * sa, "{line}: {sa}");
    }
    assert_eq!(printed.lines().count(), 3, "{printed}");
}
