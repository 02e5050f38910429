use std::path::{Path, PathBuf};

use proveout_sim::{SignatureError, check_signature, sign as put_signature, verdict::State, verify as hold};

use crate::{
    args::{SignArgs, VerifyArgs},
    failure::Failure,
};

/// Most names that are shown of a kind.
const SHOWN: usize = 20;
/// What to name as a run.
const RUN_FOLDER: &str = "name a folder written by `proveout run` or `proveout compare`";

/// Checks a run folder against its manifest, and reports what it did not check. Pass: nothing has changed.
/// Fail: a file of the folder has changed. Unchecked: an input has changed or cannot be found.
pub(crate) fn verify(args: &VerifyArgs) -> Result<State, Failure> {
    let named = args.scene.as_deref().map(folder_of);
    let found = hold(&args.run, named.as_deref()).map_err(|e| Failure::new(e).with_help(RUN_FOLDER))?;
    say!("{}: {} files unchanged since the run", args.run.display(), found.same_files);
    list("changed since the run", &found.changed_files);
    list("not checked, not covered by a digest", &found.uncovered_files);
    list("not part of the run, not checked", &found.foreign_files);
    let folder = named.or_else(|| found.scene.clone().filter(|scene| scene.is_dir()));
    match (&folder, &found.scene) {
        (Some(folder), _) => {
            let shown = folder.canonicalize().unwrap_or_else(|_| folder.clone());
            let shown = if args.scene.is_some() { folder } else { &shown };
            say!("{}: {} inputs unchanged since the run", shown.display(), found.same_inputs);
            list("input changed since the run", &found.changed_inputs);
        }
        (None, Some(gone)) => {
            say!("inputs not checked: the scene is not at {}; name it with --scene", gone.display());
        }
        (None, None) => {
            say!("inputs not checked: the manifest does not give the path of the scene; name it with --scene")
        }
    }
    let signed = match args.public_key.as_deref().map(|key| check_signature(&args.run, key)) {
        None if found.has_signature => {
            say!("signature not checked: name the signer's key with --public-key");
            true
        }
        None => {
            say!("not signed: anyone with write access to the folder could have written the manifest");
            true
        }
        Some(Ok(())) => {
            say!("the manifest is signed with this key");
            true
        }
        Some(Err(e @ (SignatureError::Wrong { .. } | SignatureError::Missing { .. }))) => {
            say!("  {e}");
            false
        }
        Some(Err(e)) => return Err(explained(&e)),
    };
    Ok(match (found.holds() && signed, folder.is_some() && found.changed_inputs.is_empty()) {
        (false, _) => State::Fail,
        (true, true) => State::Pass,
        (true, false) => State::Unchecked,
    })
}

/// Signs a run folder.
pub(crate) fn sign(args: &SignArgs) -> Result<(), Failure> {
    put_signature(&args.run, &args.key).map_err(|e| explained(&e))?;
    say!("{}: signed", args.run.display());
    Ok(())
}

/// The error with what to do about it.
fn explained(e: &SignatureError) -> Failure {
    Failure::new(e).with_help(match e {
        SignatureError::Key { what: "private", .. } => {
            "create one with `openssl genpkey -algorithm ed25519 -out key.pem`; sign with it, and give others the public key"
        }
        SignatureError::Key { .. } => {
            "`openssl pkey -in key.pem -pubout -out public.pem` extracts the public key from a private key; never hand out the private key"
        }
        SignatureError::Manifest(_) => RUN_FOLDER,
        SignatureError::Changed { .. } => "`proveout verify` lists every changed file; run the scene again and sign the new run",
        SignatureError::System { .. } => "check path and permissions of the file",
        SignatureError::Missing { .. } | SignatureError::Wrong { .. } => "ask the signer for the run folder again",
    })
}

fn list(what: &str, names: &[String]) {
    for name in names.iter().take(SHOWN) {
        say!("  {what}: {name}");
    }
    if names.len() > SHOWN {
        say!("  {what}: {} more", names.len() - SHOWN);
    }
}

fn folder_of(scene: &Path) -> PathBuf {
    if scene.is_dir() { scene.to_owned() } else { scene.parent().map_or_else(PathBuf::new, Path::to_owned) }
}
