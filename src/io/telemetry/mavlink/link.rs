//! Live sources by URL: sockets and serial lines, read with a time limit.
//!
//! | URL | link |
//! | --- | --- |
//! | `udpin://HOST:PORT` | listens, and replies to the address heard last |
//! | `udpout://HOST:PORT` | sends to this address and receives from it only; a heartbeat has to be sent first |
//! | `tcp://HOST:PORT` | connects |
//! | `serial://DEVICE?baud=N` | opens a serial line, 57600 baud by default |
//!
//! A frame never goes on from one datagram into another.
//!
//! A read returns with the first bytes, or with [`LinkEvent::Silence`] after the time limit. Refused, each with a message: an
//! unknown scheme, a missing port, a baud rate out of range. A closed connection is [`LinkEvent::Closed`]; the caller may open
//! the link again.

use crate::io::telemetry::mavlink::serial;
use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result as IoResult, Write};
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, TcpStream, ToSocketAddrs, UdpSocket};
use std::os::fd::OwnedFd;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Baud rate where a URL names none: that of telemetry radios.
pub const BAUD: u32 = 57_600;
/// The longest wait for a connection, and for one that takes no bytes.
const CONNECT: Duration = Duration::from_secs(2);
/// Bytes of datagrams that may wait; the system doubles it for its own needs and may allow less.
const WAITING_BYTES: usize = 1 << 20;
/// The longest datagram.
pub const DATAGRAM_MAX: usize = 65_535;

/// Where telemetry comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Url {
    /// Listens for datagrams at an address.
    UdpIn(String),
    /// Exchanges datagrams with an address.
    UdpOut(String),
    /// Connects to an address.
    Tcp(String),
    /// A serial line.
    Serial {
        /// The device.
        device: PathBuf,
        /// Baud rate.
        baud: u32,
    },
}

/// Why a link cannot be opened.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum LinkError {
    #[error("{0}")]
    Url(String),
    #[error("{url}: {source}")]
    Io { url: String, source: Error },
}

impl Url {
    /// Whether the text is a URL of a link of this kind.
    pub fn is_link(text: &str) -> bool {
        ["udpin://", "udpout://", "tcp://", "serial://"].iter().any(|scheme| text.starts_with(scheme))
    }

    /// Reads a URL.
    ///
    /// # Errors
    /// [`LinkError::Url`] with what was expected and found.
    pub fn parse(text: &str) -> Result<Self, LinkError> {
        let wrong = |what: &str| LinkError::Url(format!("`{text}`: {what}"));
        let (scheme, rest) = text.split_once("://").ok_or_else(|| wrong("expected scheme://..."))?;
        let address = || {
            let port = rest.rsplit_once(':').and_then(|(host, port)| (!host.is_empty()).then_some(port));
            match port.map(str::parse::<u16>) {
                Some(Ok(_)) => Ok(rest.to_owned()),
                _ => Err(wrong("expected host:port with a port from 0 to 65535")),
            }
        };
        match scheme {
            "udpin" => Ok(Url::UdpIn(address()?)),
            "udpout" => Ok(Url::UdpOut(address()?)),
            "tcp" => Ok(Url::Tcp(address()?)),
            "serial" => {
                let (device, query) = rest.split_once('?').unwrap_or((rest, ""));
                let baud = match query.strip_prefix("baud=") {
                    None if query.is_empty() => Ok(BAUD),
                    Some(baud) => baud.parse().ok().filter(|baud| serial::BAUD_RANGE.contains(baud)).ok_or(()),
                    None => Err(()),
                };
                let baud = baud.map_err(|()| wrong("expected ?baud=N with N from 1200 to 4000000"))?;
                if device.is_empty() {
                    return Err(wrong("expected serial://DEVICE?baud=N"));
                }
                Ok(Url::Serial { device: device.into(), baud })
            }
            _ => Err(wrong("expected udpin, udpout, tcp or serial")),
        }
    }

    /// Opens a link of datagrams on behalf of a process that may die: while it is away the system keeps what arrives, up
    /// to its buffer. `None` for a link of another kind.
    ///
    /// # Errors
    /// [`LinkError::Io`] with what the system says.
    pub fn hold(&self) -> Result<Option<OwnedFd>, LinkError> {
        let opened = match self {
            Url::UdpIn(address) => bind(address),
            Url::UdpOut(address) => connected(address).map(|(socket, _)| socket),
            Url::Tcp(_) | Url::Serial { .. } => return Ok(None),
        };
        opened.map(|socket| Some(socket.into())).map_err(|source| LinkError::Io { url: self.to_string(), source })
    }
}

impl std::fmt::Display for Url {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Url::UdpIn(address) => write!(f, "udpin://{address}"),
            Url::UdpOut(address) => write!(f, "udpout://{address}"),
            Url::Tcp(address) => write!(f, "tcp://{address}"),
            Url::Serial { device, baud } => write!(f, "serial://{}?baud={baud}", device.display()),
        }
    }
}

/// What a read came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinkEvent {
    /// So many bytes; none where a datagram was empty.
    Bytes(usize),
    /// Nothing within the time limit.
    Silence,
    /// The other end has gone, or the device.
    Closed,
}

#[derive(Debug)]
enum Transport {
    Udp {
        socket: UdpSocket,
        peer: Option<SocketAddr>,
        listens: bool,
    },
    Tcp(TcpStream),
    /// With how many reads in a row ended at once and empty.
    Serial(File, u32),
}

/// A serial line that waits ends its read after a tenth of a second; one that has hung up at once.
const AT_ONCE: Duration = Duration::from_millis(20);
/// So many in a row are no chance.
const HUNG_UP: u32 = 3;

/// An open link.
#[derive(Debug)]
pub struct Link {
    url: Url,
    channel: Transport,
}

impl Link {
    /// Opens it; a read gives up after `patience` (a serial line after a tenth of a second).
    ///
    /// # Errors
    /// [`LinkError::Io`] with what the system says.
    pub fn open(url: Url, patience: Duration) -> Result<Self, LinkError> {
        let channel = match &url {
            Url::UdpIn(address) => listen(address, patience),
            Url::UdpOut(address) => call(address, patience),
            Url::Tcp(address) => connect(address, patience),
            Url::Serial { device, baud } => serial::open(device, *baud).map(|file| Transport::Serial(file, 0)),
        };
        match channel {
            Ok(channel) => Ok(Link { url, channel }),
            Err(source) => Err(LinkError::Io { url: url.to_string(), source }),
        }
    }

    /// A link on a socket that another process opened by [`Url::hold`].
    ///
    /// # Errors
    /// [`LinkError`] where the URL is none of datagrams, or what was handed over is no socket.
    pub fn on_held(url: Url, held: OwnedFd, patience: Duration) -> Result<Self, LinkError> {
        let listens = match url {
            Url::UdpIn(_) => true,
            Url::UdpOut(_) => false,
            Url::Tcp(_) | Url::Serial { .. } => return Err(LinkError::Url(format!("`{url}`: only datagrams can be held"))),
        };
        let socket = UdpSocket::from(held);
        match socket.set_read_timeout(Some(patience)) {
            Ok(()) => {
                let peer = socket.peer_addr().ok();
                Ok(Link { url, channel: Transport::Udp { socket, peer, listens } })
            }
            Err(source) => Err(LinkError::Io { url: url.to_string(), source }),
        }
    }

    /// Whether a read gives a datagram; else it gives a piece of a stream.
    pub fn is_of_datagrams(&self) -> bool {
        matches!(self.channel, Transport::Udp { .. })
    }

    /// The URL.
    pub fn url(&self) -> &Url {
        &self.url
    }

    /// The address at this end, of a socket.
    pub fn local_address(&self) -> Option<SocketAddr> {
        match &self.channel {
            Transport::Udp { socket, .. } => socket.local_addr().ok(),
            Transport::Tcp(stream) => stream.local_addr().ok(),
            Transport::Serial(..) => None,
        }
    }

    /// Whether it is known who is at the other end; of one that listens only once somebody has sent something.
    pub fn has_peer(&self) -> bool {
        match &self.channel {
            Transport::Udp { peer, .. } => peer.is_some(),
            Transport::Tcp(_) | Transport::Serial(..) => true,
        }
    }

    /// Waits for bytes. Of a datagram that is longer than the buffer the rest is lost: give [`DATAGRAM_MAX`].
    ///
    /// # Errors
    /// What the system says, save that nothing came or the end has gone.
    pub fn receive(&mut self, buffer: &mut [u8]) -> IoResult<LinkEvent> {
        let (read, empty) = match &mut self.channel {
            // A datagram may be empty.
            Transport::Udp { socket, peer, listens: true } => {
                let read = socket.recv_from(buffer).map(|(count, from)| {
                    *peer = Some(from);
                    count
                });
                (read, LinkEvent::Bytes(0))
            }
            Transport::Udp { socket, .. } => (socket.recv(buffer), LinkEvent::Bytes(0)),
            Transport::Tcp(stream) => (stream.read(buffer), LinkEvent::Closed),
            Transport::Serial(file, at_once) => {
                let begun = Instant::now();
                let read = file.read(buffer);
                *at_once = if matches!(read, Ok(0)) && begun.elapsed() < AT_ONCE { *at_once + 1 } else { 0 };
                (read, if *at_once >= HUNG_UP { LinkEvent::Closed } else { LinkEvent::Silence })
            }
        };
        match read {
            Ok(0) => Ok(empty),
            Ok(count) => Ok(LinkEvent::Bytes(count)),
            Err(error) => match error.kind() {
                // A refused datagram comes back as an error of the next read: nobody listens there yet.
                ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted | ErrorKind::ConnectionRefused => {
                    Ok(LinkEvent::Silence)
                }
                ErrorKind::ConnectionReset | ErrorKind::ConnectionAborted | ErrorKind::BrokenPipe => Ok(LinkEvent::Closed),
                _ => Err(error),
            },
        }
    }

    /// Sends one frame, or several; `false` where nobody is known yet to send it to.
    ///
    /// # Errors
    /// What the system says.
    pub fn send(&mut self, bytes: &[u8]) -> IoResult<bool> {
        match &mut self.channel {
            Transport::Udp { socket, peer: Some(peer), listens: true } => socket.send_to(bytes, *peer).map(|_| true),
            Transport::Udp { listens: true, .. } => Ok(false),
            Transport::Udp { socket, .. } => match socket.send(bytes) {
                Err(error) if error.kind() == ErrorKind::ConnectionRefused => Ok(false),
                sent => sent.map(|_| true),
            },
            Transport::Tcp(stream) => stream.write_all(bytes).map(|()| true),
            Transport::Serial(file, _) => file.write_all(bytes).map(|()| true),
        }
    }
}

fn listen(address: &str, patience: Duration) -> IoResult<Transport> {
    let socket = bind(address)?;
    socket.set_read_timeout(Some(patience))?;
    Ok(Transport::Udp { socket, peer: None, listens: true })
}

fn bind(address: &str) -> IoResult<UdpSocket> {
    roomy(UdpSocket::bind(address)?)
}

fn call(address: &str, patience: Duration) -> IoResult<Transport> {
    let (socket, peer) = connected(address)?;
    socket.set_read_timeout(Some(patience))?;
    Ok(Transport::Udp { socket, peer: Some(peer), listens: false })
}

fn connected(address: &str) -> IoResult<(UdpSocket, SocketAddr)> {
    let peer = first(address)?;
    let own = match peer {
        _ if peer.ip().is_loopback() => peer.ip(),
        SocketAddr::V4(_) => Ipv4Addr::UNSPECIFIED.into(),
        SocketAddr::V6(_) => Ipv6Addr::UNSPECIFIED.into(),
    };
    let socket = UdpSocket::bind((own, 0))?;
    socket.connect(peer)?;
    Ok((roomy(socket)?, peer))
}

/// With as much room for what waits as the system allows, up to [`WAITING_BYTES`].
fn roomy(socket: UdpSocket) -> IoResult<UdpSocket> {
    rustix::net::sockopt::set_socket_recv_buffer_size(&socket, WAITING_BYTES)?;
    Ok(socket)
}

fn connect(address: &str, patience: Duration) -> IoResult<Transport> {
    let stream = TcpStream::connect_timeout(&first(address)?, CONNECT)?;
    stream.set_read_timeout(Some(patience))?;
    // An end that takes nothing any more is one that has gone.
    stream.set_write_timeout(Some(CONNECT))?;
    stream.set_nodelay(true)?;
    Ok(Transport::Tcp(stream))
}

fn first(address: &str) -> IoResult<SocketAddr> {
    address.to_socket_addrs()?.next().ok_or_else(|| Error::new(ErrorKind::NotFound, "the name has no address"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::TcpListener;

    const PATIENCE: Duration = Duration::from_millis(200);

    #[test]
    fn urls_are_told_apart_and_wrong_ones_refused() {
        let serial = Url::Serial { device: "/dev/ttyUSB0".into(), baud: 921_600 };
        assert_eq!(Url::parse("serial:///dev/ttyUSB0?baud=921600").unwrap(), serial);
        assert_eq!(Url::parse("udpin://0.0.0.0:14550").unwrap(), Url::UdpIn("0.0.0.0:14550".into()));
        assert_eq!(Url::parse("tcp://[::1]:5760").unwrap().to_string(), "tcp://[::1]:5760");
        for text in
            ["14550", "udp://a:1", "udpin://0.0.0.0", "tcp://:5760", "udpout://a:99999", "serial://", "serial:///d?baud=9"]
        {
            assert!(Url::parse(text).unwrap_err().to_string().contains("expected"), "{text}");
        }
        assert!(Url::is_link("udpin://x") && !Url::is_link("file://x"));
    }

    #[test]
    fn datagrams_go_both_ways_and_silence_is_no_error() {
        let mut listening = Link::open(Url::UdpIn("127.0.0.1:0".into()), PATIENCE).unwrap();
        let mut buffer = [0; 64];
        assert_eq!(listening.receive(&mut buffer).unwrap(), LinkEvent::Silence);
        assert!(!listening.send(b"who").unwrap() && !listening.has_peer());
        let address = listening.local_address().unwrap().to_string();
        let mut calling = Link::open(Url::UdpOut(address), PATIENCE).unwrap();
        assert!(calling.send(b"here").unwrap());
        assert_eq!(listening.receive(&mut buffer).unwrap(), LinkEvent::Bytes(4));
        assert!(listening.send(b"heard").unwrap() && listening.has_peer());
        assert_eq!(calling.receive(&mut buffer).unwrap(), LinkEvent::Bytes(5));
        assert_eq!(&buffer[..5], b"heard");
        assert!(calling.send(b"").unwrap());
        assert_eq!(listening.receive(&mut buffer).unwrap(), LinkEvent::Bytes(0), "an empty one is no silence");
    }

    #[test]
    fn a_connection_gives_its_bytes_and_then_its_end() {
        let server = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = server.local_addr().unwrap().to_string();
        let mut link = Link::open(Url::Tcp(address), PATIENCE).unwrap();
        let (mut other, _) = server.accept().unwrap();
        other.write_all(b"abc").unwrap();
        let mut buffer = [0; 64];
        assert_eq!(link.receive(&mut buffer).unwrap(), LinkEvent::Bytes(3));
        assert_eq!(link.receive(&mut buffer).unwrap(), LinkEvent::Silence);
        drop(other);
        assert_eq!(link.receive(&mut buffer).unwrap(), LinkEvent::Closed);
        drop(server);
    }

    #[test]
    fn a_line_whose_reads_are_empty_at_once_has_hung_up() {
        let channel = Transport::Serial(File::open("/dev/null").unwrap(), 0);
        let mut link = Link { url: Url::parse("serial:///dev/null").unwrap(), channel };
        let reads = [(); 3].map(|()| link.receive(&mut [0; 8]).unwrap());
        assert_eq!(reads, [LinkEvent::Silence, LinkEvent::Silence, LinkEvent::Closed]);
    }

    #[cfg(unix)]
    #[test]
    fn a_serial_line_is_opened_raw_and_what_is_none_is_refused() {
        use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
        let Ok(master) = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY) else { return };
        grantpt(&master).unwrap();
        unlockpt(&master).unwrap();
        let device = ptsname(&master, Vec::new()).unwrap().into_string().unwrap();
        let mut link = Link::open(Url::Serial { device: device.into(), baud: 115_200 }, PATIENCE).unwrap();
        let mut buffer = [0; 64];
        assert_eq!(link.receive(&mut buffer).unwrap(), LinkEvent::Silence);
        // Bytes that a line in its ordinary mode would take for signals and line ends.
        rustix::io::write(&master, &[0xFD, 3, 13, 10, 0]).unwrap();
        assert_eq!(link.receive(&mut buffer).unwrap(), LinkEvent::Bytes(5));
        assert_eq!(&buffer[..5], &[0xFD, 3, 13, 10, 0]);
        // Silence is no end; the end, as an error or as reads that are empty at once, is one.
        for _ in 0..5 {
            assert_eq!(link.receive(&mut buffer).unwrap(), LinkEvent::Silence);
        }
        drop(master);
        let ended = (0..5).find(|_| !matches!(link.receive(&mut buffer), Ok(LinkEvent::Silence)));
        assert!(ended.is_some_and(|reads| reads < 3), "{ended:?}");
        let none = Link::open(Url::Serial { device: "/dev/null".into(), baud: 57_600 }, PATIENCE);
        assert!(none.unwrap_err().to_string().contains("serial:///dev/null"));
    }
}
