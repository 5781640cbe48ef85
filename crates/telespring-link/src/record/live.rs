//! The live view: the messages of the recording for Foxglove or Lichtblick, while the session runs.

use std::net::SocketAddr;
use std::sync::Arc;

use foxglove::{Context, WebSocketServerHandle};
use telespring::InvalidInput;
use tokio::runtime::{Builder, Runtime};

use super::{Facts, Topics};
use crate::feed::{Item, Observer};

/// Messages that wait for a viewer; of one that is slower the oldest are dropped. 2 s of ticks and arrivals.
const BACKLOG: usize = 4096;

/// A server for viewers on this machine. Its thread is an ordinary one: start it before the loop asks for a priority.
pub struct LiveServer {
    context: Arc<Context>,
    handle: WebSocketServerHandle,
    /// Ends with the last view.
    _runtime: Runtime,
}

impl std::fmt::Debug for LiveServer {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("LiveServer").field("port", &self.handle.port()).finish_non_exhaustive()
    }
}

impl LiveServer {
    /// Listens at an address of this machine; port 0 is any that is free.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with the field if the address is not of this machine, or cannot be used.
    pub fn start(field: &str, address: SocketAddr) -> Result<Arc<Self>, InvalidInput> {
        let refuse = |why: String| {
            let remedy = "Write 127.0.0.1 with a free port.";
            InvalidInput::new(field, address, why, remedy)
        };
        if !address.ip().is_loopback() {
            return Err(refuse("an address of this machine: nobody checks who looks on".to_owned()));
        }
        let context = Context::new();
        let runtime = Builder::new_multi_thread()
            .worker_threads(1)
            .thread_name("live view")
            .enable_all()
            .build()
            .map_err(|error| refuse(format!("the operating system refused ({error})")))?;
        let server = context
            .websocket_server()
            .name("telespring")
            .bind(address.ip().to_string(), address.port())
            .message_backlog_size(BACKLOG);
        let handle = runtime
            .block_on(server.start())
            .map_err(|error| refuse(format!("the address cannot be used ({error})")))?;
        Ok(Arc::new(Self { context, handle, _runtime: runtime }))
    }

    /// The port at which it listens.
    pub fn port(&self) -> u16 {
        self.handle.port()
    }

    /// The view of a site.
    pub fn view(self: &Arc<Self>, facts: &Facts) -> LiveView {
        LiveView { topics: Topics::new(&self.context, facts.side, facts.zero), _server: Arc::clone(self) }
    }

    /// The number of viewers.
    pub fn viewers(&self) -> usize {
        self.handle.client_count()
    }
}

/// The live view of one site.
#[derive(Debug)]
pub struct LiveView {
    topics: Topics,
    _server: Arc<LiveServer>,
}

impl Observer for LiveView {
    fn name(&self) -> &'static str {
        "live view"
    }

    fn take(&mut self, item: &Item) {
        self.topics.publish(item);
    }

    fn miss(&mut self, count: u64) {
        self.topics.miss(count);
    }
}
