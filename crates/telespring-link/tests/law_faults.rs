//! Faults of the network and of the partner, in real time, between two namespaces: what the force did, and what was recorded.

mod live;
mod netns;

use live::{Live, STUDY, Trace, judge};
use netns::{Joined, Way, at};
use telespring_link::transport::Udp;

/// The path of the gate: 20 ms ± 3 ms, 2 % of loss each way.
const PATH: Way = Way {
    delay: 0.02,
    jitter: 0.003,
    loss: 0.02,
    copies: 0.0,
    keeps_order: false,
    rate: None,
    longest_wait: 0.1,
    is_dark: false,
};

/// A site in its namespace.
fn site(joined: &Joined, side: usize) -> Live {
    Live::start(joined, side, STUDY, move || Udp::new(at(side, 4500), at(1 - side, 4500)).unwrap())
}

/// Both sites, engaged.
fn engaged(joined: &Joined) -> [Live; 2] {
    let sites = [site(joined, 0), site(joined, 1)];
    sites.iter().for_each(|site| site.wait_engaged(300));
    sites
}

/// Site 1 leaves, site 2 hears it; both records are judged.
fn leave([first, mut second]: [Live; 2]) -> [Trace; 2] {
    let traces = [first.leave(), second.finish()];
    assert_eq!(traces.each_ref().map(|trace| trace.summary.cause), [Some("stop-requested"), Some("partner-left")]);
    judge_both(&traces);
    traces
}

fn judge_both(traces: &[Trace; 2]) {
    let speeds = traces.each_ref().map(|trace| live::largest_speed(&trace.moments));
    for side in 0..2 {
        let findings = judge(&traces[side].moments, speeds[1 - side]);
        println!("site {}: {findings:?}", side + 1);
    }
}

#[test]
fn law_loss_jitter_and_reordering_leave_force_and_account_in_bounds() {
    for (number, way) in [
        PATH,
        Way { loss: 0.05, jitter: 0.005, ..PATH },
        Way { loss: 0.05, jitter: 0.005, keeps_order: true, copies: 0.2, ..PATH },
        Way { jitter: 0.015, copies: 0.05, ..PATH },
    ]
    .into_iter()
    .enumerate()
    {
        let Some(joined) = Joined::new(way, 10 + number as u64) else { return };
        let sites = engaged(&joined);
        sites.iter().for_each(|site| site.wait_engaged(1500));
        let traces = leave(sites);
        let counts = joined.path.counts();
        println!("{way:?} {counts:?}");
        for (trace, counts) in traces.iter().zip(counts) {
            let summary = &trace.summary;
            println!("{:?} {:?} {:?}", summary.age, summary.loss, summary.lateness);
            for entry in &summary.events {
                println!("{entry:?}");
            }
            assert!(counts.lost > 0);
        }
    }
}
