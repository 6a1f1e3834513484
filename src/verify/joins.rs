//! Groups of things that hang together from one row to the next.

/// Groups by number, to be joined while a row passes. Numbers do not outlive the row, so none grows without bound.
#[derive(Debug)]
pub(super) struct Joins<G> {
    /// `None` where the group has been joined to another.
    groups: Vec<Option<G>>,
    /// Of each group the one it has been joined to, perhaps itself.
    joined: Vec<usize>,
}

impl<G> Joins<G> {
    /// The groups of the row above, by their numbers.
    pub(super) fn new(groups: Vec<G>) -> Joins<G> {
        let joined = (0..groups.len()).collect();
        Joins { groups: groups.into_iter().map(Some).collect(), joined }
    }

    /// A new group's number.
    pub(super) fn add(&mut self, group: G) -> usize {
        self.groups.push(Some(group));
        self.joined.push(self.joined.len());
        self.joined.len() - 1
    }

    fn root(&mut self, mut group: usize) -> usize {
        while self.joined[group] != group {
            self.joined[group] = self.joined[self.joined[group]];
            group = self.joined[group];
        }
        group
    }

    /// The group that a number stands for by now.
    pub(super) fn group(&mut self, group: usize) -> &mut G {
        let root = self.root(group);
        self.groups[root].as_mut().expect("a root has a group")
    }

    /// Makes one group of two, perhaps of one, the second taken in by the first.
    pub(super) fn join(&mut self, into: usize, taken: usize, absorb: impl FnOnce(&mut G, G)) {
        let (into, taken) = (self.root(into), self.root(taken));
        if into != taken {
            self.joined[taken] = into;
            let group = self.groups[taken].take().expect("a root has a group");
            absorb(self.groups[into].as_mut().expect("a root has a group"), group);
        }
    }

    /// Ends the row, whose members' numbers become those of the groups that go on: these, and those that have no member.
    pub(super) fn end<'n>(mut self, members: impl Iterator<Item = &'n mut usize>) -> (Vec<G>, Vec<G>) {
        let mut renamed = vec![0; self.groups.len()];
        let mut going_on = Vec::new();
        for member in members {
            let root = self.root(*member);
            if let Some(group) = self.groups[root].take() {
                renamed[root] = going_on.len();
                going_on.push(group);
            }
            *member = renamed[root];
        }
        (going_on, self.groups.into_iter().flatten().collect())
    }
}
