//! `telespring-link relay-config`.

use std::net::IpAddr;
use std::process::ExitCode;

use clap::Args;
use telespring::InvalidInput;
use telespring_link::keys::{SiteId, parse_ids};

use super::Failure;

/// Prints a configuration for a relay of your own, iroh-relay, that serves these sites only, and how to run it
#[derive(Debug, Args)]
pub struct RelayConfig {
    /// The name of the machine that the relay runs on, as both sites reach it; with --own-certificate also its address
    host: String,
    /// The public id of a site that may use the relay; give it for both sites
    #[arg(long = "id", required = true)]
    ids: Vec<String>,
    /// An e-mail address, which Let's Encrypt asks for: the relay has a certificate of it, and a public name
    #[arg(long, required_unless_present = "own_certificate")]
    contact: Option<String>,
    /// The relay has a certificate of an authority of your own: without the internet
    #[arg(long, conflicts_with = "contact")]
    own_certificate: bool,
}

/// The version of iroh-relay that speaks with the iroh of this program.
const VERSION: &str = "1.4.1";

impl RelayConfig {
    pub(super) fn run(self) -> Result<ExitCode, Failure> {
        let ids = parse_ids("--id", &self.ids)?;
        let host = plain("HOST", &self.host, ".-", "a name of a machine, without https:// and port")?;
        let contact = self.contact.as_deref();
        let contact =
            contact.map(|text| plain("--contact", text, "@.-_+", "an e-mail address")).transpose()?;
        print!("{}", configuration(host, contact, &ids));
        Ok(ExitCode::SUCCESS)
    }
}

/// A text of letters, digits and `others`, which needs no quotation.
fn plain<'a>(field: &str, text: &'a str, others: &str, allowed: &str) -> Result<&'a str, InvalidInput> {
    let is_plain = |letter: char| letter.is_ascii_alphanumeric() || others.contains(letter);
    if !text.is_empty() && text.len() <= 253 && text.chars().all(is_plain) {
        return Ok(text);
    }
    let remedy = "Use letters, digits, dots and dashes.";
    Err(InvalidInput::new(field, format!("{text:?}"), allowed, remedy))
}

/// The certificate: of Let's Encrypt, which asks for a `contact`, or of an authority of one's own.
fn certificate(host: &str, contact: Option<&str>) -> String {
    let Some(contact) = contact else {
        let kind = if host.parse::<IpAddr>().is_ok() { "IP" } else { "DNS" };
        return format!(
            "# a certificate of an authority of your own, made once with OpenSSL, version 3 or newer:\n\
             #\n\
             #   openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -noenc -days 3650 \\\n\
             #     -subj \"/CN=relay authority\" -keyout authority.key -out authority.pem\n\
             #   openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -noenc -days 800 \\\n\
             #     -subj \"/CN={host}\" -addext \"subjectAltName={kind}:{host}\" -addext \"basicConstraints=critical,CA:FALSE\" \\\n\
             #     -CA authority.pem -CAkey authority.key -keyout relay.key -out relay.crt\n\
             #\n\
             # authority.pem goes to both sites (relay_authority), authority.key to nobody\n\
             cert_mode = \"Manual\"\n\
             manual_cert_path = \"./relay.crt\"\n\
             manual_key_path = \"./relay.key\"\n"
        );
    };
    format!(
        "# a certificate of Let's Encrypt, which needs {host} to be public\n\
         cert_mode = \"LetsEncrypt\"\n\
         cert_dir = \"./certificates\"\n\
         contact = \"{contact}\"\n"
    )
}

fn configuration(host: &str, contact: Option<&str>, ids: &[SiteId]) -> String {
    let list: String = ids.iter().map(|id| format!("  \"{id}\",\n")).collect();
    let certificate = certificate(host, contact);
    let authority = if contact.is_none() { " and relay_authority = \"authority.pem\"" } else { "" };
    format!(
        "# A relay of your own for telespring, for iroh-relay {VERSION}. On the machine {host}:\n\
         #\n\
         #   cargo install iroh-relay --version {VERSION} --locked --features server\n\
         #   iroh-relay --config-path relay.toml      # this file\n\
         #\n\
         # It needs these ports from outside: 443/tcp (relay), 7842/udp (a site asks under which address it is seen) and\n\
         # 80/tcp. Ports below 1024 need a right: setcap cap_net_bind_service+ep iroh-relay.\n\
         # In both site files, under [network]: relay = \"https://{host}\"{authority}\n\
         # The relay sees who speaks with whom, when and how much; it cannot read or change a packet.\n\
         \n\
         enable_relay = true\n\
         enable_quic_addr_discovery = true\n\
         # numbers for a monitoring program; nobody needs them here\n\
         enable_metrics = false\n\
         http_bind_addr = \"[::]:80\"\n\
         \n\
         # these sites, and nobody else\n\
         access.allowlist = [\n{list}]\n\
         \n\
         [tls]\n\
         https_bind_addr = \"[::]:443\"\n\
         quic_bind_addr = \"[::]:7842\"\n\
         hostname = \"{host}\"\n\
         {certificate}\
         \n\
         # a session at 1 kHz is about 0.2 MB/s each way\n\
         [limits]\n\
         accept_conn_limit = 10.0\n\
         accept_conn_burst = 20\n\
         client.rx.bytes_per_second = 1000000\n\
         client.rx.max_burst_bytes = 200000\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use telespring_link::keys::SiteKey;

    #[test]
    fn law_the_configuration_is_toml_and_names_the_sites_and_nobody_else() {
        let ids = [(); 2].map(|()| SiteKey::generate().id());
        for contact in [None, Some("somebody@example.org")] {
            let text = configuration("relay.example.org", contact, &ids);
            let table: toml::Table = toml::from_str(&text).unwrap();
            let allowed: Vec<&str> = table["access"]["allowlist"]
                .as_array()
                .unwrap()
                .iter()
                .map(|id| id.as_str().unwrap())
                .collect();
            assert_eq!(allowed, ids.map(|id| id.to_string()));
            assert_eq!(table["tls"]["hostname"].as_str(), Some("relay.example.org"));
            // iroh-relay asks Let's Encrypt for nothing without an address
            assert_eq!(table["tls"].get("contact").and_then(|value| value.as_str()), contact);
            let mode = if contact.is_some() { "LetsEncrypt" } else { "Manual" };
            assert_eq!(table["tls"]["cert_mode"].as_str(), Some(mode));
            assert_eq!(table["enable_quic_addr_discovery"].as_bool(), Some(true));
        }
    }

    #[test]
    fn law_the_relay_has_the_version_of_iroh() {
        let manifest: toml::Table = toml::from_str(include_str!("../../../../Cargo.toml")).unwrap();
        let iroh = manifest["workspace"]["dependencies"]["iroh"]["version"].as_str();
        assert_eq!(iroh, Some(format!("={VERSION}").as_str()));
    }

    #[test]
    fn law_nothing_but_a_name_gets_into_the_configuration() {
        for host in ["", "https://relay", "a b", "a\"", "a\nb", "relay:443", "ä"] {
            assert!(plain("HOST", host, ".-", "a name").is_err(), "{host}");
        }
        assert_eq!(plain("HOST", "relay-1.example.org", ".-", "a name"), Ok("relay-1.example.org"));
    }
}
