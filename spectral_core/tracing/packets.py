"""Casting neighbouring rays in packets of eight.

A packet goes down the tree as one: an interval of origins and one of directions along each axis bound what any of its
rays may enter. Where its rays part, too many boxes are entered, and the packet is given up: its rays are cast one by
one. Rays and triangles that meet are tested as single rays are, so that the answers are the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .ray_triangles import by_ray_and_entry, edge_functions, keep_inside
from .rays import Frame, Nearest

if TYPE_CHECKING:
    from .bvh import Bvh

__all__ = ["trace_packets"]

Array = NDArray[Any]
Integers = NDArray[np.int64]

_SIZE = 8
"""Rays a packet."""

_FEWEST = 256
"""Rays from which on packets are worth while."""

_PARTED = 24
"""Boxes that a packet may have entered, and not yet opened or found to be leaves, before it is given up."""

_NODES = 4096
"""(packet, node) pairs tested in one go."""

_LEAVES = 2048
"""(packet, leaf) pairs tested in one go."""


def trace_packets(bvh: Bvh, frame: Frame, nearest: Nearest, *, stop_at_first: bool) -> Integers:
    """Cast the rays of a chunk in packets, as far as they stay together.

    Parameters
    ----------
    bvh : Bvh
        The tree.
    frame : Frame
        At most 65536 rays; neighbours are likely to go the same way.
    nearest : Nearest
        Where to write what they meet.
    stop_at_first : bool
        Whether any hit will do.

    Returns
    -------
    (m,) ndarray of int64
        Numbers of the rays that are still to be cast.

    Raises
    ------
    None.

    References
    ----------
    Packets and intervals: Wald, Slusallek, Benthin and Wagner, Computer Graphics Forum 20(3), 153-164 (2001); Boulos,
    Wald and Shirley, "Geometric and arithmetic culling methods for entire ray packets", Utah UUCS-06-010 (2006).
    """
    packets = len(frame) // _SIZE
    if len(frame) < _FEWEST:
        return np.arange(len(frame))
    # The k-th rays of all packets follow each other: what concerns a packet lies in a column.
    rays = np.ascontiguousarray(np.arange(packets * _SIZE).reshape(packets, _SIZE).T)
    packed = frame.take(rays.ravel())
    found = Nearest.before(packed.t_max)
    packet, leaf, entry, together = _find_leaves(bvh, packed, packets)
    if len(packet):
        _test_leaves(bvh, packed, found, packet, leaf, entry, stop_at_first=stop_at_first)
    for name in ("distance", "triangle", "u", "v"):
        getattr(nearest, name)[rays.ravel()] = getattr(found, name)
    return np.concatenate([rays[:, ~together].T.ravel(), np.arange(packets * _SIZE, len(frame))])


def _find_leaves(bvh: Bvh, frame: Frame, packets: int) -> tuple[Integers, Integers, Array, NDArray[np.bool_]]:
    """Walk the tree; return (packet, leaf, least entry distance) of the leaf boxes entered, and who stayed together."""
    # Rows of eight equal numbers meet a node's eight boxes, as for single rays.
    intervals = [_intervals(frame, axis, packets) for axis in range(3)]
    limit = _rows(frame.t_max.reshape(_SIZE, packets).max(axis=0))
    together = np.ones(packets, bool)
    reached = np.zeros(packets, np.int64)
    found: list[tuple[Integers, Integers, Array]] = []
    packet, node = np.arange(packets), np.zeros(packets, np.int64)
    while len(packet):
        below: list[tuple[Integers, Integers]] = []
        for k in range(0, len(packet), _NODES):
            some, of = packet[k : k + _NODES], node[k : k + _NODES]
            crossed, entry = _enter_children(frame, intervals, limit, some, of)
            pair = crossed >> 3
            child = np.take(bvh.children, (np.take(of, pair) << 3) | (crossed & 7))
            some = np.take(some, pair)
            at_leaf, inside = np.flatnonzero(child < 0), np.flatnonzero(child >= 0)
            leaves = np.take(some, at_leaf)
            reached += np.bincount(leaves, minlength=packets)
            found.append((leaves, -1 - np.take(child, at_leaf), np.take(entry, np.take(crossed, at_leaf))))
            below.append((np.take(some, inside), np.take(child, inside)))
        packet, node = (np.concatenate(column) for column in zip(*below, strict=True))
        together &= reached + np.bincount(packet, minlength=packets) <= _PARTED
        left = np.flatnonzero(np.take(together, packet))
        packet, node = np.take(packet, left), np.take(node, left)
    packet, leaf, entry = (np.concatenate(column) for column in zip(*found, strict=True))
    left = np.flatnonzero(np.take(together, packet))
    return np.take(packet, left), np.take(leaf, left), np.take(entry, left), together


def _intervals(frame: Frame, axis: int, packets: int) -> tuple[Array, Array, Array, Array]:
    """Rows of the origin that is farthest on and the one farthest back, and of the least and greatest reciprocal."""
    origin = frame.origin[axis].reshape(_SIZE, packets)
    reciprocal = frame.reciprocal[axis].reshape(_SIZE, packets)
    low, high = _rows(origin.min(axis=0)), _rows(origin.max(axis=0))
    ahead, behind = (low, high) if frame.backwards[axis] else (high, low)
    return ahead, behind, _rows(reciprocal.min(axis=0)), _rows(reciprocal.max(axis=0))


def _rows(values: Array) -> Array:
    return np.repeat(values, 8).reshape(-1, 8)


def _enter_children(
    frame: Frame, intervals: Sequence[tuple[Array, ...]], limit: Array, packet: Integers, node: Integers
) -> tuple[Integers, Array]:
    """Test packets against the eight boxes of their nodes.

    Returns the numbers 8 * pair + child of the boxes that a ray may enter, and least entry distances of all boxes.
    """
    dtype = limit.dtype
    slack = dtype.type(1.0 + 6.0 * np.finfo(dtype).eps)  # as for single rays
    enter = np.zeros((len(packet), 8), dtype)
    leave = np.full((len(packet), 8), np.inf, dtype)
    for axis in range(3):
        ahead, behind, least, most = (np.take(rows, packet, axis=0) for rows in intervals[axis])
        # The first to enter starts farthest ahead; before the plane it is the quickest, behind it the slowest.
        plane = np.take(frame.near[axis], node, axis=0)
        plane -= ahead
        other = plane * least
        plane *= most
        np.maximum(enter, np.minimum(plane, other, out=plane), out=enter)
        plane = np.take(frame.far[axis], node, axis=0)
        plane -= behind
        np.multiply(plane, least, out=other)
        plane *= most
        np.minimum(leave, np.maximum(plane, other, out=plane), out=leave)
    leave *= slack
    np.minimum(leave, np.take(limit, packet, axis=0), out=leave)
    return np.flatnonzero(enter <= leave), enter.ravel()


def _test_leaves(
    bvh: Bvh,
    frame: Frame,
    nearest: Nearest,
    packet: Integers,
    leaf: Integers,
    entry: Array,
    *,
    stop_at_first: bool,
) -> None:
    """Test packets against the leaves they enter, nearest first, until none can hold anything nearer for any ray."""
    order, entry = by_ray_and_entry(packet, entry)
    packet, leaf = np.take(packet, order), np.take(leaf, order)
    axes = (frame.across_x, frame.across_y, frame.along)
    tables = [
        values.reshape(_SIZE, -1) for values in (*(frame.origin[axis] for axis in axes), frame.shear_x, frame.shear_y)
    ]
    corners = [bvh.leaf_corners[corner + axis] for corner in (0, 3, 6) for axis in axes]
    distance = nearest.distance.reshape(_SIZE, -1)
    turn = np.flatnonzero(np.diff(packet, prepend=-1))
    end = np.append(turn[1:], len(packet))
    while len(turn):
        for k in range(0, len(turn), _LEAVES):
            block = turn[k : k + _LEAVES]
            some, of = np.take(packet, block), np.take(leaf, block)
            # Four triangles by eight rays by the packets.
            four = [np.ascontiguousarray(np.take(values, of, axis=0).T)[:, None] for values in corners]
            eight = [np.take(table, some, axis=1) for table in tables]
            inside, weights, heights = edge_functions(four, eight)
            if len(inside):
                number = inside // len(some)
                column = inside - number * len(some)
                triangle = np.take(bvh.leaf_triangles.ravel(), (np.take(of, column) << 2) | (number >> 3))
                ray = (number & 7) * distance.shape[1] + np.take(some, column)
                keep_inside(frame, nearest, ray, triangle, weights, heights)
        turn = turn + 1
        left = np.flatnonzero(turn < end)
        turn, end = np.take(turn, left), np.take(end, left)
        farthest = np.where(nearest.triangle < 0, nearest.distance, -1.0) if stop_at_first else nearest.distance
        left = np.flatnonzero(
            np.take(entry, turn) <= np.take(farthest.reshape(distance.shape).max(axis=0), np.take(packet, turn))
        )
        turn, end = np.take(turn, left), np.take(end, left)
