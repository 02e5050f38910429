//! `manifest.sig`: who vouches for a run folder.
//!
//! The manifest names every file with its SHA-256, so that one signature of its bytes covers all of
//! them. It is that of Ed25519 (RFC 8032: Josefsson and Liusvaara 2017) in its 64 bytes as they
//! are; keys are the PEM files of RFC 8410 that OpenSSL writes and reads:
//!
//! ```text
//! openssl genpkey -algorithm ed25519 -out key.pem
//! openssl pkey -in key.pem -pubout -out public.pem
//! openssl pkeyutl -verify -pubin -inkey public.pem -rawin -in manifest.json -sigfile manifest.sig
//! ```
//!
//! A signature says who had the key and that nothing has changed since; what the run claims is another
//! matter.

use std::{
    fs,
    io::Read,
    path::{Path, PathBuf},
};

use ed25519_compact::{KeyPair, PublicKey, SecretKey, Signature};
use proveout_input::read_regular_text;
use thiserror::Error;

use crate::evidence::manifest::{MANIFEST, ManifestError, verify_files};

/// Name of the file in a run folder.
pub const SIGNATURE: &str = "manifest.sig";
/// Largest key file.
const MAX_KEY: u64 = 1 << 16;
/// Largest manifest.
const MAX_MANIFEST: u64 = 64 << 20;

/// Why a run is not signed, or its signature does not hold.
#[derive(Debug, Error)]
pub enum SignatureError {
    /// There is no manifest.
    #[error(transparent)]
    Manifest(#[from] ManifestError),
    /// A folder that is not what the run has written must not be signed.
    #[error("{}: changed since the run: {what}", run.display())]
    Changed {
        /// The run folder.
        run: PathBuf,
        /// The first file that is not, with what is wrong.
        what: String,
    },
    /// A file cannot be read or written.
    #[error("{} cannot be {what}: {source}", path.display())]
    System {
        /// The file.
        path: PathBuf,
        /// `read`, `written`.
        what: &'static str,
        /// What the system said.
        source: std::io::Error,
    },
    /// Not a key of this kind.
    #[error("{} is no {what} Ed25519 key in PEM", path.display())]
    Key {
        /// The file.
        path: PathBuf,
        /// `private`, `public`.
        what: &'static str,
    },
    /// The folder is not signed.
    #[error("{} is not signed: it has no {SIGNATURE}", run.display())]
    Missing {
        /// The run folder.
        run: PathBuf,
    },
    /// Signed with another key, or changed since.
    #[error("{}: the signature is not that of this key and this manifest", run.display())]
    Wrong {
        /// The run folder.
        run: PathBuf,
    },
}

/// Signs a run folder with a private key; an older signature is replaced.
///
/// # Errors
/// [`SignatureError`]; a folder that is not as the run wrote it is not signed.
pub fn sign(run: &Path, key: &Path) -> Result<(), SignatureError> {
    let found = verify_files(run)?;
    if let Some(what) = found.changed_files.into_iter().next() {
        return Err(SignatureError::Changed { run: run.to_owned(), what });
    }
    let no_key = |_| SignatureError::Key { path: key.to_owned(), what: "private" };
    let secret = SecretKey::from_pem(&text(key, MAX_KEY)?).map_err(no_key)?;
    // A seed of zeros is none.
    let pair = KeyPair::try_from_seed(secret.seed()).map_err(no_key)?;
    let signature = pair.sk.sign(text(&run.join(MANIFEST), MAX_MANIFEST)?, None);
    let (path, beside) = (run.join(SIGNATURE), run.join(format!(".{SIGNATURE}.{}", std::process::id())));
    let written = fs::write(&beside, signature.as_ref()).and_then(|()| fs::rename(&beside, &path));
    written.map_err(|source| {
        // Nothing is half there; what cannot be removed has a hidden name.
        fs::remove_file(&beside).ok();
        SignatureError::System { path, what: "written", source }
    })
}

/// Holds the signature of a run folder against a public key. The files are another question, see
/// [`crate::verify`].
///
/// # Errors
/// [`SignatureError`] when it does not hold.
pub fn check_signature(run: &Path, public_key: &Path) -> Result<(), SignatureError> {
    let no_key = |_| SignatureError::Key { path: public_key.to_owned(), what: "public" };
    let key = PublicKey::from_pem(&text(public_key, MAX_KEY)?).map_err(no_key)?;
    key.validate().map_err(no_key)?;
    let path = run.join(SIGNATURE);
    if !path.is_file() {
        return Err(SignatureError::Missing { run: run.to_owned() });
    }
    let mut bytes = Vec::new();
    let read = fs::File::open(&path).and_then(|file| file.take(65).read_to_end(&mut bytes));
    read.map_err(|source| SignatureError::System { path, what: "read", source })?;
    let manifest = text(&run.join(MANIFEST), MAX_MANIFEST)?;
    let wrong = |_| SignatureError::Wrong { run: run.to_owned() };
    let signature = Signature::from_slice(&bytes).map_err(wrong)?;
    key.verify(manifest, &signature).map_err(wrong)
}

fn text(path: &Path, most: u64) -> Result<String, SignatureError> {
    read_regular_text(path, most).map_err(|source| SignatureError::System {
        path: path.to_owned(),
        what: "read",
        source,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evidence::manifest::{Manifest, verify};

    /// The first key of RFC 8032, chapter 7.1, in the PEM of RFC 8410.
    const PRIVATE: &str = "-----BEGIN PRIVATE KEY-----\n\
        MC4CAQAwBQYDK2VwBCIEIJ1hsZ3v/VpguoRK9JLsLMREScVpezJpGXA7rAMcrn9g\n-----END PRIVATE KEY-----\n";
    const PUBLIC: &str = "-----BEGIN PUBLIC KEY-----\n\
        MCowBQYDK2VwAyEA11qYAYKxCrfVS/7TyWQHOg7hcvPapiMlrwIaaPcHURo=\n-----END PUBLIC KEY-----\n";

    #[test]
    fn the_keys_are_those_of_the_standard() {
        let pair = KeyPair::try_from_seed(SecretKey::from_pem(PRIVATE).expect("a key").seed()).expect("a seed");
        assert_eq!(*pair.pk, *PublicKey::from_pem(PUBLIC).expect("a key"));
        // Its signature of nothing, as the standard prints it.
        let hex: String = pair.sk.sign("", None).iter().map(|b| format!("{b:02x}")).collect();
        assert_eq!(
            hex,
            "e5564300c360ac729086e2cc806e828a84877f1eb8e5d974d873e065224901555fb8821590a33bacc61e39701cf9b46bd25bf5f0595bbe24655141438e7a100b"
        );
    }

    #[test]
    fn a_signature_is_of_this_key_and_this_manifest() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let file = |name: &str| folder.path().join(name);
        let run = file("run");
        fs::create_dir(&run).expect("made");
        fs::write(run.join("verdict.json"), "pass").expect("written");
        fs::write(file("scene.toml"), "a scene").expect("written");
        let scene = crate::evidence::digest::of_input("scene", &file("scene.toml")).expect("there");
        Manifest::of(&run, &[scene], folder.path()).and_then(|m| m.write(&run)).expect("written");
        fs::write(file("key.pem"), PRIVATE).expect("written");
        fs::write(file("public.pem"), PUBLIC).expect("written");
        let held = || check_signature(&run, &file("public.pem"));
        assert!(matches!(held(), Err(SignatureError::Missing { .. })));
        sign(&run, &file("key.pem")).expect("signed");
        held().expect("holds");
        assert!(verify(&run, None).expect("a manifest").foreign_files.is_empty(), "the signature is the run's own");
        // Keys that are none, and each other's.
        for (key, public) in [("public.pem", "key.pem"), ("run/verdict.json", "run/verdict.json")] {
            assert!(matches!(sign(&run, &file(key)), Err(SignatureError::Key { .. })), "{key}");
            assert!(matches!(check_signature(&run, &file(public)), Err(SignatureError::Key { .. })), "{public}");
        }
        // Any other byte of the manifest or the signature.
        for name in [MANIFEST, SIGNATURE] {
            let good = fs::read(run.join(name)).expect("there");
            for at in (0..good.len()).step_by(7) {
                let mut bad = good.clone();
                bad[at] ^= 1;
                fs::write(run.join(name), bad).expect("written");
                assert!(matches!(held(), Err(SignatureError::Wrong { .. })), "{name}, byte {at}");
            }
            fs::write(run.join(name), [&good[..], &[0]].concat()).expect("written");
            assert!(matches!(held(), Err(SignatureError::Wrong { .. })), "{name} is longer");
            fs::write(run.join(name), good).expect("written");
        }
        held().expect("as before");
        fs::write(run.join("verdict.json"), "PASS").expect("written");
        assert!(matches!(sign(&run, &file("key.pem")), Err(SignatureError::Changed { .. })));
    }
}
