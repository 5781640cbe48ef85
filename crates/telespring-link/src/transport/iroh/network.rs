//! The thread of the network: it owns iroh's endpoint and forwards datagrams between it and the queues of the loop.

use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::mpsc::SyncSender;
use std::time::{Duration, Instant};

use bytes::Bytes;
use iroh::dns::DnsResolver;
use iroh::endpoint::{Connection, NetReportConfig, PathStats, PortmapperConfig, presets};
use iroh::{Endpoint, EndpointAddr, RelayMap, RelayMode, TransportAddr};
use rtrb::Consumer;
use tokio::sync::mpsc;
use tokio::time::MissedTickBehavior;

use super::IrohSettings;
use super::admission::{AllowList, accept};
use super::authority::Authority;
use super::bell::{Bell, Ear};
use super::links::Links;
use super::packet::{Inbox, Packet};
use super::quic;
use super::rate::{Outcome, RateCap};
use super::shared::{Shared, Way, count};
use super::withheld::Withheld;
use crate::real_time;

/// The name and version of what two sites speak over iroh. Others are refused in the handshake.
pub const ALPN: &[u8] = b"telespring/1";
/// From one look at path, loss and round trip to the next.
const LOOK: Duration = Duration::from_millis(100);
/// How long one attempt to reach the partner may take.
const DIAL: Duration = Duration::from_secs(3);
/// From one attempt to the next: at first, and at most.
const BACK_OFF: [Duration; 2] = [Duration::from_millis(100), Duration::from_secs(2)];
/// How long the end of the endpoint may take.
const CLOSE: Duration = Duration::from_millis(300);

/// What the thread needs of the loop's side.
pub(super) struct Ends {
    pub(super) outbox: Consumer<Packet>,
    pub(super) inbox: Inbox,
    pub(super) bell: Bell,
    pub(super) shared: Arc<Shared>,
}

/// Runs until the loop's side is dropped. `bound` hears once whether the endpoint is there.
pub(super) fn run(
    settings: &IrohSettings,
    ends: Ends,
    bound: &SyncSender<Result<Vec<std::net::SocketAddr>, String>>,
) {
    // as long as it waits behind others, packets grow old; the loop goes first
    real_time::claim(settings.priority, false, false);
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().max_blocking_threads(2).build();
    let runtime = match runtime {
        Ok(runtime) => runtime,
        Err(error) => {
            let _ = bound.send(Err(error.to_string()));
            return;
        }
    };
    let local = tokio::task::LocalSet::new();
    local.block_on(&runtime, async {
        let (ear, endpoint) = match (ends.bell.ear(), bind(settings, &ends.shared).await) {
            (Ok(ear), Ok(endpoint)) => (ear, endpoint),
            (Err(error), _) => {
                let _ = bound.send(Err(error.to_string()));
                return;
            }
            (_, Err(error)) => {
                let _ = bound.send(Err(error));
                return;
            }
        };
        let _ = bound.send(Ok(endpoint.bound_sockets()));
        live(settings, &endpoint, ear, ends).await;
        let _ = tokio::time::timeout(CLOSE, endpoint.close()).await;
    });
    drop(local);
    runtime.shutdown_timeout(CLOSE);
}

/// An endpoint that speaks with nobody but who it is told to.
async fn bind(settings: &IrohSettings, shared: &Arc<Shared>) -> Result<Endpoint, String> {
    let ids = settings.peer_ids.iter().map(|id| id.public()).collect();
    let relays = match &settings.relay {
        None => RelayMode::Disabled,
        Some(url) => RelayMode::Custom(RelayMap::from(url.clone())),
    };
    // no public name server: that of this machine is asked for the relay's name, and for nothing else
    let names = DnsResolver::builder().with_system_defaults().disable_fallback().build();
    let mut report = NetReportConfig::minimal();
    report.https_probes = settings.relay.is_some();
    let mut builder = Endpoint::builder(presets::Minimal)
        .secret_key(settings.key.secret())
        .alpns(vec![ALPN.to_vec()])
        .transport_config(quic::settings())
        .hooks(AllowList { ids, shared: Arc::clone(shared) })
        .clear_address_lookup()
        .portmapper_config(PortmapperConfig::Disabled)
        .net_report_config(report)
        .dns_resolver(names)
        // no tickets, so no 0-RTT, which could be replayed
        .max_tls_tickets(0)
        .relay_mode(relays)
        .ca_tls_config(Authority::tls(settings.relay_authority.as_ref()))
        .clear_ip_transports();
    for local in &settings.local {
        builder = builder.bind_addr(*local).map_err(|error| error.to_string())?;
    }
    builder.bind().await.map_err(|error| format!("{error:#}"))
}

/// Dials, answers and forwards until the loop's side is dropped.
async fn live(settings: &IrohSettings, endpoint: &Endpoint, ear: Ear, ends: Ends) {
    let Ends { mut outbox, inbox, bell: _, shared } = ends;
    let mut supervisor = Supervisor::new(settings, Arc::clone(&shared));
    let links = Links::new(endpoint.id(), inbox, Arc::clone(&shared), supervisor.is_any_way_allowed);
    let (established, mut arrived) = mpsc::channel(4);
    let answering = tokio::task::spawn_local(accept(
        endpoint.clone(),
        settings.peers.clone(),
        Arc::clone(&shared),
        established.clone(),
    ));
    let dialling =
        tokio::task::spawn_local(dial(endpoint.clone(), settings.clone(), Rc::clone(&links), established));
    let mut look = tokio::time::interval(LOOK);
    look.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        tokio::select! {
            biased;
            () = ear.listen() => {
                if shared.stop.load(Relaxed) {
                    break;
                }
                forward(&mut outbox, &links, &supervisor).await;
                links.flush();
            }
            Some(connection) = arrived.recv() => {
                links.add(connection);
                links.greet();
                supervisor.look(&links);
            }
            _ = look.tick() => {
                links.greet();
                supervisor.look(&links);
            }
        }
    }
    answering.abort();
    dialling.abort();
}

/// Sends what the loop has left in its queue.
async fn forward(outbox: &mut Consumer<Packet>, links: &Links, supervisor: &Supervisor) {
    let connection = links.current();
    // at each send: a path may have become another since the last look
    let connection = connection.filter(|connection| supervisor.may_send(connection));
    while let Ok(packet) = outbox.pop() {
        let taken = connection.as_ref().is_some_and(|connection| {
            connection.send_datagram(Bytes::copy_from_slice(packet.bytes())).is_ok()
        });
        count(if taken { &supervisor.shared.sent } else { &supervisor.shared.unsent }, 1);
        if !outbox.is_empty() {
            // QUIC keeps few: if this thread was held up, let it send what it has
            tokio::task::yield_now().await;
        }
    }
}

/// Looks for the partner whenever it is not there, as long as the site lives.
async fn dial(
    endpoint: Endpoint,
    settings: IrohSettings,
    links: Rc<Links>,
    established: mpsc::Sender<Connection>,
) {
    let addresses = settings.peers.iter().copied().map(TransportAddr::Ip);
    let addresses: Vec<_> =
        addresses.chain(settings.relay.iter().cloned().map(TransportAddr::Relay)).collect();
    if addresses.is_empty() {
        // this site is looked for, and looks for nobody
        return;
    }
    let [first, most] = BACK_OFF;
    let mut pause = first;
    for id in settings.peer_ids.iter().cycle() {
        while links.is_alive() {
            if links.is_connected() {
                pause = first;
            }
            // a silence is nothing that comes or goes
            let _ = tokio::time::timeout(LOOK, links.changed.notified()).await;
        }
        // until iroh has noticed the end of a connection, it would look on that one's way only
        tokio::time::sleep(first).await;
        let partner = EndpointAddr::from_parts(id.public(), addresses.iter().cloned());
        let attempt = tokio::time::timeout(DIAL, endpoint.connect(partner, ALPN));
        tokio::select! {
            // one that is dropped on the way closes by itself
            () = alive(&links) => {}
            outcome = attempt => {
                if let Ok(Ok(connection)) = outcome {
                    let _ = established.send(connection).await;
                }
                tokio::time::sleep(pause).await;
                pause = (2 * pause).min(most);
            }
        }
    }
}

/// Waits until the partner is there.
async fn alive(links: &Links) {
    while !links.is_alive() {
        let _ = tokio::time::timeout(LOOK, links.changed.notified()).await;
    }
}

/// Watches the path: which way it goes, what gets lost on it, how long it takes.
struct Supervisor {
    /// There is no relay, or datagrams may go over it.
    is_any_way_allowed: bool,
    shared: Arc<Shared>,
    start: Instant,
    rate: RateCap,
    /// The path in use: number of the connection, address, kind.
    path: Option<(u64, TransportAddr, Way)>,
    /// What it had counted at the last look.
    counted: Outcome,
    withheld: Withheld,
}

impl Supervisor {
    fn new(settings: &IrohSettings, shared: Arc<Shared>) -> Self {
        Self {
            is_any_way_allowed: settings.relay.is_none() || settings.relayed,
            shared,
            start: Instant::now(),
            rate: RateCap::default(),
            path: None,
            counted: Outcome::default(),
            withheld: Withheld::default(),
        }
    }

    /// Whether a datagram that is sent now takes a way that this site allows.
    fn may_send(&self, connection: &Connection) -> bool {
        self.is_any_way_allowed || self.way(connection) == Way::Direct
    }

    /// The way that a datagram would take now.
    fn way(&self, connection: &Connection) -> Way {
        let paths = connection.paths();
        let mut selected = paths.iter().filter(|path| path.is_selected()).peekable();
        let is_direct = if selected.peek().is_some() {
            selected.all(|path| path.is_ip())
        } else {
            !paths.is_empty() && paths.iter().all(|path| path.is_ip())
        };
        match (is_direct, self.is_any_way_allowed) {
            (true, _) => Way::Direct,
            (false, true) => Way::Relayed,
            (false, false) => Way::Withheld,
        }
    }

    /// Looks at the path, and says what is new.
    fn look(&mut self, links: &Links) {
        let connection = links.current().filter(|_| links.is_connected());
        let path = connection.as_ref().and_then(|connection| {
            let paths = connection.paths();
            let path = paths.iter().find(|path| path.is_selected()).or_else(|| paths.iter().next())?;
            let key = (links.current_number(), path.remote_addr().clone(), self.way(connection));
            Some((key, path.stats()))
        });
        let (path, stats) = path.map_or((None, None), |(path, stats)| (Some(path), Some(stats)));
        // what comes does not say which way it took: without a direct one it may have come over the relay
        let way = path.as_ref().map_or(Way::None, |(_, _, way)| *way);
        links.set_open(self.is_any_way_allowed || way == Way::Direct);
        self.shared.set_round_trip(stats.as_ref().map(|stats| stats.rtt));
        if self.withheld.is_time(self.start.elapsed(), way) {
            links.renew();
        }
        if path != self.path {
            self.shared.set_way(way);
            self.path = path;
            self.counted = stats.as_ref().map(counted).unwrap_or_default();
        } else if let Some(stats) = stats {
            let (now, before) = (counted(&stats), self.counted);
            self.counted = now;
            let outcome = Outcome {
                sent: now.sent.saturating_sub(before.sent),
                lost: now.lost.saturating_sub(before.lost),
                acknowledgements: now.acknowledgements.saturating_sub(before.acknowledgements),
            };
            count(&self.shared.lost, outcome.lost);
            self.rate.observe(self.start.elapsed(), outcome);
            self.shared.set_every(self.rate.every());
        }
    }
}

/// What a path has counted since it is there.
fn counted(stats: &PathStats) -> Outcome {
    Outcome {
        sent: stats.sent_packets,
        lost: stats.lost_packets,
        acknowledgements: stats.frame_rx.acks + stats.frame_rx.path_acks,
    }
}
