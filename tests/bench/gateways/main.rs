//! How well gateways and stars are read off buildings that others recorded: `../shared/data`, see its README.
//!
//! `cargo xtask gateways [visits] [again] [doors] [borders] [stability] [defaults] [chain]` prints what is asked for, everything unless told:
//!
//! * `visits`: the places of the ACES log, a star a visit;
//! * `again`: the places that recorded logs come to again, a star a visit;
//! * `doors`: the annotated doors of gdc3, from the pose from which a robot approaches each on either side;
//! * `borders`: the borders between rooms of the segmented maps, plain and furnished, from either side;
//! * `stability`: whether the star of a place survives another laying of the grid, noise, and another arrival;
//! * `defaults`: every default 20 % down and up, and what that changes in windows cut out beforehand;
//! * `chain`: the same, from the raw ACES log to its map.
//!
//! With `GATEWAY_PICTURES=DIR` every window with a visit, a door or a border is drawn there.

#![allow(clippy::unwrap_used, clippy::panic, reason = "an evaluation ends where something is wrong")]

mod aces;
mod again;
mod borders;
mod chain;
mod defaults;
mod doors;
mod maps;
mod openings;
mod stability;
mod visits;

fn main() {
    let asked: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    if !maps::data("maps").is_dir() {
        println!("skipped, as ../shared/data is not there: gateways {}", asked.join(" "));
        return;
    }
    let parts: [(&str, fn()); 7] = [
        ("visits", visits::print),
        ("again", again::print),
        ("doors", doors::print),
        ("borders", borders::print),
        ("stability", stability::print),
        ("defaults", defaults::print),
        ("chain", chain::print),
    ];
    for (name, print) in parts {
        if asked.is_empty() || asked.iter().any(|word| word == name) {
            print();
        }
    }
}
