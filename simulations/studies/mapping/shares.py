"""Many loops on several ranks: each rank works through its own share, none waits for another."""

from collections.abc import Callable

from analytic.half_plane.linear import ContactNotConverged

from ...fem.parallel import on_root
from .points import Energies, Point, by_simulation
from .store import Store


def simulate_all(comm, store: Store, points: list[Point], tell: Callable[[str], None]) -> dict[Point, Energies | str]:
    """Results of all points on every rank. Loops already in the store are not run again; ``tell`` reports progress.

    A loop that does not converge has the reason in place of its result.
    """
    kept = on_root(comm, store.read)
    missing = [point for point in points if point not in kept]
    tell(f"{len(points)} loops, {len(points) - len(missing)} of them kept from before, {comm.size} rank(s)")
    # neighbours cost about the same: dealing them out in turn gives everyone the same work
    mine = missing[comm.rank :: comm.size]
    done = {}
    for number, point in enumerate(mine, start=1):
        try:
            done[point] = by_simulation(point)
        except ContactNotConverged as failure:
            done[point] = str(failure)  # not kept: another run tries again
        else:
            store.keep(point, done[point])
        if number % 10 == 0 or number == len(mine):
            tell(f"{number}/{len(mine)} loops of rank {comm.rank} done")
    for part in comm.allgather(done):
        kept |= part
    return {point: kept[point] for point in points}
