//! Sets of rotations of a star.

/// A set of rotations, one bit each. Stars of more than 64 slots have no such sets: see [`Walk::tracked`](super::walk::Walk::tracked).
pub(super) type Rotations = u64;

/// A slot or rotation below twice `size`, modulo `size`.
pub(super) fn wrapped(slot: usize, size: usize) -> usize {
    if slot < size { slot } else { slot - size }
}

/// Every rotation of a set further on by some slots of `size`, at most 64, and by no more than `size`.
pub(super) fn turned(set: Rotations, by: usize, size: usize) -> Rotations {
    let by = wrapped(by, size);
    let all = Rotations::MAX >> (Rotations::BITS as usize - size);
    if by == 0 { set } else { (set << by | set >> (size - by)) & all }
}

/// Every rotation of a set the other way round.
pub(super) fn reversed(set: Rotations, size: usize) -> Rotations {
    members(set).fold(0, |reversed, rotation| reversed | 1 << wrapped(size - rotation, size))
}

/// The rotations of a set, ascending.
pub(super) fn members(mut set: Rotations) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let first = (set != 0).then(|| set.trailing_zeros() as usize)?;
        set &= set - 1;
        Some(first)
    })
}
