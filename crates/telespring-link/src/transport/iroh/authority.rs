//! Who vouches for the relay: the authority whose certificate it must have.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use iroh::tls::CaTlsConfig;
use rustls_pki_types::CertificateDer;
use rustls_pki_types::pem::PemObject;
use telespring::InvalidInput;

/// More bytes than the certificates of an authority have.
const MOST_BYTES: u64 = 1 << 20;

/// An authority of one's own: a relay must have a certificate of it, and of no other one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Authority(Vec<CertificateDer<'static>>);

impl Authority {
    /// Reads the certificates of an authority from a file in the form of PEM, as OpenSSL writes it.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with `field` if there is no such file, or no certificate in it.
    pub fn read(field: &str, path: &Path) -> Result<Self, InvalidInput> {
        let refuse = |allowed: String| {
            let remedy = "Give the file authority.pem that telespring-link relay-config tells how to make.";
            InvalidInput::new(field, path.display(), allowed, remedy)
        };
        let mut text = Vec::new();
        File::open(path)
            .and_then(|file| file.take(MOST_BYTES).read_to_end(&mut text))
            .map_err(|error| refuse(format!("the file cannot be read ({error})")))?;
        match CertificateDer::pem_slice_iter(&text).collect::<Result<Vec<_>, _>>() {
            Ok(certificates) if !certificates.is_empty() => Ok(Self(certificates)),
            _ => Err(refuse("a certificate between BEGIN CERTIFICATE and END CERTIFICATE".to_owned())),
        }
    }

    /// What iroh is told: the authority, or those on Mozilla's list if there is none.
    pub(super) fn tls(authority: Option<&Self>) -> CaTlsConfig {
        authority
            .map_or_else(CaTlsConfig::embedded, |authority| CaTlsConfig::custom_roots(authority.0.clone()))
    }
}
