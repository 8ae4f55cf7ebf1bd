//! The preferred maps are the simplest of all maps.

use crate::engine::{affordable, axiom_sets, explain, names, story};
use crate::reference::{self, Story};
use crate::strategies::tangled_walks;
use proptest::prelude::*;
use topostar::abduction::{AxiomSet, Boundary, Profile};

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_minimum_is_that_of_the_reference(walk in tangled_walks(8)) {
        let soft = [AxiomSet::built_in(), AxiomSet::of(Profile::Paper)];
        let soft = soft.map(|axioms| axioms.with_boundary(Some(Boundary::Soft)));
        for axioms in axiom_sets().into_iter().chain(soft) {
            let ranks = axioms.boundary() == Some(Boundary::Soft);
            let visits = affordable(&walk.visits, axioms);
            let report = explain(visits, axioms).report();
            let all = reference::explanations(visits, &names(axioms), true);
            let expected = reference::minimal(visits, &all, ranks);
            prop_assert_eq!(report.minimal.iter().map(story).collect::<Vec<Story>>(), expected.clone());
            prop_assert!(report.proven);
            prop_assert_eq!(report.unique, expected.len() == 1);
            for candidate in &report.minimal {
                let size = candidate.simplicity(axioms);
                prop_assert_eq!((size.paths, size.places), reference::size(visits, &story(candidate)));
                let abnormalities = ranks.then(|| reference::abnormalities(visits, &story(candidate)));
                prop_assert_eq!(size.abnormalities, abnormalities);
            }
        }
    }
}
