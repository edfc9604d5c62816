//! The services: one publisher each, which never waits, and any number of subscribers, which count the messages that they missed.
//!
//! The queue of a subscriber holds [`Payload::BUFFER`] messages; when it is full the oldest is overwritten (safe overflow of the
//! middleware), and the gap in the sequence numbers is the number of missed messages. Every message carries the incarnation of
//! its publisher ([`MessageHeader::incarnation`]); a message of an earlier incarnation that arrives after one of a later is
//! dropped and counted.

use super::clock::monotonic_ns;
use super::error::BusError;
use super::payload::{
    AcknowledgementPayload, DerivativesPayload, EventPayload, FindingPayload, InnovationsPayload, MessageHeader, ModesPayload,
    OutputErrorPayload, Payload, SamplePayload, SmoothedPayload, StatePayload,
};
use super::root::{BusRole, BusRoot, RoleLock};
use iceoryx2::config::Config;
use iceoryx2::node::{Node, NodeBuilder};
use iceoryx2::port::subscriber::SubscriberCreateError;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::{FileName, Path as BusPath, SemanticString, ServiceName, SignalHandlingMode, ipc};
use iceoryx2::service::builder::publish_subscribe::{PublishSubscribeOpenError, PublishSubscribeOpenOrCreateError};
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;
use std::path::Path;
use std::time::Duration;

/// Subscribers that a service has room for.
pub const MOST_SUBSCRIBERS: usize = 10;

/// Publishers that a service has room for: one that lives, and dead ones whose place has not been cleared yet.
const PUBLISHERS: usize = 4;

/// Processes, likewise.
const NODES: usize = 64;

/// The longest that the middleware waits for another process that is making what it needs.
const CREATION: Duration = Duration::from_millis(500);

type Open<P> = PortFactory<ipc::Service, P, ()>;

/// Every service, open for as long as this process is inside the root.
#[derive(Debug)]
struct Services {
    _sample: Open<SamplePayload>,
    _state: Open<StatePayload>,
    _smoothed: Open<SmoothedPayload>,
    _innovation: Open<InnovationsPayload>,
    _derivatives: Open<DerivativesPayload>,
    _modes: Open<ModesPayload>,
    _output_error: Open<OutputErrorPayload>,
    _event: Open<EventPayload>,
    _finding: Open<FindingPayload>,
    _taken: Open<AcknowledgementPayload>,
}

/// A process' place on the bus.
#[derive(Debug)]
pub struct Bus {
    // Dropped in this order: the services before the node, the lock last.
    _services: Services,
    node: Node<ipc::Service>,
    root: BusRoot,
    incarnation: u64,
}

impl Bus {
    /// Enters the root and opens every service.
    ///
    /// # Errors
    /// [`BusError`] where the root cannot be used, or programs of another version are in it.
    pub fn enter(path: &Path) -> Result<Self, BusError> {
        let (root, door) = BusRoot::enter(path)?;
        let config = config(&root)?;
        let refused = |what: String| middleware(&root, "joining the bus", what);
        let node = NodeBuilder::new()
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<ipc::Service>()
            .map_err(|error| refused(format!("{error:?}")))?;
        let services = Services {
            _sample: open(&node, &root)?,
            _state: open(&node, &root)?,
            _smoothed: open(&node, &root)?,
            _innovation: open(&node, &root)?,
            _derivatives: open(&node, &root)?,
            _modes: open(&node, &root)?,
            _output_error: open(&node, &root)?,
            _event: open(&node, &root)?,
            _finding: open(&node, &root)?,
            _taken: open(&node, &root)?,
        };
        drop(door);
        Ok(Bus { _services: services, node, root, incarnation: monotonic_ns() })
    }

    /// The same in a root of this process and those that it starts, which is removed at the end.
    ///
    /// # Errors
    /// [`BusError`] where the root cannot be used.
    pub fn enter_private(path: &Path) -> Result<Self, BusError> {
        let mut bus = Bus::enter(path)?;
        bus.root.remove_at_the_end();
        Ok(bus)
    }

    /// The root.
    pub fn root(&self) -> &BusRoot {
        &self.root
    }

    /// Which life of this program it is: the monotonic clock when it entered or last took a role, ns.
    pub fn incarnation(&self) -> u64 {
        self.incarnation
    }

    /// Takes a role in the root.
    ///
    /// # Errors
    /// [`BusError::RoleTaken`] where another process has it.
    pub fn take(&mut self, role: BusRole) -> Result<RoleLock, BusError> {
        self.take_within(role, Duration::ZERO)
    }

    /// The same, waiting so long for a process that is ending. Of two that want a role the one that gets it later has the
    /// later incarnation, whichever entered first.
    ///
    /// # Errors
    /// [`BusError::RoleTaken`] where another process still has it then.
    pub fn take_within(&mut self, role: BusRole, limit: Duration) -> Result<RoleLock, BusError> {
        let held = self.root.take_within(role, limit)?;
        self.incarnation = monotonic_ns();
        Ok(held)
    }

    /// Clears away what dead processes hold in the services; takes some ten milliseconds.
    pub fn clear_the_dead(&self) {
        let _ = self.node.try_cleanup_dead_nodes();
    }

    /// A publisher. That there is one only is the role's matter.
    ///
    /// # Errors
    /// [`BusError`] where the service has another schema or no room.
    pub fn publisher<P: Payload>(&self) -> Result<Publisher<P>, BusError> {
        let refused = |what: String| middleware(&self.root, &format!("publishing {}", P::SERVICE), what);
        let service = open::<P>(&self.node, &self.root)?;
        let port = service.publisher_builder().max_loaned_samples(1).create().map_err(|error| refused(format!("{error:?}")))?;
        Ok(Publisher { port, next: 0, incarnation: self.incarnation, root: self.root.path().into() })
    }

    /// A subscriber; it gets the last [`Payload::HISTORY`] messages too, of a publisher that lives.
    ///
    /// # Errors
    /// [`BusError`] where the service has another schema or no room.
    pub fn subscriber<P: Payload>(&self) -> Result<Subscriber<P>, BusError> {
        let refused = |what: String| middleware(&self.root, &format!("subscribing {}", P::SERVICE), what);
        let service = open::<P>(&self.node, &self.root)?;
        let port = service.subscriber_builder().create().map_err(|error| match error {
            SubscriberCreateError::ExceedsMaxSupportedSubscribers => {
                refused(format!("expected at most {MOST_SUBSCRIBERS} readers in one root, found one more"))
            }
            other => refused(format!("{other:?}")),
        })?;
        Ok(Subscriber { port, last: None, missed: 0, stale: 0, root: self.root.path().into() })
    }
}

fn middleware(root: &BusRoot, doing: &str, what: String) -> BusError {
    BusError::Middleware { path: root.path().into(), doing: doing.to_owned(), what }
}

fn config(root: &BusRoot) -> Result<Config, BusError> {
    let directory = root.bus_directory()?;
    let wrong = |what: String| BusError::Root { path: root.path().into(), what };
    let path = BusPath::new(directory.as_os_str().as_encoded_bytes())
        .map_err(|error| wrong(format!("a path that the bus cannot use, too long or with strange characters: {error:?}")))?;
    let mut config = Config::default();
    config.global.set_root_path(&path);
    config.global.prefix = FileName::new(root.prefix().as_bytes()).map_err(|error| wrong(format!("{error:?}")))?;
    config.global.creation_timeout = CREATION;
    Ok(config)
}

fn open<P: Payload>(node: &Node<ipc::Service>, root: &BusRoot) -> Result<Open<P>, BusError> {
    let refused = |what: String| middleware(root, &format!("opening {}", P::SERVICE), what);
    let name = ServiceName::new(P::SERVICE).map_err(|error| refused(format!("{error:?}")))?;
    let opened = node
        .service_builder(&name)
        .publish_subscribe::<P>()
        .enable_safe_overflow(true)
        .subscriber_max_buffer_size(P::BUFFER)
        .history_size(P::HISTORY)
        .subscriber_max_borrowed_samples(1)
        .max_subscribers(MOST_SUBSCRIBERS)
        .max_publishers(PUBLISHERS)
        .max_nodes(NODES)
        .open_or_create();
    use PublishSubscribeOpenError as Wrong;
    opened.map_err(|error| match error {
        PublishSubscribeOpenOrCreateError::PublishSubscribeOpenError(
            Wrong::IncompatibleTypes
            | Wrong::IncompatibleMessagingPattern
            | Wrong::IncompatibleOverflowBehavior
            | Wrong::DoesNotSupportRequestedMinBufferSize
            | Wrong::DoesNotSupportRequestedMinHistorySize
            | Wrong::DoesNotSupportRequestedMinSubscriberBorrowedSamples
            | Wrong::DoesNotSupportRequestedAmountOfSubscribers
            | Wrong::DoesNotSupportRequestedAmountOfPublishers
            | Wrong::DoesNotSupportRequestedAmountOfNodes
            | Wrong::VersionMismatch,
        ) => BusError::Schema { path: root.path().into(), service: P::SERVICE, expected: P::SCHEMA },
        other => refused(format!("{other:?}")),
    })
}

/// The one who publishes a service.
#[derive(Debug)]
pub struct Publisher<P: Payload> {
    port: iceoryx2::port::publisher::Publisher<ipc::Service, P, ()>,
    next: u64,
    incarnation: u64,
    root: std::path::PathBuf,
}

impl<P: Payload> Publisher<P> {
    /// Publishes a message that rests on a sample which came at `sampled_ns`, or now where that is `None`. Never waits:
    /// a subscriber that is slow loses its oldest message. Returns the header as it went out.
    ///
    /// # Errors
    /// [`BusError::Middleware`] where the middleware has no memory left; that is a fault, for its memory is all taken
    /// when the publisher is made.
    pub fn publish(&mut self, payload: &P, sampled_ns: Option<u64>) -> Result<MessageHeader, BusError> {
        let refused = |root: &Path, what: String| BusError::Middleware {
            path: root.into(),
            doing: format!("publishing {}", P::SERVICE),
            what,
        };
        let loan = self.port.loan_uninit().map_err(|error| refused(&self.root, format!("{error:?}")))?;
        let mut message = *payload;
        let published_ns = monotonic_ns();
        let header = message.header_mut();
        header.sequence = self.next;
        header.incarnation = self.incarnation;
        header.sampled_ns = sampled_ns.unwrap_or(published_ns);
        header.published_ns = published_ns;
        let header = *header;
        loan.write_payload(message).send().map_err(|error| refused(&self.root, format!("{error:?}")))?;
        self.next += 1;
        Ok(header)
    }

    /// Makes the connections to subscribers that came since. The next [`Publisher::publish`] would make them, which takes
    /// memory and files: so a publisher that may not wait does it here, where nothing waits for it. Costs next to nothing
    /// where nobody came.
    ///
    /// # Errors
    /// [`BusError::Middleware`] where a subscriber's memory cannot be reached.
    pub fn meet(&mut self) -> Result<(), BusError> {
        self.port.update_connections().map_err(|error| BusError::Middleware {
            path: self.root.clone(),
            doing: format!("meeting readers of {}", P::SERVICE),
            what: format!("{error:?}"),
        })
    }

    /// How many messages were published.
    pub fn published(&self) -> u64 {
        self.next
    }
}

/// One who listens to a service.
#[derive(Debug)]
pub struct Subscriber<P: Payload> {
    port: iceoryx2::port::subscriber::Subscriber<ipc::Service, P, ()>,
    last: Option<(u64, u64)>,
    missed: u64,
    stale: u64,
    root: std::path::PathBuf,
}

impl<P: Payload> Subscriber<P> {
    /// The next message; `None` where there is none now. Never waits.
    ///
    /// # Errors
    /// [`BusError::Middleware`] where the memory of a publisher cannot be read.
    pub fn receive(&mut self) -> Result<Option<P>, BusError> {
        loop {
            let received = self.port.receive().map_err(|error| BusError::Middleware {
                path: self.root.clone(),
                doing: format!("receiving {}", P::SERVICE),
                what: format!("{error:?}"),
            })?;
            let Some(message) = received else { return Ok(None) };
            let payload = *message.payload();
            let MessageHeader { sequence, incarnation, .. } = *payload.header();
            let expected = match self.last {
                Some((life, last)) if life == incarnation => last + 1,
                Some((life, _)) if life > incarnation => {
                    self.stale += 1;
                    continue;
                }
                // A later life than the one heard so far counts from its first message on.
                Some(_) => 0,
                None => sequence,
            };
            if sequence < expected {
                self.stale += 1;
                continue;
            }
            self.missed += sequence - expected;
            self.last = Some((incarnation, sequence));
            return Ok(Some(payload));
        }
    }

    /// How many messages were overwritten before they were received, over all lives of the publisher heard so far.
    pub fn missed(&self) -> u64 {
        self.missed
    }

    /// How many messages of an earlier life came after one of a later, and were dropped.
    pub fn stale(&self) -> u64 {
        self.stale
    }
}
