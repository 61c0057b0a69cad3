"""The graded gmsh mesh: layers towards the surface, columns towards the contact and stick edges.

Lengths are in contact half-widths ``a``; the depth is the mesh depth ``s`` of ``forms.depth_map``. The mesh is a
tensor product of quadrilaterals, because on symmetric columns the nodal contact forces are more accurate
(by an order of magnitude, measured) than on triangles of the same number of unknowns.
"""

from collections.abc import Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

import gmsh
import numpy as np
from dolfinx.graph import adjacencylist
from dolfinx.io import gmshio

from forms.depth_map import DepthMap

from .parallel import on_root

SURFACE, FAR, SYMMETRY, BODY = 1, 2, 3, 4  # physical groups
PLACED_APART = 1.4  # facets between edges that can both be placed: nearer ones stretch those between them too much
STOP_GROWTH = 1.8  # of columns beside a stop: its facets are few
STRIP = 1.25  # half-width, over that of the contact, of the strip where contact is looked for
MIRRORED = 1e-11  # over the extent of the domain: columns this symmetric are meant to be


@dataclass(frozen=True)
class Grading:
    """Cell sizes of the mesh, all relative to the contact half-width ``a``.

    edges: positions where pressure or traction end like a root, graded down to ``edge_facet``; sweeps: intervals
    (from, to, facet length) over which such an edge moves, or places (x, x, facet length) where it stops;
    facet: largest facet under the indenter; growth, layer_growth: ratio of neighbouring columns, layers;
    first_layer: height of the surface cells, less for k > 0; extent: half-width and depth of the domain; edge_at: where
    in its facet an edge or a stop lies, from 0 at the inner end to 1; -1: anywhere; unknown: why edges were not found.
    """

    edges: tuple[float, ...]
    facet: float = 0.025
    edge_facet: float = 1e-3
    growth: float = 1.3
    first_layer: float = 1e-3
    layer_growth: float = 1.3
    extent: float = 20.0
    sweeps: tuple[tuple[float, float, float], ...] = ()
    edge_at: float = -1.0
    unknown: str = ""

    @property
    def strip(self) -> float:
        """Contact is looked for on |x| < strip; beyond, the columns may grow without limit."""
        return STRIP * max(map(abs, self.edges))

    @property
    def stops(self) -> tuple[float, ...]:
        """Places where a moving edge stops."""
        return tuple(left for left, right, _ in self.sweeps if left == right)

    def facet_size(self, x):
        """Wanted facet length at ``x``."""
        slope = np.log(self.growth)
        to_edge = np.min([np.abs(x - edge) for edge in self.edges], axis=0)
        outside = np.maximum(np.abs(x) - self.strip, 0.0)
        sizes = [self.edge_facet + slope * to_edge, self.facet + slope * outside]
        stops = np.array([(left, size) for left, right, size in self.sweeps if left == right])
        for left, right, size in self.sweeps:
            if left < right:
                sizes.append(size + slope * np.maximum(np.maximum(left - x, x - right), 0.0))
        if len(stops):
            places, least = stops[np.argsort(stops[:, 0])].T
            sizes.append(_least(x, places, least, np.log(max(self.growth, STOP_GROWTH))))
        return np.min(sizes, axis=0)


def _least(x, places, sizes, slope):
    """Least of size + slope |x - place| at x, of any shape; the places (n,) increase."""
    from_left = np.minimum.accumulate(sizes - slope * places)
    from_right = np.minimum.accumulate((sizes + slope * places)[::-1])[::-1]
    before = np.searchsorted(places, x)
    left, right = np.append(np.inf, from_left)[before], np.append(from_right, np.inf)[before]
    return np.minimum(left + slope * x, right - slope * x)


def columns(grading: Grading) -> np.ndarray:
    """Abscissae (n,) of the columns, from -extent to extent, spaced as ``facet_size`` wants.

    Nodes equidistribute 1/facet_size, an even number of columns. Symmetric edges give a mesh symmetric to the last
    digit: slender cells beside the axis need that. Without ``edge_at`` no node is placed beside an edge on purpose.
    """
    extent = grading.extent
    clouds = [np.linspace(-extent, extent, 4001), 2 * np.linspace(-grading.strip, grading.strip, 4001)]
    offsets = np.geomspace(1e-2 * grading.edge_facet, 2 * extent, 4000)
    clouds += [edge + sign * offsets for edge in set(grading.edges) for sign in (-1, 1)]
    offsets = np.geomspace(1e-2 * grading.edge_facet, grading.facet / np.log(STOP_GROWTH), 500)
    clouds += [stop + sign * offsets for stop in set(grading.stops) for sign in (-1, 1)]
    clouds += [np.linspace(left, right, 1001) for left, right, _ in grading.sweeps]
    x = np.unique(np.concatenate(clouds))
    x = x[np.abs(x) <= extent]
    cells = np.diff(x) / grading.facet_size((x[1:] + x[:-1]) / 2)
    count = np.concatenate([[0.0], np.cumsum(cells)])
    even = 2 * int(np.ceil(count[-1] / 2))
    number = np.linspace(0.0, count[-1], even + 1)
    if grading.edge_at >= 0.0:
        facets = np.interp((*grading.edges, *grading.stops), x, count) * (even / count[-1])
        number = _placed(facets, len(grading.edges), grading.edge_at, even) * (count[-1] / even)
    found = np.interp(number, count, x)
    mirrored = (found - found[::-1]) / 2
    return mirrored if np.abs(found - mirrored).max() <= MIRRORED * extent else found


def _placed(edges, first: int, at: float, columns: int) -> np.ndarray:
    """Numbers (columns + 1,) from 0 to ``columns``, stretched so that ``edges`` lie ``at`` between two of them, counted
    outwards; edges within PLACED_APART of others stay where they are, those after the ``first`` ones for these.
    """
    middle = columns / 2
    kept = [(0.0, 0.0), (middle, middle), (float(columns), float(columns))]  # number of a node, and what becomes of it
    outer_first = [sorted(part, key=lambda edge: -abs(edge - middle)) for part in (edges[:first], edges[first:])]
    for edge in sum(outer_first, []):
        side = np.sign(edge - middle)
        place = middle + side * (np.round(abs(edge - middle) - at) + at)
        if all(min(abs(place - a), abs(edge - b)) > PLACED_APART for a, b in kept):
            kept.append((place, edge))
    before, after = np.array(sorted(kept)).T
    return np.interp(np.arange(columns + 1.0), before, after)


def layers(grading: Grading, depth: DepthMap, kink_depths: Sequence[float] = ()) -> np.ndarray:
    """Mesh depths (n,) of the layers, from the surface to ``extent``, one at each of the ``kink_depths`` of E(y).

    For k <= 0 they grow from ``first_layer`` by ``layer_growth``: y_i = r (growth^i - 1). In a mesh depth s = y^(1/m)
    the field varies on the scale (r + y)^(1/m): s_i = r^(1/m) (growth^(i/m) - 1). All are scaled to end at ``extent``.
    """
    start = depth.s(grading.first_layer / (grading.layer_growth - 1))
    growth = grading.layer_growth ** (1 / depth.m)
    bottom = depth.s(grading.extent)
    n = int(np.ceil(np.log1p(bottom / start) / np.log(growth)))
    s = np.expm1(np.arange(n + 1) * np.log(growth))
    s *= bottom / s[-1]
    placed: list[float] = []
    for at in (depth.s(kink) for kink in kink_depths if kink < grading.extent):
        nearest = 1 + np.argmin(np.abs(s[1:-1] - at))
        if s[nearest] in placed:
            s = np.sort(np.append(s, at))
        else:
            s[nearest] = at
        placed.append(at)
    return s


def create_mesh(comm, x: np.ndarray, s: np.ndarray):
    """Distributed mesh of [x0, x1] x [0, s1] and its facet tags SURFACE (s = 0), FAR (the rest).

    Where x starts at 0 the left side is tagged SYMMETRY instead of FAR. Ranks own columns from left to right, as many
    each: of two ranks on symmetric columns each has one half of the body.
    """
    with ExitStack() as stack:
        on_root(comm, lambda: _build(stack, x, s))
        mesh, _, facets = gmshio.model_to_mesh(gmsh.model, comm, 0, gdim=2, partitioner=_by_columns(comm, x))
    # gmsh places nodes to round-off of the domain. Slender cells beside the axis, whose halves are alike, need more.
    for direction, exact in enumerate((x, s)):
        between = (exact[1:] + exact[:-1]) / 2
        mesh.geometry.x[:, direction] = exact[np.searchsorted(between, mesh.geometry.x[:, direction])]
    return mesh, facets


def _build(stack, x, s):
    """Mesh the domain as the current gmsh model, which goes when ``stack`` ends."""
    # Relative to the domain: with gmsh's own 1e-8 thin cells would be merged.
    tolerance = 1e-3 * min(np.diff(x).min(), np.diff(s).min()) / max(np.ptp(x), s[-1])
    options = {"General.Terminal": 0, "Geometry.Tolerance": tolerance}
    plain = {"Mesh.ElementOrder": 1, "Mesh.SubdivisionAlgorithm": 0}  # whatever a caller's session has
    stack.enter_context(_own_model(options | plain))
    corner = gmsh.model.geo.addPoint(x[0], 0.0, 0.0)
    (_, (_, surface)) = gmsh.model.geo.extrude([(0, corner)], x[-1] - x[0], 0, 0, *_cells(x))
    swept = gmsh.model.geo.extrude([(1, surface)], 0, s[-1], 0, *_cells(s), recombine=True)
    gmsh.model.geo.synchronize()
    (_, bottom), (_, body), *sides = swept
    groups = {SURFACE: [surface], FAR: [bottom], SYMMETRY: []}
    for _, side in sides:
        on_axis = x[0] == 0.0 and gmsh.model.getBoundingBox(1, abs(side))[0] == 0.0
        groups[SYMMETRY if on_axis else FAR].append(side)
    for group, tags in groups.items():
        if tags:
            gmsh.model.addPhysicalGroup(1, [abs(tag) for tag in tags], group)
    gmsh.model.addPhysicalGroup(2, [body], BODY)
    gmsh.model.mesh.generate(2)


@contextmanager
def _own_model(options):
    """A new gmsh model and numerical options for it. A caller's own session gets its model and options back."""
    was_open = gmsh.isInitialized()
    if not was_open:
        gmsh.initialize(interruptible=False)
    current, kept = gmsh.model.getCurrent(), {name: gmsh.option.getNumber(name) for name in options}
    gmsh.model.add("half-plane")
    try:
        for name, value in options.items():
            gmsh.option.setNumber(name, value)
        yield
    finally:
        if was_open:
            gmsh.model.remove()
            gmsh.model.setCurrent(current)
            for name, value in kept.items():
                gmsh.option.setNumber(name, value)
        else:
            gmsh.finalize()


def _by_columns(comm, x):
    """Partitioner that deals out columns of cells; None on one rank."""
    if comm.size == 1:
        return None
    nodes = gmshio.extract_geometry(gmsh.model)[:, 0] if comm.rank == 0 else np.empty(0)

    def destinations(_comm, parts, _types, cells):
        middle = nodes[np.asarray(cells[0]).reshape(-1, 4)].mean(axis=1)
        column = np.searchsorted(x, middle) - 1
        return adjacencylist((column * parts // (len(x) - 1)).astype(np.int32))

    return destinations


def _cells(nodes):
    """gmsh's description of one cell between each two of ``nodes``: counts and relative ends."""
    return [1] * (len(nodes) - 1), list((nodes[1:] - nodes[0]) / (nodes[-1] - nodes[0]))
