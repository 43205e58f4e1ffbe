// SPDX-License-Identifier: MIT OR Apache-2.0
use super::mesh::TetraMesh;
use crate::Error;

/// What a support does to one displacement component of its nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Hold {
    /// Nothing.
    Free,
    /// Each node is held at a given displacement.
    Prescribed,
    /// All nodes share one unknown displacement, which has its own force equation.
    Guided,
}

/// A set of nodes that is held somehow.
#[derive(Clone, Debug, PartialEq)]
pub struct Support {
    /// For messages and reports.
    pub name: String,
    /// Node numbers.
    pub nodes: Vec<usize>,
    /// For x, y and z.
    pub hold: [Hold; 3],
}

/// Where one displacement component of one node comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Source {
    /// An unknown of its own.
    Unknown(usize),
    /// The value of a case.
    Prescribed(usize),
    /// Zero: pinned so that a free rigid motion does not make the stiffness singular.
    Pinned,
}

/// One component of one support: a displacement that can be prescribed, or one that is guided and can
/// be loaded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Case {
    pub(super) support: usize,
    pub(super) component: usize,
    /// The shared unknown of a guided component, `None` for a prescribed one.
    pub(super) unknown: Option<usize>,
}

/// Names of the displacement components.
pub(super) const AXES: [char; 3] = ['x', 'y', 'z'];

/// The unknowns of a supported body, in their order of elimination; guided ones last.
#[derive(Clone, Debug)]
pub(super) struct Unknowns {
    /// For each node and component.
    pub(super) source: Vec<[Source; 3]>,
    /// Number of unknowns, guided ones included.
    pub(super) n: usize,
    pub(super) n_guided: usize,
    pub(super) cases: Vec<Case>,
}

/// Who holds each component of each node: an index into the cases, `None` where it is free.
#[derive(Clone, Debug)]
pub(super) struct Claims {
    pub(super) claim: Vec<[Option<usize>; 3]>,
    pub(super) cases: Vec<Case>,
}

impl Claims {
    /// Cases of all supports, in the order of `supports` and x, y, z within one.
    pub(super) fn new(mesh: &TetraMesh, supports: &[Support]) -> Result<Self, Error> {
        let n_nodes = mesh.nodes().len();
        let mut claim = vec![[None; 3]; n_nodes];
        let mut cases: Vec<Case> = Vec::new();
        for (number, support) in supports.iter().enumerate() {
            for component in 0..3 {
                if support.hold[component] == Hold::Free {
                    continue;
                }
                let guided = support.hold[component] == Hold::Guided;
                let case = cases.len();
                cases.push(Case {
                    support: number,
                    component,
                    unknown: guided.then_some(0),
                });
                for (index, &node) in support.nodes.iter().enumerate() {
                    if node >= n_nodes {
                        return Err(Error::Index {
                            name: "support node",
                            index,
                            what: "node",
                            value: node,
                            count: n_nodes,
                        });
                    }
                    let Some(other) = claim[node][component] else {
                        claim[node][component] = Some(case);
                        continue;
                    };
                    // two supports may prescribe the same component: the first one leads
                    if other != case && (guided || cases[other].unknown.is_some()) {
                        return Err(Error::Contradiction {
                            first: supports[cases[other].support].name.clone(),
                            second: support.name.clone(),
                            component: AXES[component],
                            node,
                        });
                    }
                }
            }
        }
        Ok(Claims { claim, cases })
    }

    /// Nodes with an unknown of their own.
    pub(super) fn active(&self) -> Vec<bool> {
        self.claim
            .iter()
            .map(|c| c.iter().any(Option::is_none))
            .collect()
    }

    /// Numbers the unknowns along `order`; components in `pins` are held at zero as well.
    pub(super) fn number(&self, order: &[usize], pins: &[(usize, usize)]) -> Unknowns {
        let mut source = vec![[Source::Pinned; 3]; self.claim.len()];
        let mut n = 0;
        for &node in order {
            for component in 0..3 {
                if self.claim[node][component].is_none() && !pins.contains(&(node, component)) {
                    source[node][component] = Source::Unknown(n);
                    n += 1;
                }
            }
        }
        let mut cases = self.cases.clone();
        let n_own = n;
        for case in &mut cases {
            if case.unknown.is_some() {
                case.unknown = Some(n);
                n += 1;
            }
        }
        for (node, claims) in self.claim.iter().enumerate() {
            for component in 0..3 {
                if let Some(case) = claims[component] {
                    source[node][component] = match cases[case].unknown {
                        Some(unknown) => Source::Unknown(unknown),
                        None => Source::Prescribed(case),
                    };
                }
            }
        }
        Unknowns {
            source,
            n,
            n_guided: n - n_own,
            cases,
        }
    }
}
