//! Both sides on this machine: simulated robots and people, real sockets and clocks, and an emulated path between them.

use std::net::{SocketAddr, UdpSocket};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use rtrb::Consumer;
use serde::Serialize;
use telespring::InvalidInput;
use telespring::session::Span;
use telespring::study::Study;

use crate::conduct::{ConductError, Plan, conduct};
use crate::console::{Console, Narrator, Output};
use crate::device::Simulated;
use crate::feed::Observer;
use crate::hello::draw_session;
use crate::operator::Order;
use crate::real_time::Limits;
use crate::record::live::LiveServer;
use crate::record::{Facts, check_folder};
use crate::settings::LoopChoice;
use crate::site::{Safety, SiteSettings};
use crate::summary::{SCHEMA, Summary};
use crate::transport::{Emulated, Udp};

/// The paper's two robots, H-MANs, as a study writes them.
pub const ROBOTS: &str = "\
robot1 = {axes = [\"x\", \"y\"], mass = [0.8334, 1.0649], damping = [7.7257, 10.1168]}
robot2 = {axes = [\"x\", \"y\"], mass = [0.7776, 1.3407], damping = [7.4208, 9.3496]}
";

/// What a demonstration shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Demo {
    /// How long, s.
    pub seconds: f64,
    /// The one-way delay of the path, s.
    pub delay: f64,
    /// The largest additional delay of a packet, s.
    pub jitter: f64,
    /// The probability that a packet is lost.
    pub loss: f64,
    /// The stiffness of the virtual spring, N/m.
    pub stiffness: f64,
    /// The strategy of both sides, as a study writes it.
    pub strategy: &'static str,
    /// Draws the path and what the simulated people see.
    pub seed: u64,
    /// A delay imposed on the partner's motion, s, if any.
    pub imposed_delay: Option<f64>,
    /// What both loops ask the operating system for.
    pub real_time: LoopChoice,
    /// The folder for the recordings of both sides; `None` for none.
    pub record: Option<PathBuf>,
    /// Where viewers may look on both sides; `None` for nowhere.
    pub live: Option<SocketAddr>,
}

impl Default for Demo {
    /// The paper's robots at 142 N/m behind the guard for 20 s; 60 ms each way, 6 ms of jitter, 2 % of loss.
    fn default() -> Self {
        Self {
            seconds: 20.0,
            delay: 0.06,
            jitter: 0.006,
            loss: 0.02,
            stiffness: 142.0,
            strategy: "guard",
            seed: 1,
            imposed_delay: None,
            real_time: LoopChoice::default(),
            record: None,
            live: None,
        }
    }
}

/// What a demonstration was.
#[derive(Debug, Clone, Serialize)]
pub struct DemoSummary {
    /// [`SCHEMA`].
    pub schema: u32,
    /// The study, as TOML.
    pub study: String,
    /// Both sides.
    pub sites: [Summary; 2],
}

/// What one side has of its own.
struct Side {
    number: u8,
    link: Udp,
    orders: Option<Consumer<Order>>,
}

/// Why a demonstration did not take place.
#[derive(Debug, thiserror::Error)]
pub enum DemoError {
    /// A value out of range.
    #[error(transparent)]
    Input(#[from] InvalidInput),
    /// The operating system gave no socket or thread.
    #[error("the operating system refused: {0}")]
    System(#[from] std::io::Error),
    /// A site that did not run.
    #[error(transparent)]
    Conduct(#[from] ConductError),
    /// A loop has broken off; its message is above.
    #[error("a loop has broken off")]
    Broken,
}

impl Demo {
    /// The study that is shown.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with the key of the study.
    pub fn study(&self) -> Result<Study, InvalidInput> {
        let Self { delay, jitter, loss, stiffness, strategy, imposed_delay, .. } = self;
        let playout = imposed_delay
            .map_or("\"adaptive\"".to_owned(), |delay| format!("{{kind = \"fixed\", delay = {delay}}}"));
        Study::from_toml(&format!(
            "name = \"Demonstration\"\n{ROBOTS}\
             coupling.stiffness = {stiffness}\n\
             network = {{delay = {delay}, jitter = {jitter}, loss = {loss}}}\n\
             session = {{strategy = \"{strategy}\", playout = {playout}}}\n"
        ))
    }

    /// Runs both sides, each on a thread of its own, until the time is over or `stop` is set. `orders`: what the people at
    /// both sides order, if anybody does; `console` tells what happens to a program, `words` to a person.
    ///
    /// # Errors
    ///
    /// [`DemoError`].
    pub fn run(
        &self,
        stop: &AtomicBool,
        orders: [Option<Consumer<Order>>; 2],
        console: Option<&Output>,
        words: Option<&Output>,
    ) -> Result<DemoSummary, DemoError> {
        if !(self.seconds > 0.0 && self.seconds <= 86_400.0) {
            let allowed = "above 0, up to 86400 s";
            return Err(InvalidInput::new("seconds", self.seconds, allowed, "Give 20.").into());
        }
        let study = self.study()?;
        if let Some(folder) = &self.record {
            check_folder("--record", folder)?;
        }
        let server = self.live.map(|address| LiveServer::start("--live", address)).transpose()?;
        let sockets = [UdpSocket::bind("127.0.0.1:0")?, UdpSocket::bind("127.0.0.1:0")?];
        let [here, there] = [sockets[0].local_addr()?, sockets[1].local_addr()?];
        let [first, second] = sockets;
        let links = [Udp::on(first, there)?, Udp::on(second, here)?];
        let [first, second] = std::thread::scope(|scope| {
            let (study, server) = (&study, server.as_ref());
            let mut sides = (1_u8..).zip(links.into_iter().zip(orders));
            [(); 2]
                .map(|()| {
                    sides.next().map(|(number, (link, orders))| {
                        let name = format!("site {number}");
                        std::thread::Builder::new().name(name).spawn_scoped(scope, move || {
                            self.run_side(
                                study,
                                Side { number, link, orders },
                                server,
                                [console, words],
                                stop,
                            )
                        })
                    })
                })
                .map(|thread| match thread {
                    Some(Ok(thread)) => thread.join().map_err(|_| DemoError::Broken)?,
                    Some(Err(error)) => Err(error.into()),
                    None => Err(DemoError::Broken),
                })
        });
        Ok(DemoSummary { schema: SCHEMA, study: study.to_toml(), sites: [first?, second?] })
    }

    fn run_side(
        &self,
        study: &Study,
        Side { number: side, link, orders }: Side,
        server: Option<&Arc<LiveServer>>,
        [console, words]: [Option<&Output>; 2],
        stop: &AtomicBool,
    ) -> Result<Summary, DemoError> {
        let laboratory = study.laboratory()?;
        let index = usize::from(side) - 1;
        let travel = Span::from_seconds(self.delay - laboratory.controller.sample_period).max(Span(0));
        let path = laboratory.network.towards(index);
        let transport = Emulated::new(link, path, travel, self.seed, index);
        let device = Simulated::new(&laboratory, index, self.seed)?;
        let settings = SiteSettings::new(study, side, draw_session(), Safety::default())?.simulated();
        // The second side only follows, so that its goodbye is an answer.
        let after = if side == 1 { 0.0 } else { 1.0 };
        let limits = Limits { duration: Some(Span::from_seconds(self.seconds + after)) };
        let facts = Facts::new(study, &settings).with("device", "simulated").with("network", "emulated");
        let folder = self.record.as_ref().map(|folder| ("--record", folder));
        let console = console.map(|output| Console::new(output.clone(), side));
        let words = words.map(|output| Narrator::new(output.clone(), format!("side {side}: "), false));
        let console = console.map(|console| Box::new(console) as Box<dyn Observer>);
        let observers =
            console.into_iter().chain(words.map(|words| Box::new(words) as Box<dyn Observer>)).collect();
        let plan = Plan { real_time: self.real_time, limits, observers, orders, ..Plan::default() };
        let plan = plan.watched(&facts, folder, server)?;
        Ok(conduct(settings, device, transport, plan, stop, |_| {})?)
    }
}
