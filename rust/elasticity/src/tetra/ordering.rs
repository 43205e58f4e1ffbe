// SPDX-License-Identifier: MIT OR Apache-2.0
use feral_metis::{CscPattern, MetisOptions, metis_order_full};

/// Undirected graph without loops, neighbours of vertex `v` in `neighbours[start[v]..start[v + 1]]`,
/// sorted.
pub(super) struct Graph {
    pub(super) start: Vec<usize>,
    pub(super) neighbours: Vec<usize>,
}

impl Graph {
    /// Vertices sharing one of the `groups`.
    pub(super) fn of_groups<'a>(
        n: usize,
        groups: impl Iterator<Item = &'a [usize]> + Clone,
    ) -> Graph {
        let mut start = vec![0; n + 1];
        for group in groups.clone() {
            for &a in group {
                start[a + 1] += group.len() - 1;
            }
        }
        for v in 0..n {
            start[v + 1] += start[v];
        }
        let mut cursor = start.clone();
        let mut raw = vec![usize::MAX; start[n]];
        for group in groups {
            for &a in group {
                for &b in group.iter().filter(|&&b| b != a) {
                    raw[cursor[a]] = b;
                    cursor[a] += 1;
                }
            }
        }
        let mut neighbours = Vec::new();
        let mut packed = vec![0; n + 1];
        for v in 0..n {
            let row = &mut raw[start[v]..cursor[v]];
            row.sort_unstable();
            let before = neighbours.len();
            for &b in row.iter() {
                if neighbours.len() == before || neighbours.last() != Some(&b) {
                    neighbours.push(b);
                }
            }
            packed[v + 1] = neighbours.len();
        }
        Graph {
            start: packed,
            neighbours,
        }
    }

    pub(super) fn len(&self) -> usize {
        self.start.len() - 1
    }

    pub(super) fn of(&self, v: usize) -> &[usize] {
        &self.neighbours[self.start[v]..self.start[v + 1]]
    }
}

/// Order of elimination of the `active` vertices: nested dissection.
///
/// Dissecting the corners only and attaching the middles of edges to them is quicker by a few tenths
/// of a second, which the 8 to 14 % more operations of the factorisation then eat up.
pub(super) fn nested_dissection(graph: &Graph, active: &[bool]) -> Vec<usize> {
    let kept: Vec<usize> = (0..graph.len()).filter(|&v| active[v]).collect();
    let mut number = vec![usize::MAX; graph.len()];
    for (k, &v) in kept.iter().enumerate() {
        number[v] = k;
    }
    let mut start = vec![0];
    let mut neighbours = Vec::with_capacity(graph.neighbours.len());
    for &v in &kept {
        let others = graph.of(v).iter().map(|&w| number[w]);
        neighbours.extend(others.filter(|&w| w != usize::MAX));
        start.push(neighbours.len());
    }
    let order = dissect(&Graph { start, neighbours });
    order.into_iter().map(|k| kept[k]).collect()
}

/// Elimination order of a graph, first vertex first.
pub(super) fn dissect(graph: &Graph) -> Vec<usize> {
    let start: Vec<i32> = graph.start.iter().map(|&s| s as i32).collect();
    let neighbours: Vec<i32> = graph.neighbours.iter().map(|&v| v as i32).collect();
    CscPattern::new(graph.len(), &start, &neighbours)
        .and_then(|pattern| metis_order_full(&pattern, &MetisOptions::default()).ok())
        .map_or_else(
            || (0..graph.len()).collect(),
            |(order, _, _)| order.into_iter().map(|v| v as usize).collect(),
        )
}

/// Rank of each vertex in the order (`usize::MAX` if it is not eliminated), and the parent of each rank in the
/// elimination tree, by path compression [GeorgeLiu1981].
fn elimination_tree(graph: &Graph, order: &[usize]) -> (Vec<usize>, Vec<usize>) {
    let n = order.len();
    let mut rank = vec![usize::MAX; graph.len()];
    for (k, &v) in order.iter().enumerate() {
        rank[v] = k;
    }
    let mut parent = vec![usize::MAX; n];
    let mut ancestor = vec![usize::MAX; n];
    for k in 0..n {
        for &w in graph.of(order[k]) {
            let mut i = rank[w];
            if i >= k {
                continue; // later, or not eliminated (usize::MAX)
            }
            while ancestor[i] != usize::MAX && ancestor[i] != k {
                let next = ancestor[i];
                ancestor[i] = k;
                i = next;
            }
            if ancestor[i] == usize::MAX {
                ancestor[i] = k;
                parent[i] = k;
            }
        }
    }
    (rank, parent)
}

/// Operations of the elimination, in cubes of the unknowns of a vertex: the squares of the lengths of all columns.
pub(super) fn operations(graph: &Graph, order: &[usize]) -> f64 {
    let (rank, parent) = elimination_tree(graph, order);
    let n = order.len();
    let mut length = vec![1.0_f64; n];
    let mut seen = vec![usize::MAX; n];
    for k in 0..n {
        seen[k] = k;
        for &w in graph.of(order[k]) {
            let mut i = rank[w];
            // row k of the factor is a part of the tree, from its neighbours up to k
            while i < k && seen[i] != k {
                seen[i] = k;
                length[i] += 1.0;
                i = parent[i];
            }
        }
    }
    length.iter().map(|l| l * l).sum()
}

/// The same elimination with its tree in postorder: children before their parent, subtrees together.
///
/// `graph` over all vertices; `order` lists those that are eliminated. Supernodes form only between
/// neighbours in the order, so this must precede the symbolic factorisation.
pub(super) fn postordered(graph: &Graph, order: &[usize]) -> Vec<usize> {
    let n = order.len();
    let (_, parent) = elimination_tree(graph, order);
    let mut first_child = vec![usize::MAX; n];
    let mut sibling = vec![usize::MAX; n];
    for k in (0..n).rev() {
        if parent[k] != usize::MAX {
            sibling[k] = first_child[parent[k]];
            first_child[parent[k]] = k;
        }
    }
    let mut result = Vec::with_capacity(n);
    let mut stack = Vec::new();
    for tree in (0..n).filter(|&k| parent[k] == usize::MAX) {
        stack.push(tree);
        while let Some(&k) = stack.last() {
            if first_child[k] == usize::MAX {
                stack.pop();
                result.push(order[k]);
            } else {
                stack.push(first_child[k]);
                first_child[k] = sibling[first_child[k]];
            }
        }
    }
    result
}
