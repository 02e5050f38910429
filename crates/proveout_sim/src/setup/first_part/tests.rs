use super::*;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace root").to_owned()
}

/// A call with a program of this text, in a folder of its own.
fn call(folder: &Path, name: &str, text: &str, machine: &str) -> FirstPart {
    let program = folder.join(name);
    std::fs::write(&program, text).expect("written");
    FirstPart {
        programs: vec![program],
        machine: root().join("machines").join(machine),
        output: folder.join("new"),
        ..FirstPart::default()
    }
}

fn answers(list: &[(&str, &str)]) -> BTreeMap<String, String> {
    list.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect()
}

const FACE: &str = "%\nO1000\n(T1 D=10. CR=0. - ZMIN=-3. - FLAT END MILL)\nG21 G90 G17 G94\nT1 M6\nS3000 M3\nG54\nG0 X-20. Y10.\nG43 H1 Z20.\nZ-2.\n\
                    G1 X70. F500.\nZ-3. F100.\nX-20. F500.\nG0 Z20.\nM30\n%\n";

#[test]
fn every_open_question_is_named_and_nothing_is_taken() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let call = call(folder.path(), "face.nc", FACE, "three-axis-mill");
    let error = propose(&call, &mut |_| None).expect_err("nobody answers");
    let FirstPartError::Unanswered(open) = error else { panic!("{error:?}") };
    assert_eq!(open.iter().map(|q| q.key.as_str()).collect::<Vec<_>>(), ["holder", "stock"]);
    // The holder changes no cut: what is proposed without its answer is what is proposed with it.
    let early = open[1].proposed.clone();
    let call = FirstPart { answers: answers(&[("holder", "none")]), ..call };
    let FirstPartError::Unanswered(open) = propose(&call, &mut |_| None).expect_err("no stock") else { panic!() };
    assert_eq!(open[0].key, "stock");
    // The descent at X-20 is next to the stock: cutter of 5 mm radius.
    let proposed = open[0].proposed.clone().expect("a proposal");
    assert_eq!(early.as_deref(), Some(proposed.as_str()));
    assert!(proposed.starts_with("-15,0,-4,"), "{proposed}");
    assert!(!call.output.exists());
}

#[test]
fn offsets_follow_from_the_mounting_on_both_kinds_of_zero() {
    for (machine, name) in [("three-axis-mill", "a"), ("bc-trunnion-home-zero", "b")] {
        let folder = tempfile::tempdir().expect("temporary folder");
        let mut call = call(folder.path(), "face.nc", FACE, machine);
        call.answers = answers(&[("holder", "40x60"), ("stock", "0,0,-20,50,20,0"), ("mount", "10,20,150")]);
        let proposal = propose(&call, &mut |_| None).unwrap_or_else(|e| panic!("{name}: {e:?}"));
        proposal.write().expect("written");
        let scene = crate::scene::Scene::read(&call.output).unwrap_or_else(|e| panic!("{e}"));
        let machine = Machine::read(&call.machine).expect("machine");
        let zero = machine.program_zero().expect("zero");
        let offset = scene.file.work_offsets["G54"];
        let tip = zero + Vector::new(offset.X_mm, offset.Y_mm, offset.Z_mm);
        assert!((tip - Point::new(10.0, 20.0, 150.0)).norm() < 1e-6, "{tip:?}");
        // Nothing is written over.
        let again = propose(&call, &mut |_| None).expect_err("is there");
        assert!(matches!(again, FirstPartError::Refused { message, .. } if message.contains("is there already")));
    }
}

#[test]
fn answers_that_nothing_asks_for_are_refused() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let mut call = call(folder.path(), "face.nc", FACE, "three-axis-mill");
    call.answers = answers(&[("holder", "none"), ("stock", "proposed"), ("offset.G55", "0,0,0")]);
    let FirstPartError::Refused { message, .. } = propose(&call, &mut |_| None).expect_err("no G55") else { panic!() };
    assert!(message.contains("offset.G55"), "{message}");
    call.answers = answers(&[("holder", "wide"), ("stock", "proposed")]);
    let FirstPartError::Refused { message, .. } = propose(&call, &mut |_| None).expect_err("no holder") else {
        panic!()
    };
    assert!(message.contains("wide"), "{message}");
}
