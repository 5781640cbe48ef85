//! The replay of both sites of a session.

use super::recorded::{RecordedArrival, RecordedSite};
use super::site::{ReplaySettings, ReplayedSite, RunningReplay};
use crate::error::{InvalidInput, Result};
use crate::rig::network::Datagram;
use crate::session::{LocalTime, Packet};

/// Replays both sites of a session. A packet that arrived arrives once more at the recorded time and place in the order, with
/// the content that its replayed sender gives it: energies, stamps and waves are those of the settings here. What was lost
/// stays lost. A datagram that the partner's recording does not account for has the content that it had
/// ([`ReplayedSite::renewed`] counts the others).
///
/// # Errors
///
/// [`InvalidInput`] for a setting out of range, the same session id on both sides, or two recordings that contradict each
/// other: each needs a packet that the other had not sent yet.
pub fn replay_pair(
    settings: [ReplaySettings; 2],
    recordings: [&RecordedSite; 2],
) -> Result<[ReplayedSite; 2]> {
    let sessions = settings.each_ref().map(|settings| settings.endpoint.session);
    if sessions[0] == sessions[1] {
        return Err(InvalidInput::new(
            "session",
            format!("{:#x}", sessions[0]),
            "both sides have a session id of their own",
            "Give the recordings of two sites, not one of them twice.",
        ));
    }
    let [one, two] = settings;
    let mut first = RunningReplay::new(one, recordings[0])?;
    let mut second = RunningReplay::new(two, recordings[1])?;
    (first.sent, second.sent) = (Some(Vec::new()), Some(Vec::new()));
    loop {
        let before = [first.place(), second.place()];
        advance(&mut first, &second, sessions[1]);
        advance(&mut second, &first, sessions[0]);
        if first.now().is_none() && second.now().is_none() {
            return Ok([first.finish(), second.finish()]);
        }
        if [first.place(), second.place()] == before {
            return Err(InvalidInput::new(
                "arrivals",
                "a packet before it was sent",
                "each site gets only packets that the other has sent",
                "Give the two recordings of one session.",
            ));
        }
    }
}

/// Replays a site up to the first packet that its partner has not sent yet.
fn advance(site: &mut RunningReplay<'_>, partner: &RunningReplay<'_>, partner_session: u64) {
    while let Some(recorded) = site.next_arrival() {
        match renew(&recorded, partner, partner_session) {
            Content::Later => return,
            Content::Recorded => site.take(&recorded),
            Content::Renewed(datagram) => {
                site.take(&RecordedArrival { datagram, ..recorded });
                site.renewed += 1;
            }
        }
    }
}

/// Where the content of an arrival comes from.
enum Content {
    /// The partner sends it later.
    Later,
    /// The recording.
    Recorded,
    /// The replayed partner.
    Renewed(Datagram),
}

/// The content of an arrival.
fn renew(recorded: &RecordedArrival, partner: &RunningReplay<'_>, partner_session: u64) -> Content {
    let (Ok(packet), Some(sent)) = (Packet::decode(&recorded.datagram), &partner.sent) else {
        return Content::Recorded;
    };
    if packet.session != partner_session {
        return Content::Recorded;
    }
    let stamp = LocalTime(packet.sent.0);
    let found = sent.binary_search_by_key(&stamp, |(stamp, _)| *stamp);
    let Ok(index) = found else {
        // the partner has come that far, or to its end, without it
        return if partner.is_past(stamp) { Content::Recorded } else { Content::Later };
    };
    match Packet::decode(&sent[index].1) {
        // a recording with gaps counts its packets differently
        Ok(renewed) => Content::Renewed(Packet { sequence: packet.sequence, ..renewed }.encode()),
        Err(_) => Content::Recorded,
    }
}
