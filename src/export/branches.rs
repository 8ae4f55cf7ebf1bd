//! The candidates as a tree, as JSON.

use crate::abduction::Abduction;
use crate::explanation::{Node, children, ended};
use crate::export::EndedBranch;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// A beginning that some candidates have in common.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct TreeNode {
    /// The last observation of the beginning.
    pub observation: usize,
    /// The place it is taken for.
    pub place: usize,
    /// How many slots further on the star of the place each slot seen is.
    pub rotation: u8,
    /// The position of the first candidate that begins so; with the observation it names the node.
    pub candidate: usize,
    /// How many candidates begin so.
    pub leaves: usize,
    /// How many children candidates descend from.
    pub branches: usize,
    /// Those children, as deep and as wide as was asked for; null below that depth, and where the
    /// answer has no more room.
    #[schema(no_recursion)]
    pub children: Option<Vec<TreeNode>>,
    /// The children that were proposed and that no candidate descends from, if asked for; null where
    /// `children` is.
    pub ended: Option<EndedBranches>,
}

/// Branches that ended at the same node.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct EndedBranches {
    /// How many there are.
    pub count: usize,
    /// The first of them, as many as was asked for.
    pub branches: Vec<EndedBranch>,
}

/// How much of a tree to show.
#[derive(Clone, Copy, Debug)]
pub struct TreeExtent {
    /// How many observations below the node.
    pub depth: usize,
    /// How many children, and ended branches, of each node.
    pub width: usize,
    /// How many children of the uppermost node to pass over.
    pub skip: usize,
    /// Whether to find out about the branches that ended.
    pub ended: bool,
}

/// The most nodes of one answer.
const NODES: usize = 1000;

impl TreeNode {
    /// A node with what is below it, to an extent, and of no more than 1000 nodes in all.
    pub fn of(abduction: &Abduction, node: &Node, extent: TreeExtent) -> TreeNode {
        TreeNode::within(abduction, node, extent, &mut { NODES })
    }

    fn within(abduction: &Abduction, node: &Node, extent: TreeExtent, room: &mut usize) -> TreeNode {
        let below = children(abduction, node);
        let open = extent.depth > 0 && *room > 0;
        let inner = TreeExtent { depth: extent.depth.saturating_sub(1), skip: 0, ..extent };
        let shown: Vec<Node> = below.iter().skip(extent.skip).take(extent.width).copied().collect();
        if open {
            *room = room.saturating_sub(shown.len());
        }
        TreeNode {
            observation: node.observation,
            place: node.assignment.place.index(),
            rotation: node.assignment.rotation,
            candidate: node.first,
            leaves: node.leaves,
            branches: below.len(),
            children: open
                .then(|| shown.iter().map(|child| TreeNode::within(abduction, child, inner, room)).collect()),
            ended: (open && extent.ended).then(|| EndedBranches::of(abduction, node, extent.width)),
        }
    }
}

impl EndedBranches {
    fn of(abduction: &Abduction, node: &Node, width: usize) -> EndedBranches {
        let all = ended(abduction, node);
        EndedBranches { count: all.len(), branches: all.iter().take(width).map(EndedBranch::of).collect() }
    }
}
