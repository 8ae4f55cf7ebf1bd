//! Where candidates come from: the assignments of all candidates, as a tree.

use crate::abduction::{Assignment, Lineage};
use std::sync::Arc;

/// One layer of nodes for each observation, each node with its parent in the layer before. Nodes without
/// descendants in the last layer stay: they are the candidates that were refuted or cut. Eight bytes a node; a clone
/// shares all layers.
#[derive(Clone, Debug, Default)]
pub(super) struct Tree {
    layers: Vec<Arc<[Node]>>,
}

/// What a candidate takes an observation for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub(super) parent: u32,
    pub(super) assignment: Assignment,
}

/// A leaf of a tree, by its position.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaf<'a> {
    tree: &'a Tree,
    index: usize,
}

impl Lineage for Leaf<'_> {
    fn assignments(&self) -> Vec<Assignment> {
        self.tree.assignments(self.index)
    }
}

impl Tree {
    /// The leaf at a position.
    pub(super) fn leaf(&self, index: usize) -> Leaf<'_> {
        Leaf { tree: self, index }
    }

    /// The number of observations.
    pub(super) fn depth(&self) -> usize {
        self.layers.len()
    }

    /// The nodes of the last observation.
    pub(super) fn leaves(&self) -> &[Node] {
        self.layers.last().map_or(&[], |layer| layer)
    }

    /// The number of nodes of each observation.
    pub(super) fn widths(&self) -> impl ExactSizeIterator<Item = usize> {
        self.layers.iter().map(|layer| layer.len())
    }

    /// Bytes of all nodes.
    pub(super) fn bytes(&self) -> usize {
        self.widths().sum::<usize>() * size_of::<Node>()
    }

    /// Adds the nodes of one more observation.
    pub(super) fn push(&mut self, layer: Vec<Node>) {
        self.layers.push(layer.into());
    }

    /// Takes leaves out: those of which `keep`, in their order, says no.
    pub(super) fn prune(&mut self, keep: &[bool]) {
        if let Some(leaves) = self.layers.last_mut() {
            let kept = leaves.iter().zip(keep).filter(|&(_, &keep)| keep);
            *leaves = kept.map(|(leaf, _)| *leaf).collect();
        }
    }

    /// What a leaf takes the last two observations for; the first one alone counts as both.
    pub(super) fn last_two(&self, leaf: usize) -> [Assignment; 2] {
        let Node { parent, assignment } = self.leaves()[leaf];
        let before = self.layers.iter().rev().nth(1).map(|layer| layer[parent as usize].assignment);
        [before.unwrap_or(assignment), assignment]
    }

    /// The assignments on the way to a leaf, first observation first.
    pub(super) fn assignments(&self, leaf: usize) -> Vec<Assignment> {
        let mut assignments = Vec::with_capacity(self.layers.len());
        let mut index = leaf;
        for layer in self.layers.iter().rev() {
            assignments.push(layer[index].assignment);
            index = layer[index].parent as usize;
        }
        assignments.reverse();
        assignments
    }
}
