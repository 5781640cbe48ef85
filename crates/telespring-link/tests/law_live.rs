//! The live view: viewers see the messages of the recording, and none of them holds anybody up.

mod common;
mod recording;

use std::net::{SocketAddr, TcpListener, TcpStream};
use std::time::Duration;

use common::hman_study;
use prost_reflect::{DescriptorPool, DynamicMessage};
use recording::{number, whole};
use serde_json::{Value, json};
use telespring::session::{LocalTime, SessionSnapshot, Span, WatchdogState};
use telespring_link::feed::{Item, Observer};
use telespring_link::record::Facts;
use telespring_link::record::live::LiveServer;
use telespring_link::site::{Forces, Moment, Phase, Safety, SiteSettings};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

fn facts(side: u8) -> Facts {
    let study = hman_study("coupling.stiffness = 142\nnetwork.delay = 0.03\nsession.strategy = \"guard\"");
    Facts::new(&study, &SiteSettings::new(&study, side, 5, Safety::default()).unwrap())
}

fn tick(number: u64) -> Item {
    let time = LocalTime(1_000_000 * number);
    let moment = Moment {
        tick: number,
        time,
        commanded: time,
        phase: Phase::Running,
        state: WatchdogState::Engaged,
        motion: None,
        target: None,
        force: [number as f64, 0.5],
        balance: None,
        age: None,
        heard: None,
        stamp: None,
        device_delay: None,
        is_measured: false,
        is_timed: false,
        forces: Forces::default(),
        asked: None,
        newest: None,
        session: SessionSnapshot::default(),
        wanted_stiffness: 142.0,
        unnoted_arrivals: 0,
        offset: None,
        consents: [true; 2],
        pauses: [false; 2],
        round_trip: None,
        share: 1.0,
        is_cut: false,
    };
    Item::Tick { moment, lateness: Span(0), duration: Span(0), overruns: 0 }
}

struct Viewer(WebSocket<TcpStream>);

impl Viewer {
    fn connect(port: u16) -> Self {
        let stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        let mut request = format!("ws://127.0.0.1:{port}").into_client_request().unwrap();
        request.headers_mut().insert("Sec-WebSocket-Protocol", "foxglove.sdk.v1".parse().unwrap());
        Self(tungstenite::client(request, stream).unwrap().0)
    }

    fn told(&mut self) -> Value {
        loop {
            if let Message::Text(text) = self.0.read().unwrap() {
                return serde_json::from_str(&text).unwrap();
            }
        }
    }

    /// Waits until a topic is offered; its channel.
    fn offered(&mut self, topic: &str) -> Value {
        loop {
            let told = self.told();
            let channels = told["channels"].as_array().cloned().unwrap_or_default();
            if let Some(channel) = channels.into_iter().find(|channel| channel["topic"] == topic) {
                return channel;
            }
        }
    }

    fn subscribe(&mut self, channel: &Value) {
        let order = json!({"op": "subscribe", "subscriptions": [{"id": 3, "channelId": channel["id"]}]});
        self.0.send(Message::text(order.to_string())).unwrap();
    }

    /// The next message of a channel, and its date.
    fn message(&mut self, channel: &Value) -> (u64, DynamicMessage) {
        loop {
            let Message::Binary(bytes) = self.0.read().unwrap() else { continue };
            // message data, subscription, date, content
            if bytes[0] != 1 {
                continue;
            }
            assert_eq!(bytes[1..5], [3, 0, 0, 0]);
            let date = u64::from_le_bytes(bytes[5..13].try_into().unwrap());
            let schema = base64(channel["schema"].as_str().unwrap());
            let pool = DescriptorPool::decode(&schema[..]).unwrap();
            let schema = pool.get_message_by_name(channel["schemaName"].as_str().unwrap()).unwrap();
            return (date, DynamicMessage::decode(schema, &bytes[13..]).unwrap());
        }
    }
}

fn base64(text: &str) -> Vec<u8> {
    let alphabet = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let (mut bits, mut count, mut bytes) = (0_u32, 0, Vec::new());
    for byte in text.bytes().filter(|byte| *byte != b'=') {
        bits = bits << 6 | alphabet.iter().position(|letter| *letter == byte).unwrap() as u32;
        count += 6;
        if count >= 8 {
            count -= 8;
            bytes.push((bits >> count) as u8);
            bits &= (1 << count) - 1;
        }
    }
    bytes
}

#[test]
fn law_viewers_see_the_messages_of_both_sites() {
    let server = LiveServer::start("live.address", "127.0.0.1:0".parse().unwrap()).unwrap();
    let facts = [facts(1), facts(2)];
    let mut views = facts.each_ref().map(|facts| server.view(facts));
    for (side, view) in (1..).zip(&mut views) {
        let mut viewer = Viewer::connect(server.port());
        let channel = viewer.offered(&format!("/site{side}/tick"));
        assert_eq!((&channel["encoding"], &channel["schemaName"]), (&json!("protobuf"), &json!("tick.Tick")));
        viewer.subscribe(&channel);
        // until the server has heard of the subscription, nothing comes
        std::thread::scope(|scope| {
            let (stop, stopped) = std::sync::mpsc::channel::<()>();
            let zero = facts[side - 1].zero;
            let publish = scope.spawn(move || {
                let mut number = 0;
                while stopped
                    .recv_timeout(Duration::from_millis(1))
                    .is_err_and(|error| error == std::sync::mpsc::RecvTimeoutError::Timeout)
                {
                    view.take(&tick(number));
                    number += 1;
                }
            });
            let mut last = None;
            for _ in 0..20 {
                let (date, message) = viewer.message(&channel);
                let tick = whole(&message, "tick").unwrap();
                assert_eq!(date, zero + 1_000_000 * tick);
                assert_eq!(number(&message, "commanded_force.x"), Some(tick as f64));
                assert!(last.is_none_or(|last| tick == last + 1), "{tick} {last:?}");
                last = Some(tick);
            }
            drop(stop);
            publish.join().unwrap();
        });
    }
}

#[test]
fn law_a_viewer_that_reads_nothing_holds_nobody_up() {
    let server = LiveServer::start("live.address", "127.0.0.1:0".parse().unwrap()).unwrap();
    let mut view = server.view(&facts(1));
    let mut idle = Viewer::connect(server.port());
    let channel = idle.offered("/site1/tick");
    idle.subscribe(&channel);
    let mut busy = Viewer::connect(server.port());
    let channel = busy.offered("/site1/tick");
    busy.subscribe(&channel);
    // far more than all buffers hold
    (0..100_000).for_each(|number| view.take(&tick(number)));
    assert_eq!(server.viewers(), 2);
    std::thread::scope(|scope| {
        let reader = scope.spawn(|| (0..10).map(|_| whole(&busy.message(&channel).1, "tick").unwrap()).max());
        for number in 100_000.. {
            view.take(&tick(number));
            std::thread::sleep(Duration::from_millis(1));
            if reader.is_finished() {
                break;
            }
        }
        assert!(reader.join().unwrap().is_some());
    });
}

#[test]
fn law_an_address_that_others_reach_or_somebody_has_is_refused() {
    let refuse = |address: SocketAddr| LiveServer::start("live.address", address).unwrap_err().to_string();
    let message = refuse("0.0.0.0:0".parse().unwrap());
    assert!(message.contains("live.address = 0.0.0.0:0") && message.contains("of this machine"), "{message}");
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    assert!(refuse(taken.local_addr().unwrap()).contains("cannot be used"));
}
