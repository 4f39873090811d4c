//! Numbers that tell one set of settings from another.

use std::collections::BTreeSet;
use std::path::PathBuf;

use super::{Scene, SpaceSpec};

/// A number that differs where what it was shown does (FNV-1a, 64 bits; Fowler, Noll & Vo, RFC 9923). It starts from the
/// version of the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fingerprint(u64);

impl Default for Fingerprint {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325).and(env!("CARGO_PKG_VERSION").as_bytes())
    }
}

impl Fingerprint {
    /// Takes bytes in.
    #[must_use]
    pub fn and(self, bytes: &[u8]) -> Self {
        Self(bytes.iter().fold(self.0, |hash, &b| (hash ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3)))
    }

    /// The number.
    pub fn number(self) -> u64 {
        self.0
    }
}

impl Scene {
    /// The fingerprint of the scene, its mesh file, the files of its shapes and the program.
    ///
    /// # Errors
    /// What the system says where a file cannot be read.
    pub fn fingerprint(&self) -> std::io::Result<Fingerprint> {
        // Another working folder names the same scene by another path.
        let bare = Self { folder: PathBuf::new(), ..self.clone() };
        let fingerprint = Fingerprint::default().and(format!("{bare:?}").as_bytes());
        let mesh = self.solid.iter().filter_map(|solid| solid.mesh.file.as_ref());
        // Copies of a body share their files.
        let files: BTreeSet<&PathBuf> = mesh.chain(self.space.iter().flat_map(SpaceSpec::files)).collect();
        files.into_iter().try_fold(fingerprint, |fingerprint, file| {
            Ok(fingerprint.and(&std::fs::read(self.folder.join(file))?))
        })
    }
}
