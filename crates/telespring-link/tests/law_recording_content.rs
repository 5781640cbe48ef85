//! What is read back from a recording is what the loop saw, bit for bit.

mod common;
mod recorded;
mod recording;

use recorded::{Shared, items, recorder, settings, study, summary};
use recording::{number, pair, value, whole, word};
use telespring::session::{Endpoint, LocalTime, Motion, Packet, Span};
use telespring::study::Study;
use telespring_link::feed::{Item, Observer};

fn motion(message: &prost_reflect::DynamicMessage, path: &str) -> Option<Motion> {
    let position = pair(message, &format!("{path}.position"))?;
    Some(Motion { position, velocity: pair(message, &format!("{path}.velocity")).unwrap() })
}

#[test]
fn law_what_is_read_back_is_what_the_loop_saw() {
    let items = items(4000);
    let file = Shared::default();
    let (mut recorder, recording, facts) = recorder(file.clone(), 1);
    items.iter().for_each(|item| recorder.take(item));
    let summary = summary();
    recorder.finish(&summary);
    assert_eq!(recording.summary().status, "complete");
    let file = file.file();
    assert!(file.is_whole);
    // messages stand in the order of the loop
    let mut messages = file.messages.iter().filter(|message| {
        ["tick", "arrival", "event"].map(|name| format!("/site1/{name}")).contains(&message.topic)
    });
    let (mut coupled, mut predicted, mut limited, mut taken, mut refused, mut stale) = (0, 0, 0, 0, 0, 0);
    for item in &items {
        let message = messages.next().unwrap();
        let content = &message.content;
        match item {
            Item::Tick { moment, lateness, duration, overruns } => {
                assert_eq!(whole(content, "overruns"), Some(*overruns));
                assert_eq!(value(content, "is_timed").unwrap().as_bool(), Some(moment.is_timed));
                assert_eq!(number(content, "share"), Some(moment.share));
                assert_eq!(pair(content, "handle_offset"), moment.offset);
                assert_eq!(message.topic, "/site1/tick");
                assert_eq!(whole(content, "tick"), Some(moment.tick));
                assert_eq!(whole(content, "time"), Some(moment.time.0));
                assert_eq!(whole(content, "asked_time"), moment.asked.map(|time| time.0));
                assert_eq!(whole(content, "commanded_time"), Some(moment.commanded.0));
                assert_eq!(number(content, "lateness"), Some(lateness.seconds()));
                assert_eq!(number(content, "duration"), Some(duration.seconds()));
                assert_eq!(word(content, "phase").as_deref(), Some(moment.phase.word()));
                assert_eq!(value(content, "is_measured").unwrap().as_bool(), Some(moment.is_measured));
                assert_eq!(motion(content, "own"), moment.motion);
                assert_eq!(motion(content, "target"), moment.target);
                assert_eq!(number(content, "device_sequence"), moment.stamp.map(|stamp| stamp.sequence));
                assert_eq!(pair(content, "commanded_force"), Some(moment.force));
                assert_eq!(pair(content, "wanted_force"), moment.forces.wanted);
                assert_eq!(pair(content, "told_force"), moment.forces.told);
                assert_eq!(pair(content, "measured_force"), moment.forces.measured);
                let used = moment.used_partner();
                assert_eq!(motion(content, "partner_played"), used.map(|used| used.played));
                assert_eq!(motion(content, "partner_predicted"), used.map(|used| used.wanted));
                assert_eq!(number(content, "played_age"), used.map(|used| used.age));
                let newest = moment.newest;
                assert_eq!(motion(content, "partner_newest"), newest.map(|newest| newest.packet.motion));
                assert_eq!(whole(content, "partner_arrival_time"), newest.map(|newest| newest.arrival.0));
                assert_eq!(whole(content, "partner_sent_time"), newest.map(|newest| newest.packet.sent.0));
                assert_eq!(number(content, "energy_balance"), moment.balance);
                let session = moment.session;
                let offset = value(content, "clock_offset").map(|value| value.as_i64().unwrap());
                assert_eq!(offset, session.clock.offset.map(|span| span.0));
                assert_eq!(number(content, "round_trip"), session.clock.round_trip.map(Span::seconds));
                // what an endpoint that is not asked has to say is of an earlier time
                let is_limited = moment.asked.is_some() && session.outgoing.limited;
                assert_eq!(value(content, "is_limited").unwrap().as_bool(), Some(is_limited));
                let stiffness =
                    used.map_or(0.0, |_| session.outgoing.stiffness * session.enabled * moment.share);
                assert_eq!(number(content, "stiffness"), Some(stiffness));
                stale += u64::from(used.is_none() && session.outgoing.stiffness > 0.0);
                assert_eq!(number(content, "stiffness_wanted"), Some(142.0));
                assert_eq!(number(content, "energy_given_out"), Some(session.strategy.given_out));
                assert_eq!(whole(content, "packets_received"), Some(session.received));
                assert_eq!(whole(content, "packets_refused"), Some(session.refused));
                let latency = moment.latency(*lateness);
                assert_eq!(number(content, "latency_loop"), Some(latency.control));
                assert_eq!(number(content, "latency_network"), latency.network);
                assert_eq!(number(content, "latency_playout"), latency.playout);
                coupled += u64::from(moment.asked.is_some());
                predicted += u64::from(used.is_some_and(|used| used.wanted != used.played));
                limited += u64::from(moment.forces.wanted.is_some_and(|wanted| wanted != moment.force));
            }
            Item::Arrival(arrival) => {
                assert_eq!(message.topic, "/site1/arrival");
                assert_eq!(whole(content, "tick"), Some(arrival.tick));
                assert_eq!(whole(content, "time"), Some(arrival.time.0));
                assert_eq!(whole(content, "length"), Some(arrival.length as u64));
                let datagram = value(content, "datagram").unwrap().as_bytes().unwrap().clone();
                assert_eq!(datagram, arrival.bytes());
                assert_eq!(value(content, "is_taken").unwrap().as_bool(), Some(arrival.is_taken));
                let packet = Packet::decode(&datagram).ok().filter(|_| arrival.length == datagram.len());
                assert_eq!(packet.is_some(), arrival.is_taken);
                taken += u64::from(arrival.is_taken);
                refused += u64::from(!arrival.is_taken);
            }
            Item::Event { time, .. } => {
                assert_eq!(message.topic, "/site1/event");
                assert_eq!(whole(content, "time"), Some(time.0));
            }
        }
        let time = whole(content, "time").unwrap();
        assert_eq!([message.log_time, message.publish_time], [facts.zero + time; 2]);
    }
    assert!(messages.next().is_none());
    // the session had all of it
    assert!(
        coupled > 2000 && predicted > 500 && limited > 100 && taken > 2000,
        "{coupled} {predicted} {limited} {taken}"
    );
    assert!(refused >= 20 && stale > 100, "{refused} {stale}");
    let events: Vec<_> = file.events(1).into_iter().map(|(event, _)| event).collect();
    assert!(
        ["agreed", "phase", "partner-found", "engaged"]
            .iter()
            .all(|event| events.contains(&(*event).to_owned())),
        "{events:?}"
    );
    assert_eq!(file.of("/site1/log").count(), events.len());
    // 60 per second of 4 s
    for topic in ["/site1/handle", "/site1/target"] {
        assert!((235..=242).contains(&file.of(topic).count()), "{topic} {}", file.of(topic).count());
    }
    let telespring = &file.metadata["telespring"];
    for (key, expected) in
        [("format_version", "1"), ("side", "1"), ("session", "0x0000000000000015"), ("device", "simulated")]
    {
        assert_eq!(telespring[key], expected, "{key}");
    }
    assert_eq!(telespring["wall_time_zero"], facts.zero.to_string());
    assert_eq!(file.metadata["end"]["missed"], "0");
    let read_study = Study::from_toml(std::str::from_utf8(&file.attachments["study.toml"]).unwrap()).unwrap();
    assert_eq!(read_study.to_toml(), study().to_toml());
    let read_summary: serde_json::Value = serde_json::from_slice(&file.attachments["summary.json"]).unwrap();
    assert_eq!(read_summary["side"], 1);
}

#[test]
fn law_an_endpoint_that_is_told_what_the_file_says_wants_what_it_wanted() {
    let items = items(4000);
    let file = Shared::default();
    let (mut recorder, ..) = recorder(file.clone(), 1);
    items.iter().for_each(|item| recorder.take(item));
    recorder.finish(&summary());
    let file = file.file();
    let mut endpoint = Endpoint::new(settings(&study(), 1).endpoint).unwrap();
    let (mut arrivals, mut compared, mut timed, mut largest) = (Vec::new(), 0, 0, 0.0_f64);
    for message in &file.messages {
        let content = &message.content;
        let time = || LocalTime(whole(content, "time").unwrap());
        if message.topic == "/site1/arrival" {
            let mut datagram = value(content, "datagram").unwrap().as_bytes().unwrap().to_vec();
            datagram.resize(usize::try_from(whole(content, "length").unwrap()).unwrap(), 0);
            arrivals.push((time(), datagram));
        }
        if message.topic != "/site1/tick" {
            continue;
        }
        if value(content, "is_measured").unwrap().as_bool() == Some(true) {
            if let Some(told) = pair(content, "told_force") {
                endpoint.handle_acted(told);
            }
            let _ = endpoint.handle_measurement(time(), motion(content, "own").unwrap());
            if let Some(target) = motion(content, "target") {
                endpoint.handle_target(time(), target);
            }
            endpoint.poll_transmit(time()).unwrap();
        }
        if value(content, "is_timed").unwrap().as_bool() == Some(true) {
            endpoint.handle_timeout(time());
            timed += 1;
        }
        for (time, datagram) in arrivals.drain(..) {
            let _ = endpoint.handle_datagram(time, &datagram);
        }
        if let Some(asked) = whole(content, "asked_time") {
            let force = endpoint.force(LocalTime(asked));
            assert_eq!(
                Some(force.map(f64::to_bits)),
                pair(content, "wanted_force").map(|force| force.map(f64::to_bits))
            );
            compared += 1;
            largest = force.iter().fold(largest, |largest, force| largest.max(force.abs()));
        }
    }
    assert!(compared > 2000 && timed > 10 && largest > 1.0, "{compared} {timed} {largest}");
}
