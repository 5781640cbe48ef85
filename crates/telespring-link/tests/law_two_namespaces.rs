//! The real program between two namespaces: a session over an impaired path, sudden deaths, wrong keys and other versions.

mod judge;
mod live;
mod netns;

use std::process::Command;
use std::time::{Duration, Instant};

use judge::{Rules, judge};
use live::{Known, Live, PORT, SAFETY, STIFFNESS, Trace};
use netns::{Way, at};
use serde_json::Value;
use telespring::session::LocalTime;
use telespring_link::hello::{Greeting, Purpose, Terms, draw_session};
use telespring_link::keys::{SiteId, SiteKey};
use telespring_link::site::Limits;
use telespring_link::transport::{Iroh, Transport};

/// 20 ms ± 3 ms, 2 % of loss each way.
const PATH: Way = Way { delay: 0.02, jitter: 0.003, loss: 0.02, ..Way::IDEAL };
/// Faster than any simulated person moves a handle, m/s: the partner's motion is in another process.
const SPEED: f64 = 2.0;

fn rules() -> Rules {
    Rules { safety: SAFETY, stiffness: STIFFNESS, speed: Some(SPEED) }
}

fn summary(output: &std::process::Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {output:?}"))
}

fn events(summary: &Value) -> Vec<&str> {
    summary["events"].as_array().unwrap().iter().map(|entry| entry["event"].as_str().unwrap()).collect()
}

#[test]
fn law_the_program_couples_two_namespaces_over_an_impaired_path() {
    let Some(known) = Known::new(PATH, 31) else { return };
    // the second one only follows, so that its goodbye is an answer
    let sites = [known.program(0, 8.0), known.program(1, 60.0)];
    let outputs = sites.map(netns::Started::output);
    let counts = known.path().counts();
    println!("{counts:?}");
    for (side, output) in outputs.iter().enumerate() {
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        let summary = summary(output);
        println!("{} {} {} {}", summary["age"], summary["loss"], summary["round_trip"], summary["path"]);
        assert_eq!(summary["cause"], ["time-over", "partner-left"][side], "{summary}");
        assert!(events(&summary).contains(&"engaged"), "{summary}");
        assert!(summary["coupled_share"].as_f64().unwrap() > 0.5, "{summary}");
        let largest = summary["largest_force"].as_f64().unwrap();
        assert!(largest > 0.0 && largest <= Limits::default().force, "{summary}");
        assert!(summary["energy"]["least_balance"].as_f64().unwrap() >= 0.0, "{summary}");
        assert!(summary["te"].as_f64().unwrap() > 0.0, "{summary}");
        assert!(summary["loss"]["received"].as_u64().unwrap() > 1000, "{summary}");
        // the path took some; a busy machine may have taken more
        assert!(counts[1 - side].lost > 0 && summary["loss"]["lost"].as_u64().unwrap() > 0, "{summary}");
        // no packet takes less than the path
        let error = summary["round_trip"]["clock_error"].as_f64().unwrap();
        assert!(summary["round_trip"]["smallest"].as_f64().unwrap() >= 0.034, "{summary}");
        assert!(summary["age"]["smallest"].as_f64().unwrap() >= 0.017 - error, "{summary}");
    }
}

#[test]
fn law_after_sigkill_of_either_program_the_other_force_is_zero_in_time_and_a_new_one_begins_from_zero() {
    for side in 0..2 {
        let Some(known) = Known::new(PATH, 32 + side as u64) else { return };
        let site = known.start(1 - side);
        let program = known.program(side, 120.0);
        site.wait_engaged(300);
        program.kill();
        site.wait_idle(300);
        let mut program = known.program(side, 120.0);
        site.wait_engaged(300);
        terminate(&mut program);
        let output = program.output();
        let trace = { site }.finish();
        println!("side {side}: {:?}", judge(&trace.moments, &rules()));
        assert_eq!(trace.summary.cause, Some("partner-left"), "{:#?}", trace.summary);
        assert!(trace.silences() >= 1, "{:#?}", trace.summary.events);
        assert!(trace.count("agreed") >= 2, "{:#?}", trace.summary.events);
        let summary = summary(&output);
        assert_eq!(summary["cause"], "stop-requested", "{summary}");
        assert!(events(&summary).contains(&"engaged"), "{summary}");
        assert!(summary["energy"]["least_balance"].as_f64().unwrap() >= 0.0, "{summary}");
    }
}

fn terminate(program: &mut netns::Started) {
    let id = program.child().id().to_string();
    assert!(Command::new("kill").args(["-TERM", &id]).status().unwrap().success());
}

/// A site that nobody may couple: never a force, and it leaves as it came.
fn leave_alone(site: Live) -> Trace {
    let trace = site.leave();
    let findings = judge(&trace.moments, &rules());
    assert_eq!(findings.largest_force, 0.0);
    assert_eq!(trace.summary.coupled_share, 0.0, "{:#?}", trace.summary);
    trace
}

#[test]
fn law_a_program_with_a_wrong_key_gets_no_force() {
    let Some(mut known) = Known::new(PATH, 35) else { return };
    // site 1 expects somebody else at the address of site 2
    let right = known.settings[0].peer_ids.clone();
    known.settings[0].peer_ids = vec![SiteKey::generate().id()];
    let site = known.start(0);
    let output = known.program(1, 3.0).output();
    let trace = leave_alone(site);
    assert!(trace.summary.path.strangers > 0, "{:#?}", trace.summary);
    assert_eq!(trace.summary.path.connections, 0, "{:#?}", trace.summary);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let summary = summary(&output);
    assert_eq!(
        (&summary["largest_force"], &summary["coupled_share"]),
        (&0.0.into(), &0.0.into()),
        "{summary}"
    );
    // the same with the right key
    known.settings[0].peer_ids = right;
    let (site, program) = (known.start(0), known.program(1, 60.0));
    site.wait_engaged(100);
    assert_eq!(site.leave().summary.cause, Some("stop-requested"));
    assert_eq!(program.output().status.code(), Some(0));
}

#[test]
fn law_a_greeting_of_another_version_is_refused_with_the_reason() {
    let Some(known) = Known::new(PATH, 36) else { return };
    let mut site = known.start(0);
    let settings = known.settings[1].clone();
    known.joined.namespaces[1].within(|| {
        let mut other = Iroh::new(&settings).unwrap();
        let terms = Terms::new(&live::study(), 2).unwrap();
        let greeting = Greeting::new(Purpose::Hello, draw_session(), 0, terms);
        let mut bytes = greeting.encode();
        // the version
        bytes[4] = bytes[4].wrapping_add(1);
        let begin = Instant::now();
        while !site.has_ended() && begin.elapsed() < Duration::from_secs(60) {
            other.send(LocalTime(0), &bytes);
            std::thread::sleep(Duration::from_millis(20));
        }
    });
    let trace = site.finish();
    assert_eq!(judge(&trace.moments, &rules()).largest_force, 0.0);
    assert_eq!((trace.summary.cause, trace.summary.disagreement), (Some("refused"), Some("version")));
    assert!(trace.has("disagreed", Some("version: greeting 3 here, greeting 4 there")));
}

#[test]
fn law_another_version_of_the_protocol_is_refused_in_the_handshake() {
    use iroh::endpoint::presets;
    use iroh::{Endpoint, EndpointAddr, PublicKey, SecretKey, TransportAddr};

    let Some(mut known) = Known::new(PATH, 37) else { return };
    let key = SecretKey::generate();
    // whoever it is, the key is the right one
    known.settings[0].peer_ids = vec![SiteId::from(key.public())];
    let id: PublicKey = known.settings[0].key.id().to_string().parse().unwrap();
    let site = known.start(0);
    let refused = known.joined.namespaces[1].within(|| {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        runtime.block_on(async {
            let old = b"telespring/0".to_vec();
            let builder = Endpoint::builder(presets::Minimal).secret_key(key).alpns(vec![old.clone()]);
            let endpoint =
                builder.clear_ip_transports().bind_addr(at(1, PORT)).unwrap().bind().await.unwrap();
            let site = EndpointAddr::from_parts(id, [TransportAddr::Ip(at(0, PORT))]);
            let outcome = endpoint.connect(site, &old).await;
            endpoint.close().await;
            outcome.map(|_| ()).map_err(|error| format!("{error:?}"))
        })
    });
    println!("{refused:?}");
    assert!(refused.unwrap_err().contains("protocol"));
    assert_eq!(leave_alone(site).summary.path.connections, 0);
}
