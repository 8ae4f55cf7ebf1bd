//! The maps of the candidates, made when they are asked for.

use crate::abduction::children::Seen;
use crate::abduction::tree::Tree;
use crate::abduction::{AxiomSet, Simplicity};
use crate::map::{Atlas, TopologicalMap};
use std::sync::Arc;

/// What the maps of a tree's leaves are made of: a leaf differs from its parent by what it takes the latest
/// observation for, and most leaves are never asked for their maps. A clone shares all.
#[derive(Clone, Debug, Default)]
pub(super) struct LeafMaps {
    /// The maps of the layer before the leaves, [`BATCH`] to an atlas; of the first layer its own.
    parents: Arc<Vec<Atlas>>,
    /// The latest observation, but not the first.
    seen: Option<Arc<Seen>>,
}

/// Candidates that one thread extends at a time: enough to be worth a thread, and few enough to share out evenly.
pub(super) const BATCH: usize = 512;

impl LeafMaps {
    /// The map of the first observation.
    pub(super) fn first(map: &TopologicalMap) -> LeafMaps {
        let mut atlas = Atlas::default();
        atlas.push(map);
        LeafMaps { parents: Arc::new(vec![atlas]), seen: None }
    }

    /// The maps of leaves whose parents have these maps.
    pub(super) fn new(parents: Vec<Atlas>, seen: Seen) -> LeafMaps {
        LeafMaps { parents: Arc::new(parents), seen: Some(Arc::new(seen)) }
    }

    /// Turns a map into that of a leaf. Linear in its dstates.
    pub(super) fn make(&self, tree: &Tree, leaf: usize, map: &mut TopologicalMap) {
        self.make_parent(tree, leaf, map);
        if let Some(seen) = &self.seen {
            seen.extend(map, tree.last_two(leaf));
        }
    }

    /// How simple the map of a leaf is, found by turning a map into that of its parent.
    pub(super) fn simplicity(
        &self,
        tree: &Tree,
        leaf: usize,
        axioms: AxiomSet,
        map: &mut TopologicalMap,
    ) -> Simplicity {
        self.make_parent(tree, leaf, map);
        match &self.seen {
            Some(seen) => seen.simplicity(map, tree.last_two(leaf), axioms),
            None => Simplicity::of(map, axioms),
        }
    }

    fn make_parent(&self, tree: &Tree, leaf: usize, map: &mut TopologicalMap) {
        let parent = tree.leaves()[leaf].parent as usize;
        self.parents[parent / BATCH].read(parent % BATCH, map);
    }
}
