//! Where candidates come from: the dstates that their observations are assigned to, as a tree.

use crate::classic::DstateId;

/// All assignments tried, each observation with the one before. Nodes without descendants stay: they are what was
/// refuted or cut. Eight bytes a node.
#[derive(Clone, Debug, Default)]
pub(super) struct History {
    nodes: Vec<Node>,
}

/// An observation assigned to a dstate.
#[derive(Clone, Copy, Debug)]
struct Node {
    before: u32, // its own number at the first observation
    at: DstateId,
}

/// The name of a node. A later one was made later.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct NodeId(u32);

impl History {
    /// Adds an observation after another; none if there are more than can be numbered.
    pub(super) fn push(&mut self, before: Option<NodeId>, at: DstateId) -> Option<NodeId> {
        let own = u32::try_from(self.nodes.len()).ok()?;
        self.nodes.push(Node { before: before.map_or(own, |node| node.0), at });
        Some(NodeId(own))
    }

    /// The dstate of the observation.
    pub(super) fn at(&self, node: NodeId) -> DstateId {
        self.nodes[node.0 as usize].at
    }

    /// The dstates of all observations up to this one, the first first.
    pub(super) fn story(&self, node: NodeId) -> Vec<DstateId> {
        let mut story = vec![self.at(node)];
        let mut own = node.0;
        while self.nodes[own as usize].before != own {
            own = self.nodes[own as usize].before;
            story.push(self.nodes[own as usize].at);
        }
        story.reverse();
        story
    }
}
