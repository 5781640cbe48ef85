//! What a site is put together from: its transport and its device, as a site file names them.

use telespring::InvalidInput;
use telespring::study::Study;
use telespring_link::device::{Device, Simulated, UdpDevice};
use telespring_link::feed::Observer;
use telespring_link::hello::Terms;
use telespring_link::settings::{DeviceChoice, NetworkChoice, TelemetryChoice};
use telespring_link::telemetry::Telemetry;
use telespring_link::transport::{Iroh, Transport, Udp};

/// The way to the partner; `priority` is that of the loop.
pub(super) fn transport(
    network: &NetworkChoice,
    priority: Option<i32>,
) -> Result<Box<dyn Transport>, InvalidInput> {
    Ok(match network {
        NetworkChoice::Udp { local, peer } => {
            Box::new(Udp::new(*local, *peer).map_err(system("network.local", local))?)
        }
        NetworkChoice::Iroh(choice) => {
            let local: Vec<String> = choice.local.iter().map(ToString::to_string).collect();
            let refuse = system("network.local", local.join(", "));
            Box::new(Iroh::new(&choice.settings(priority)?).map_err(refuse)?)
        }
    })
}

/// The robot of `side`, 1 or 2.
pub(super) fn device(
    choice: &DeviceChoice,
    study: &Study,
    side: u8,
) -> Result<Box<dyn Device>, InvalidInput> {
    Ok(match *choice {
        DeviceChoice::Simulated { seed } => {
            let laboratory = study.laboratory_without_traces()?;
            Box::new(Simulated::new(&laboratory, usize::from(side) - 1, seed)?)
        }
        DeviceChoice::Udp { local, device, deadline } => {
            Box::new(UdpDevice::new(local, device, deadline).map_err(system("device.local", local))?)
        }
    })
}

/// The rows for other programs of this machine.
pub(super) fn telemetry(choice: &TelemetryChoice, terms: &Terms) -> Result<Box<dyn Observer>, InvalidInput> {
    Ok(Box::new(Telemetry::new(choice, terms).map_err(system("telemetry.address", "a socket"))?))
}

/// A refusal of the operating system, with the key that led to it.
fn system(field: &str, value: impl ToString) -> impl FnOnce(std::io::Error) -> InvalidInput {
    let value = value.to_string();
    let remedy = "Give an address of this machine with a free port, or end the program that has it.";
    let field = field.to_owned();
    move |error| InvalidInput::new(field, value, format!("the address cannot be used ({error})"), remedy)
}
