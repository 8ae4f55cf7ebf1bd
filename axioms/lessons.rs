//! What searches for room hand on to those of later observations.

use crate::measured::sightings;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use topostar::abduction::{
    Abduction, AxiomId, AxiomSet, Clash, Evidence, Learned, Limits, Profile, Proposal, Visit, judge,
};
use topostar::metric::{Measurements, Patience, Room};
use topostar::worlds::{Drift, corridor_grid, covering_walk, drifting_trace};

/// Measurements that ask once more, with nothing learned, where a search for room finds none.
#[derive(Debug)]
struct Doubting {
    measured: Measurements,
    /// How often none was found, and how often that was not found out without what was learned.
    asked: Arc<[AtomicUsize; 2]>,
}

impl Evidence for Doubting {
    fn holds(&self, axiom: AxiomId, proposal: &Proposal<'_>) -> bool {
        let holds = self.measured.holds(axiom, proposal);
        if !holds && self.clash(axiom, proposal).words.contains("leave no room") {
            // The second range holds all others, and may leave room where they do not.
            let ranges = [0, 2, 3, 4];
            let rooms = ranges.map(|range| self.measured.room(proposal, range, 5.0, Patience::Short));
            assert!(!rooms.iter().any(|room| matches!(room, Some(Room::Found(_)))), "{proposal:?}");
            let open = rooms.iter().any(|room| matches!(room, Some(Room::Unknown)));
            self.asked[0].fetch_add(1, Ordering::Relaxed);
            self.asked[1].fetch_add(usize::from(open), Ordering::Relaxed);
        }
        holds
    }

    fn clash(&self, axiom: AxiomId, proposal: &Proposal<'_>) -> Clash {
        self.measured.clash(axiom, proposal)
    }

    fn learned(&self, proposal: &Proposal<'_>) -> Learned {
        self.measured.learned(proposal)
    }
}

/// What was learned on earlier observations refutes nothing for which room is found without, and who judges one assignment from
/// its beginning has learned what the search has.
#[test]
fn what_was_learned_refutes_what_has_no_room() {
    let asked: Arc<[AtomicUsize; 2]> = Arc::default();
    for seed in [0, 3, 10, 20] {
        let places = corridor_grid(5, 5, 10.0);
        let trace = drifting_trace(&places, &covering_walk(&places, seed), Drift::WORST, seed).unwrap();
        let (mut measured, mut visits) = (Measurements::default(), Vec::new());
        let mut found = Abduction::new(AxiomSet::of(Profile::Default), Limits::default());
        for sighting in sightings(&trace.events) {
            measured = measured.with(&sighting);
            let doubting = Doubting { measured: measured.clone(), asked: Arc::clone(&asked) };
            visits.push(Visit::from(&sighting));
            let evidence = measured.any().then(|| Arc::new(doubting) as Arc<dyn Evidence>);
            found.observe_measured(&visits[visits.len() - 1], evidence).unwrap();
        }
        let evidence = measured.evidence();
        for candidate in found.candidates() {
            let judged = judge(&visits, evidence.as_deref(), found.axioms(), &candidate.visits);
            assert_eq!(judged, Ok(Some(candidate)), "{seed}");
        }
    }
    println!("{asked:?}");
    assert!(asked[0].load(Ordering::Relaxed) >= 20, "{asked:?}");
}
