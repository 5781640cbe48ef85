//! `telespring-link relay-config`.

use std::process::ExitCode;

use clap::Args;
use telespring::InvalidInput;
use telespring_link::keys::{SiteId, parse_ids};

use super::Failure;

/// Prints a configuration for a relay of your own, iroh-relay, that serves these sites only, and how to run it
#[derive(Debug, Args)]
pub struct RelayConfig {
    /// The name of the machine that the relay runs on, as both sites reach it
    host: String,
    /// The public id of a site that may use the relay; give it for both sites
    #[arg(long = "id", required = true)]
    ids: Vec<String>,
    /// An e-mail address for the certificate authority
    #[arg(long)]
    contact: Option<String>,
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

fn configuration(host: &str, contact: Option<&str>, ids: &[SiteId]) -> String {
    let list: String = ids.iter().map(|id| format!("  \"{id}\",\n")).collect();
    let contact = contact.map_or_else(
        || "# contact = \"you@example.org\"      # where the certificate authority writes to\n".to_owned(),
        |contact| format!("contact = \"{contact}\"\n"),
    );
    format!(
        "# A relay of your own for telespring, for iroh-relay {VERSION}. On the machine {host}:\n\
         #\n\
         #   cargo install iroh-relay --version {VERSION} --locked --features server\n\
         #   telespring-link relay-config {host} --id … --id … > relay.toml\n\
         #   iroh-relay --config-path relay.toml\n\
         #\n\
         # It needs these ports from outside: 443/tcp (relay), 7842/udp (a site asks under which address it is seen) and\n\
         # 80/tcp. Ports below 1024 need a right: setcap cap_net_bind_service+ep iroh-relay.\n\
         # In both site files: relay = \"https://{host}\" under [network].\n\
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
         # a certificate of Let's Encrypt, which needs {host} to be public; for one of your own: cert_mode = \"Manual\",\n\
         # with manual_cert_path and manual_key_path, from an authority that Mozilla's list has\n\
         cert_mode = \"LetsEncrypt\"\n\
         cert_dir = \"./certificates\"\n\
         {contact}\
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
            assert_eq!(table["tls"].get("contact").and_then(|value| value.as_str()), contact);
            assert_eq!(table["enable_quic_addr_discovery"].as_bool(), Some(true));
        }
    }

    #[test]
    fn law_nothing_but_a_name_gets_into_the_configuration() {
        for host in ["", "https://relay", "a b", "a\"", "a\nb", "relay:443", "ä"] {
            assert!(plain("HOST", host, ".-", "a name").is_err(), "{host}");
        }
        assert_eq!(plain("HOST", "relay-1.example.org", ".-", "a name"), Ok("relay-1.example.org"));
    }
}
