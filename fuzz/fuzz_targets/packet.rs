//! Any bytes are decoded as a packet, which encodes to the same bytes, or refused with a message.

#![no_main]

use libfuzzer_sys::fuzz_target;
use telespring::session::Packet;

fuzz_target!(|bytes: &[u8]| match Packet::decode(bytes) {
    Ok(packet) => {
        assert_eq!(packet.encode().as_slice(), bytes);
        assert!(packet.motion.impossible_value().is_none());
        assert!(packet.energy_sent >= 0.0 && packet.energy_sent.is_finite());
        assert!(packet.stiffness >= 0.0 && packet.stiffness.is_finite());
        assert!(packet.signal.iter().all(|value| value.is_finite()));
    }
    Err(refusal) => assert!(!refusal.to_string().is_empty()),
});
