//! The preferred maps are the simplest of all maps.

use crate::engine::{affordable, axiom_sets, explain, names, story};
use crate::reference::{self, Story};
use crate::strategies::tangled_walks;
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_minimum_is_that_of_the_reference(walk in tangled_walks(8)) {
        for axioms in axiom_sets() {
            let visits = affordable(&walk.visits, axioms);
            let report = explain(visits, axioms).report();
            let all = reference::explanations(visits, &names(axioms), true);
            let expected = reference::minimal(visits, &all);
            prop_assert_eq!(report.minimal.iter().map(story).collect::<Vec<Story>>(), expected.clone());
            prop_assert!(report.proven);
            prop_assert_eq!(report.unique, expected.len() == 1);
            for candidate in &report.minimal {
                let size = candidate.simplicity();
                prop_assert_eq!((size.paths, size.places), reference::size(visits, &story(candidate)));
            }
        }
    }
}
