//! The tree that is walked: nodes of eight boxes, leaves of one block.

use super::BuildError;

/// Set in a child code that names a leaf block; the rest is the block's index.
pub(super) const LEAF: u32 = 1 << 31;

/// Child code of an empty slot. Its box is empty, so it is never followed.
const EMPTY: u32 = u32::MAX;

/// Entries of the traversal stack. A walk that goes to one child keeps at most
/// seven others, so 36 levels always fit; `WideTree::new` checks the actual need.
/// A power of two, so that an index can be masked instead of tested.
pub(super) const STACK_ENTRIES: usize = 256;

/// Eight child boxes, side by side per plane. 256 bytes: four cache lines.
#[repr(C, align(64))]
#[derive(Clone, Copy)]
pub(super) struct Node8 {
    /// `planes[axis][0]` the lower, `planes[axis][1]` the upper bounds.
    pub(super) planes: [[[f32; 8]; 2]; 3],
    /// Index of a node, or `LEAF |` index of a block.
    pub(super) child: [u32; 8],
    _pad: [u32; 8],
}

impl Node8 {
    /// A node without children.
    pub(super) const NONE: Self = Self {
        planes: [[[f32::INFINITY; 8], [f32::NEG_INFINITY; 8]]; 3],
        child: [EMPTY; 8],
        _pad: [0; 8],
    };

    /// Fills one slot.
    pub(super) fn set(&mut self, slot: usize, lo: [f32; 3], hi: [f32; 3], child: u32) {
        for axis in 0..3 {
            self.planes[axis][0][slot] = lo[axis];
            self.planes[axis][1][slot] = hi[axis];
        }
        self.child[slot] = child;
    }

    /// Child codes of the slots in use.
    pub(super) fn children(&self) -> impl Iterator<Item = u32> + '_ {
        self.child.iter().copied().filter(|&c| c != EMPTY)
    }
}

/// A tree whose walks are known to fit the stack. Node 0 is the root; children
/// stand behind their parents.
pub(super) struct WideTree {
    nodes: Vec<Node8>,
}

impl WideTree {
    /// Takes nodes in which every child stands behind its parent.
    ///
    /// # Errors
    /// `TooDeep` if a walk could need more than `STACK_ENTRIES`.
    pub(super) fn new(mut nodes: Vec<Node8>) -> Result<Self, BuildError> {
        if nodes.is_empty() {
            nodes.push(Node8::NONE);
        }
        let entries = stack_need(&nodes);
        // One spare: the sorting push writes all children of a node, also the
        // one that is followed.
        if entries >= STACK_ENTRIES {
            return Err(BuildError::TooDeep {
                entries,
                limit: STACK_ENTRIES,
            });
        }
        Ok(Self { nodes })
    }

    /// All nodes, the root first.
    #[inline(always)]
    pub(super) fn nodes(&self) -> &[Node8] {
        &self.nodes
    }
}

/// The most entries that wait on the stack, in the worst order of children.
fn stack_need(nodes: &[Node8]) -> usize {
    let mut need = vec![0_usize; nodes.len()];
    for index in (0..nodes.len()).rev() {
        let mut count = 0;
        let mut deepest = 0;
        for child in nodes[index].children() {
            count += 1;
            if child & LEAF == 0 {
                deepest = deepest.max(need.get(child as usize).copied().unwrap_or(0));
            }
        }
        need[index] = deepest + count;
    }
    need.first().copied().unwrap_or(0)
}
