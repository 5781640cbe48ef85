//! Two network namespaces, joined by nothing but an impaired path: each has a TUN device, and a thread of this process carries
//! what one sends to the other, as late and as seldom as a test asks for.
//!
//! Nothing of it has a name, a file or a process: the namespaces live as long as this process holds them, and the kernel removes
//! them with everything in it, however the process ends. Tests may run at the same time.

#![allow(dead_code, reason = "every test uses its part")]

mod line;
mod path;

use std::fs::File;
use std::io::{Error, ErrorKind, Write};
use std::net::{Ipv4Addr, SocketAddr};
use std::os::fd::AsFd;
use std::process::{Child, Command};
use std::sync::Arc;

use rustix::thread::{LinkNameSpaceType, UnshareFlags, move_into_link_name_space, unshare_unsafe};
use tun_rs::{DeviceBuilder, SyncDevice};

#[allow(unused_imports, reason = "every test uses its part")]
pub use line::{Counts, Line, Way};
#[allow(unused_imports, reason = "every test uses its part")]
pub use path::Path;

/// A network namespace of its own, kept by an open file.
#[derive(Debug, Clone)]
pub struct Namespace(Arc<File>);

impl Namespace {
    /// A namespace with no network but its own TUN device, at this address.
    fn new(address: Ipv4Addr) -> Result<(Self, SyncDevice), Error> {
        let made = || -> Result<_, Error> {
            // SAFETY: only the network namespace of a thread that ends here changes; no file descriptors do.
            unsafe { unshare_unsafe(UnshareFlags::NEWNET) }?;
            let namespace = Self(Arc::new(File::open("/proc/thread-self/ns/net")?));
            let device = DeviceBuilder::new().name("path0").ipv4(address, 24, None).mtu(1500).build_sync()?;
            device.set_nonblocking(true)?;
            Ok((namespace, device))
        };
        std::thread::scope(|scope| scope.spawn(made).join().unwrap())
    }

    /// Moves this thread into the namespace for good: sockets that it opens and processes that it starts belong there.
    pub fn enter(&self) {
        move_into_link_name_space(self.0.as_fd(), Some(LinkNameSpaceType::Network)).unwrap();
    }

    /// Does something on a thread of this namespace.
    pub fn within<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        std::thread::scope(|scope| {
            let thread = scope.spawn(|| {
                self.enter();
                work()
            });
            thread.join().unwrap()
        })
    }

    /// Starts a program in this namespace. It is killed when the test has done with it.
    pub fn start(&self, command: &mut Command) -> Started {
        Started(Some(self.within(|| command.spawn().unwrap())))
    }
}

/// A program that does not outlive the test.
#[derive(Debug)]
pub struct Started(Option<Child>);

impl Started {
    pub fn child(&mut self) -> &mut Child {
        self.0.as_mut().unwrap()
    }

    /// Waits for its end.
    pub fn output(mut self) -> std::process::Output {
        self.0.take().unwrap().wait_with_output().unwrap()
    }

    /// Kills it as nobody can foresee: SIGKILL.
    pub fn kill(self) {}
}

impl Drop for Started {
    fn drop(&mut self) {
        if let Some(mut child) = self.0.take() {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// The addresses of the two namespaces. They mean nothing outside: every pair has the same.
pub const ADDRESSES: [Ipv4Addr; 2] = [Ipv4Addr::new(10, 77, 0, 1), Ipv4Addr::new(10, 77, 0, 2)];

/// An address with a port, in namespace 0 or 1.
pub fn at(side: usize, port: u16) -> SocketAddr {
    (ADDRESSES[side], port).into()
}

/// Two namespaces and the path between them.
#[derive(Debug)]
pub struct Joined {
    pub namespaces: [Namespace; 2],
    pub path: Path,
}

impl Joined {
    /// Two namespaces whose path does this each way. `None`, said in a loud line, where this machine or user cannot have any.
    pub fn new(way: Way, seed: u64) -> Option<Self> {
        let [first, second] = ADDRESSES.map(Namespace::new);
        match (first, second) {
            (Ok((one, here)), Ok((two, there))) => {
                let path = Path::new([here, there], way, seed);
                Some(Self { namespaces: [one, two], path })
            }
            (Err(error), _) | (_, Err(error)) => {
                skip_or_panic(&error);
                None
            }
        }
    }
}

/// What a machine may lack is no failure; anything else is.
fn skip_or_panic(error: &Error) {
    let lacks = [ErrorKind::PermissionDenied, ErrorKind::NotFound, ErrorKind::Unsupported];
    // no such device, no module for it, no namespaces in this kernel
    let codes = [libc::ENODEV, libc::ENXIO, libc::ENOSYS, libc::EINVAL, libc::ENOSPC];
    let is_lacking =
        lacks.contains(&error.kind()) || error.raw_os_error().is_some_and(|code| codes.contains(&code));
    assert!(is_lacking, "two network namespaces with TUN devices: {error}");
    // past the test harness, which keeps what a passing test prints to itself
    let _ = writeln!(
        std::io::stderr(),
        "SKIPPED {}: no network namespaces with TUN devices here ({error}); they need root and /dev/net/tun",
        std::thread::current().name().unwrap_or("a test")
    );
}
