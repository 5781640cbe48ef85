//! Packets that came while nothing was coupled: the endpoint never saw them, and they were not lost.

use telespring::session::wire::Packet;

/// Counts the packets between two that the endpoint took.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PassedOver {
    /// The session and the highest sequence number of those that the endpoint took, or that were passed over since.
    highest: Option<(u64, u64)>,
    /// Passed over since the endpoint took one.
    waiting: u64,
    /// Those that the endpoint takes for lost, since it took a later one.
    counted: u64,
}

impl PassedOver {
    /// A packet is passed over. One that was overtaken does not count.
    pub(super) fn pass(&mut self, packet: Option<&Packet>) {
        let Some((packet, (session, highest))) = packet.zip(self.highest) else { return };
        if packet.session == session && packet.sequence > highest {
            self.highest = Some((session, packet.sequence));
            self.waiting += 1;
        }
    }

    /// The endpoint takes a packet.
    pub(super) fn take(&mut self, packet: &Packet) {
        let (session, sequence) = (packet.session, packet.sequence);
        match self.highest {
            Some((former, highest)) if former == session => {
                if sequence > highest {
                    self.counted += std::mem::take(&mut self.waiting);
                    self.highest = Some((session, sequence));
                }
            }
            _ => (self.highest, self.waiting) = (Some((session, sequence)), 0),
        }
    }

    /// What was lost, of what the endpoint takes for lost.
    pub(super) fn lost(&self, counted: u64) -> u64 {
        counted.saturating_sub(self.counted)
    }
}
