//! What somebody can do about what happened, in a sentence or two.

use crate::device::Fault;
use crate::operator::{MarkKind, Order};
use crate::site::{Happened, Interruption, Phase, Why};
use crate::transport::PathEvent;

/// What to do about it; `None` if there is nothing to do, or nothing that is not said already.
pub(super) fn remedy(happened: &Happened) -> Option<&'static str> {
    Some(match happened {
        Happened::Entered(phase) => return of_phase(*phase),
        Happened::Interrupted(interruption) => return of_interruption(*interruption),
        Happened::Path(event) => return of_path(*event),
        Happened::OrderRefused { order, phase } => of_order(order, *phase),
        Happened::Disagreed(difference) => difference.on.remedy(),
        Happened::Offset(_) => "Then let both handles rest.",
        Happened::EmergencyStop { is_own: true } => "Release the emergency stop, then order clear.",
        Happened::EmergencyStop { is_own: false } => {
            "It is released and cleared at the partner's site; nothing to do here."
        }
        Happened::NetworkPause(_) => "Order resume here once the network is good again.",
        Happened::DelayTooShort { .. } => {
            "Impose a longer delay: playout of the study, at both sites; or use a faster network."
        }
        Happened::ImpossibleValue { .. } => {
            "Mend the device program: it sends finite numbers, in m, m/s and N (docs/device-protocol.md)."
        }
        Happened::DeviceAwaited => {
            "No row has come from the device: start its program, which sends from device.device to device.local of the site file."
        }
        Happened::PartnerAwaited => {
            "Nothing has come from the partner: start its site; if it runs, compare addresses, and try telespring-link check at both."
        }
        Happened::RecordingBroken => "See whether the disk is full; what was written before can be read.",
        _ => return None,
    })
}

fn of_phase(phase: Phase) -> Option<&'static str> {
    match phase {
        Phase::Homing => Some("Home both robots and enable their motors, at the site where that is missing."),
        Phase::Aligning => Some("Bring the handles to the same place, and let them rest."),
        Phase::Consenting => Some("Order consent at each site whose person agrees to be coupled now."),
        Phase::Paused => Some("Order resume at each site that wanted the pause."),
        Phase::Stopped => Some("Release the emergency stop, and order clear where it was pressed."),
        _ => None,
    }
}

fn of_interruption(interruption: Interruption) -> Option<&'static str> {
    match interruption {
        Interruption::Device(Fault::Silent) => Some(
            "Start the device program again, or see why it stands still; nothing else needs a new start.",
        ),
        Interruption::Device(Fault::Impossible) => {
            Some("Mend what the device program sends; the event impossible-value says which value.")
        }
        Interruption::DeviceNotReady => Some("Home the robot and enable its motors."),
        Interruption::Velocity => {
            Some("Let the handle rest, then order resume; limits.velocity is the limit.")
        }
        Interruption::Workspace => Some("Move the handle back into limits.workspace, then order resume."),
        Interruption::Partner(Why::NotReady) => {
            Some("The partner's robot is silent, not homed, or its motors are off: nothing to do here.")
        }
        Interruption::Partner(Why::Paused) => Some("The partner wanted the pause: it must resume there."),
        Interruption::Partner(Why::Stopped) => {
            Some("The emergency stop is released and cleared at the partner's site.")
        }
        _ => None,
    }
}

fn of_path(event: PathEvent) -> Option<&'static str> {
    match event {
        PathEvent::Refused => Some(
            "The partner does not know this site's key: send it what telespring-link id prints here, for its network.peer_id.",
        ),
        PathEvent::Stranger => {
            Some("If that is the partner: network.peer_id here must be what telespring-link id prints there.")
        }
        PathEvent::Withheld => {
            Some("Open a port at one site, or allow packets over the relay at both (docs/network.md).")
        }
        _ => None,
    }
}

fn of_order(order: &Order, phase: Phase) -> &'static str {
    match order {
        Order::Unknown(text) => of_text(text.text()),
        _ if matches!(phase, Phase::RampingOut | Phase::Ended) => {
            "The force is let down: try again when that is over."
        }
        Order::Consent => match phase {
            Phase::Connecting => "Wait for the partner first.",
            Phase::Homing => "Home both robots and enable their motors first.",
            Phase::Aligning => "Align the handles first: the event offset says how far they are apart.",
            Phase::Consenting => "The consent of this site is given; the partner's is missing.",
            Phase::Paused => "Order resume first, at each site that wanted the pause.",
            Phase::Stopped => "Release the emergency stop and order clear first, where it was pressed.",
            _ => "Both sites have consented already.",
        },
        Order::Withdraw => "No consent of this site is given.",
        Order::Pause => "This site is paused already.",
        Order::Resume if phase == Phase::Paused => "The partner wanted this pause: it must resume there.",
        Order::Resume => "This site has not ordered a pause.",
        Order::Clear if phase == Phase::Stopped => {
            "Release the emergency stop first; the partner's is cleared at its own site."
        }
        Order::Clear => "No emergency stop has latched here.",
        _ => "The session leaves.",
    }
}

/// What is wrong with a text that is no order.
fn of_text(text: &str) -> &'static str {
    let mut words = text.split_whitespace();
    match (words.next(), words.next()) {
        (Some("mark"), Some(kind)) if kind == MarkKind::Participant.word() => {
            "A participant is a code of up to 16 letters, digits, - and _ with at least one digit, such as P-07: never a name."
        }
        (Some("mark"), _) => {
            "Write mark, then trial, condition, participant or note, then up to 64 printable ASCII characters."
        }
        _ => "The orders are consent, withdraw, pause, resume, stop, clear, and mark KIND TEXT.",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_a_refused_order_says_what_comes_first_and_who_can_do_it() {
        let said = |order: Order, phase| remedy(&Happened::OrderRefused { order, phase }).unwrap();
        for (order, phase, what) in [
            (Order::Resume, Phase::Paused, "The partner wanted"),
            (Order::Resume, Phase::Running, "has not ordered a pause"),
            (Order::Clear, Phase::Stopped, "Release the emergency stop first"),
            (Order::Consent, Phase::Aligning, "Align the handles first"),
            (Order::Consent, Phase::Running, "already"),
            (Order::parse("consnt"), Phase::Consenting, "The orders are consent, "),
            (Order::parse("mark participant Anna"), Phase::Consenting, "with at least one digit"),
            (Order::parse("mark lunch"), Phase::Consenting, "Write mark, then trial"),
        ] {
            assert!(said(order, phase).contains(what), "{order:?} {phase:?}: {}", said(order, phase));
        }
    }
}
