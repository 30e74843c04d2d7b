"""Parts by name: those that ship, those that installed packages bring, and a person's own.

A kind of part (mapping method, reading filter, importer, ...) has one `Registry`. What ships is
one line in its table. An installed package adds its own by entry points of the kind's group::

    [project.entry-points."sonarbed.methods"]
    my-mapper = "my_package.mapper:MyMapper"

and whatever can be imported is a part without any registration, as ``package.module:Name``.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from types import MappingProxyType
from typing import Any, Generic, TypeVar

from sonarmap.errors import InputError, did_you_mean

__all__ = ["Registry", "import_object"]

Part = TypeVar("Part")


class Registry(Mapping[str, Part], Generic[Part]):
    """The parts of one kind by name; each is imported when it is first asked for.

    Parameters
    ----------
    kind : str
        What a part is called in messages, in the singular: "method".
    group : str
        Group of the entry points by which installed packages add theirs: "sonarbed.methods".
    shipped : mapping of str to str
        ``package.module:Name`` of each part that ships. A shipped name cannot be taken by another.
    """

    def __init__(self, kind: str, group: str, shipped: Mapping[str, str]) -> None:
        self.kind, self.group = kind, group
        self._shipped = MappingProxyType(dict(shipped))

    def __getitem__(self, name: str) -> Part:
        if name in self._shipped:
            return import_object(self.kind, self._shipped[name])  # type: ignore[no-any-return]
        entry = self._installed()[name]
        return import_object(self.kind, entry.value)  # type: ignore[no-any-return]

    def __iter__(self) -> Iterator[str]:
        return iter({**self._shipped, **self._installed()})

    def __len__(self) -> int:
        return len({**self._shipped, **self._installed()})

    def __contains__(self, name: object) -> bool:
        return name in self._shipped or name in self._installed()

    @property
    def shipped(self) -> tuple[str, ...]:
        """Names of the parts that ship, which may be loaded without running anyone else's code."""
        return tuple(self._shipped)

    def find(self, name: str) -> Part:
        """Return the part called `name`, or the object that ``package.module:Name`` imports.

        Raises
        ------
        InputError
            If there is no such name (with the nearest known one), or it cannot be imported.
        """
        if not isinstance(name, str):
            raise InputError(f"{self.kind} must be a name, got {name!r}")
        if ":" in name:
            return import_object(self.kind, name)  # type: ignore[no-any-return]
        if name not in self:
            raise InputError(f"{self.kind} {name!r} is unknown{did_you_mean(name, self)}")
        return self[name]

    def _installed(self) -> dict[str, EntryPoint]:
        return {
            entry.name: entry
            for entry in entry_points(group=self.group)
            if entry.name not in self._shipped
        }


def import_object(kind: str, path: str) -> Any:
    """Return what ``package.module:Name`` stands for; `kind` is what messages call it.

    Raises
    ------
    InputError
        If the text is of another form, the module cannot be imported, or has no such name.
    """
    module_name, _, attributes = path.partition(":")
    if not module_name or not attributes:
        raise InputError(f"{kind} must be a name or package.module:Name, got {path!r}")
    try:
        found: Any = import_module(module_name)
    except ImportError as error:
        raise InputError(f"{kind} {path!r} cannot be imported: {error}") from error
    for attribute in attributes.split("."):
        try:
            found = getattr(found, attribute)
        except AttributeError:
            raise InputError(
                f"{kind} {path!r} cannot be imported: {module_name!r} has no {attributes!r}"
            ) from None
    return found
