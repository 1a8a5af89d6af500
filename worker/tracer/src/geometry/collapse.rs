//! From a binary tree to eight-wide nodes and leaf blocks of least expected cost
//! (Ylitie, Karras, Laine 2017, "Efficient incoherent ray traversal on GPUs
//! through compressed wide BVHs", section 3.2, equations 3 to 5).
//!
//! `cost(n, i)` is the least cost of the subtree of `n` held by at most `i` slots
//! of a wide node. A node test and a block test cost the same: one vector test.

use obvhs::bvh2::node::Bvh2Node;

use super::sah::BinaryTree;
use super::wide::{LEAF, Node8};

/// A slot budget is 1 to 7; eight are distributed over two children.
const BUDGETS: usize = 7;

/// Per binary node: the table row and how it came about.
#[derive(Clone, Copy)]
struct Row {
    cost: [f32; BUDGETS],
    /// Slots for the left child at budget `i + 1`; 0: same as budget `i`.
    left: [u8; BUDGETS],
    /// Slots for the left child when this node becomes a wide node.
    left_of_eight: u8,
    /// The subtree is one block.
    is_leaf: bool,
    /// Boxes below.
    count: u32,
}

/// The wide nodes, and the box numbers of each block.
pub(super) struct Collapsed {
    pub(super) nodes: Vec<Node8>,
    /// Block `b` holds `items[starts[b]..starts[b + 1]]`.
    pub(super) items: Vec<u32>,
    pub(super) starts: Vec<u32>,
}

impl Collapsed {
    /// Box numbers, block by block.
    pub(super) fn blocks(&self) -> impl Iterator<Item = &[u32]> {
        self.starts
            .windows(2)
            .map(|w| &self.items[w[0] as usize..w[1] as usize])
    }
}

/// Collapses `tree` into nodes with at most `block_size` boxes to a leaf.
pub(super) fn collapse(tree: &BinaryTree, block_size: u32, block_cost: f32) -> Collapsed {
    let rows = fill_table(&tree.nodes, block_size, block_cost);
    let mut out = Collapsed {
        nodes: vec![Node8::NONE],
        items: Vec::with_capacity(tree.order.len()),
        starts: vec![0],
    };
    if tree.nodes.is_empty() {
        return out;
    }
    let mut tasks = Vec::new();
    if rows[0].is_leaf {
        let leaf = push_block(tree, 0, &mut out);
        set_slot(&mut out.nodes[0], 0, &tree.nodes[0], leaf);
    } else {
        tasks.push((0_u32, 0_u32));
    }
    // Wide node `wide` stands for binary node `root`.
    while let Some((root, wide)) = tasks.pop() {
        let mut children = [0; 8];
        let count = gather(&tree.nodes, &rows, root, &mut children);
        likely_blockers_first(&mut children[..count], &tree.nodes, &rows);
        for (slot, &child) in children[..count].iter().enumerate() {
            let code = if rows[child as usize].is_leaf {
                push_block(tree, child, &mut out)
            } else {
                out.nodes.push(Node8::NONE);
                let index = out.nodes.len() as u32 - 1;
                tasks.push((child, index));
                index
            };
            set_slot(
                &mut out.nodes[wide as usize],
                slot,
                &tree.nodes[child as usize],
                code,
            );
        }
    }
    out
}

/// A shadow ray goes to the first slot it enters: leaves first, which may end it at
/// once, then the largest boxes. Closest hits do not care.
fn likely_blockers_first(children: &mut [u32], nodes: &[Bvh2Node], rows: &[Row]) {
    let area = |child: u32| nodes[child as usize].aabb().half_area();
    children.sort_by(|&a, &b| {
        let leaf = |child: u32| rows[child as usize].is_leaf;
        leaf(b).cmp(&leaf(a)).then(area(b).total_cmp(&area(a)))
    });
}

fn set_slot(node: &mut Node8, slot: usize, source: &Bvh2Node, code: u32) {
    node.set(
        slot,
        source.aabb().min.to_array(),
        source.aabb().max.to_array(),
        code,
    );
}

/// Children stand behind their parents, so a backward sweep is bottom-up.
fn fill_table(nodes: &[Bvh2Node], block_size: u32, block_cost: f32) -> Vec<Row> {
    let empty = Row {
        cost: [0.0; BUDGETS],
        left: [0; BUDGETS],
        left_of_eight: 0,
        is_leaf: true,
        count: 1,
    };
    let mut rows = vec![empty; nodes.len()];
    for index in (0..nodes.len()).rev() {
        let node = &nodes[index];
        let area = node.aabb().half_area();
        rows[index] = if node.is_leaf() {
            Row {
                cost: [area * block_cost; BUDGETS],
                ..empty
            }
        } else {
            let first = node.first_index as usize;
            inner_row(&rows[first], &rows[first + 1], area, block_size, block_cost)
        };
    }
    rows
}

fn inner_row(l: &Row, r: &Row, area: f32, block_size: u32, block_cost: f32) -> Row {
    let count = l.count + r.count;
    let (spread, left_of_eight) = distribute(l, r, 8);
    let inner = spread + area;
    let leaf = if count <= block_size {
        area * block_cost
    } else {
        f32::INFINITY
    };
    let is_leaf = count <= block_size && leaf <= inner;
    let mut row = Row {
        cost: [0.0; BUDGETS],
        left: [0; BUDGETS],
        left_of_eight,
        is_leaf,
        count,
    };
    row.cost[0] = if is_leaf { leaf } else { inner };
    for budget in 2..=BUDGETS {
        let (cost, left) = distribute(l, r, budget);
        if cost < row.cost[budget - 2] {
            row.cost[budget - 1] = cost;
            row.left[budget - 1] = left;
        } else {
            row.cost[budget - 1] = row.cost[budget - 2];
        }
    }
    row
}

/// The cheapest way to give `budget` slots to two subtrees, and the left share.
fn distribute(l: &Row, r: &Row, budget: usize) -> (f32, u8) {
    let mut best = (f32::INFINITY, 1);
    for left in 1..budget {
        let cost = l.cost[left - 1] + r.cost[budget - left - 1];
        if cost < best.0 {
            best = (cost, left as u8);
        }
    }
    best
}

/// The roots that fill the slots of the wide node for `root`, left to right.
fn gather(nodes: &[Bvh2Node], rows: &[Row], root: u32, children: &mut [u32; 8]) -> usize {
    let mut count = 0;
    let first = nodes[root as usize].first_index;
    let left = rows[root as usize].left_of_eight;
    // At most 7 splits wait at once, since every split adds a slot.
    let mut pending = vec![(first + 1, 8 - left), (first, left)];
    while let Some((node, budget)) = pending.pop() {
        let row = &rows[node as usize];
        let mut budget = usize::from(budget);
        while budget > 1 && row.left[budget - 1] == 0 {
            budget -= 1;
        }
        if budget == 1 {
            children[count] = node;
            count += 1;
        } else {
            let left = row.left[budget - 1];
            let first = nodes[node as usize].first_index;
            pending.push((first + 1, budget as u8 - left));
            pending.push((first, left));
        }
    }
    count
}

/// Makes a block of all boxes under `root`; its child code.
fn push_block(tree: &BinaryTree, root: u32, out: &mut Collapsed) -> u32 {
    let mut pending = vec![root];
    while let Some(index) = pending.pop() {
        let node = &tree.nodes[index as usize];
        if node.is_leaf() {
            let first = node.first_index as usize;
            out.items
                .extend_from_slice(&tree.order[first..first + node.prim_count as usize]);
        } else {
            pending.push(node.first_index + 1);
            pending.push(node.first_index);
        }
    }
    out.starts.push(out.items.len() as u32);
    LEAF | (out.starts.len() as u32 - 2)
}
