"""The construction tree: the words of all elements, from the whole figure down.

The root is the whole figure and has the empty address. A node of level n stands for
P T_i1 ... T_in K_{depth-n}, the part of the figure whose addresses begin with its word; the leaves
are the elements. Nodes are made when they are asked for, so a tree of any size costs nothing.

Source: the paper, section 3.1, figure 7.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from operator import index

import numpy as np

from ifs_cad.design.address import curve_addresses, format_word, is_dotted, parse_word
from ifs_cad.design.curve import DEEPEST
from ifs_cad.design.reading import whole_number
from ifs_cad.design.size import require_memory
from ifs_cad.errors import AddressError
from ifs_cad.types import FloatArray, IntArray, frozen

BYTES_OF_A_NODE = 256  # two positions, an edge, and an address as Python text

__all__ = ["ConstructionTree", "Node", "TreeDrawing", "read_word"]


def read_word(word: str | Sequence[int], count: int, longest: int) -> tuple[int, ...]:
    """Read a word over the alphabet of `count` transformations.

    Parameters
    ----------
    word : str or sequence of int
        Digits from 0, coarsest first.
    count : int
        N, the number of transformations.
    longest : int
        Most digits that it can have.

    Raises
    ------
    AddressError
        Too many digits, or a digit that no transformation has.
    """
    if isinstance(word, str):
        digits = parse_word(word, is_dotted((count,)))
    else:
        digits = tuple(index(digit) for digit in word)
    if len(digits) > longest:
        raise AddressError(
            f"{word!r} has {len(digits)} digits; words of this depth have at most {longest}.",
            addresses=[str(word)],
        )
    for place, digit in enumerate(digits):
        if not 0 <= digit < count:
            raise AddressError(
                f"Digit {place + 1} of {word!r} must be from 0 to {count - 1}.",
                addresses=[str(word)],
            )
    return digits


@dataclass(frozen=True)
class ConstructionTree:
    """The tree of a number of transformations, some construction steps deep.

    Parameters
    ----------
    count : int
        N, the number of transformations.
    depth : int
        Number of construction steps.

    Raises
    ------
    InputError
        A count below 1 or a depth below 0.

    References
    ----------
    The paper, figure 7.
    """

    count: int
    depth: int

    def __post_init__(self) -> None:
        whole_number(self.count, "The number of transformations", 1)
        whole_number(self.depth, "The iteration depth", 0, DEEPEST)

    def __str__(self) -> str:
        return self.text()

    def __len__(self) -> int:
        """Return the number of nodes, the root included."""
        return sum(self.count**level for level in range(self.depth + 1))

    @property
    def root(self) -> Node:
        """The whole figure."""
        return Node(self, ())

    def node(self, word: str | Sequence[int]) -> Node:
        """Return the node of a word.

        Raises
        ------
        AddressError
            More digits than the tree has levels, or a digit that no transformation has.
        """
        return Node(self, read_word(word, self.count, self.depth))

    def walk(self, prefix: str | Sequence[int] = ()) -> Iterator[Node]:
        """Go through the nodes below a prefix, its own first, each before its children."""
        return self.node(prefix).walk()

    def level(self, number: int, prefix: str | Sequence[int] = ()) -> list[str]:
        """Return the addresses of a level, in order, all or those with a prefix.

        Raises
        ------
        InputError
            A level that the tree does not have, or above that of the prefix.
        SizeError
            More addresses than fit in memory.
        """
        start = self.node(prefix)
        whole_number(number, "The level", start.level, self.depth)
        require_memory(self.count, number, BYTES_OF_A_NODE, known=start.level)
        return self._addresses(start, number - start.level)

    def text(self, prefix: str | Sequence[int] = (), levels: int | None = None) -> str:
        """Write the tree, or the branch of a prefix, one node a line.

        Parameters
        ----------
        prefix : str or sequence of int
            The branch; the whole tree by default.
        levels : int, optional
            How many levels below the branch's own to show; all by default.

        Returns
        -------
        str
            Address and formula of each node, branches drawn as the command ``tree`` draws them.

        Raises
        ------
        SizeError
            More lines than fit in memory.
        """
        start = self.node(prefix)
        last = self._last_level(start, levels)
        lines = [start.label]
        # A stack instead of recursion: a tree of one transformation may be 1000 levels deep.
        waiting = [(child, "") for child in reversed(start.children)] if start.level < last else []
        while waiting:
            node, indent = waiting.pop()
            is_last = node.word[-1] == self.count - 1
            lines.append(f"{indent}{'└── ' if is_last else '├── '}{node.label}")
            if node.level < last:
                below = indent + ("    " if is_last else "│   ")
                waiting += [(child, below) for child in reversed(node.children)]
        return "\n".join(lines)

    def drawing(self, prefix: str | Sequence[int] = (), levels: int | None = None) -> TreeDrawing:
        """Return where to draw the nodes, and which to join.

        Parameters
        ----------
        prefix, levels
            As in `text`.

        Raises
        ------
        SizeError
            More nodes than fit in memory.
        """
        start = self.node(prefix)
        steps = self._last_level(start, levels) - start.level
        sizes = [self.count**level for level in range(steps + 1)]
        firsts = np.cumsum([0, *sizes])
        # A node stands in the middle of its leaves, and leaves are one apart.
        across = [(np.arange(size) + 0.5) * (sizes[-1] / size) - 0.5 for size in sizes]
        down = np.repeat(-np.arange(steps + 1.0), sizes)
        parents = [
            first + np.arange(size) // self.count
            for first, size in zip(firsts[:-2], sizes[1:], strict=True)
        ]
        children = np.arange(1, firsts[-1])
        edges = np.column_stack([np.concatenate([[], *parents]).astype(np.int64), children])
        addresses = [
            address for level in range(steps + 1) for address in self._addresses(start, level)
        ]
        positions = np.column_stack([np.concatenate(across), down])
        return TreeDrawing(frozen(positions), frozen(edges), tuple(addresses))

    def _last_level(self, start: Node, levels: int | None) -> int:
        """Return the last level to show, within memory."""
        below = self.depth - start.level
        if levels is not None:
            below = min(below, whole_number(levels, "The number of levels", 0))
        # All levels above the last one together have at most as many nodes again.
        require_memory(self.count, start.level + below, 2 * BYTES_OF_A_NODE, known=start.level)
        return start.level + below

    def _addresses(self, start: Node, steps: int) -> list[str]:
        """Return the addresses some steps below a node, in order."""
        if steps == 0:
            return [start.address]
        below = curve_addresses((self.count,) * steps)
        lead = start.address + ("." if start.word and is_dotted((self.count,)) else "")
        return [lead + address for address in below] if lead else below


@dataclass(frozen=True)
class Node:
    """A node of a construction tree.

    Parameters
    ----------
    tree : ConstructionTree
    word : tuple of int
        Valid digits, coarsest first; empty for the root.
    """

    tree: ConstructionTree
    word: tuple[int, ...]

    def __str__(self) -> str:
        return self.label

    @cached_property
    def address(self) -> str:
        """The word as text; empty for the root."""
        return format_word(self.word, is_dotted((self.tree.count,)))

    @property
    def formula(self) -> str:
        """The node in the paper's letters, whose indices count from 1: ``PT1T2K``."""
        return f"P{''.join(f'T{digit + 1}' for digit in self.word)}K"

    @property
    def label(self) -> str:
        """Address and formula."""
        return f"{self.address}  {self.formula}" if self.word else self.formula

    @property
    def level(self) -> int:
        """Number of construction steps above the node."""
        return len(self.word)

    @property
    def is_leaf(self) -> bool:
        """Whether the node is an element."""
        return self.level == self.tree.depth

    @property
    def parent(self) -> Node | None:
        """The node above, none for the root."""
        return Node(self.tree, self.word[:-1]) if self.word else None

    @property
    def children(self) -> tuple[Node, ...]:
        """The nodes below in the order of the transformations, none for a leaf."""
        if self.is_leaf:
            return ()
        return tuple(Node(self.tree, (*self.word, digit)) for digit in range(self.tree.count))

    def walk(self) -> Iterator[Node]:
        """Go through this node and all below it, each before its children."""
        waiting = [self]
        while waiting:
            node = waiting.pop()
            yield node
            waiting.extend(reversed(node.children))


@dataclass(frozen=True, eq=False)
class TreeDrawing:
    """Where to draw the nodes of a construction tree.

    Attributes
    ----------
    positions : (n, 2) float
        Level by level from the root; leaves are one apart and levels one below the other.
    edges : (n - 1, 2) int
        Parent and child, as rows of `positions`.
    addresses : n str
        The root's is empty.
    """

    positions: FloatArray
    edges: IntArray
    addresses: tuple[str, ...]
