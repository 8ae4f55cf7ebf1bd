//! `topostar demo`: a bundled world, end to end over real HTTP on loopback.

use crate::cli::failure::Failure;
use crate::cli::serve::{maps, runtime};
use crate::cli::words::{certainty, headline};
use crate::cli::world;
use crate::export::{MapGraph, Report, map_svg, map_text, place_type};
use crate::service::http;
use crate::trace::{Event, EventKind, write_event};
use crate::worlds::{self, lpm_trace};
use clap::Args;
use clap::builder::PossibleValuesParser;
use serde::de::DeserializeOwned;
use std::fs;
use std::io::{Write, stdout};
use std::net::SocketAddr;
use std::path::PathBuf;
use tokio::net::TcpListener;

/// Map a bundled world end to end over HTTP on loopback; prints what happens at each place.
///
/// The walk is rendered as occupancy grids, which are posted one by one to a real server; everything printed and
/// drawn comes from its answers.
#[derive(Debug, Args)]
pub(super) struct Demo {
    /// The world to walk through; `topostar world` lists them.
    #[arg(default_value = "office", value_parser = PossibleValuesParser::new(worlds::names()))]
    world: String,
    /// Draws where each grid lies in its frame, and the noise of the odometry.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Where to write the map as a picture.
    #[arg(short, long, value_name = "DIR", default_value = "topostar-out")]
    output: PathBuf,
}

/// Side of a grid cell, metres.
const RESOLUTION: f64 = 0.05;

impl Demo {
    pub(super) fn run(self) -> Result<(), Failure> {
        let world = world::load(&self.world)?;
        let trace =
            lpm_trace(&world, self.seed, RESOLUTION).map_err(|error| Failure::Broken(error.to_string()))?;
        let server = Server::start()?;
        writeln!(stdout(), "{}\n{}\n", world.title, world.story)?;
        writeln!(
            stdout(),
            "a real server listens on http://{}; the walk is posted to it as occupancy grids\n",
            server.address
        )?;
        server.create()?;
        writeln!(stdout(), "{:>3}  {:22} {:>10}  preferred map so far", "", "place seen", "candidates")?;
        let mut visit = 0;
        for event in &trace.events {
            server.post(event)?;
            if matches!(event.kind, EventKind::Observation(_)) {
                writeln!(stdout(), "{}", server.line(visit)?)?;
                visit += 1;
            }
        }
        self.conclude(&server)
    }

    fn conclude(&self, server: &Server) -> Result<(), Failure> {
        let report = server.report()?;
        let Some(preferred) = &report.preferred else {
            return Err(Failure::NoMap("no consistent map".into()));
        };
        let map = server.graph()?;
        let ties = report.minimal.len();
        writeln!(stdout(), "\n{}\n{}", headline(&report.candidates, preferred, ties), map_text(&map))?;
        let file = self.output.join(format!("{}.svg", self.world));
        let picture = map_svg(&map, &self.world, &certainty(&report.candidates, preferred, ties));
        fs::create_dir_all(&self.output)
            .and_then(|()| fs::write(&file, picture))
            .map_err(|error| Failure::writing(&file, error))?;
        Ok(writeln!(stdout(), "drawn in {}", file.display())?)
    }
}

/// The service on a free port of the loopback interface, and a client of it.
struct Server {
    address: SocketAddr,
    client: ureq::Agent,
    /// Keeps the service running.
    _runtime: tokio::runtime::Runtime,
}

impl Server {
    fn start() -> Result<Server, Failure> {
        let broken = |error: std::io::Error| Failure::Broken(format!("cannot listen on loopback: {error}"));
        let runtime = runtime()?;
        let listener = runtime.block_on(TcpListener::bind("127.0.0.1:0")).map_err(broken)?;
        let address = listener.local_addr().map_err(broken)?;
        runtime.spawn(http::serve(listener, maps()));
        Ok(Server { address, client: ureq::agent(), _runtime: runtime })
    }

    fn create(&self) -> Result<(), Failure> {
        self.client.put(self.url("")).send_empty().map(|_| ()).map_err(|error| failed("PUT", error))
    }

    fn post(&self, event: &Event) -> Result<(), Failure> {
        let mut line = Vec::new();
        write_event(&mut line, event)?;
        let request = self.client.post(self.url("/events")).header("content-type", "application/x-ndjson");
        request.send(&line[..]).map(|_| ()).map_err(|error| failed("POST", error))
    }

    fn report(&self) -> Result<Report, Failure> {
        self.get("")
    }

    fn graph(&self) -> Result<MapGraph, Failure> {
        self.get("/candidates/preferred/graph")
    }

    /// What the service says after an observation.
    fn line(&self, visit: usize) -> Result<String, Failure> {
        let (report, map) = (self.report()?, self.graph()?);
        let Some(preferred) = &report.preferred else {
            return Ok(format!("{visit:>3}  {:22} {:>10}", "", report.candidates.value));
        };
        let place = preferred.visits.last().and_then(|&place| map.places.get(place));
        let seen = place.map(place_type).unwrap_or_default();
        let visits: Vec<String> = preferred.visits.iter().map(usize::to_string).collect();
        Ok(format!("{visit:>3}  {seen:22} {:>10}  visits {}", report.candidates.value, visits.join(" ")))
    }

    fn get<T: DeserializeOwned>(&self, path: &str) -> Result<T, Failure> {
        let mut response = self.client.get(self.url(path)).call().map_err(|error| failed("GET", error))?;
        response.body_mut().read_json().map_err(|error| failed("GET", error))
    }

    fn url(&self, path: &str) -> String {
        format!("http://{}/v1/maps/demo{path}", self.address)
    }
}

fn failed(method: &str, error: ureq::Error) -> Failure {
    Failure::Broken(format!("{method} failed: {error}"))
}
