//! The service: maps that grow with what robots post.
//!
//! What it promises: events of a map are taken in order of `seq`, each once, and posting one again does no
//! harm. An event is kept before it is acknowledged. What cannot be taken changes nothing; what came before
//! stays. The state of a map depends on its configuration and its events alone, so it is rebuilt from them by
//! replay. Nothing grows without a bound of [`Limits`].
//!
//! [`session`] is the state machine of one map, without I/O, and [`view_session`] that of a trace of views, which the
//! service does not keep maps of yet; [`store`] keeps configurations and events;
//! [`maps`] gives every map its turn on the [`workers`]; `jobs` keeps what clients do not wait for; [`http`] speaks to the world, and [`problem`] alone
//! decides statuses.

pub mod limits;
pub mod map_name;
pub mod map_config;
pub mod session;
pub mod view_session;
pub mod store;
pub mod view;
mod tags;
pub mod lines;
pub mod intake;
pub mod workers;
pub mod maps;
pub mod problem;
mod representation;
mod jobs;
pub mod http;

pub use http::{app, openapi, serve};
pub use intake::{Batch, Fault, Intake, IntakeError, Position, Taken};
pub use limits::Limits;
pub use lines::{Line, Lines};
pub use map_config::{MapConfig, WireMapConfig};
pub use map_name::{MapName, MapNameError};
pub use maps::{Maps, MapsError};
pub use session::{Accepted, Session, SessionError};
pub use store::{Created, MemoryStore, Store, StoreError, StoredMap};
pub use view::View;
pub use view_session::{ViewSession, ViewSessionError};
pub use workers::{Panicked, Workers, Workload};
